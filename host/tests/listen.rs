//! Tests `monitor --plain` at a pseudo-terminal.
#![cfg(target_os = "linux")]

mod common;

use ridgetone_host::events;
use ridgetone_proto::boot::{Boot, SettingsSource};
use ridgetone_proto::settings::Settings;
use ridgetone_proto::telemetry::{
    Contact, Event, Hello, PROTOCOL, Packet, Release, WIRE_MAX, encode,
};
use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
use std::fs::File;
use std::io::{BufRead, BufReader, Read, Write};
use std::process::{Child, ChildStderr, Stdio};

/// Returns the board's end of a line, and the name of the far end.
fn pty() -> (File, String) {
    // The command must not inherit this end, or the board could never be unplugged.
    let end =
        openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY | OpenptFlags::CLOEXEC).expect("a terminal");
    grantpt(&end).expect("granted");
    unlockpt(&end).expect("unlocked");
    let name = ptsname(&end, Vec::new())
        .expect("a name")
        .into_string()
        .expect("ASCII");
    (File::from(end), name)
}

#[test]
fn telemetry_is_printed_as_json_and_a_disconnection_is_reported() {
    let (mut board, name) = pty();
    let mut child = common::ridgetone()
        .args(["monitor", "--json", "--port", &name])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the command runs");
    let mut messages = BufReader::new(child.stderr.take().expect("a pipe")).lines();
    let mut out = BufReader::new(child.stdout.take().expect("a pipe")).lines();
    let next = |lines: &mut dyn Iterator<Item = std::io::Result<String>>| {
        lines.next().expect("a line").expect("UTF-8")
    };
    assert_eq!(next(&mut messages), format!("ridgetone: {name}: open"));

    // Start in the middle of a frame, as with a board that is already running.
    board.write_all(&[17, 4, 0]).expect("written");
    for sequence in [7, 8, 11] {
        let contact = Contact {
            t_us: 1_500_000 + u64::from(sequence),
            taxel: 3,
            height_v: 0.02,
            onset_us: 0,
            reported_after_us: 0,
        };
        let packet = Packet {
            sequence,
            event: Event::Contact(contact),
        };
        let mut wire = [0; WIRE_MAX];
        let used = encode(&packet, &mut wire).expect("it fits");
        board.write_all(&wire[..used]).expect("written");
        let (line, expected) = (next(&mut out), events::json(&packet).expect("JSON"));
        // The fields are followed by the time of receipt and the time of the event.
        let (begin, beside) = line.split_at(expected.len() - 1);
        assert_eq!(begin, &expected[..expected.len() - 1]);
        let object: serde_json::Value = serde_json::from_str(&line).expect("JSON");
        let second = |name: &str| object[name].as_f64().expect("a time");
        assert!(
            beside.starts_with(",\"received_utc_s\":")
                && second("utc_s") <= second("received_utc_s"),
            "{line}"
        );
        let now = std::time::SystemTime::now()
            .duration_since(std::time::UNIX_EPOCH)
            .expect("a clock")
            .as_secs_f64();
        assert!(
            (now - second("received_utc_s")).abs() < 10.0 && object["utc_sigma_s"].is_null(),
            "{line}"
        );
    }
    assert_eq!(
        next(&mut messages),
        "ridgetone: 2 packets lost, 1 damaged so far"
    );
    drop(board);
    let gone = next(&mut messages);
    assert!(
        gone.starts_with(&format!("ridgetone: {name}: "))
            && gone.ends_with("; waiting for the board"),
        "{gone}"
    );
    assert!(child.try_wait().expect("a child").is_none(), "it waits");
    child.kill().expect("killed");
    child.wait().expect("ended");
}

/// Only damaged frames are sent, as at a wrong baud rate, so no sequence number reveals a loss.
#[test]
fn damage_without_end_is_reported() {
    let (mut board, name) = pty();
    let mut child = common::ridgetone()
        .args(["monitor", "--plain", "--port", &name])
        .stderr(Stdio::piped())
        .spawn()
        .expect("the command runs");
    let mut messages = BufReader::new(child.stderr.take().expect("a pipe")).lines();
    assert_eq!(
        messages.next().expect("a line").expect("UTF-8"),
        format!("ridgetone: {name}: open")
    );
    for _ in 0..30 {
        board.write_all(&[17, 4, 33, 0]).expect("written");
        std::thread::sleep(std::time::Duration::from_millis(50));
    }
    let last = messages.next().expect("a line").expect("UTF-8");
    assert!(
        last.starts_with("ridgetone: 0 packets lost, ") && last.ends_with(" damaged so far"),
        "{last}"
    );
    child.kill().expect("killed");
    child.wait().expect("ended");
}

#[test]
fn a_board_that_is_not_there_is_reported_on_one_line() {
    let folder = common::directory();
    let name = folder.path().join("none");
    common::assert_one_line(
        &common::run(&["monitor", "--plain", "--port", common::text(&name)]),
        1,
        &[common::text(&name)],
    );
    let nobody = common::run(&["monitor", "--plain", "--usb-serial", "no such number"]);
    common::assert_one_line(&nobody, 1, &["port"]);
    let both = common::run(&["monitor", "--plain", "--port", "a", "--usb-serial", "b"]);
    common::assert_one_line(&both, 2, &["--port"]);
}

/// Starts `monitor --json` at a board's line, and waits until the line is open.
fn listening() -> (File, Child, BufReader<ChildStderr>) {
    let (board, name) = pty();
    let mut child = common::ridgetone()
        .args(["monitor", "--json", "--port", &name])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the command runs");
    let mut messages = BufReader::new(child.stderr.take().expect("a pipe"));
    let mut open = String::new();
    messages.read_line(&mut open).expect("a line");
    assert_eq!(open, format!("ridgetone: {name}: open\n"));
    (board, child, messages)
}

/// Waits for the command to end. Returns its standard output and standard error.
fn ended(child: Child, mut messages: BufReader<ChildStderr>) -> (String, String) {
    let output = child.wait_with_output().expect("it ends");
    let mut report = String::new();
    messages.read_to_string(&mut report).expect("UTF-8");
    (common::stdout(&output), report)
}

fn send(board: &mut File, sequence: u16, event: Event) {
    let mut wire = [0; WIRE_MAX];
    let used = encode(&Packet { sequence, event }, &mut wire).expect("it fits");
    board.write_all(&wire[..used]).expect("written");
}

/// The board's greeting must be checked before packets are printed, because they would be misread.
#[test]
fn a_board_with_another_protocol_is_refused_before_anything_is_printed() {
    let (mut board, child, messages) = listening();
    let release = Event::Release(Release {
        t_us: 5,
        reported_after_us: 0,
    });
    let foreign = Hello {
        protocol: PROTOCOL + 1,
        version: [0, 1, 0],
        frame_rate_hz: 241.14,
        settings: Settings::DEFAULT,
        source: SettingsSource::Default,
        boot: Boot::default(),
        t_us: 0,
    };
    send(&mut board, 700, release.clone());
    let mut heard = [0; 1];
    board.read_exact(&mut heard).expect("a request");
    send(&mut board, 701, release);
    send(&mut board, 702, Event::Hello(foreign));
    let (printed, report) = ended(child, messages);
    assert_eq!(printed, "");
    assert!(report.contains("speaks protocol"), "{report}");
}

#[test]
fn a_packet_that_comes_twice_is_printed_once_and_counted() {
    let (mut board, child, messages) = listening();
    for (sequence, t_us) in [(7, 5), (7, 5), (8, 6), (8, 6), (9, 7)] {
        send(
            &mut board,
            sequence,
            Event::Release(Release {
                t_us,
                reported_after_us: 0,
            }),
        );
    }
    std::thread::sleep(std::time::Duration::from_secs(3));
    let process = rustix::process::Pid::from_child(&child);
    rustix::process::kill_process(process, rustix::process::Signal::INT).expect("interrupted");
    let (printed, report) = ended(child, messages);
    assert_eq!(printed.lines().count(), 3, "{printed}");
    let counts = "3 packets received, 0 lost, 0 damaged, 2 repeated";
    assert!(report.contains(counts), "{report}");
}
