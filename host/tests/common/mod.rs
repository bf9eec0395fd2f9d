//! Helpers that run the command, and create files for it.
#![allow(dead_code, reason = "every test file uses a part of it")]

use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// Returns the command of the tested package, without arguments.
pub fn ridgetone() -> Command {
    let program = option_env!("CARGO_BIN_EXE_ridgetone")
        .or(option_env!("CARGO_BIN_EXE_ridgetone-teletaction"));
    Command::new(program.expect("a command"))
}

pub fn run(arguments: &[&str]) -> Output {
    ridgetone()
        .args(arguments)
        .output()
        .expect("the command runs")
}

pub fn stdout(output: &Output) -> String {
    String::from_utf8(output.stdout.clone()).expect("UTF-8")
}

pub fn stderr(output: &Output) -> String {
    String::from_utf8(output.stderr.clone()).expect("UTF-8")
}

/// Parses standard output as one JSON object per line; the command must have succeeded.
pub fn json_lines(output: &Output) -> Vec<serde_json::Value> {
    assert!(output.status.success(), "{}", stderr(output));
    stdout(output)
        .lines()
        .map(|line| serde_json::from_str(line).expect("JSON"))
        .collect()
}

/// Asserts that the command failed with this status and printed one line with all `parts`. On a
/// busy machine, progress may precede this line.
pub fn assert_one_line(output: &Output, status: i32, parts: &[&str]) {
    let all = stderr(output);
    let is_progress = |line: &&str| line.ends_with(" rows read") || line.ends_with(" rows checked");
    let lines: Vec<&str> = all.lines().skip_while(is_progress).collect();
    let printed = lines.join("\n");
    assert_eq!(output.status.code(), Some(status), "{printed}");
    assert_eq!(printed.lines().count(), 1, "{printed}");
    assert!(
        printed.starts_with("ridgetone: ") && !printed.contains("thread 'main'"),
        "{printed}"
    );
    for part in parts {
        assert!(printed.contains(part), "{part:?} is not in {printed}");
    }
}

pub fn directory() -> tempfile::TempDir {
    tempfile::tempdir().expect("a temporary directory")
}

pub fn file(directory: &Path, name: &str, text: &str) -> PathBuf {
    let path = directory.join(name);
    std::fs::write(&path, text).expect("the file can be written");
    path
}

pub fn text(path: &Path) -> &str {
    path.to_str().expect("UTF-8")
}

/// Returns a table of `channels` columns, sampled at `rate_hz`: a tone of `frequency_hz` with an
/// overtone, a little noise, and different amplitudes and phases. Stamps are rounded down to
/// multiples of `jitter_s` unless it is zero.
pub fn tone(
    channels: usize,
    rows: usize,
    rate_hz: f64,
    frequency_hz: f64,
    jitter_s: f64,
) -> String {
    let mut csv = String::from("time_s");
    for c in 0..channels {
        let _ = write!(csv, ",c{c}");
    }
    let mut state = 1u32;
    for row in 0..rows {
        let t_s = row as f64 / rate_hz;
        let stamp_s = if jitter_s > 0.0 {
            (t_s / jitter_s).floor() * jitter_s
        } else {
            t_s
        };
        let _ = write!(csv, "\n{stamp_s:.6}");
        for c in 0..channels {
            // Quick generator from Numerical Recipes. It need only be reproducible.
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            let noise = f64::from(state >> 8) / f64::from(1 << 24) - 0.5;
            let phase = std::f64::consts::TAU * frequency_hz * t_s + c as f64;
            let value = 100.0
                + 10.0 * c as f64
                + (1.0 + 0.1 * c as f64) * (phase.cos() + 0.4 * (2.0 * phase).sin());
            let _ = write!(csv, ",{:.6}", value + 0.2 * noise);
        }
    }
    csv.push('\n');
    csv
}
