//! Tests `ridgetone fit` on generated tables.

mod common;

use common::{assert_one_line, directory, file, json_lines, run, stderr, stdout, text, tone};
use serde_json::Value;

fn number(object: &Value, name: &str) -> f64 {
    object[name]
        .as_f64()
        .unwrap_or_else(|| panic!("{name} in {object}"))
}

fn fit(arguments: &[&str]) -> Value {
    let output = run(&[&["fit", "--json"], arguments].concat());
    let lines = json_lines(&output);
    assert_eq!(lines.len(), 1);
    lines[0].clone()
}

#[test]
fn frequency_amplitudes_and_phases_are_found() {
    let folder = directory();
    let path = file(folder.path(), "tone.csv", &tone(16, 1000, 241.0, 8.0, 0.0));
    let found = fit(&[text(&path)]);
    assert_eq!(
        (found["type"].as_str(), found["status"].as_str()),
        (Some("fit"), Some("good"))
    );
    assert_eq!(found["file"].as_str(), Some(text(&path)));
    let (frequency_hz, sigma_hz) = (number(&found, "frequency_hz"), number(&found, "sigma_hz"));
    assert!(
        (frequency_hz - 8.0).abs() < 4.0 * sigma_hz && sigma_hz < 1e-3,
        "{frequency_hz} {sigma_hz}"
    );
    assert!((number(&found, "rate_hz") - 241.0).abs() < 1e-3);
    assert!((number(&found, "window_s") - 1000.0 / 241.0).abs() < 1e-4);
    assert_eq!(found["harmonics"].as_u64(), Some(2));
    let channels = found["channels"].as_array().unwrap();
    assert_eq!(channels.len(), 16);
    // The window's centre is half a sample before row 500.
    let centre_s = 499.5 / 241.0;
    for (c, channel) in channels.iter().enumerate() {
        assert_eq!(channel["name"].as_str(), Some(format!("c{c}").as_str()));
        assert!((number(channel, "offset") - (100.0 + 10.0 * c as f64)).abs() < 0.02);
        assert!((number(channel, "amplitude") - (1.0 + 0.1 * c as f64)).abs() < 0.02);
        let phase =
            std::f64::consts::TAU * 8.0 * centre_s + c as f64 - number(channel, "phase_rad");
        assert!(
            phase.sin().abs() < 0.02 && phase.cos() > 0.0,
            "channel {c}: {phase}"
        );
        // The noise is uniformly distributed, 0.2 peak to peak.
        assert!((number(channel, "residual") - 0.2 / 12f64.sqrt()).abs() < 0.005);
    }
}

#[test]
fn the_lean_scene_is_declared_by_all_of_its_parts() {
    let folder = directory();
    let path = file(folder.path(), "tone.csv", &tone(16, 1000, 241.0, 8.0, 0.0));
    let settings = file(
        folder.path(),
        "lean.toml",
        "[scene]\novertones = false\ncurved_baseline = false\ncoloured_noise = false\n\
         shared_noise = false\nimpulses = false\n",
    );
    let parts = "overtones,curved-baseline,coloured-noise,shared-noise,impulses";
    let all = fit(&[text(&path), "--exclude", "all"]);
    for ways in [
        &["--exclude", parts][..],
        &["--settings", text(&settings)],
        &["--exclude", "all", "--harmonics", "5"],
    ] {
        assert_eq!(fit(&[&[text(&path)], ways].concat()), all, "{ways:?}");
    }
    assert_eq!(all["harmonics"].as_u64(), Some(1));
    // The tone has an overtone, which contradicts the declared scene.
    assert_eq!(all["status"].as_str(), Some("ambiguous"));
    assert!((number(&all, "frequency_hz") - 8.0).abs() < 0.01);
    let refused = run(&["fit", text(&path), "--exclude", "everything"]);
    assert!(!refused.status.success() && stderr(&refused).contains("overtones"));
}

#[test]
fn the_unit_does_not_matter() {
    let folder = directory();
    let table = tone(4, 400, 100.0, 3.0, 0.0);
    let scaled = |factor: f64, offset: f64| {
        let mut lines = table.lines();
        let mut csv = lines.next().unwrap().to_owned();
        for line in lines {
            let mut fields = line.split(',');
            csv += &format!("\n{}", fields.next().unwrap());
            fields.for_each(|field| {
                csv += &format!(",{:e}", field.parse::<f64>().unwrap() * factor + offset)
            });
        }
        let path = file(folder.path(), "scaled.csv", &csv);
        fit(&[text(&path)])
    };
    let (plain, tiny, large) = (scaled(1.0, 0.0), scaled(1e-9, 0.0), scaled(1e6, 1e10));
    for other in [&tiny, &large] {
        let difference_hz = number(&plain, "frequency_hz") - number(other, "frequency_hz");
        assert!(
            difference_hz.abs() < 0.1 * number(&plain, "sigma_hz"),
            "{difference_hz}"
        );
    }
    assert!((number(&tiny["channels"][1], "amplitude") * 1e9 - 1.1).abs() < 0.02);
    assert!((number(&large["channels"][1], "offset") - 1.011e10).abs() < 0.02e6);
}

#[test]
fn jitter_of_the_stamps_and_missing_rows_are_harmless() {
    let folder = directory();
    let table = tone(16, 900, 35.6, 0.5, 0.001);
    let mut rows: Vec<&str> = table.lines().collect();
    rows.drain(301..304);
    let path = file(folder.path(), "jitter.csv", &rows.join("\n"));
    let found = fit(&[text(&path)]);
    assert!(
        (number(&found, "frequency_hz") / 0.5 - 1.0).abs() < 1e-3,
        "{found}"
    );
    assert_eq!(
        (found["rows"].as_u64(), found["rows_missing"].as_u64()),
        (Some(897), Some(3))
    );
}

#[test]
fn a_part_of_the_time_and_of_the_columns() {
    let folder = directory();
    let path = file(folder.path(), "tone.csv", &tone(20, 1000, 100.0, 4.0, 0.0));
    // More channels than the estimator takes at once.
    let found = fit(&[text(&path)]);
    assert_eq!(found["groups"].as_u64(), Some(2));
    assert!((number(&found, "frequency_hz") - 4.0).abs() < 0.01);
    let found = fit(&[
        text(&path),
        "--columns",
        "c7,c3",
        "--from",
        "2",
        "--to",
        "5.5",
    ]);
    assert!((number(&found, "frequency_hz") - 4.0).abs() < 0.01);
    assert_eq!(found["rows"].as_u64(), Some(351));
    let names: Vec<&str> = found["channels"]
        .as_array()
        .unwrap()
        .iter()
        .filter_map(|c| c["name"].as_str())
        .collect();
    assert_eq!(names, ["c7", "c3"]);
}

#[test]
fn without_time_the_rate_is_given() {
    let folder = directory();
    let table = tone(2, 500, 50.0, 2.0, 0.0);
    let without: Vec<&str> = table
        .lines()
        .map(|line| line.split_once(',').unwrap().1)
        .collect();
    let path = file(folder.path(), "no_time.csv", &without.join("\n"));
    assert_one_line(
        &run(&["fit", text(&path)]),
        1,
        &["no_time.csv", "time_s", "--rate"],
    );
    let found = fit(&[text(&path), "--rate", "50", "--from", "1", "--to", "9"]);
    assert!((number(&found, "frequency_hz") - 2.0).abs() < 0.01);
    assert_eq!(found["rows"].as_u64(), Some(401));
}

#[test]
fn what_cannot_be_used_is_listed_as_such() {
    let folder = directory();
    let table = tone(2, 400, 100.0, 5.0, 0.0);
    let mut csv = String::new();
    for (row, line) in table.lines().enumerate() {
        csv += &format!("{line},{}\n", if row == 0 { "stuck" } else { "7" });
    }
    let path = file(folder.path(), "stuck.csv", &csv);
    let found = fit(&[text(&path)]);
    let channels = found["channels"].as_array().unwrap();
    assert_eq!(channels[2]["name"].as_str(), Some("stuck"));
    assert_eq!(
        (&channels[0]["usable"], &channels[2]["usable"]),
        (&Value::Bool(true), &Value::Bool(false))
    );
    assert!(channels[2]["amplitude"].is_null());
}

#[test]
fn noise_alone_has_no_frequency() {
    let folder = directory();
    let path = file(folder.path(), "noise.csv", &tone(3, 400, 100.0, 0.0, 0.0));
    let found = fit(&[text(&path)]);
    assert_eq!(found["status"].as_str(), Some("no_tone"));
    assert!(found["frequency_hz"].is_null() && found["sigma_hz"].is_null());
    let output = run(&["fit", text(&path)]);
    assert!(
        output.status.success() && stdout(&output).contains("no_tone"),
        "{}",
        stderr(&output)
    );
}

#[test]
fn a_table_for_people() {
    let folder = directory();
    let path = file(folder.path(), "tone.csv", &tone(2, 500, 100.0, 5.0, 0.0));
    let output = run(&["fit", text(&path), "--harmonics", "1"]);
    let lines = stdout(&output);
    for name in [
        "frequency_hz",
        "sigma_hz",
        "status        good",
        "harmonics     1",
        "window_s",
        "rows          500",
        "c1",
    ] {
        assert!(lines.contains(name), "{name}: {lines}");
    }
}

#[test]
fn a_rate_against_the_stamps_is_reported() {
    let folder = directory();
    let path = file(folder.path(), "tone.csv", &tone(2, 400, 100.0, 5.0, 0.0));
    let output = run(&["fit", text(&path), "--rate", "50", "--json"]);
    assert!(output.status.success());
    let printed = common::stderr(&output);
    assert!(
        printed.contains("--rate 50 Hz") && printed.contains("100.0000 Hz"),
        "{printed}"
    );
    assert!(common::stderr(&run(&["fit", text(&path), "--rate", "100"])).is_empty());
}

/// Fits the guide's scene of 15 mm/s over 3.6 mm: contact, hold, slide, hold.
#[test]
fn the_slide_of_a_touch_is_found_and_all_else_is_fitted_whole() {
    let folder = directory();
    let scene = folder.path().join("slide.csv");
    let made = run(&[
        "emulate",
        "--scene-speed",
        "15",
        "--print-scene",
        text(&scene),
    ]);
    assert!(made.status.success(), "{}", stderr(&made));
    let found = fit(&[text(&scene)]);
    let hz = 15.0 / 3.6;
    assert_eq!(
        (found["part"].as_str(), found["status"].as_str()),
        (Some("slide"), Some("good")),
        "{found}"
    );
    assert!(
        (number(&found, "frequency_hz") - hz).abs() < 4.0 * number(&found, "sigma_hz"),
        "{found}"
    );
    let (from, to) = (number(&found, "from_s"), number(&found, "to_s"));
    assert!(to - from > 2.0 && from > 0.5, "{found}");
    let shown = stdout(&run(&["fit", text(&scene)]));
    assert!(shown.contains("part          the slide, "), "{shown}");
    let without_part = |mut found: Value| {
        found.as_object_mut().expect("an object").remove("part");
        found
    };
    // The same part selected by hand must yield the same fit.
    let (from, to) = (from.to_string(), to.to_string());
    let given = fit(&[text(&scene), "--from", &from, "--to", &to]);
    assert_eq!(given["part"], "given");
    assert_eq!(without_part(given), without_part(found));
    let whole = fit(&[text(&scene), "--whole"]);
    assert_eq!(whole["part"], "whole");
    assert!(number(&whole, "window_s") > 4.5 && whole["status"] != "good");
    // Without a touch, the whole file must be fitted, with or without the option.
    let path = file(folder.path(), "tone.csv", &tone(16, 1000, 241.0, 8.0, 0.0));
    let all = fit(&[text(&path)]);
    assert_eq!(all["part"], "whole");
    assert_eq!(all, fit(&[text(&path), "--whole"]));
}

#[test]
fn a_picture_has_the_numbers_of_the_fit_in_time_and_by_place() {
    let folder = directory();
    let rows = tone(2, 1000, 250.0, 8.0, 0.0);
    let mut lines = rows.lines();
    let mut table = format!("{},v_mm_s\n", lines.next().expect("a header"));
    lines.for_each(|row| table += &format!("{row},20.5\n"));
    let path = file(folder.path(), "tone.csv", &table);
    let svg = folder.path().join("fit.svg");
    for (options, field) in [
        (&["--columns", "c0,c1"][..], "frequency_hz"),
        (&["--speed-column", "v_mm_s"], "period_mm"),
    ] {
        let with_picture = [&[text(&path), "--svg", text(&svg)], options].concat();
        let found = number(&fit(&with_picture), field);
        let picture = std::fs::read_to_string(&svg).expect("a picture");
        let (_, title) = picture.split_once(">tone.csv: ").expect("a title");
        let shown: f64 = title.split(' ').next().unwrap().parse().unwrap();
        assert!((shown / found - 1.0).abs() < 1e-4, "{shown} for {found}");
        assert!(picture.contains(">c0<") && picture.contains(">c1<"));
        std::fs::remove_file(&svg).expect("it was written");
    }
}
