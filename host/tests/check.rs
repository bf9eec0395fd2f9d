//! `check` as a command: exit status, report files; a whole run is in `emulated.rs`.
#![cfg(target_os = "linux")]

mod common;
#[path = "common/terminal.rs"]
mod terminal;

use common::{assert_one_line, directory, file, ridgetone, run, stderr, stdout, text};
use ridgetone_proto::boot::{Boot, SettingsSource};
use ridgetone_proto::settings::{FRAME_RATE_HZ, Settings};
use ridgetone_proto::telemetry::{Event, Hello, PROTOCOL, Packet, WIRE_MAX, encode};
use std::io::{Read, Write};
use terminal::Terminal;

#[test]
fn what_makes_no_sense_is_refused_and_a_report_is_not_overwritten() {
    let folder = directory();
    let old = file(folder.path(), "check.txt", "an older report\n");
    assert_one_line(&run(&["check", "--for", "0"]), 2, &["--for"]);
    assert_one_line(&run(&["check", "--inputs", "wet"]), 2, &["wet"]);
    assert_one_line(&run(&["check", "--port", "/dev/none", "-o", text(&old)]), 1, &["check.txt", "exists"]);
    assert_one_line(&run(&["check", "--port", "/dev/none"]), 1, &["/dev/none"]);
    assert_eq!(std::fs::read_to_string(&old).expect("a file"), "an older report\n");
}

/// A board of another protocol, at a pseudo-terminal.
#[test]
fn a_check_that_fails_is_reported_and_is_the_exit_status() {
    let folder = directory();
    let (settings, source, boot) = (Settings::DEFAULT, SettingsSource::Default, Boot::default());
    let (protocol, version, frame_rate_hz) = (PROTOCOL + 1, [9, 9, 9], FRAME_RATE_HZ);
    let hello = Hello { protocol, version, frame_rate_hz, settings, source, boot };
    let mut wire = [0; WIRE_MAX];
    let length = encode(&Packet { sequence: 0, event: Event::Hello(hello) }, &mut wire).expect("it fits");
    for name_of_report in ["report.json", "report.txt"] {
        let terminal = Terminal::new(80, 24);
        let (name, mut board) = (terminal.name.clone(), terminal.into_file());
        let report = folder.path().join(name_of_report);
        let child = ridgetone()
            .args(["check", "--json", "--port", &name, "-o", text(&report)])
            .stdout(std::process::Stdio::piped())
            .stderr(std::process::Stdio::piped())
            .spawn()
            .expect("the command runs");
        // The command has opened the line when its first request arrives.
        assert!(board.read(&mut [0; 64]).expect("a request") > 0);
        board.write_all(&wire[..length]).expect("written");
        let output = child.wait_with_output().expect("it ends");
        assert_eq!(output.status.code(), Some(1));
        assert!(stderr(&output).contains("failed: firmware"), "{}", stderr(&output));
        let lines: Vec<serde_json::Value> =
            stdout(&output).lines().map(|line| serde_json::from_str(line).expect("JSON")).collect();
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
            assert_eq!((&whole["summary"], whole["checks"].as_array().expect("checks").as_slice()), (summary, checks));
        } else {
            let line = written.lines().find(|line| line.contains(" firmware  ")).expect("a line");
            assert!(line.starts_with("fail ") && line.ends_with("-> docs/book/2-first-run.md"), "{line}");
        }
    }
}
