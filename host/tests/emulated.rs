//! The firmware image in the emulator. `cargo xtask test` builds the image first.
#![cfg(target_os = "linux")]

use ridgetone::telemetry::{Event, Packet};
use ridgetone_host::emulator::{self, Options, Outcome};
use ridgetone_host::input::Input;

fn run(keep_conversions: bool) -> (Outcome, Vec<Packet>) {
    let elf = emulator::image::find().unwrap();
    let options = Options { keep_conversions, ..Options::new(&elf) };
    let mut packets = Vec::new();
    let input = Input::default().open().unwrap();
    let outcome = emulator::run(
        input,
        options,
        &mut |packet| {
            packets.push(packet.clone());
            Ok(())
        },
        &mut |_, _| {},
    );
    (outcome.unwrap(), packets)
}

#[test]
#[ignore = "needs the emulator: cargo xtask test"]
fn two_runs_give_the_same_bytes() {
    let (first, packets) = run(true);
    let (second, _) = run(false);
    assert_eq!(first.serial, second.serial);
    assert!(matches!(packets[0].event, Event::Hello(_)));
    assert_eq!((first.missing, first.damaged, first.conversions_lost), (0, 0, 0));
    assert_eq!(first.received, packets.len() as u64);
    assert_eq!(first.conversions.len() as u64, first.conversions_served);
    assert!(second.conversions.is_empty());
}
