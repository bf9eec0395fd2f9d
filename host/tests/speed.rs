//! Tests `ridgetone fit` against position, with columns of positions and speeds.

mod common;

use common::{assert_one_line, directory, file, json_lines, run, stdout, text};
use std::f64::consts::TAU;
use std::fmt::Write;
use std::path::PathBuf;

const PERIOD_MM: f64 = 2.5;

/// Returns position and speed of a hand that moves 100 mm back and forth every two seconds.
fn hand(t_s: f64) -> (f64, f64) {
    (
        50.0 * (1.0 - (TAU * t_s / 2.0).cos()),
        50.0 * TAU / 2.0 * (TAU * t_s / 2.0).sin(),
    )
}

/// Writes a recording of the [`hand`]: two channels, position and speed.
fn recording(folder: &tempfile::TempDir) -> PathBuf {
    let (mut csv, mut state) = (String::from("time_s,a,x_mm,b,v_mm_s\n"), 1u32);
    for row in 0..1200 {
        let t_s = row as f64 / 500.0;
        let (place_mm, speed_mm_s) = hand(t_s);
        let mut noise = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            0.2 * (f64::from(state >> 8) / f64::from(1 << 24) - 0.5)
        };
        let turns = TAU * place_mm / PERIOD_MM;
        let (a, b) = (
            turns.cos() + noise(),
            5.0 + 0.5 * (turns + 1.0).sin() + noise(),
        );
        let _ = writeln!(csv, "{t_s:.4},{a:.6},{place_mm:.6},{b:.6},{speed_mm_s:.6}");
    }
    file(folder.path(), "hand.csv", &csv)
}

#[test]
fn a_column_of_places_or_speeds_makes_it_cycles_per_millimetre() {
    let folder = directory();
    let path = recording(&folder);
    for place in [["--position-column", "x_mm"], ["--speed-column", "v_mm_s"]] {
        let columns = ["--columns", "a,b"];
        let found = &json_lines(&run(&[
            &["fit", text(&path), "--json"][..],
            &place[..],
            &columns[..],
        ]
        .concat()))[0];
        let (period, sigma) = (
            found["period_mm"].as_f64().unwrap(),
            found["period_sigma_mm"].as_f64().unwrap(),
        );
        assert_eq!(
            (&found["domain"], &found["status"]),
            (&"position".into(), &"good".into()),
            "{found}"
        );
        assert!(
            (period - PERIOD_MM).abs() < 4.0 * sigma + 1e-5 && sigma < 1e-3,
            "{found}"
        );
        assert!((found["frequency_per_mm"].as_f64().unwrap() * period - 1.0).abs() < 1e-6);
        assert!(
            found.get("frequency_hz").is_none() && found["channels"].as_array().unwrap().len() == 2
        );
    }
    // Fitted against time, these rows have no single frequency.
    let found = &json_lines(&run(&["fit", text(&path), "--columns", "a,b", "--json"]))[0];
    assert_eq!(found["domain"], "time");
    let printed = stdout(&run(&[
        "fit",
        text(&path),
        "--columns",
        "a,b",
        "--position-column",
        "x_mm",
    ]));
    for part in [
        "frequency_per_mm",
        "sigma_per_mm",
        "period_mm        2.50",
        "period_sigma_mm",
    ] {
        assert!(printed.contains(part), "{part:?} is not in {printed}");
    }
}

#[test]
fn the_column_of_the_place_is_no_channel() {
    let folder = directory();
    let path = recording(&folder);
    let found = &json_lines(&run(&[
        "fit",
        text(&path),
        "--position-column",
        "x_mm",
        "--json",
    ]))[0];
    let names: Vec<_> = found["channels"]
        .as_array()
        .unwrap()
        .iter()
        .map(|channel| channel["name"].clone())
        .collect();
    assert_eq!(names, ["a", "b", "v_mm_s"]);
}

#[test]
fn wrong_columns_are_refused() {
    let folder = directory();
    let path = file(
        folder.path(),
        "rest.csv",
        &format!("a,x\n{}", "1,5\n2,5\n1,5\n3,5\n".repeat(10)),
    );
    let fit = |column: &str| {
        run(&[
            "fit",
            text(&path),
            "--rate",
            "10",
            "--position-column",
            column,
        ])
    };
    assert_one_line(&fit("y"), 1, &["no column y", "a, x"]);
    assert_one_line(&fit("x"), 1, &["by column x the finger does not move"]);
}
