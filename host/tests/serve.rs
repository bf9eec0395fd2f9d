//! Tests `serve` with JSON lines at pseudo-terminals. MQTT and Foxglove are in `streams.rs`.
#![cfg(target_os = "linux")]

mod common;
#[path = "common/serial_board.rs"]
mod serial_board;

use ridgetone_host::input::Input;
use ridgetone_host::recording::{self, Keep};
use ridgetone_host::replay;
use ridgetone_proto::settings::Settings;
use rustix::process::{Pid, Signal, kill_process};
use serde_json::Value;
use serial_board::SerialBoard;
use std::collections::BTreeMap;
use std::io::{BufRead, BufReader, Lines, Read};
use std::process::{Child, ChildStdout, Command, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

/// `serve`, printing JSON lines.
struct Serving {
    child: Child,
    lines: Lines<BufReader<ChildStdout>>,
}

impl Serving {
    fn start(fingers: &[&str]) -> Self {
        let mut command = common::ridgetone();
        command
            .arg("serve")
            .arg("--json")
            .args(fingers.iter().flat_map(|finger| ["--finger", finger]));
        let mut child = piped(&mut command).spawn().expect("the command runs");
        let lines = BufReader::new(child.stdout.take().expect("a pipe")).lines();
        Self { child, lines }
    }

    fn next(&mut self) -> Option<(String, Value)> {
        let line = self.lines.next()?.expect("UTF-8");
        let mut object: Value = serde_json::from_str(&line).expect("JSON");
        Some((
            object["topic"].as_str().expect("a topic").to_owned(),
            object["message"].take(),
        ))
    }

    /// Interrupts the command like Ctrl-C, and asserts that it succeeds. Returns the remaining
    /// messages and its report.
    fn interrupt(mut self) -> (Vec<(String, Value)>, String) {
        let pid = Pid::from_raw(self.child.id() as i32).expect("a process");
        kill_process(pid, Signal::INT).expect("interrupted");
        self.finish()
    }

    fn finish(&mut self) -> (Vec<(String, Value)>, String) {
        let mut rest = Vec::new();
        while let Some(message) = self.next() {
            rest.push(message);
        }
        let mut report = String::new();
        self.child
            .stderr
            .take()
            .expect("a pipe")
            .read_to_string(&mut report)
            .expect("UTF-8");
        assert!(self.child.wait().expect("ended").success(), "{report}");
        (rest, report)
    }
}

fn piped(command: &mut Command) -> &mut Command {
    command
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
}

/// Asserts that every topic's messages are numbered from 0 without gaps. Returns their numbers.
fn counted(messages: &[(String, Value)]) -> BTreeMap<String, u64> {
    let mut counts = BTreeMap::new();
    for (topic, message) in messages {
        let count = counts.entry(topic.clone()).or_insert(0);
        assert_eq!(
            message["index"].as_u64(),
            Some(*count),
            "{topic}: {message}"
        );
        *count += 1;
    }
    counts
}

#[test]
fn fingers_are_served_beside_one_that_is_not_there() {
    let (left, right) = (SerialBoard::new(), SerialBoard::new());
    let fingers = [
        format!("left={}", left.name),
        format!("right={}", right.name),
        "gone=/dev/no-such-port".to_owned(),
    ];
    let mut serving = Serving::start(&fingers.each_ref().map(String::as_str));
    let mut messages = Vec::new();
    let of = |messages: &[(String, Value)], topic: &str| {
        messages.iter().filter(|(found, _)| found == topic).count()
    };
    while ["left", "right"]
        .iter()
        .any(|name| of(&messages, &format!("/ridgetone/{name}/frames")) < 400)
    {
        messages.push(serving.next().expect("a message"));
    }
    let (rest, report) = serving.interrupt();
    messages.extend(rest);
    let counts = counted(&messages);
    for (name, board) in [("left", &left), ("right", &right)] {
        let path = |topic: &str| format!("/ridgetone/{name}/{topic}");
        assert!(
            counts[&path("frames")] >= 400 && counts[&path("health")] >= 1,
            "{counts:?}"
        );
        let found = |kind: &str| {
            messages
                .iter()
                .find(|(topic, message)| topic.starts_with(&path("")) && message["type"] == kind)
        };
        assert_eq!(
            found("hello").expect("a greeting").1["positions_mm"][4],
            serde_json::json!([1.15, 1.15])
        );
        let frames: Vec<&Value> = messages
            .iter()
            .filter(|(topic, _)| *topic == path("frames"))
            .map(|(_, m)| m)
            .collect();
        let numbers = frames
            .iter()
            .map(|frame| frame["number"].as_u64().expect("a number"));
        assert!(
            numbers.eq(0..frames.len() as u64),
            "every frame in its order"
        );
        // Compares the board's time in UTC with its true start.
        let last = frames[frames.len() - 1];
        let off_s = last["utc_s"].as_f64().expect("a time")
            - last["t_s"].as_f64().expect("a time")
            - board.begun_utc_s();
        assert!(off_s.abs() < 0.02, "{off_s}");
        assert!(
            last["volts"][15].is_number() && last["utc_sigma_s"].is_number(),
            "{last}"
        );
    }
    let failed = messages
        .iter()
        .filter(|(topic, _)| topic == "/ridgetone/gone/diagnostics")
        .collect::<Vec<_>>();
    assert_eq!(
        (failed.len(), &failed[0].1["state"]),
        (1, &Value::from("failed")),
        "once, not at every attempt"
    );
    assert!(
        report.contains("ridgetone: gone: /dev/no-such-port: ")
            && report.contains("; trying again"),
        "{report}"
    );
    assert!(
        report.contains("ridgetone: left: ") && report.contains(" 0 lost, 0 damaged"),
        "{report}"
    );
    assert!(
        report.contains(&format!(
            "json: {} messages delivered, 0 frames and 0 events lost\n",
            messages.len()
        )),
        "{report}"
    );
}

/// A stalled reader must not block a board. Its losses must be counted and reported.
#[test]
fn a_slow_reader_loses_frames_by_count() {
    let board = SerialBoard::of_rate(2000.0);
    let mut serving = Serving::start(&[&format!("left={}", board.name)]);
    while serving.next().expect("a message").1["type"] != "raw" {}
    let begun = Instant::now();
    // Fill the pipe (64 KiB) and the queue (4096 frames).
    while begun.elapsed() < Duration::from_secs(5) {
        sleep(Duration::from_millis(100));
    }
    board.stop();
    let frames = board.frames();
    assert!(
        board.late_s() < 0.5 && frames > 9000,
        "{} s late after {frames} frames",
        board.late_s()
    );
    sleep(Duration::from_millis(300));
    let (messages, report) = serving.interrupt();
    let lost: u64 = messages
        .iter()
        .filter_map(|(_, message)| {
            message["frames"]
                .as_u64()
                .filter(|_| message["at"] == "json")
        })
        .max()
        .unwrap_or(0);
    let frames_read = messages
        .iter()
        .filter(|(_, message)| message["type"] == "raw")
        .count() as u64;
    assert!(lost > 1000, "{lost}");
    assert_eq!(1 + frames_read + lost, board.frames(), "{report}");
    assert!(
        report.contains(&format!(", {lost} frames and 0 events lost")),
        "{report}"
    );
}

#[test]
fn a_recording_is_played_in_real_time_as_if_it_happened_now() {
    let folder = common::directory();
    let path = folder.path().join("touch.rec");
    let input = Input::default().open().expect("a scene");
    let outcome =
        replay::run(input, Settings::DEFAULT, &mut |_| Ok(()), &mut |_, _| {}).expect("a run");
    recording::create(&path, "a test", 0.0)
        .expect("a file")
        .keep(&outcome.serial, None)
        .expect("kept");
    let begun = Instant::now();
    let mut serving = Serving::start(&[&format!("left={}", common::text(&path))]);
    let (messages, report) = serving.finish();
    let lasts_s = begun.elapsed().as_secs_f64();
    let counts = counted(&messages);
    assert!(
        counts["/ridgetone/left/tone"] > 2 && counts["/ridgetone/left/contact"] >= 3,
        "{counts:?}"
    );
    let times_s = messages
        .iter()
        .filter_map(|(_, message)| message["t_s"].as_f64());
    let (first_s, last_s) = times_s.fold((f64::INFINITY, 0.0_f64), |(a, b), t_s| {
        (a.min(t_s), b.max(t_s))
    });
    assert!(
        lasts_s > 0.95 * (last_s - first_s) && last_s - first_s > 2.0,
        "{lasts_s} s for {first_s} to {last_s}"
    );
    let now_s = std::time::SystemTime::now()
        .duration_since(std::time::UNIX_EPOCH)
        .expect("a clock")
        .as_secs_f64();
    let last = messages
        .iter()
        .rev()
        .find(|(_, message)| message["utc_s"].is_number())
        .expect("a time");
    assert!(
        (now_s - last.1["utc_s"].as_f64().expect("a time")).abs() < 5.0,
        "{last:?}"
    );
    assert_eq!(messages.last().expect("a message").1["state"], "over");
    assert!(report.contains("0 frames and 0 events lost"), "{report}");
}

#[test]
fn wrong_arguments_are_refused_on_one_line() {
    let cases: &[(&[&str], &[&str])] = &[
        (&["--json"], &["--finger"]),
        (&["--finger", "a=x"], &["--foxglove", "--mqtt", "--json"]),
        (
            &["--json", "--finger", "a=x", "--finger", "a=y"],
            &["two fingers are named a"],
        ),
        (&["--json", "--finger", "a/b=x"], &["a/b", "letters"]),
        (
            &["--json", "--board", "a/b", "--finger", "a=x"],
            &["a/b", "letters"],
        ),
        (&["--json", "--finger", "/dev/ttyUSB0"], &["NAME=SOURCE"]),
        (
            &["--json", "--finger", "a=http://127.0.0.1:8321"],
            &["http://127.0.0.1:8321", "a port, emulated or a recording"],
        ),
        (&["--foxglove", "nowhere", "--finger", "a=x"], &["nowhere"]),
        #[cfg(not(feature = "mqtt"))]
        (
            &["--mqtt", "--finger", "a=x"],
            &["cargo install --path host --features mqtt"],
        ),
        #[cfg(not(feature = "foxglove"))]
        (
            &["--foxglove", "--finger", "a=x"],
            &["cargo install --path host --features foxglove"],
        ),
    ];
    for (arguments, parts) in cases {
        common::assert_one_line(&common::run(&[&["serve"], *arguments].concat()), 2, parts);
    }
}
