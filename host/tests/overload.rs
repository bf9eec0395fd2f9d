//! Overload on the emulated chip: acquisition never waits, and what is lost is counted, exactly.
//! `cargo xtask test` builds the image and runs these.
#![cfg(target_os = "linux")]

use ridgetone_host::emulator::{self, Options, Outcome};
use ridgetone_host::input::Input;
use ridgetone_proto::telemetry::{Event, Health, Packet};

/// Clock of a simulated chip whose scan, made for 15.72864 MHz and 5064 conversions a second, makes
/// 23,739 of them: the most that the real one does by any setting (SBAS297G: 16 MHz, DRATE 3, no
/// delay). No real chip bears this clock.
const FAST_CLOCK_HZ: u32 = 73_734_000;

/// Runs the default scene, which such a clock does not make any shorter, and gives the last
/// `health` too.
fn run(
    clock_hz: Option<u32>,
    change: impl FnOnce(&mut Options<'_>),
) -> (Outcome, Vec<Packet>, Health) {
    let elf = emulator::image::find().expect("an image");
    let mut options = Options::new(&elf);
    change(&mut options);
    let mut input = Input::default().open().expect("an input");
    if let Some(clock_hz) = clock_hz {
        input.options.clock_hz = clock_hz;
    }
    let mut packets = Vec::new();
    let mut sink = |packet: &Packet| {
        packets.push(packet.clone());
        Ok(())
    };
    let outcome = emulator::run(input, options, &mut sink, &mut |_, _| {}).expect("a run");
    let mut healths = packets.iter().filter_map(|packet| match &packet.event {
        Event::Health(health) => Some(*health),
        _ => None,
    });
    let health = healths.next_back().expect("a health");
    (outcome, packets, health)
}

/// Every conversion that the chip made was read or is reported as lost; every packet that was
/// numbered arrived or is reported as dropped.
fn assert_accounted(what: &str, outcome: &Outcome, packets: &[Packet], health: &Health) {
    let (made, read) = (outcome.chip.conversions, outcome.chip.read);
    let lost = u64::from(health.conversions_lost);
    assert_eq!(
        outcome.arrived + outcome.read_once,
        read,
        "{what}: the bus damages nothing"
    );
    assert!(
        made - read <= lost + 1,
        "{what}: {made} made, {read} read, {lost} reported as lost"
    );
    // What was read is in a frame, or reported as lost: dropped because the queue was full. The
    // last scan may not be over.
    let slots = 21;
    let framed = u64::from(health.frames) * slots;
    assert!(
        framed + lost + slots > made,
        "{what}: {made} made, {} frames, {lost} reported as lost",
        health.frames
    );
    // Numbers begin at zero: the decoder cannot know what is missing before the first packet, since
    // it may start listening late.
    let missing = outcome.counts.missing + u32::from(packets.first().expect("a packet").sequence);
    // The stack is deepest when interrupts come on top of a fit under overload; a kilobyte is left
    // for cases that these runs do not meet.
    let (used, size) = (health.stack_used_bytes, health.stack_bytes);
    // A processor that is never idle does not measure it.
    let is_never_idle = size == 0 && health.load == 0.0;
    assert!(
        is_never_idle || used + 1024 <= size,
        "{what}: {used} of {size} bytes of the stack"
    );
    // What was dropped for the sake of that `health`, or later, it cannot know.
    let unknown = missing.checked_sub(health.messages_dropped);
    assert!(
        unknown.is_some_and(|unknown| unknown <= 3) && outcome.counts.damaged == 0,
        "{what}: {missing} {health:?}"
    );
}

#[test]
#[ignore = "needs the emulator: cargo xtask test"]
fn at_the_chips_top_speed_every_loss_is_reported() {
    let (outcome, packets, health) = run(Some(FAST_CLOCK_HZ), |_| ());
    assert_accounted("23,739 conversions a second", &outcome, &packets, &health);
    let seconds = (outcome.end_us - outcome.first_edge_us) as f64 * 1e-6;
    let rate_hz = outcome.chip.conversions as f64 / seconds;
    assert!((rate_hz / 23_739.0 - 1.0).abs() < 0.005, "{rate_hz}");
    // What was read a single time the firmware drops: nothing confirms it.
    assert_eq!(
        u64::from(health.conversions_lost),
        outcome.chip.lost + outcome.read_once,
        "{health:?} {:?}",
        outcome.chip
    );
}

#[test]
#[ignore = "needs the emulator: cargo xtask test"]
fn a_fit_too_slow_for_the_stride_costs_strides() {
    // Strides of 24 frames in 21 ms in place of 0.1 s.
    let (outcome, packets, health) = run(Some(FAST_CLOCK_HZ), |options| {
        options.settings.stride_s = 0.1;
    });
    assert_accounted("slow fit", &outcome, &packets, &health);
    assert!(health.overruns > 0, "{health:?}");
    assert!(
        packets
            .iter()
            .any(|packet| matches!(packet.event, Event::Estimate(_))),
        "some strides are fitted"
    );
}
