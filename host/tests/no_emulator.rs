//! Tests `ridgetone emulate` with foreign images.
#![cfg(target_os = "linux")]

mod common;

use common::{assert_one_line, directory, file, run, text};
use object::write::{Object, StandardSection, Symbol, SymbolSection};
use object::{Architecture, BinaryFormat, Endianness, SymbolFlags, SymbolKind, SymbolScope};
use ridgetone_emulator::Image;
use std::path::{Path, PathBuf};

/// Writes an ELF file with the given architecture, symbol and text.
fn elf(
    folder: &Path,
    name: &str,
    architecture: Architecture,
    symbol: &str,
    content: &[u8],
) -> PathBuf {
    let mut object = Object::new(BinaryFormat::Elf, architecture, Endianness::Little);
    let section = object.section_id(StandardSection::Text);
    object.append_section_data(section, content, 4);
    object.add_symbol(Symbol {
        name: symbol.into(),
        value: 0,
        size: 4,
        kind: SymbolKind::Text,
        scope: SymbolScope::Linkage,
        weak: false,
        section: SymbolSection::Section(section),
        flags: SymbolFlags::None,
    });
    let path = folder.join(name);
    std::fs::write(&path, object.write().unwrap()).unwrap();
    path
}

/// An image may be embedded in a program at an odd address.
#[test]
fn an_image_is_read_at_any_address() {
    let folder = directory();
    let path = elf(folder.path(), "a.elf", Architecture::Arm, "EXTI4", b"code");
    let bytes = std::fs::read(&path).unwrap();
    for shift in 0..4 {
        let moved = [&vec![0; shift], &bytes[..]].concat();
        let image = Image::parse(&moved[shift..], &path).unwrap();
        assert_eq!(image.symbol("EXTI4"), Some(0), "{shift}");
    }
}

#[test]
fn images_that_are_not_ours() {
    let folder = directory();
    let emulate = |path: &Path| run(&["emulate", "--elf", text(path)]);
    assert_one_line(
        &emulate(&folder.path().join("none.elf")),
        1,
        &["none.elf", "no such firmware image", "cargo xtask firmware"],
    );
    assert_one_line(
        &emulate(&file(folder.path(), "text.elf", "not an ELF")),
        1,
        &["text.elf", "ELF"],
    );
    let foreign = elf(
        folder.path(),
        "pc.elf",
        Architecture::X86_64,
        "EXTI4",
        b"code",
    );
    assert_one_line(&emulate(&foreign), 1, &["pc.elf", "ELF"]);
    let other = elf(
        folder.path(),
        "other.elf",
        Architecture::Arm,
        "main",
        b"code",
    );
    assert_one_line(
        &emulate(&other),
        1,
        &["other.elf", "not Ridgetone's firmware"],
    );
    let cut = std::fs::read(&foreign).unwrap();
    let half = folder.path().join("half.elf");
    std::fs::write(&half, &cut[..cut.len() / 2]).unwrap();
    assert_one_line(&emulate(&half), 1, &["half.elf"]);
}
