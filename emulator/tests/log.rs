//! Tests the log of a touch, read from RAM as by a debug probe: RTT's buffer with defmt's frames.

mod common;

use common::{Run, estimates, image};
use object::read::elf::ElfFile32;
use object::{LittleEndian, Object, ObjectSymbol};
use ridgetone_emulator::Board;
use ridgetone_proto::telemetry::Status;
use std::path::Path;

/// Decodes a defmt rzCOBS frame, without its final zero, from the end. A byte from 1 to 0x7F has
/// one bit for each of seven bytes, set for a zero. 0x80 to 0xFE stand for a zero before 7 to 133
/// other bytes.
fn decoded(frame: &[u8]) -> Vec<u8> {
    let mut bytes = frame.iter().rev().copied();
    let mut plain = Vec::new();
    while let Some(code) = bytes.next() {
        match code {
            1..=0x7F => plain.extend((0..7).filter_map(|at| match code >> (6 - at) & 1 {
                0 => bytes.next(),
                _ => Some(0),
            })),
            0xFF => plain.extend(bytes.by_ref().take(134)),
            _ => {
                plain.push(0);
                plain.extend(bytes.by_ref().take(usize::from(code & 0x7F) + 7));
            }
        }
    }
    plain.reverse();
    plain
}

/// Returns the text of a log line: `number` is the address of the symbol whose name contains the
/// text.
fn text(elf: &ElfFile32<'_, LittleEndian>, number: u16) -> String {
    let mut names = elf
        .symbols()
        .filter(|one| one.address() == u64::from(number))
        .filter_map(|one| one.name().ok());
    let data = |name: &str| {
        Some(
            name.split_once("\"data\":\"")?
                .1
                .split('"')
                .next()?
                .to_owned(),
        )
    };
    names.find_map(data).expect("a line's text")
}

#[test]
#[ignore = "needs the boards' images: cargo xtask test"]
fn the_log_shows_a_touch_line_by_line() {
    let board = Board::FeatherF405;
    let mut run = Run::sliding(board);
    run.run_s(7.0);
    // `_SEGGER_RTT` holds an id of 16 bytes and two numbers of channels, then the first channel's
    // name, buffer, size, write and read offsets. Nothing has been read yet.
    let header = image(board).symbol("_SEGGER_RTT").expect("a log");
    let word = |address: u32| {
        let bytes = run.emulator.ram(address).first_chunk().copied();
        u32::from_le_bytes(bytes.expect("RAM"))
    };
    let (buffer, written) = (word(header + 28), word(header + 36) as usize);
    let frames = run.emulator.ram(buffer)[..written].split(|byte| *byte == 0);
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let target = std::env::var_os("CARGO_TARGET_DIR")
        .map_or_else(|| root.join("target"), |target| root.join(target));
    let file = target
        .join("firmware")
        .join(board.name())
        .join("ridgetone-firmware.elf");
    let elf = std::fs::read(file).expect("an image");
    let elf = ElfFile32::parse(&elf[..]).expect("an ELF");
    let mut lines = Vec::new();
    for frame in frames.filter(|frame| !frame.is_empty()).map(decoded) {
        let line = text(&elf, u16::from_le_bytes([frame[0], frame[1]]));
        // Fields: line number, time, frequency, uncertainty, length of the status, and its letters.
        if line.ends_with("Hz {=str}") {
            let value =
                |at: usize| f32::from_le_bytes(*frame[at..].first_chunk().expect("a value"));
            lines.push(format!("{} {}", value(6), value(10)));
            assert_eq!(&frame[18..22], b"good", "{frame:?}");
        } else {
            lines.push(line);
        }
    }
    let found = estimates(&run.events);
    assert!(found.iter().all(|one| one.status == Status::Good));
    let found = found
        .iter()
        .map(|one| format!("{} {}", one.frequency, one.sigma));
    let (logged, others): (Vec<_>, Vec<_>) =
        lines.into_iter().partition(|line| line.starts_with("8.3"));
    assert_eq!(logged, found.collect::<Vec<_>>());
    let begin = "the {=str} is set up and scans";
    assert_eq!(others, [begin, "contact", "slide", "slide over", "release"]);
}
