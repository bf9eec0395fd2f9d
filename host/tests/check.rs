//! `check` as a command: exit status, report files; a whole run is in `emulated.rs`.
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
use std::io::{Read, Write};
use std::process::{Child, Stdio};
use terminal::Terminal;

#[test]
fn what_makes_no_sense_is_refused_and_a_report_is_not_overwritten() {
    let folder = directory();
    let old = file(folder.path(), "check.txt", "an older report\n");
    assert_one_line(&run(&["check", "--for", "0"]), 2, &["--for"]);
    assert_one_line(&run(&["check", "--inputs", "wet"]), 2, &["wet"]);
    assert_one_line(
        &run(&["check", "--port", "/dev/none", "-o", text(&old)]),
        1,
        &["check.txt", "exists"],
    );
    assert_one_line(&run(&["check", "--port", "/dev/none"]), 1, &["/dev/none"]);
    assert_eq!(
        std::fs::read_to_string(&old).expect("a file"),
        "an older report\n"
    );
}

/// A board of another protocol, at a pseudo-terminal.
#[test]
fn a_check_that_fails_is_reported_and_is_the_exit_status() {
    let folder = directory();
    let (settings, source, boot) = (Settings::DEFAULT, SettingsSource::Default, Boot::default());
    let (protocol, version, frame_rate_hz) = (PROTOCOL + 1, [9, 9, 9], FRAME_RATE_HZ);
    let hello = Hello {
        protocol,
        version,
        frame_rate_hz,
        settings,
        source,
        boot,
        t_us: 0,
    };
    let mut wire = [0; WIRE_MAX];
    let length = encode(
        &Packet {
            sequence: 0,
            event: Event::Hello(hello),
        },
        &mut wire,
    )
    .expect("it fits");
    for name_of_report in ["report.json", "report.txt"] {
        let terminal = Terminal::new(80, 24);
        let (name, mut board) = (terminal.name.clone(), terminal.into_file());
        let report = folder.path().join(name_of_report);
        let child = ridgetone()
            .args(["check", "--json", "--port", &name, "-o", text(&report)])
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .expect("the command runs");
        // The command has opened the line when its first request arrives.
        assert!(board.read(&mut [0; 64]).expect("a request") > 0);
        board.write_all(&wire[..length]).expect("written");
        let output = child.wait_with_output().expect("it ends");
        assert_eq!(output.status.code(), Some(1));
        assert!(
            stderr(&output).contains("failed: firmware"),
            "{}",
            stderr(&output)
        );
        let lines: Vec<serde_json::Value> = stdout(&output)
            .lines()
            .map(|line| serde_json::from_str(line).expect("JSON"))
            .collect();
        let (summary, checks) = lines.split_last().expect("lines");
        let firmware = &checks[0];
        assert_eq!(
            (&firmware["type"], &firmware["name"], &firmware["verdict"]),
            (&"check".into(), &"firmware".into(), &"fail".into())
        );
        assert_eq!(
            (&summary["type"], &summary["verdict"], &summary["failed"]),
            (&"summary".into(), &"fail".into(), &1.into())
        );
        assert_eq!(summary["board"], name.as_str());
        let written = std::fs::read_to_string(&report).expect("a report");
        if name_of_report.ends_with(".json") {
            let whole: serde_json::Value = serde_json::from_str(&written).expect("JSON");
            assert_eq!(
                (
                    &whole["summary"],
                    whole["checks"].as_array().expect("checks").as_slice()
                ),
                (summary, checks)
            );
        } else {
            let line = written
                .lines()
                .find(|line| line.contains(" firmware  "))
                .expect("a line");
            assert!(
                line.starts_with("fail ")
                    && line.ends_with("-> docs/guide/2-build.md#flash-and-check"),
                "{line}"
            );
        }
    }
}

/// The board's end of a terminal. At the second start, with the changed settings in the flash,
/// Ctrl-C is pressed; from then on the board is silent until it hears something.
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

/// Interrupted while its own settings are stored, the command still restores what was stored
/// before.
#[test]
fn ctrl_c_in_the_middle_restores_the_settings() {
    for before in [
        None,
        Some(Settings {
            window_s: 0.5,
            ..Settings::DEFAULT
        }),
    ] {
        let (flash, boot) = (RamFlash::default(), Boot::default());
        if let Some(settings) = before {
            let mut start = Start::new(flash.clone(), boot.clone());
            assert!(start.store.save(Some(&settings), true).is_ok());
        }
        let terminal = Terminal::new(80, 24);
        let (name, line) = (terminal.name.clone(), terminal.into_file());
        let child = ridgetone()
            .args(["check", "--for", "1", "--port", &name])
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .expect("the command runs");
        let mut pressed = Pressed {
            line,
            child: &child,
            starts: 0,
            is_silent: false,
        };
        // The command has opened the line when its first request arrives.
        assert!(pressed.line.read(&mut [0; 64]).expect("a request") > 0);
        // It ends when the command has closed its end.
        let ended = simulated::run(
            Opened::untouched(),
            Start::new(flash.clone(), boot.clone()),
            &mut pressed,
        );
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
        let start = Start::new(flash, boot);
        let source = if before.is_some() {
            SettingsSource::Stored
        } else {
            SettingsSource::Default
        };
        assert_eq!(
            (start.settings, start.source),
            (before.unwrap_or_default(), source)
        );
    }
}
