//! Tests scene files on the command line.

mod common;

use common::{assert_one_line, directory, file, json_lines, run, stderr, text};
use std::path::PathBuf;

fn shipped(name: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
        .join("../hal-mock/scenes")
        .join(name)
}

#[test]
fn the_papers_scenes_are_understood() {
    for (name, hertz) in [
        ("c1.toml", 15.0 / 3.6),
        ("c7.toml", 48.0 / 3.1),
        ("c10.toml", 48.0 / 2.6),
    ] {
        let events = json_lines(&run(&["replay", "--scene", text(&shipped(name)), "--json"]));
        let fits = events
            .iter()
            .filter(|event| event["type"] == "estimate" && event["status"] == "good");
        let windows: Vec<f64> = fits
            .filter(|fit| fit["span"] == "window")
            .filter_map(|fit| fit["frequency_hz"].as_f64())
            .collect();
        assert!(!windows.is_empty(), "{name}");
        for found in windows {
            assert!((found / hertz - 1.0).abs() < 0.01, "{name}: {found}");
        }
        assert_eq!(
            events
                .iter()
                .filter(|event| event["type"] == "contact")
                .count(),
            1,
            "{name}"
        );
    }
}

#[test]
fn a_scene_file_and_its_truth() {
    let folder = directory();
    let trace = folder.path().join("c3.csv");
    let output = run(&[
        "emulate",
        text(&shipped("c3.toml")),
        "--print-scene",
        text(&trace),
        "--json",
    ]);
    let truth = &json_lines(&output)[0];
    assert!((truth["frequency_hz"].as_f64().unwrap() - 15.0 / 4.1).abs() < 1e-9);
    assert!(
        stderr(&output).contains("tone 3.6585 Hz"),
        "{}",
        stderr(&output)
    );
}

#[test]
fn the_crystals_error_and_the_seed_reach_the_chip() {
    let folder = directory();
    let scene = |name: &str, more: &str| {
        file(
            folder.path(),
            name,
            &format!("slide_mm = 30\nsnr_db = 20\n{more}"),
        )
    };
    let plain = scene("plain.toml", "");
    let fast = scene("fast.toml", "converter.clock_error_ppm = 5000");
    let frequency = |path: &PathBuf, more: &[&str]| {
        let events = json_lines(&run(
            &[&["replay", "--json", "--scene", text(path)], more].concat()
        ));
        let good =
            |event: &&serde_json::Value| event["type"] == "estimate" && event["span"] == "window";
        events
            .iter()
            .find(good)
            .and_then(|fit| fit["frequency_hz"].as_f64())
            .unwrap()
    };
    let (true_hz, slow_hz) = (frequency(&plain, &[]), frequency(&fast, &[]));
    // The scan is 0.5 % too fast, but its times come from the processor's clock, so the frequency
    // must not change as much.
    assert!(
        (slow_hz / true_hz - 1.0).abs() < 2e-3,
        "{slow_hz} {true_hz}"
    );
    assert_ne!(true_hz, slow_hz);
    assert_ne!(true_hz, frequency(&plain, &["--seed", "2"]));
    assert_eq!(true_hz, frequency(&plain, &["--seed", "1"]));
}

#[test]
fn an_error_in_one_is_a_line() {
    let folder = directory();
    let wrong = file(folder.path(), "wrong.toml", "period_mm = 3\nspeed = 15\n");
    let trace = folder.path().join("trace.csv");
    for command in [
        vec!["replay", "--scene", text(&wrong)],
        vec!["emulate", text(&wrong), "--print-scene", text(&trace)],
        vec!["demo", "--elf", "none.elf", "--scene", text(&wrong)],
    ] {
        assert_one_line(
            &run(&command),
            1,
            &["wrong.toml", "line 2", "`speed`", "`speed_mm_s`"],
        );
    }
    let fine = file(
        folder.path(),
        "fine.toml",
        "period_mm = 0.2\nridge_mm = 0.1",
    );
    assert_one_line(
        &run(&["replay", "--scene", text(&fine)]),
        1,
        &["line 1", "period_mm", "0.249 mm"],
    );
    assert_one_line(
        &run(&["replay", "--scene", text(&fine), "--period", "3"]),
        2,
        &["--period"],
    );
    assert_one_line(
        &run(&["replay", "any.csv", "--scene", text(&fine)]),
        2,
        &["--scene"],
    );
}
