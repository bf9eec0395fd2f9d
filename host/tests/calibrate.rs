//! Tests `ridgetone calibrate` and the defaults derived from it.

mod common;

use common::{assert_one_line, directory, file, json_lines, run, stdout};
use ridgetone_proto::settings::Array;

/// Writes scenes of the simulated finger on gratings that do not occur in the paper. Returns them
/// as `MM=FILE`.
fn gratings(folder: &tempfile::TempDir, speed_mm_s: f64, more: &str) -> Vec<String> {
    let scene = |period_mm: f64| {
        let text = format!("speed_mm_s = {speed_mm_s}\nperiod_mm = {period_mm}\n{more}");
        let path = file(folder.path(), &format!("{period_mm}.toml"), &text);
        format!("{period_mm}={}", path.display())
    };
    [2.5, 3.0, 3.5, 4.0].map(scene).into()
}

fn calibrate(gratings: &[String], more: &[&str]) -> std::process::Output {
    let gratings: Vec<&str> = gratings.iter().map(String::as_str).collect();
    run(&[&["calibrate"], &gratings[..], more].concat())
}

#[test]
fn the_defaults_are_the_simulated_fingers() {
    let folder = directory();
    // The scan's skew is corrected, so the result must not depend on speed or direction.
    for (speed_mm_s, way) in [(15.0, ""), (28.0, "reverse = true\n")] {
        let found = &json_lines(&calibrate(&gratings(&folder, speed_mm_s, way), &["--json"]))[0];
        let number = |name: &str| found[name].as_f64().expect("a number");
        let array = Array::DEFAULT;
        // The taxels' lags differ a little. They are weighted by the noise next to the tone, which
        // is known only to some tens of percent in one window.
        assert!(
            (number("pitch_mm") - f64::from(array.pitch_mm)).abs() < 0.003,
            "{found}"
        );
        assert!(
            (number("edge_phase_rad") - f64::from(array.edge_phase_rad)).abs() < 0.005,
            "{found}"
        );
        assert!(
            (number("edge_phase_sigma_rad") - 0.01).abs() < 0.001,
            "{found}"
        );
    }
}

/// Under a contact 30 mm long, the pitch from the lag is exactly that of the units.
#[test]
fn under_a_long_contact_the_pitch_is_the_units_own() {
    let folder = directory();
    let long = "[finger]\ncontact_mm = 30\n";
    let found = &json_lines(&calibrate(&gratings(&folder, 15.0, long), &["--json"]))[0];
    assert!(
        (found["pitch_mm"].as_f64().unwrap() - 2.3).abs() < 0.01,
        "{found}"
    );
    assert!(
        found["edge_phase_rad"].as_f64().unwrap().abs() < 0.03,
        "{found}"
    );
}

/// The phases of the columns do not depend on the conversion rate or the number of inputs.
#[test]
fn the_constants_are_those_of_every_plan_with_both_columns() {
    let folder = directory();
    // The plan `texture` has windows of 0.175 s, which contain less than two cycles at 28 mm/s.
    let gratings = gratings(&folder, 60.0, "");
    for plan in ["hand", "texture"] {
        let found = &json_lines(&calibrate(&gratings, &["--plan", plan, "--json"]))[0];
        let number = |name: &str| found[name].as_f64().expect("a number");
        assert!(
            (number("pitch_mm") - f64::from(Array::DEFAULT.pitch_mm)).abs() < 0.02,
            "{plan}: {found}"
        );
        assert!(
            (number("edge_phase_rad") - f64::from(Array::DEFAULT.edge_phase_rad)).abs() < 0.05,
            "{plan}: {found}"
        );
    }
    assert_one_line(
        &calibrate(&gratings, &["--plan", "single"]),
        1,
        &["single", "one in each column"],
    );
}

/// One grating at a known speed, under short and long contacts: the periods of all other gratings
/// must then be right within their uncertainty.
#[test]
fn one_grating_calibrates_a_finger() {
    for contact_mm in [7, 8, 10, 30] {
        let folder = directory();
        let finger = format!("[finger]\ncontact_mm = {contact_mm}\n");
        let gratings = gratings(&folder, 28.0, &finger);
        let found = &json_lines(&calibrate(&gratings[1..2], &["--speed", "28", "--json"]))[0];
        let given = |name: &str| found[name].as_f64().expect("a number").to_string();
        let options: Vec<String> = ["pitch_mm", "edge_phase_rad", "edge_phase_sigma_rad"]
            .into_iter()
            .flat_map(|name| ["--set".to_owned(), format!("array.{name}={}", given(name))])
            .collect();
        let options: Vec<&str> = options.iter().map(String::as_str).collect();
        for (grating, true_mm) in gratings.iter().zip([2.5, 3.0, 3.5, 4.0]) {
            let (_, scene) = grating.split_once('=').expect("MM=FILE");
            // With a short contact, the answer is unique only if the direction is known.
            let replay = [
                "replay",
                "--set",
                "array.may_go_backward=false",
                "--json",
                "--scene",
                scene,
            ];
            let replayed = run(&[&replay[..], &options[..]].concat());
            let events = json_lines(&replayed);
            let slide = |event: &&serde_json::Value| {
                event["type"] == "estimate" && event["span"] == "slide"
            };
            let slide = events.iter().find(slide).expect("a slide");
            assert_eq!(slide["travel"], "unique", "{contact_mm}: {slide}");
            let number = |name: &str| slide[name].as_f64().expect("a number");
            let off = (number("spatial_period_mm") - true_mm) / number("spatial_period_sigma_mm");
            assert!(
                off.abs() < 2.0,
                "{contact_mm} mm, {true_mm} mm: {off} sigma"
            );
        }
    }
}

#[test]
fn it_is_printed_as_the_command_that_sets_it() {
    let folder = directory();
    let printed = stdout(&calibrate(&gratings(&folder, 28.0, ""), &[]));
    assert!(
        printed.contains("ridgetone settings set --keep array.pitch_mm=2.36")
            && printed.contains("array.edge_phase_rad=0.4")
            && printed.contains("array.edge_phase_sigma_rad=0.0"),
        "{printed}"
    );
}

/// If the speed varies by a sixth, no window of 3 mm is good, although the lags are correct.
#[test]
fn windows_that_are_not_good_are_taken_only_if_they_are_accepted() {
    let (folder, steady) = (directory(), directory());
    let moving = "[stimulator]\nripple_percent = 18\nripple_hz = 1.5\n";
    let steady = gratings(&steady, 28.0, "");
    let gratings = [
        &gratings(&folder, 28.0, moving)[1..2],
        &steady[..1],
        &steady[2..3],
    ]
    .concat();
    assert_one_line(
        &calibrate(&gratings, &[]),
        1,
        &["3.toml", "no window is good", "`unsteady`", "--accept"],
    );
    let found = &json_lines(&calibrate(&gratings, &["--accept", "--json"]))[0];
    let pitch_mm = found["pitch_mm"].as_f64().expect("a number");
    assert!(
        (pitch_mm - f64::from(Array::DEFAULT.pitch_mm)).abs() < 0.02,
        "{found}"
    );
    assert!(
        found["gratings"][0]["windows"].as_u64() > Some(0),
        "{found}"
    );
}

#[test]
fn what_is_no_calibration_is_refused_in_a_line() {
    let folder = directory();
    let gratings = gratings(&folder, 28.0, "");
    assert_one_line(
        &calibrate(&gratings[1..2], &["--speed", "29"]),
        1,
        &["3.toml", "moves at 28.0", "--speed is 29"],
    );
    assert_one_line(&run(&["calibrate", "a.csv"]), 2, &["MM=FILE"]);
    assert_one_line(&run(&["calibrate", "0=a.csv"]), 2, &["greater than 0"]);
    let wrong = gratings[2].replace("3.5=", "2.9=");
    let three = [gratings[0].clone(), gratings[1].clone(), wrong];
    assert_one_line(
        &calibrate(&three, &[]),
        1,
        &["3.5.toml", "do not fit a period of 2.9 mm"],
    );
}
