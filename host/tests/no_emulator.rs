//! `ridgetone emulate` where there is no emulator, none of ours, or one that fails.
#![cfg(target_os = "linux")]

mod common;

use common::{assert_one_line, directory, file, ridgetone, run, stderr, text};
use object::write::{Object, StandardSection, Symbol, SymbolSection};
use object::{Architecture, BinaryFormat, Endianness, SymbolFlags, SymbolKind, SymbolScope};
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use std::process::Output;
use std::time::{Duration, Instant};

/// An ELF file of this architecture with this symbol and this text in it.
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

/// One that passes for the firmware.
fn firmware(folder: &Path) -> PathBuf {
    elf(
        folder,
        "firmware.elf",
        Architecture::Arm,
        "EXTI4",
        b"....spi.request\0",
    )
}

/// Runs `emulate` with a script for an emulator, in a temporary folder of its own that must be
/// empty afterwards.
fn emulate_with(script: &str, arguments: &[&str]) -> Output {
    let folder = directory();
    let (bin, temporary) = (folder.path().join("bin"), folder.path().join("tmp"));
    std::fs::create_dir(&bin).unwrap();
    std::fs::create_dir(&temporary).unwrap();
    let fake = file(&bin, "qemu-system-arm", &format!("#!/bin/sh\n{script}\n"));
    std::fs::set_permissions(&fake, std::fs::Permissions::from_mode(0o755)).unwrap();
    let (svg, serial) = (folder.path().join("run.svg"), folder.path().join("run.bin"));
    let output = ridgetone()
        .args([
            "emulate",
            "--elf",
            text(&firmware(folder.path())),
            "--svg",
            text(&svg),
            "--serial-out",
            text(&serial),
        ])
        .args(arguments)
        .env("PATH", &bin)
        .env("TMPDIR", &temporary)
        .output()
        .unwrap();
    assert!(!svg.exists() && !serial.exists(), "half-written");
    assert_eq!(
        std::fs::read_dir(&temporary).unwrap().count(),
        0,
        "a temporary folder is left"
    );
    output
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
        &["text.elf", "not an ELF"],
    );
    let foreign = elf(
        folder.path(),
        "pc.elf",
        Architecture::X86_64,
        "EXTI4",
        b"spi.request\0",
    );
    assert_one_line(&emulate(&foreign), 1, &["pc.elf", "ARM"]);
    let other = elf(
        folder.path(),
        "other.elf",
        Architecture::Arm,
        "main",
        b"spi.request\0",
    );
    assert_one_line(
        &emulate(&other),
        1,
        &["other.elf", "not Ridgetone's firmware"],
    );
    let board = elf(
        folder.path(),
        "board.elf",
        Architecture::Arm,
        "EXTI4",
        b"no bridge",
    );
    assert_one_line(
        &emulate(&board),
        1,
        &["board.elf", "emulator", "cargo xtask firmware"],
    );
    let cut = std::fs::read(firmware(folder.path())).unwrap();
    let half = folder.path().join("half.elf");
    std::fs::write(&half, &cut[..cut.len() / 2]).unwrap();
    assert_one_line(&emulate(&half), 1, &["half.elf"]);
}

#[test]
fn no_emulator_installed() {
    let folder = directory();
    let image = firmware(folder.path());
    let output = ridgetone()
        .args(["emulate", "--elf", text(&image)])
        .env("PATH", folder.path())
        .output()
        .unwrap();
    assert_one_line(
        &output,
        1,
        &["qemu-system-arm is not installed", "cargo xtask setup"],
    );
}

#[test]
fn an_emulator_that_fails_at_once() {
    let output = emulate_with(
        "echo 'first trouble' >&2; echo 'last trouble' >&2; exit 1",
        &[],
    );
    assert_one_line(
        &output,
        1,
        &["qemu-system-arm failed", "exit status: 1", "last trouble"],
    );
    assert_one_line(&emulate_with("exit 0", &[]), 1, &["left before the end"]);
    assert_one_line(
        &emulate_with("echo 'at main.rs:1' >&2; exit 101", &[]),
        1,
        &["panicked", "main.rs"],
    );
}

#[test]
fn an_emulator_that_says_nothing() {
    let begun = Instant::now();
    let output = emulate_with("/bin/sleep 600", &["--patience", "0.5"]);
    assert_one_line(&output, 1, &["no sign of life", "0.5 s"]);
    assert!(begun.elapsed() < Duration::from_secs(20));
}

#[test]
fn an_emulator_that_is_killed() {
    // Its child keeps the pipes open, as a hung helper would.
    let output = emulate_with("/bin/sleep 5 & kill -9 $$", &[]);
    assert_one_line(&output, 1, &["qemu-system-arm failed", "signal: 9"]);
}

#[test]
fn an_emulator_that_speaks_nonsense() {
    let output = emulate_with(
        r"printf '\377\377\377\377\377\377\377\377' > spi.request; /bin/sleep 600",
        &[],
    );
    assert_one_line(&output, 1, &["bridge"]);
}

#[test]
fn an_emulator_that_dies_in_the_middle() {
    // A poll at 5 us, whose answer of 12 bytes is read, and the end.
    let script = r"exec 3< spi.reply
printf '\000\000\000\000\005\000\000\000' > spi.request
/usr/bin/head -c 12 <&3 > /dev/null
exit 3";
    assert_one_line(&emulate_with(script, &[]), 1, &["the firmware faulted"]);
}

#[test]
fn a_line_full_of_rubbish_is_counted_not_believed() {
    let output = emulate_with(r"printf '\001\002\003\000\004\005\006\000'; exit 1", &[]);
    assert_eq!(output.status.code(), Some(1), "{}", stderr(&output));
    assert!(output.stdout.is_empty());
}
