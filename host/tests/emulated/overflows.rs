//! Compares the firmware built with overflow checks with the release image.

use ridgetone_host::emulator::image::{self, Firmware};
use ridgetone_host::emulator::{self, Options, Outcome};
use ridgetone_host::input::Input;
use ridgetone_proto::telemetry::{Event, Packet};
use std::mem::discriminant;
use std::path::PathBuf;

fn run(elf: &Firmware) -> (Outcome, Vec<Packet>) {
    let mut packets = Vec::new();
    let mut sink = |packet: &Packet, _| {
        packets.push(packet.clone());
        Ok(())
    };
    let input = Input::default().open().expect("an input");
    let outcome =
        emulator::run(input, Options::new(elf), &mut sink, &mut |_, _| {}).expect("a run");
    (outcome, packets)
}

/// Arithmetic wraps silently in the release image, but panics in the checked one. Both must report
/// the same messages for a touch, but the slower checked image stamps some a microsecond later, and
/// may skip windows.
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
        // Ignores health and converter messages, which depend on processor load and time, and the
        // order, because messages may overtake a slower fit.
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
    let (checked_fits, checked_others) = events(&image::read(&checked).expect("an image"));
    let (fits, others) = events(&image::find().expect("an image"));
    assert_eq!(checked_others.len(), others.len());
    for (checked, usual) in checked_others.iter().zip(&others) {
        assert_eq!(discriminant(checked), discriminant(usual));
        let [at_us, usual_us] = [checked, usual].map(|event| event.t_us().unwrap_or_default());
        assert!(at_us.abs_diff(usual_us) <= 2, "{checked:?} {usual:?}");
    }
    for fit in &checked_fits {
        let Event::Estimate(checked) = fit else {
            continue;
        };
        let same = fits.iter().find_map(|usual| match usual {
            Event::Estimate(usual) => {
                let is_same = usual.span == checked.span && usual.t_us.abs_diff(checked.t_us) <= 2;
                is_same.then_some(usual)
            }
            _ => None,
        });
        let usual = same.expect("the same window");
        let off = (checked.frequency - usual.frequency).abs();
        assert!(off < 0.1 * usual.sigma, "{checked:?} {usual:?}");
    }
}
