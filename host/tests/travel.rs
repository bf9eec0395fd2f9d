//! Tests spatial period, speed and direction on the command line.

mod common;

use common::{assert_one_line, json_lines, run, stdout};
use serde_json::Value;

/// C1 of the paper: 3.6 mm at 15 mm/s, towards units 1 and 3.
const C1: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../hal-mock/scenes/c1.toml");

/// Uncertainty that `calibrate` reports for the simulated finger (`tests/calibrate.rs`), whose
/// pitch and edge phase are the defaults.
const CALIBRATED: [&str; 2] = ["--set", "array.edge_phase_sigma_rad=0.01"];
/// Settings for a grating that moves in only one direction.
const FORWARD: &str = "array.may_go_backward=false";
const BACKWARD: &str = "array.may_go_forward=false";

fn estimates(more: &[&str]) -> Vec<Value> {
    let more = [&CALIBRATED[..], more].concat();
    replayed(&more)
}

fn replayed(more: &[&str]) -> Vec<Value> {
    let events = json_lines(&run(&[&["replay", "--scene", C1, "--json"], more].concat()));
    events
        .into_iter()
        .filter(|event| event["type"] == "estimate")
        .collect()
}

#[test]
fn period_speed_and_direction_are_reported_with_their_uncertainties() {
    let found = estimates(&[]);
    assert!(found.len() > 2);
    for estimate in found {
        assert_eq!(
            (&estimate["travel"], &estimate["direction"]),
            (&"unique".into(), &"backward".into()),
            "{estimate}"
        );
        let number = |name: &str| estimate[name].as_f64().expect("a number");
        let (period_sigma, speed_sigma) = (
            number("spatial_period_sigma_mm"),
            number("speed_sigma_mm_s"),
        );
        assert!(
            (number("spatial_period_mm") / 3.6 - 1.0).abs() < 0.01 && period_sigma > 0.0,
            "{estimate}"
        );
        assert!(
            (number("speed_mm_s") / 15.0 - 1.0).abs() < 0.015 && speed_sigma > 0.0,
            "{estimate}"
        );
        let speed = number("frequency_hz") * number("spatial_period_mm");
        assert!(
            (number("speed_mm_s") / speed - 1.0).abs() < 1e-6,
            "{estimate}"
        );
    }
    let printed = stdout(&run(&[&["replay", "--scene", C1], &CALIBRATED[..]].concat()));
    assert!(
        printed.contains("; period 3.6") && printed.contains(" mm, backward at 15.0"),
        "{printed}"
    );
}

#[test]
fn what_is_possible_is_the_users_to_say() {
    // A period of 3.6 mm backward has the same phase as 5 mm forward.
    for (options, verdict) in [
        (&["--set", FORWARD][..], "out_of_range"),
        (
            &["--set", BACKWARD, "--set", "array.period_max_mm=9"],
            "unique",
        ),
        (&["--set", "array.period_max_mm=9"], "ambiguous"),
        (&["--set", "array.period_min_mm=1.2"], "ambiguous"),
        (&["--set", "array.period_min_mm=3.7"], "out_of_range"),
    ] {
        for estimate in estimates(options) {
            assert_eq!(estimate["travel"], verdict, "{options:?}: {estimate}");
            assert_eq!(
                estimate["spatial_period_mm"].is_null(),
                verdict != "unique",
                "{estimate}"
            );
        }
    }
    assert_one_line(
        &run(&[
            "replay",
            "--set",
            "array.period_min_mm=5",
            "--set",
            "array.period_max_mm=4",
        ]),
        2,
        &["period_max_mm = 4", "5 to 100"],
    );
    assert_one_line(
        &run(&["replay", "--set", "array.pitch_mm=0"]),
        2,
        &["pitch_mm = 0"],
    );
}

/// By default the array is not calibrated. The uncertainty then covers any finger, and is too large
/// to decide between 3.6 mm in one direction and 4.3 mm in the other.
#[test]
fn an_array_that_nobody_calibrated_says_so() {
    for estimate in replayed(&[]) {
        assert_eq!(estimate["travel"], "uncalibrated", "{estimate}");
        assert!(estimate["direction"].is_null(), "{estimate}");
        let number = |name: &str| estimate[name].as_f64().expect("a number");
        let fraction = number("spatial_period_sigma_mm") / number("spatial_period_mm");
        assert!((0.06..0.09).contains(&fraction), "{estimate}");
        assert!(
            number("speed_sigma_mm_s") > 0.06 * number("speed_mm_s"),
            "{estimate}"
        );
    }
    for estimate in replayed(&["--set", BACKWARD]) {
        assert_eq!(estimate["direction"], "backward", "{estimate}");
    }
    let printed = stdout(&run(&["replay", "--scene", C1]));
    assert!(printed.contains("(uncalibrated)"), "{printed}");
}

#[test]
fn a_given_speed_gives_the_period() {
    // If the speed is too low, the protocol's slide is longer than the true one.
    for (speed, verdict) in [("15", "given"), ("18", "contradicted")] {
        let speed_mm_s: f64 = speed.parse().expect("a number");
        for estimate in estimates(&["--speed", speed]) {
            assert_eq!(estimate["travel"], verdict, "{estimate}");
            assert_eq!(
                estimate["speed_mm_s"].as_f64(),
                Some(speed_mm_s),
                "{estimate}"
            );
            let period_mm = estimate["spatial_period_mm"].as_f64().expect("a number");
            assert!(
                (period_mm * 15.0 / speed_mm_s / 3.6 - 1.0).abs() < 0.002,
                "{estimate}"
            );
        }
    }
}
