//! Tests `check` as a command: exit status and report files. A complete run is in `emulated.rs`.
#![cfg(target_os = "linux")]

mod common;
#[path = "common/ram_flash.rs"]
mod ram_flash;
#[path = "common/terminal.rs"]
mod terminal;

use common::{assert_one_line, directory, file, ridgetone, run, stderr, stdout, text};
use hal_mock::SimulatedBoard;
use ram_flash::RamFlash;
use ridgetone_finger::tasks::Received;
use ridgetone_host::input::Opened;
use ridgetone_host::simulated::{self, Start, Surroundings};
use ridgetone_proto::boot::{Boot, SettingsSource};
use ridgetone_proto::settings::{FRAME_RATE_HZ, Settings};
use ridgetone_proto::store::Store;
use ridgetone_proto::telemetry::{Event, Hello, PROTOCOL, Packet, WIRE_MAX, encode};
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::process::{Pid, Signal, kill_process};
use serde_json::json;
use std::io::{Read, Write};
use std::process::{Child, Stdio};
use terminal::Terminal;

#[test]
fn what_makes_no_sense_is_refused_and_a_report_is_not_overwritten() {
    let folder = directory();
    let old = file(folder.path(), "check.txt", "an older report\n");
    for (arguments, status, words) in [
        (vec!["--for", "0"], 2, "--for"),
        (vec!["--inputs", "wet"], 2, "wet"),
        (
            vec!["--port", "/dev/none", "-o", text(&old)],
            1,
            "check.txt",
        ),
        (vec!["--port", "/dev/none"], 1, "/dev/none"),
    ] {
        assert_one_line(&run(&[vec!["check"], arguments].concat()), status, &[words]);
    }
    let kept = std::fs::read_to_string(&old).expect("a file");
    assert_eq!(kept, "an older report\n");
}

/// Starts `check` at a pseudo-terminal and waits for its first request. Returns the command, the
/// terminal's name and the board's end of the line.
fn start(arguments: &[&str]) -> (Child, String, std::fs::File) {
    let terminal = Terminal::new(80, 24);
    let (name, mut line) = (terminal.name.clone(), terminal.into_file());
    let mut check = ridgetone();
    check.args(["check", "--port", &name]).args(arguments);
    let check = check.stdout(Stdio::piped()).stderr(Stdio::piped());
    let child = check.spawn().expect("the command runs");
    assert!(line.read(&mut [0; 64]).expect("a request") > 0);
    (child, name, line)
}

/// The board uses a different protocol, so the check must fail.
#[test]
fn a_check_that_fails_is_reported_and_is_the_exit_status() {
    let folder = directory();
    let event = Event::Hello(Hello {
        protocol: PROTOCOL + 1,
        version: [9, 9, 9],
        frame_rate_hz: FRAME_RATE_HZ,
        settings: Settings::DEFAULT,
        source: SettingsSource::Default,
        boot: Boot::default(),
        t_us: 0,
    });
    let mut wire = [0; WIRE_MAX];
    let length = encode(&Packet { sequence: 0, event }, &mut wire).expect("it fits");
    for name_of_report in ["report.json", "report.txt"] {
        let report = folder.path().join(name_of_report);
        let (child, name, mut board) = start(&["--json", "-o", text(&report)]);
        board.write_all(&wire[..length]).expect("written");
        let output = child.wait_with_output().expect("it ends");
        assert_eq!(output.status.code(), Some(1));
        assert!(
            stderr(&output).contains("failed: firmware"),
            "{}",
            stderr(&output)
        );
        let printed = stdout(&output);
        let lines = printed.lines().map(serde_json::from_str);
        let lines: Vec<serde_json::Value> = lines.collect::<Result<_, _>>().expect("JSON");
        let (summary, checks) = lines.split_last().expect("lines");
        for (object, key, value) in [
            (&checks[0], "type", json!("check")),
            (&checks[0], "name", json!("firmware")),
            (&checks[0], "verdict", json!("fail")),
            (summary, "type", json!("summary")),
            (summary, "verdict", json!("fail")),
            (summary, "failed", json!(1)),
            (summary, "board", json!(name)),
        ] {
            assert_eq!(object[key], value, "{key}");
        }
        let written = std::fs::read_to_string(&report).expect("a report");
        if name_of_report.ends_with(".json") {
            let whole: serde_json::Value = serde_json::from_str(&written).expect("JSON");
            assert_eq!(whole, json!({ "summary": summary, "checks": checks }));
        } else {
            let mut lines = written.lines();
            let line = lines
                .find(|line| line.contains(" firmware  "))
                .expect("a line");
            let page = "-> docs/guide/2-build.md#flash-and-check";
            assert!(line.starts_with("fail ") && line.ends_with(page), "{line}");
        }
    }
}

/// Board's end of a terminal. At the second start, when the changed settings are in flash, it
/// interrupts the command, and then is silent until it receives something.
struct Pressed<'a> {
    line: std::fs::File,
    child: &'a Child,
    starts: u32,
    is_silent: bool,
}

impl Surroundings for Pressed<'_> {
    fn started(&mut self, _: &SimulatedBoard, _: bool) -> anyhow::Result<()> {
        self.starts += 1;
        if self.starts == 2 {
            self.is_silent = true;
            kill_process(Pid::from_child(self.child), Signal::INT)?;
        }
        Ok(())
    }

    fn exchange(&mut self, _: &SimulatedBoard, sent: &[u8]) -> anyhow::Result<Vec<Received>> {
        if sent.is_empty() {
            return Ok(Vec::new());
        }
        if !self.is_silent {
            self.line.write_all(sent)?;
        }
        let mut fds = [PollFd::new(&self.line, PollFlags::IN)];
        let is_there = poll(&mut fds, Some(&Timespec::default()))? > 0;
        let mut bytes = [0; 256];
        let length = if is_there {
            self.line.read(&mut bytes)?
        } else {
            0
        };
        self.is_silent &= length == 0;
        Ok(bytes[..length]
            .iter()
            .map(|byte| Received::Byte(*byte))
            .collect())
    }
}

/// If the command is interrupted while its own settings are stored, it must still restore the
/// original settings.
#[test]
fn ctrl_c_in_the_middle_restores_the_settings() {
    let stored = Settings {
        window_s: 0.5,
        ..Settings::DEFAULT
    };
    for (before, source) in [
        (None, SettingsSource::Default),
        (Some(stored), SettingsSource::Stored),
    ] {
        let (flash, boot) = (RamFlash::default(), Boot::default());
        let start_anew = || Start::new(flash.clone(), boot.clone());
        if let Some(settings) = before {
            assert!(start_anew().store.save(Some(&settings), true).is_ok());
        }
        let (child, _, line) = start(&["--for", "1"]);
        let mut pressed = Pressed {
            line,
            child: &child,
            starts: 0,
            is_silent: false,
        };
        // The run ends when the command closes the line.
        let ended = simulated::run(Opened::untouched(), start_anew(), &mut pressed);
        assert!(
            ended.is_err() && pressed.starts == 2,
            "{} starts",
            pressed.starts
        );
        let output = child.wait_with_output().expect("it ends");
        assert_eq!(output.status.code(), Some(1), "{}", stderr(&output));
        for words in ["not stored: interrupted", "It ended early: interrupted"] {
            assert!(stdout(&output).contains(words), "{}", stdout(&output));
        }
        let found = start_anew();
        assert_eq!(
            (found.settings, found.source),
            (before.unwrap_or_default(), source)
        );
    }
}
