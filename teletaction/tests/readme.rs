//! The guide: its commands run, and its table of pins is the firmware's.

#[path = "../../host/tests/common/mod.rs"]
mod common;

use common::{directory, file, stderr, stdout};
use pulldown_cmark::{CodeBlockKind, Event, Parser, Tag, TagEnd};
use std::path::Path;
use std::process::{Command, Output, Stdio};

const GUIDE: &str = include_str!("../README.md");

/// Commands that need a board or another computer; `link.rs` has a board at a pseudo-terminal.
const WITH_A_BOARD: [&str; 4] = [
    "ridgetone link --finger /dev/ttyUSB0 --stylus udp:0.0.0.0:7450",
    "ridgetone link --finger udp:robot.local:7450",
    "ridgetone link --finger /dev/ttyUSB0 --stylus /dev/ttyUSB1",
    "ridgetone link --finger udp:robot.local:7450 --stylus /dev/ttyUSB0",
];

/// Commands that go on until somebody interrupts them, with what they say within seconds.
const ENDLESS: [(&str, &str); 4] = [
    ("ridgetone touch --emulated", "http://127.0.0.1:8322/"),
    ("ridgetone pins --emulated", " sensor "),
    ("ridgetone pins --emulated --page", "http://127.0.0.1:8323/"),
    (
        "ridgetone link --emulated --delay-ms 120 --jitter-ms 40 --loss 5%",
        " received, ",
    ),
];

/// The guide's commands of `ridgetone`, as they follow, without the comments behind them.
fn commands() -> Vec<String> {
    let (mut text, mut inside) = (String::new(), false);
    for mark in Parser::new(GUIDE) {
        match mark {
            Event::Start(Tag::CodeBlock(CodeBlockKind::Fenced(name))) => inside = &*name == "sh",
            Event::End(TagEnd::CodeBlock) => inside = false,
            Event::Text(block) if inside => text.push_str(&block),
            _ => {}
        }
    }
    text.lines()
        .map(|line| {
            line.split(" #")
                .next()
                .unwrap_or_default()
                .trim()
                .to_owned()
        })
        .filter(|command| command.starts_with("ridgetone "))
        .collect()
}

/// Runs a command in a folder, for at most so many seconds if it is endless.
fn run(folder: &Path, command: &str, most_s: Option<u32>) -> Output {
    let program = common::ridgetone();
    let ours = command.replacen("ridgetone", &program.get_program().to_string_lossy(), 1);
    // Interrupted as Ctrl-C does, once; without `--foreground` it would be twice.
    let shell = most_s.map_or(ours.clone(), |s| {
        format!("timeout --foreground --preserve-status --signal INT {s} {ours}")
    });
    let output = Command::new("sh")
        .args(["-c", &shell])
        .current_dir(folder)
        .stdin(Stdio::null())
        .output()
        .expect("a shell");
    assert!(output.status.success(), "{command}: {}", stderr(&output));
    output
}

#[test]
fn every_command_is_listed_or_runs() {
    let folder = directory();
    // Rows of a grating of 3 mm at 30 mm/s, as a recording has them.
    let recording = common::tone(16, 1000, 241.0, 10.0, 0.0);
    file(folder.path(), "recording.csv", &recording);
    let all = commands();
    for listed in WITH_A_BOARD
        .iter()
        .chain(ENDLESS.map(|(name, _)| name).iter())
    {
        assert!(all.iter().any(|command| command == listed), "{listed}");
    }
    let texture = "ridgetone texture learn";
    let is_short = |command: &&String| {
        !WITH_A_BOARD.contains(&command.as_str()) && !command.contains("--emulated")
    };
    // A texture is learned before it is played.
    let (first, then): (Vec<_>, Vec<_>) = all
        .iter()
        .filter(is_short)
        .partition(|command| command.starts_with(texture));
    for command in first.iter().chain(&then) {
        run(folder.path(), command, None);
    }
    assert!(first.len() == 1 && then.len() == 4, "{first:?} {then:?}");
}

#[test]
#[ignore = "needs the emulator: cargo xtask test --all"]
fn the_endless_commands_run() {
    let folder = directory();
    for (command, words) in ENDLESS {
        let output = run(folder.path(), command, Some(15));
        let all = format!("{}{}", stdout(&output), stderr(&output));
        assert!(all.contains(words), "{command} does not say \"{words}\"");
    }
}

/// The pins of the stylus, each on the line of its function.
#[test]
fn the_pins_of_the_stylus_are_the_firmwares() {
    let board = include_str!("../stylus/image/board.rs");
    let pins = [
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
        ("| telemetry out", "PB10, PB11", "gpiob.pb10, rx"),
    ];
    // A chain of calls may be on several lines.
    let code: String = board.split_whitespace().collect();
    for (signal, pin, calls) in pins {
        let row = GUIDE
            .lines()
            .find(|line| line.starts_with(signal))
            .unwrap_or_else(|| panic!("no row {signal}"));
        assert!(
            row.split('|').nth(3).is_some_and(|cell| cell.trim() == pin),
            "{row}"
        );
        let calls: String = calls.split_whitespace().collect();
        assert!(code.contains(&calls), "{signal} is not on {pin}");
    }
}
