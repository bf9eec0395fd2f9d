//! Tests the README: its commands exist, those with the emulated finger run, and its table of pins
//! matches the firmware.

#[path = "../../host/tests/common/mod.rs"]
mod common;

use common::{directory, ridgetone, stderr, stdout};
use std::process::{Command, Stdio};

const README: &str = include_str!("../README.md");

/// The `ridgetone` commands in the README, without their comments.
fn commands() -> impl Iterator<Item = &'static str> {
    let commands = README.lines().filter(|line| line.starts_with("ridgetone "));
    commands.map(|line| line.split(" #").next().unwrap_or(line).trim())
}

/// `--help` comes last, because the parser checks every word before it.
#[test]
fn every_command_exists() {
    let mut count = 0;
    for command in commands() {
        let words = command.split_whitespace().skip(1);
        let help = ridgetone().args(words).arg("--help").output();
        let help = help.expect("the command runs");
        assert!(help.status.success(), "{command}: {}", stderr(&help));
        count += 1;
    }
    assert_eq!(count, 6);
}

#[test]
#[ignore = "needs the emulator: cargo xtask test --all"]
fn the_commands_of_the_emulated_finger_run() {
    let folder = directory();
    for (command, words) in
        commands().zip(["http://127.0.0.1:8322/", "\"forces_n\"", " received, "])
    {
        let program = ridgetone();
        let ours = command.replacen("ridgetone", &program.get_program().to_string_lossy(), 1);
        // Interrupts once, as Ctrl-C does. Without `--foreground`, the command would be interrupted
        // twice.
        let shell = format!("timeout --foreground --preserve-status --signal INT 15 {ours}");
        let output = Command::new("sh")
            .args(["-c", &shell])
            .current_dir(folder.path())
            .stdin(Stdio::null())
            .output()
            .expect("a shell");
        assert!(output.status.success(), "{command}: {}", stderr(&output));
        let all = format!("{}{}", stdout(&output), stderr(&output));
        assert!(all.contains(words), "{command} does not say \"{words}\"");
    }
}

/// The README must list the stylus' pins by function, as in the firmware.
#[test]
fn the_pins_of_the_stylus_are_the_firmwares() {
    let code: String = include_str!("../image/board.rs")
        .split_whitespace()
        .collect();
    for (signal, pin, call) in [
        ("| amplifier", "PA4", "gpioa.pa4.into_analog()"),
        (
            "| encoder, channel A",
            "PC6",
            "gpioc.pc6.into_alternate::<2>()",
        ),
        (
            "| encoder, channel B",
            "PC7",
            "gpioc.pc7.into_alternate::<2>()",
        ),
        ("| telemetry out", "PB10, PB11", "gpiob.pb10,rx"),
    ] {
        let row = README.lines().find(|line| line.starts_with(signal));
        let row = row.unwrap_or_else(|| panic!("no row {signal}"));
        assert_eq!(row.split('|').nth(3).map(str::trim), Some(pin), "{row}");
        assert!(code.contains(call), "{signal} is not on {pin}");
    }
}
