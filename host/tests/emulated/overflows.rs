//! The firmware with every addition checked for overflow, beside the usual one.

use ridgetone_host::emulator::image::{self, Firmware};
use ridgetone_host::emulator::{self, Options, Outcome};
use ridgetone_host::input::Input;
use ridgetone_proto::telemetry::{Event, Packet};
use std::path::PathBuf;

fn run(elf: &Firmware) -> (Outcome, Vec<Packet>) {
    let mut packets = Vec::new();
    let mut sink = |packet: &Packet| {
        packets.push(packet.clone());
        Ok(())
    };
    let input = Input::default().open().expect("an input");
    let outcome =
        emulator::run(input, Options::new(elf), &mut sink, &mut |_, _| {}).expect("a run");
    (outcome, packets)
}

/// Arithmetic wraps silently in the release image and panics in this one. A touch gives equal bits
/// in both.
#[test]
#[ignore = "needs the emulator and an image in RIDGETONE_CHECKED_ELF: cargo xtask test"]
fn no_arithmetic_overflows_in_a_touch() {
    let events = |elf: &Firmware| {
        let (outcome, packets) = run(elf);
        assert_eq!(
            (
                outcome.counts.missing,
                outcome.counts.damaged,
                outcome.chip.lost
            ),
            (0, 0, 0)
        );
        // Health says how busy the processor is, and the converter when it was looked at, which
        // differ; and other messages overtake a slower fit.
        let all = packets
            .into_iter()
            .map(|packet| packet.event)
            .filter(|event| !matches!(event, Event::Health(_) | Event::Converter(_)));
        let (fits, others): (Vec<_>, Vec<_>) =
            all.partition(|event| matches!(event, Event::Estimate(_)));
        assert!(fits.len() > 1 && !others.is_empty());
        (fits, others)
    };
    let checked =
        PathBuf::from(std::env::var_os("RIDGETONE_CHECKED_ELF").expect("RIDGETONE_CHECKED_ELF"));
    assert_eq!(
        events(&image::read(&checked).expect("an image")),
        events(&image::find().expect("an image"))
    );
}
