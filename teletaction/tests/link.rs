//! `ridgetone link`: two ends over UDP, the emulated finger, what is refused, and the link in
//! virtual time.

#[path = "../../host/tests/common/mod.rs"]
mod common;
#[path = "link/in_virtual_time.rs"]
mod in_virtual_time;
#[cfg(target_os = "linux")]
#[path = "../../host/tests/common/serial_board.rs"]
mod serial_board;
#[cfg(target_os = "linux")]
#[path = "common/stylus_board.rs"]
mod stylus_board;
#[cfg(target_os = "linux")]
#[path = "link/with_a_board.rs"]
mod with_a_board;

use common::{assert_one_line, directory, json_lines, ridgetone, run, text};
use ridgetone_host::input::Input;
use ridgetone_host::recording::{self, Keep};
use ridgetone_host::replay;
use ridgetone_host::touches::PERIODS_MM;
use ridgetone_proto::settings::Settings;
use serde_json::Value;
use std::io::{BufRead, BufReader, Read};
use std::path::PathBuf;
use std::process::Stdio;

/// A hand at 100 mm/s, with counts of 5 um.
#[cfg(target_os = "linux")]
const SPEED_MM_S: f64 = 100.0;
#[cfg(target_os = "linux")]
fn counts(t_s: f64) -> i64 {
    (SPEED_MM_S / 0.005 * t_s) as i64
}

/// A recording of the telemetry of the demo's touch.
fn recorded_touch(folder: &tempfile::TempDir) -> PathBuf {
    let path = folder.path().join("touch.rec");
    let input = Input::default().open().expect("a scene");
    let outcome =
        replay::run(input, Settings::DEFAULT, &mut |_| Ok(()), &mut |_, _| {}).expect("a run");
    recording::create(&path, "a test", 0.0)
        .expect("a file")
        .keep(&outcome.serial, None)
        .expect("kept");
    path
}

fn last(lines: &[Value]) -> &Value {
    lines.last().expect("a report")
}

/// A recorded finger at one end, a hand at the other, and a real network between two processes,
/// which loses, doubles and damages too.
#[test]
fn two_ends_find_each_other_over_a_network() {
    let folder = directory();
    let path = recorded_touch(&folder);
    let impairments = [
        "--delay-ms",
        "40",
        "--jitter-ms",
        "10",
        "--loss",
        "5%",
        "--doubled",
        "5%",
        "--damaged",
        "5%",
        "--json",
    ];
    let mut finger = ridgetone()
        .args([
            "link",
            "--finger",
            text(&path),
            "--stylus",
            "udp:127.0.0.1:0",
        ])
        .args(impairments)
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the command runs");
    let mut report = BufReader::new(finger.stderr.take().expect("a pipe"));
    let mut line = String::new();
    report.read_line(&mut line).expect("a line");
    let address = line
        .trim()
        .rsplit(' ')
        .next()
        .expect("an address")
        .to_owned();
    let stylus = run(&[
        &[
            "link",
            "--finger",
            &address,
            "--stylus",
            "simulated",
            "--for",
            "7",
        ],
        &impairments[..],
    ]
    .concat());
    let stylus = json_lines(&stylus);
    let mut printed = String::new();
    finger
        .stdout
        .take()
        .expect("a pipe")
        .read_to_string(&mut printed)
        .expect("UTF-8");
    assert!(finger.wait().expect("ended").success(), "{line}");
    let finger: Vec<Value> = printed
        .lines()
        .map(|line| serde_json::from_str(line).expect("JSON"))
        .collect();
    let number = |of: &Value, what: &str| {
        of[what]
            .as_u64()
            .unwrap_or_else(|| panic!("{what} in {of}"))
    };
    // The finger has the positions of the hand, and the stylus the texture of 3.6 mm.
    let positions = &last(&finger)["positions"];
    assert!(
        number(positions, "received") > 200 && number(positions, "lost") > 5,
        "{finger:?}"
    );
    assert!(
        number(positions, "doubled") > 1 && number(positions, "damaged") > 1,
        "{finger:?}"
    );
    let felt = stylus
        .iter()
        .rfind(|report| report["is_felt"] == true)
        .unwrap_or_else(|| panic!("felt: {stylus:?}"));
    let [period_mm, sigma_mm] =
        ["period_mm", "period_sigma_mm"].map(|what| felt[what].as_f64().expect("a number"));
    // An array that nobody calibrated knows it to some 8 %.
    assert!(
        (period_mm - 3.6).abs() < 4.0 * sigma_mm && sigma_mm < 0.3,
        "{felt}"
    );
    // The recording is over before: the link is dead, and nothing is felt any more.
    assert_eq!(last(&stylus)["is_felt"], false, "{stylus:?}");
}

#[test]
fn what_makes_no_sense_is_refused_on_one_line() {
    let refused = |arguments: &[&str], words: &[&str]| {
        assert_one_line(&run(&[&["link"], arguments].concat()), 2, words)
    };
    refused(&[], &["--finger"]);
    refused(&["--emulated", "--finger", "emulated"], &["--finger"]);
    refused(&["--emulated", "--follows"], &["--follows", "serial port"]);
    refused(
        &["--finger", "udp:127.0.0.1:1", "--follows"],
        &["--follows", "finger's end"],
    );
    refused(&["--emulated", "--loss", "101%"], &["0 to 100"]);
    refused(&["--emulated", "--loss", "-1"], &["0 to 100"]);
    refused(&["--emulated", "--loss", "NaN"], &["not a number"]);
    refused(&["--emulated", "--delay-ms", "5000"], &["--delay-ms 5000"]);
    assert_one_line(
        &run(&["link", "--emulated", "--stylus", "mine"]),
        1,
        &["--stylus", "simulated", "mine"],
    );
    refused(
        &["--finger", "udp:127.0.0.1:1", "--stylus", "udp:127.0.0.1:0"],
        &["one end must be here"],
    );
    refused(
        &["--finger", "http://127.0.0.1:1"],
        &["a port, emulated or a recording"],
    );
    refused(&["--emulated", "--speed-mm-s", "1e9"], &["--speed-mm-s"]);
    assert_one_line(
        &run(&["link", "--finger", "udp:nowhere"]),
        1,
        &["nowhere", "HOST:PORT"],
    );
}

/// From a clean clone: the emulated finger, a simulated hand, and the paper's network. The delay is
/// not felt.
#[test]
#[ignore = "needs the emulator: cargo xtask test"]
fn the_emulated_finger_is_felt_without_the_delay() {
    let paper = ["--delay-ms", "120", "--jitter-ms", "40", "--loss", "5%"];
    let reports = json_lines(&run(&[
        &["link", "--emulated", "--for", "40", "--json"],
        &paper[..],
    ]
    .concat()));
    assert!(reports.len() >= 10, "{}", reports.len());
    // Seconds in which neither end had a new texture: the finger has it a delay before the stylus,
    // so the report after must have the same one too.
    let steady: Vec<&Value> = reports
        .windows(3)
        .filter(|three| {
            three[0]["period_mm"].is_number()
                && three
                    .iter()
                    .all(|report| report["period_mm"] == three[0]["period_mm"])
        })
        .map(|three| &three[1])
        .collect();
    assert!(steady.len() >= 3, "{reports:?}");
    for report in steady {
        let number = |what: &str| {
            report[what]
                .as_f64()
                .unwrap_or_else(|| panic!("{what}: {report}"))
        };
        let is_one = |period_mm: &f64| (number("period_mm") - period_mm).abs() < 0.1;
        assert!(PERIODS_MM.iter().any(is_one), "{report}");
        assert!(
            number("error_percent") < 1.0 && number("error_cycles") < 0.02,
            "{report}"
        );
        assert!(number("as_vibration_percent") > 50.0, "{report}");
    }
}
