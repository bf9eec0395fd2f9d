//! Tests `ridgetone fit` with windows, many files, standard input and bounds.

mod common;

use common::{directory, file, json_lines, ridgetone, run, stderr, stdout, text, tone};
use std::f64::consts::TAU;
use std::fmt::Write as _;
use std::fs::File;
use std::process::Stdio;

fn column(csv: &str, name: &str) -> Vec<String> {
    let mut lines = csv.lines().map(|line| line.split(','));
    let at = lines
        .next()
        .and_then(|mut header| header.position(|column| column == name))
        .expect("the column");
    lines
        .map(|mut cells| cells.nth(at).expect("a cell").to_owned())
        .collect()
}

fn table(rows: usize, rate_hz: f64, value: impl Fn(f64) -> f64) -> String {
    let mut csv = String::from("time_s,a");
    let mut state = 7u32;
    for row in 0..rows {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        let noise = f64::from(state >> 8) / f64::from(1 << 24) - 0.5;
        let t_s = row as f64 / rate_hz;
        let _ = write!(csv, "\n{t_s:.6},{:.6}", value(t_s) + 0.1 * noise);
    }
    csv
}

#[test]
fn each_window_is_the_fit_of_its_rows() {
    let folder = directory();
    let path = file(folder.path(), "a.csv", &tone(4, 2000, 250.0, 8.0, 0.0));
    let other = file(folder.path(), "b.csv", &tone(2, 500, 250.0, 5.0, 0.0));
    let all = folder.path().join("all.csv");
    let output = run(&[
        "fit",
        text(&path),
        text(&other),
        "--window",
        "1",
        "--stride",
        "0.5",
        "-o",
        text(&all),
    ]);
    assert!(output.status.success(), "{}", stderr(&output));
    let csv = std::fs::read_to_string(&all).expect("a table");
    let starts: Vec<f64> = column(&csv, "from_s")
        .iter()
        .map(|from_s| from_s.parse().expect("a time"))
        .collect();
    // Files of 8 s and 2 s, with windows every half second.
    let expected: Vec<f64> = (0..15).chain(0..3).map(|n| 0.5 * f64::from(n)).collect();
    assert_eq!(starts, expected);
    let alone = run(&["fit", text(&path), "--from", "3", "--to", "3.996", "--json"]);
    let alone = json_lines(&alone)[0].clone();
    let found: f64 = column(&csv, "frequency_hz")[6].parse().expect("a number");
    assert_eq!(Some(found), alone["frequency_hz"].as_f64());
    // One window may not be good: the estimator has a false alarm in one of a few hundred.
    let status = column(&csv, "status");
    let good = status.iter().filter(|status| *status == "good").count();
    assert!(good >= 17, "{status:?}");
    assert!(column(&csv, "rows").iter().all(|rows| rows == "250"));
}

#[test]
fn a_pause_leaves_windows_out_and_a_short_recording_is_refused() {
    let folder = directory();
    let table = tone(1, 1000, 250.0, 8.0, 0.0);
    let mut paused = String::new();
    for (row, line) in table.lines().enumerate() {
        let Some((t_s, value)) = line.split_once(',').filter(|_| row > 500) else {
            paused += line;
            paused.push('\n');
            continue;
        };
        let t_s: f64 = t_s.parse().expect("a time");
        let _ = writeln!(paused, "{:.6},{value}", t_s + 1e6);
    }
    let path = file(folder.path(), "paused.csv", &paused);
    let output = run(&["fit", text(&path), "--window", "1"]);
    let csv = stdout(&output);
    assert!(output.status.success(), "{}", stderr(&output));
    assert_eq!(column(&csv, "rows"), ["250"; 4], "{csv}");
    let refused = run(&["fit", text(&path), "--window", "2e6"]);
    assert!(
        stderr(&refused).contains("fill no window of 2000000 s"),
        "{}",
        stderr(&refused)
    );
}

#[test]
fn a_stride_shorter_than_a_row_is_refused_with_the_shortest() {
    let folder = directory();
    let path = file(folder.path(), "a.csv", &tone(1, 300, 250.0, 8.0, 0.0));
    for (stride, is_refused) in [("0.004", false), ("0.0039", true), ("1e-9", true)] {
        let output = run(&["fit", text(&path), "--window", "1", "--stride", stride]);
        let told = stderr(&output).contains("type --stride 0.004 or more");
        assert_eq!(
            (output.status.success(), told),
            (!is_refused, is_refused),
            "{stride}: {}",
            stderr(&output)
        );
    }
}

#[test]
fn a_file_that_cannot_be_read_has_a_row_and_fails_the_command() {
    let folder = directory();
    let path = file(folder.path(), "a.csv", &tone(4, 500, 250.0, 8.0, 0.0));
    let output = run(&["fit", text(&path), "/nonexistent/b.csv"]);
    assert_eq!(output.status.code(), Some(1));
    let csv = stdout(&output);
    assert_eq!(column(&csv, "status"), ["good", ""], "{csv}");
    assert!(column(&csv, "why")[1].contains("No such file"), "{csv}");
}

#[test]
fn standard_input_gives_what_the_file_gives() {
    let folder = directory();
    let path = file(folder.path(), "a.csv", &tone(4, 500, 250.0, 8.0, 0.0));
    let piped = ridgetone()
        .args(["fit", "-", "--json"])
        .stdin(Stdio::from(File::open(&path).expect("a file")))
        .output()
        .expect("the command runs");
    let (piped, of_file) = (
        json_lines(&piped),
        json_lines(&run(&["fit", text(&path), "--json"])),
    );
    assert_eq!(piped[0]["file"], "standard input");
    assert_eq!(piped[0]["frequency_hz"], of_file[0]["frequency_hz"]);
    assert_eq!(piped[0]["channels"], of_file[0]["channels"]);
}

#[test]
fn more_rows_than_the_estimator_takes_are_fitted_through_a_filter() {
    let folder = directory();
    // The second tone is too fast for the frame rate after decimation. It must not appear as an
    // alias.
    let csv = table(150_000, 5000.0, |t_s| {
        (TAU * 37.5 * t_s).cos() + 0.5 * (TAU * 1017.0 * t_s).cos()
    });
    let path = file(folder.path(), "long.csv", &csv);
    let output = run(&["fit", text(&path), "--json"]);
    assert!(
        stderr(&output).contains("150000 rows are fitted by a low-pass filter"),
        "{}",
        stderr(&output)
    );
    let found = &json_lines(&output)[0];
    let number = |name: &str| found[name].as_f64().expect("a number");
    assert_eq!(
        (found["status"].as_str(), number("rows")),
        (Some("good"), 150_000.0)
    );
    assert!((number("frequency_hz") - 37.5).abs() < 4.0 * number("sigma_hz"));
    let channel = &found["channels"][0];
    assert!((channel["amplitude"].as_f64().expect("a number") - 1.0).abs() < 0.01);
    // The phase is that at the centre of all rows.
    let centre_s = 0.5 * 149_999.0 / 5000.0;
    let phase = TAU * 37.5 * centre_s - channel["phase_rad"].as_f64().expect("a phase");
    assert!(phase.sin().abs() < 0.01 && phase.cos() > 0.0, "{phase}");
}

#[test]
fn bounds_choose_a_tone_or_say_what_lies_outside() {
    let folder = directory();
    // Two tones that together look like a harmonic comb of 10 Hz.
    let csv = table(2000, 250.0, |t_s| {
        (TAU * 20.0 * t_s).cos() + 0.4 * (TAU * 30.0 * t_s).cos()
    });
    let path = file(folder.path(), "comb.csv", &csv);
    let found_hz = |options: &[&str]| {
        let output = run(&[&["fit", text(&path), "--json"], options].concat());
        json_lines(&output)[0]["frequency_hz"].as_f64()
    };
    let near = |found: Option<f64>, hz: f64| found.is_some_and(|found| (found - hz).abs() < 0.05);
    assert!(near(found_hz(&["--min-hz", "15", "--max-hz", "25"]), 20.0));
    let output = run(&["fit", text(&path), "--min-hz", "40"]);
    let shown = stderr(&output);
    assert!(
        shown.contains("is outside of --min-hz and --max-hz"),
        "{shown}"
    );
    assert!(stdout(&output).contains("no_tone"));
    let slow = table(2000, 250.0, |t_s| {
        (TAU * 60.0 * t_s).cos() + 0.3 * (TAU * 3.0 * t_s).cos()
    });
    let path = file(folder.path(), "slow.csv", &slow);
    let output = run(&["fit", text(&path), "--json", "--max-hz", "10"]);
    assert!(near(json_lines(&output)[0]["frequency_hz"].as_f64(), 3.0));
    let wrong = run(&["fit", text(&path), "--min-hz", "5", "--max-hz", "2"]);
    assert_eq!(wrong.status.code(), Some(2));
}
