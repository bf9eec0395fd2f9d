//! Tests overload on the emulated board: a fit that takes longer than the stride.
//! `emulator/tests/long.rs` accounts for every conversion at the converter's top speed.

use ridgetone_host::emulator::{self, Options};
use ridgetone_host::input::Input;
use ridgetone_proto::telemetry::{Event, Packet};

/// Clock at which the simulated chip's default scan makes 23,739 conversions a second (5064 at
/// 15.72864 MHz), the maximum of the real chip (SBAS297G: 16 MHz, DRATE 3, no delay). No real chip
/// runs at this clock.
const FAST_CLOCK_HZ: u32 = 73_734_000;

#[test]
#[ignore = "needs the boards' images: cargo xtask test"]
fn a_fit_too_slow_for_the_stride_costs_strides() {
    let elf = emulator::image::find().expect("an image");
    let mut options = Options::new(&elf);
    // Strides of 24 frames take 21 ms instead of 0.1 s.
    options.settings.stride_s = 0.1;
    let mut input = Input::default().open().expect("an input");
    input.options.clock_hz = FAST_CLOCK_HZ;
    let mut packets = Vec::new();
    let mut sink = |packet: &Packet, _| {
        packets.push(packet.clone());
        Ok(())
    };
    let outcome = emulator::run(input, options, &mut sink, &mut |_, _| {}).expect("a run");
    let mut healths = packets.iter().filter_map(|packet| match &packet.event {
        Event::Health(health) => Some(*health),
        _ => None,
    });
    let health = healths.next_back().expect("a health");
    assert!(health.overruns > 0, "{health:?}");
    // Even a fit that overruns its stride must not cost a conversion.
    assert_eq!(
        (outcome.chip.lost, health.conversions_lost),
        (0, 0),
        "{health:?}"
    );
    assert!(
        packets
            .iter()
            .any(|packet| matches!(packet.event, Event::Estimate(_))),
        "some strides are fitted"
    );
}
