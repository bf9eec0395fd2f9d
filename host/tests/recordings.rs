//! Tests `record`, `replay`, `export`, `monitor`, `ports` and `settings` without an emulator, at a
//! pseudo-terminal and on recordings.
#![cfg(target_os = "linux")]

mod common;
#[path = "common/terminal.rs"]
mod terminal;

use common::{assert_one_line, directory, file, json_lines, run, stderr, stdout, text, tone};
use ridgetone_host::input::Input;
use ridgetone_host::replay;
use rustix::process::{Pid, Signal, kill_process};
use std::fs::File;
use std::io::{BufRead, BufReader, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, Stdio};
use std::time::{Duration, Instant};
use terminal::Terminal;

fn telemetry() -> Vec<u8> {
    let input = Input::default().open().expect("a scene");
    replay::run(input, Default::default(), &mut |_| Ok(()), &mut |_, _| {})
        .expect("a replay")
        .serial
}

/// Writes the telemetry of the default scene to a file, without a header.
fn recording(folder: &Path) -> PathBuf {
    let path = folder.join("touch.rec");
    std::fs::write(&path, telemetry()).expect("a file");
    path
}

fn interrupt(child: &Child) {
    let id = Pid::from_raw(child.id() as i32).expect("a process");
    kill_process(id, Signal::INT).expect("a signal");
}

#[test]
fn a_board_is_recorded_until_ctrl_c_and_the_file_holds_what_it_sent() {
    let (board, folder, bytes) = (Terminal::new(80, 24), directory(), telemetry());
    let path = folder.path().join("touch.rec");
    let mut child = common::ridgetone()
        .args(["record", "--port", &board.name, "-o", text(&path)])
        .stderr(Stdio::piped())
        .spawn()
        .expect("the command runs");
    let mut messages = BufReader::new(child.stderr.take().expect("a pipe")).lines();
    let mut next = || messages.next().expect("a line").expect("UTF-8");
    assert_eq!(next(), format!("ridgetone: {}: open", board.name));
    let mut board = board.into_file();
    // Send only a part of the last frame.
    board.write_all(&bytes[..bytes.len() - 5]).expect("written");
    let whole = bytes.iter().filter(|byte| **byte == 0).count() - 1;
    // Every part ends with a zero: the header, frames, and the marks with their times of receipt.
    let written = || {
        let file = std::fs::read(&path).unwrap_or_default();
        file.split_inclusive(|byte| *byte == 0)
            .filter(|part| part.ends_with(&[0]) && part[0] != b'@')
            .count()
    };
    while written() < 1 + whole {
        std::thread::sleep(std::time::Duration::from_millis(20));
    }
    interrupt(&child);
    assert!(child.wait().expect("ended").success());
    assert_eq!(
        messages.last().expect("a line").expect("UTF-8"),
        format!("ridgetone: {whole} packets received, 0 lost, 0 damaged")
    );

    let mut replayed = json_lines(&run(&["replay", text(&path), "--json"]));
    for line in &mut replayed {
        // Only packets from a board have a time of receipt.
        let object = line.as_object_mut().expect("an object");
        assert!(
            object
                .remove("received_utc_s")
                .is_some_and(|utc_s| utc_s.as_f64() > Some(1.7e9))
        );
        object.retain(|name, _| {
            !["utc_s", "utc_sigma_s"].contains(&name.as_str()) && !name.starts_with("clock_")
        });
    }
    let scene = json_lines(&run(&["replay", "--json"]));
    assert_eq!(replayed, scene[..whole]);
    assert_one_line(
        &run(&["record", "--port", &board_name(), "-o", text(&path)]),
        1,
        &["no such"],
    );
}

fn board_name() -> String {
    "/dev/no such port".into()
}

#[test]
fn a_recording_is_replayed_and_monitored_line_by_line_and_losses_are_reported() {
    let folder = directory();
    let path = recording(folder.path());
    let scene = stdout(&run(&["replay"]));
    let replayed = run(&["replay", text(&path)]);
    assert_eq!(stdout(&replayed), scene);
    let monitored = run(&["monitor", "--file", text(&path), "--pace", "0"]);
    assert_eq!(stdout(&monitored), scene);
    assert!(
        stderr(&monitored).contains("0 lost, 0 damaged"),
        "{}",
        stderr(&monitored)
    );
    // The third frame is missing, and the fourth is damaged.
    let bytes = telemetry();
    let ends: Vec<usize> = bytes
        .iter()
        .enumerate()
        .filter(|(_, byte)| **byte == 0)
        .map(|(at, _)| at + 1)
        .collect();
    let mut damaged = [&bytes[..ends[1]], &bytes[ends[2]..]].concat();
    damaged[ends[1] + 3] ^= 0x40;
    std::fs::write(&path, damaged).expect("a file");
    let replayed = run(&["replay", text(&path), "--json"]);
    let count = ends.len() - 2;
    assert_eq!(
        stderr(&replayed).lines().last(),
        Some(&*format!(
            "ridgetone: {count} packets received, 2 lost, 1 damaged"
        ))
    );
    assert!(
        stdout(&replayed)
            .lines()
            .all(|line| line.starts_with('{') && line.ends_with('}'))
    );
    // Without raw frames there is nothing to run through the library again.
    assert_one_line(
        &run(&["replay", text(&path), "--window", "0.5"]),
        1,
        &["touch.rec", "no raw frames", "record with --raw"],
    );
    assert_one_line(
        &run(&["replay", text(&path), "--scale", "2"]),
        2,
        &["--scale"],
    );
}

#[test]
fn exports_go_to_files_or_standard_output_and_say_what_is_missing() {
    let folder = directory();
    let path = recording(folder.path());
    let lines = run(&["export", text(&path), "--format", "ndjson"]);
    assert_eq!(stdout(&lines), stdout(&run(&["replay", "--json"])));
    let csv = folder.path().join("estimates.csv");
    let output = run(&["export", text(&path), "--format", "csv", "-o", text(&csv)]);
    assert!(
        output.status.success() && stdout(&output).is_empty(),
        "{}",
        stderr(&output)
    );
    assert!(stderr(&output).contains("packets received, 0 lost, 0 damaged"));
    assert!(
        std::fs::read_to_string(&csv)
            .expect("a file")
            .starts_with("t_s,window_s,span,")
    );
    // A recording must not be overwritten, because it cannot be made again.
    let before = std::fs::read(&path).expect("a file");
    for over in [
        &["export", text(&path), "--format", "csv", "-o", text(&path)][..],
        &["emulate", "--print-scene", text(&path)],
    ] {
        assert_one_line(&run(over), 1, &[text(&path), "not overwritten"]);
        assert_eq!(std::fs::read(&path).expect("a file"), before);
    }
    let mcap = folder.path().join("touch.mcap");
    assert!(
        run(&["export", text(&path), "--format", "mcap", "-o", text(&mcap)])
            .status
            .success()
    );
    // Magic bytes of the format, at both ends (mcap.dev).
    let bytes = std::fs::read(&mcap).expect("a file");
    assert!(bytes.starts_with(b"\x89MCAP0\r\n") && bytes.ends_with(b"\x89MCAP0\r\n"));
    let frames = folder.path().join("frames.csv");
    let none = run(&[
        "export",
        text(&path),
        "--format",
        "csv",
        "--table",
        "frames",
        "-o",
        text(&frames),
    ]);
    assert_one_line(&none, 1, &["record with --raw"]);
    assert!(!frames.exists());
    assert_one_line(
        &run(&[
            "export",
            text(&path),
            "--format",
            "mcap",
            "--table",
            "health",
        ]),
        2,
        &["--table"],
    );
    let table = file(folder.path(), "table.csv", "time_s,ain0\n0,1\n");
    assert_one_line(
        &run(&["export", text(&table), "--format", "ndjson"]),
        1,
        &["table.csv", "no telemetry"],
    );
}

#[test]
fn options_that_do_not_go_together_and_missing_boards_are_refused_on_one_line() {
    let folder = directory();
    let path = recording(folder.path());
    assert_one_line(
        &run(&["monitor", "--file", text(&path), "--emulated"]),
        2,
        &["--file", "--emulated"],
    );
    assert_one_line(
        &run(&["monitor", "--file", text(&path), "--elf", "a.elf"]),
        2,
        &["--emulated"],
    );
    let table = file(folder.path(), "table.csv", "time_s,ain0\n0,1\n");
    for option in [&[][..], &["--file"]] {
        for (command, parts) in [
            ("monitor", &["use `ridgetone view ", "table.csv`"][..]),
            ("view", &["table.csv: one row alone"]),
        ] {
            let arguments = [&[command], option, &[text(&table)]].concat();
            assert_one_line(&run(&arguments), 1, parts);
        }
    }
    assert_one_line(
        &run(&["monitor", "--port", &board_name()]),
        1,
        &["no such port"],
    );
    assert_one_line(
        &run(&["monitor", "--file", "no such file"]),
        1,
        &["no such file"],
    );
    assert_one_line(
        &run(&["monitor", "--file", text(&path), "--pace", "-1"]),
        2,
        &["--pace"],
    );
    assert_one_line(
        &run(&["settings", "get", "--port", &board_name()]),
        1,
        &["no such port"],
    );
    // Bounds and their reasons must be printed before the command looks for a board.
    let port = board_name();
    assert_one_line(
        &run(&["settings", "set", "window_s=9", "--port", &port]),
        2,
        &["0.1 to 3.9", "memory"],
    );
    assert_one_line(
        &run(&["settings", "set", "windows=1", "--port", &port]),
        2,
        &["no setting `windows`", "window_s"],
    );
    assert_one_line(
        &run(&["settings", "set", "--port", &port]),
        2,
        &["NAME=VALUE"],
    );
}

#[test]
fn one_file_of_settings_serves_all_and_options_go_over_it() {
    let folder = directory();
    let settings = file(
        folder.path(),
        "finger.toml",
        "window_s = 0.5\nharmonics = 2\n[array]\nperiod_max_mm = 3.9\n",
    );
    let hello = |arguments: &[&str]| json_lines(&run(arguments))[0]["settings"].clone();
    let found = hello(&["replay", "--json", "--settings", text(&settings)]);
    assert_eq!(
        (&found["window_s"], &found["harmonics"]),
        (&0.5.into(), &2.into())
    );
    assert!((found["array"]["period_max_mm"].as_f64().expect("a number") - 3.9).abs() < 1e-6);
    let found = hello(&[
        "replay",
        "--json",
        "--settings",
        text(&settings),
        "--window",
        "0.7",
    ]);
    assert_eq!(
        (
            found["window_s"].as_f64().map(|s| (s * 1e3).round()),
            &found["harmonics"]
        ),
        (Some(700.0), &2.into())
    );
    let table = file(folder.path(), "tone.csv", &tone(2, 1000, 241.0, 8.0, 0.0));
    let harmonics = |arguments: &[&str]| {
        let given = ["fit", "--json", text(&table), "--settings", text(&settings)];
        json_lines(&run(&[&given[..], arguments].concat()))[0]["harmonics"].clone()
    };
    assert_eq!(
        (harmonics(&[]), harmonics(&["--harmonics", "1"])),
        (2.into(), 1.into())
    );
    let wrong = file(folder.path(), "wrong.toml", "window_s = 7\n");
    assert_one_line(
        &run(&["fit", text(&table), "--settings", text(&wrong)]),
        1,
        &["wrong.toml", "0.1 to 3.9"],
    );
    assert_one_line(
        &run(&["replay", "--settings", text(&wrong)]),
        1,
        &["wrong.toml", "0.1 to 3.9", "memory"],
    );
}

#[test]
fn ports_lists_what_there_is_or_says_why_not() {
    let output = run(&["ports", "--json"]);
    if output.status.success() {
        assert!(
            stdout(&output)
                .lines()
                .all(|line| line.starts_with("{\"name\":"))
        );
        assert_eq!(
            stdout(&output).is_empty(),
            stderr(&output).contains("no serial port")
        );
    } else {
        assert_one_line(&output, 1, &["cannot be listed"]);
    }
}

/// On a real terminal the screen must appear, respond to keys, and restore the terminal at the end.
#[test]
fn the_screen_comes_on_a_terminal_and_goes_without_a_trace() {
    let folder = directory();
    let path = recording(folder.path());
    let mut terminal = Terminal::new(80, 24);
    let end = terminal.other_end();
    let mut child = common::ridgetone()
        .args(["monitor", "--file", text(&path), "--pace", "0"])
        .env("TERM", "xterm")
        .stdin(end.try_clone().expect("an end"))
        .stdout(end)
        .stderr(Stdio::piped())
        .spawn()
        .expect("the command runs");
    terminal.read_until("touch.rec  over");
    // The screen is drawn in pieces; this text is near the end.
    terminal.read_until("overruns");
    for part in [
        "frequency, Hz",
        "static image after",
        "health: OK",
        "no raw frames",
        "8.33342 ± 0.00022 Hz",
        "q quit",
    ] {
        assert!(
            terminal.shows(part),
            "{part:?} is not on\n{}",
            terminal.screen().contents()
        );
    }
    // All text must have the terminal's own colours, so that it is readable on any background.
    for place in 0..80 * 24 {
        let cell = terminal
            .screen()
            .cell(place / 80, place % 80)
            .expect("a cell");
        assert_eq!(
            (cell.fgcolor(), cell.bgcolor()),
            (vt100::Color::Default, vt100::Color::Default),
            "{place}"
        );
    }
    assert!(terminal.screen().alternate_screen());
    terminal.send(b"h");
    terminal.read_until("any key closes this");
    terminal.send(b"x");
    terminal.send(b"q");
    assert!(child.wait().expect("ended").success());
    terminal.read_to_end();
    // The previous content and the cursor must be restored.
    assert!(!terminal.screen().alternate_screen() && !terminal.screen().hide_cursor());
    assert_eq!(terminal.screen().contents(), "");
    let mut lines = BufReader::new(child.stderr.take().expect("a pipe")).lines();
    assert!(
        lines
            .next()
            .expect("a line")
            .expect("UTF-8")
            .contains("0 lost, 0 damaged")
    );
}

#[test]
fn a_terminal_that_is_closed_ends_the_screen() {
    let folder = directory();
    let path = recording(folder.path());
    assert_ends_with_its_terminal(&path, |_| Stdio::null());
    // Standard error goes to the same terminal, as in a shell.
    assert_ends_with_its_terminal(&path, |end| end.into());
}

fn assert_ends_with_its_terminal(path: &Path, stderr: impl Fn(File) -> Stdio) {
    let mut terminal = Terminal::new(80, 24);
    let end = terminal.other_end();
    // The child stays in this test's session, so it gets no signal when the terminal closes.
    let mut child = common::ridgetone()
        .args(["monitor", "--file", text(path), "--pace", "0"])
        .env("TERM", "xterm")
        .stdin(end.try_clone().expect("an end"))
        .stderr(stderr(end.try_clone().expect("an end")))
        .stdout(end)
        .spawn()
        .expect("the command runs");
    terminal.read_until("touch.rec  over");
    drop(terminal);
    let closed = Instant::now();
    let status = loop {
        if let Some(status) = child.try_wait().expect("a child") {
            break status;
        }
        if closed.elapsed() > Duration::from_secs(5) {
            child.kill().expect("killed");
            panic!("the command goes on without its terminal");
        }
        std::thread::sleep(Duration::from_millis(20));
    };
    assert!(status.code().is_some(), "it aborts: {status}");
}

#[test]
fn a_plotter_gets_a_line_for_each_good_estimate() {
    let folder = directory();
    let path = recording(folder.path());
    let monitor = |option| run(&["monitor", option, "--file", text(&path), "--pace", "0"]);
    let expected: Vec<_> = json_lines(&monitor("--json"))
        .into_iter()
        .filter(|line| line["type"] == "estimate" && line["status"] == "good")
        .map(|line| ["frequency_hz", "sigma_hz"].map(|name| line[name].as_f64().expect("a number")))
        .collect();
    let plotted: Vec<_> = stdout(&monitor("--plotter"))
        .lines()
        .map(|line| {
            let (hz, sigma) = line.split_once(",sigma:").expect("two values");
            let hz = hz.strip_prefix("Hz:").expect("a name");
            [hz, sigma].map(|value| value.parse::<f64>().expect("a number"))
        })
        .collect();
    assert!(expected.len() > 3);
    assert_eq!(plotted, expected);
}
