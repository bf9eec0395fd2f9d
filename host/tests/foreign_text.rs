//! Tests that names and lines from files are printed without control characters, and truncated if
//! long.

mod common;

use common::{directory, file, run, text};
use std::path::Path;

/// Text that sets a window's title, rings the bell, clears the screen with a C1 code, reverses the
/// text's direction and deletes a character.
const HOSTILE: &str = "a\x1b]0;title\x07b\u{9b}2Jc\u{202e}d\x7f";

/// Maximum length of a line on standard error, bytes; some characters take four.
const BYTES_MAX: usize = 5000;

fn is_harmless(character: char) -> bool {
    character == '\n' || !(character.is_control() || character == '\u{202e}')
}

/// Runs a command and asserts that its output for people is harmless. Returns true if the output
/// quotes the text.
fn check(arguments: &[&str]) -> bool {
    let output = run(arguments);
    let error = String::from_utf8(output.stderr).expect("UTF-8");
    assert!(error.chars().all(is_harmless), "{arguments:?}: {error:?}");
    for line in error.lines() {
        assert!(
            line.len() < BYTES_MAX,
            "{arguments:?}: {} bytes",
            line.len()
        );
    }
    let results = String::from_utf8(output.stdout).expect("UTF-8");
    let is_safe = results.chars().all(is_harmless);
    assert!(is_safe, "{arguments:?}: {results:?}");
    assert_ne!(output.status.code(), Some(101), "{arguments:?}: {error}");
    error.contains("u{1b}") || error.contains("... (")
}

/// Returns every command that reads a user's file, with this path.
fn commands(path: &Path) -> Vec<Vec<&str>> {
    let path = text(path);
    vec![
        vec!["fit", path],
        vec!["fit", path, path],
        vec!["fit", path, "--columns", "none"],
        vec!["fit", path, "--time-column", path],
        vec!["fit", path, "--speed-column", path],
        vec!["fit", path, "--positions", path],
        vec!["calibrate", path, path],
        vec!["calibrate", path],
        vec!["replay", path],
        vec!["replay", "--settings", path],
        vec!["replay", "--scene", path],
        vec!["export", path],
        vec!["export", path, "--table", "health"],
        vec!["export", path, "--format", "ndjson"],
        vec!["monitor", "--plain", "--file", path],
        vec!["view", "--settings", path, "--port", path],
        vec!["serve", "--finger", path],
        vec!["record", "--port", path, "-o", path],
        vec!["monitor", "--plain", "--port", path],
        vec!["check", "--port", path],
        vec!["settings", "get", "--port", path],
        vec!["settings", "set", "--file", path, "--port", path],
        vec!["command", "follow", path, "--port", path],
        vec!["emulate", "--elf", path],
        vec!["emulate", path, "--print-scene", path],
        vec!["emulate", "--period", path],
        vec![path],
    ]
}

#[test]
fn no_command_passes_on_what_acts_on_a_terminal() {
    let folder = directory();
    let in_file = |name: &str, content: &str| file(folder.path(), name, content);
    let long = "x".repeat(64_000);
    let mcap = folder.path().join("a.mcap");
    let damaged = HOSTILE.repeat(40);
    std::fs::write(&mcap, [b"\x89MCAP0\r\n", damaged.as_bytes()].concat()).expect("a file");
    let paths = [
        in_file(&format!("{HOSTILE}.csv"), "time_s,a\n0,1\n"),
        in_file(
            "names.csv",
            &format!("time_s,{HOSTILE},{HOSTILE}\n0,1,2\n0.1,2,inf\n"),
        ),
        in_file(
            "cells.csv",
            &format!("time_s,a\n0,1\n0.1,{HOSTILE}\n0.2,{HOSTILE}\n"),
        ),
        in_file("name.csv", &format!("time_s,{long}\n0,1\n0.1,inf\n")),
        in_file(
            "cell.csv",
            &format!("time_s,a\n0,1\n0.1,{long}\n0.2,{long}\n"),
        ),
        in_file("a.toml", &format!("{HOSTILE} = 1\n")),
        in_file("b.toml", &format!("plan = \"{HOSTILE}\"\n")),
        in_file("c.toml", &format!("{long} = {long}\n")),
        in_file("d.toml", &format!("\"{long}\" = 1\n")),
        mcap,
        in_file(
            "a.ndjson",
            &format!("{{\"type\":\"raw\",\"t_s\":\"{HOSTILE}{long}\"}}\n"),
        ),
        folder.path().join(format!("{HOSTILE}/missing.csv")),
        folder.path().join(format!("missing-{long}")),
    ];
    for path in &paths {
        let quoted = commands(path)
            .into_iter()
            .filter(|arguments| check(arguments))
            .count();
        // Errors must quote the text, to show that it was the cause; MCAP errors quote nothing.
        let is_mcap = path
            .extension()
            .is_some_and(|extension| extension == "mcap");
        assert!(quoted > 0 || is_mcap, "nothing quotes {path:?}");
    }
}

#[test]
fn names_of_columns_are_harmless_in_results_too() {
    let folder = directory();
    let table = common::tone(1, 400, 100.0, 5.0, 0.0).replace("c0", HOSTILE);
    let path = file(folder.path(), "tone.csv", &table);
    for arguments in [
        &["fit", "--whole"][..],
        &["fit", "--whole", "--json"],
        &["fit", "--whole", "--window", "1"],
    ] {
        check(&[arguments, &[text(&path)]].concat());
    }
    let output = run(&["fit", "--whole", text(&path)]);
    assert!(common::stdout(&output).contains(r"a\u{1b}]0;title"));
}
