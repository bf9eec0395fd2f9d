//! Tests `ridgetone replay` and `ridgetone emulate --print-scene` with scenes and recordings.

mod common;
#[path = "common/raw_recording.rs"]
mod raw_recording;

use common::{assert_one_line, directory, json_lines, run, stderr, stdout, text};
use ridgetone_proto::settings::Settings;
use serde_json::Value;

fn of_type<'a>(events: &'a [Value], name: &str) -> Vec<&'a Value> {
    events
        .iter()
        .filter(|event| event["type"] == name)
        .collect()
}

fn slide_estimate(events: &[Value]) -> &Value {
    let estimates = of_type(events, "estimate");
    estimates
        .into_iter()
        .find(|event| event["span"] == "slide")
        .expect("an estimate over the slide")
}

#[test]
fn the_default_scene_is_understood() {
    let output = run(&["replay", "--json"]);
    let events = json_lines(&output);
    assert_eq!(events[0]["type"], "hello");
    assert_eq!(of_type(&events, "contact").len(), 1);
    assert!((of_type(&events, "contact")[0]["t_s"].as_f64().unwrap() - 0.51).abs() < 0.02);
    let slides = of_type(&events, "slide");
    assert_eq!(slides.len(), 2);
    assert_eq!(
        (&slides[0]["state"], &slides[1]["state"]),
        (&"start".into(), &"end".into())
    );
    assert_eq!(
        (&slides[0]["t_s"], &slides[1]["t_s"]),
        (&slides[1]["start_s"], &slides[1]["end_s"])
    );
    assert!((slides[1]["end_s"].as_f64().unwrap() - 3.51).abs() < 0.05);
    assert_eq!(of_type(&events, "release").len(), 1);
    let found = slide_estimate(&events);
    assert_eq!(found["status"], "good");
    assert!((found["frequency_hz"].as_f64().unwrap() / (30.0 / 3.6) - 1.0).abs() < 1e-3);
    assert_eq!(found["channels"].as_array().unwrap().len(), 16);
    for (number, event) in events.iter().enumerate() {
        assert_eq!(event["sequence"].as_u64(), Some(number as u64));
    }
    let messages = stderr(&output);
    assert_eq!(
        messages.lines().last(),
        Some(
            format!(
                "ridgetone: {} packets received, 0 lost, 0 damaged",
                events.len()
            )
            .as_str()
        )
    );
}

/// A texture's power in mV^2 must be rounded to two digits of its uncertainty.
#[test]
fn a_power_is_written_with_two_digits_of_its_uncertainty() {
    let lines = stdout(&run(&["replay"]));
    let power = lines
        .lines()
        .find_map(|line| line.split_once(" texture ")?.1.split_once(", power "))
        .expect("a texture")
        .1;
    let words: Vec<&str> = power.split([' ', ',']).take(5).collect();
    let [value, "mV^2", "+-", sigma, "mV^2"] = words[..] else {
        panic!("{power}");
    };
    let digits = sigma.trim_start_matches(['0', '.']).replace('.', "");
    assert_eq!(digits.len(), 2, "{power}");
    let decimals = |number: &str| number.split_once('.').map_or(0, |(_, digits)| digits.len());
    assert_eq!(decimals(value), decimals(sigma), "{power}");
}

#[test]
fn the_same_run_gives_the_same_lines() {
    let arguments = [
        "replay",
        "--json",
        "--scene-speed",
        "48",
        "--period",
        "3.1",
        "--snr",
        "6",
        "--seed",
        "7",
    ];
    assert_eq!(stdout(&run(&arguments)), stdout(&run(&arguments)));
    assert_ne!(
        stdout(&run(&arguments)),
        stdout(&run(&[&arguments[..8], &["8"]].concat()))
    );
}

#[test]
fn a_scene_written_down_and_replayed() {
    let folder = directory();
    let trace = folder.path().join("trace.csv");
    let output = run(&[
        "emulate",
        "--scene-speed",
        "15",
        "--period",
        "2.6",
        "--print-scene",
        text(&trace),
        "--json",
    ]);
    let truth = &json_lines(&output)[0];
    assert_eq!(truth["type"], "truth");
    assert!((truth["frequency_hz"].as_f64().unwrap() - 15.0 / 2.6).abs() < 1e-9);
    assert!(
        stderr(&output).contains("contact 0.510 s"),
        "{}",
        stderr(&output)
    );
    let table = std::fs::read_to_string(&trace).unwrap();
    assert!(table.starts_with("time_s,ain0,"));
    assert_eq!(
        table.lines().count() as u64,
        truth["rows"].as_u64().unwrap() + 1
    );

    let events = json_lines(&run(&["replay", text(&trace), "--json"]));
    let found = slide_estimate(&events)["frequency_hz"].as_f64().unwrap();
    assert!(
        (found / truth["frequency_hz"].as_f64().unwrap() - 1.0).abs() < 1e-3,
        "{found}"
    );

    // Write the same recording in millivolts, to be read with the matching scale.
    let mut millivolts = String::new();
    for (row, line) in table.lines().enumerate() {
        let fields =
            line.split(',')
                .enumerate()
                .map(|(column, field)| match field.parse::<f64>() {
                    Ok(volts) if row > 0 && column > 0 => (1e3 * volts).to_string(),
                    _ => field.to_owned(),
                });
        millivolts += &fields.collect::<Vec<_>>().join(",");
        millivolts.push('\n');
    }
    let scaled = common::file(folder.path(), "millivolts.csv", &millivolts);
    let events = json_lines(&run(&[
        "replay",
        text(&scaled),
        "--scale",
        "0.001",
        "--json",
    ]));
    assert!((slide_estimate(&events)["frequency_hz"].as_f64().unwrap() / found - 1.0).abs() < 1e-4);

    // A clipped recording contains no touch.
    let output = run(&["replay", text(&scaled)]);
    assert_eq!(output.status.code(), Some(3));
    let warning = stderr(&output).lines().next().unwrap().to_owned();
    assert!(
        warning.contains(" V is beyond +-4.096 V; ") && warning.contains("--scale"),
        "{warning}"
    );
}

#[test]
fn settings_reach_the_library() {
    let events = json_lines(&run(&[
        "replay",
        "--json",
        "--window",
        "0.5",
        "--stride",
        "0.1",
        "--harmonics",
        "2",
        "--speed",
        "30",
        "--set",
        "slide.delay_s=1",
        "--set",
        "slide.length_mm=45",
    ]));
    let settings = &events[0]["settings"];
    assert_eq!(settings["slide"]["rule"], "protocol");
    assert_eq!(
        (
            settings["window_s"].as_f64(),
            settings["harmonics"].as_u64()
        ),
        (Some(0.5), Some(2))
    );
    let slide = of_type(&events, "slide")[1];
    let length_s = slide["end_s"].as_f64().unwrap() - slide["start_s"].as_f64().unwrap();
    assert!((length_s - 1.5).abs() < 0.02, "{length_s}");
    assert!(of_type(&events, "estimate").len() > 8);
    assert!(
        (slide_estimate(&events)["frequency_hz"].as_f64().unwrap() / (30.0 / 3.6) - 1.0).abs()
            < 1e-3
    );
}

#[test]
fn commands_that_make_no_sense() {
    let status = 2;
    assert_one_line(
        &run(&["replay", "--window", "9"]),
        status,
        &["window_s", "9", "0.1", "3.9"],
    );
    assert_one_line(&run(&["replay", "--stride", "x"]), status, &["--stride"]);
    assert_one_line(
        &run(&["replay", "any.csv", "--period", "3"]),
        status,
        &["--period"],
    );
    assert_one_line(&run(&["replay", "--scale", "2"]), status, &["<FILE>"]);
    for (set, parts) in [
        ("array.pitch_mm=0", &["pitch_mm = 0", "0.1 to 100"][..]),
        (
            "slide.rule=sometimes",
            &["slide.rule", "found or protocol or always"],
        ),
        ("pitch=2", &["no setting `pitch`", "choose from"]),
        ("window_s", &["window_s: write NAME=VALUE"]),
    ] {
        assert_one_line(&run(&["replay", "--set", set]), status, parts);
    }
    assert_one_line(
        &run(&["emulate", "any.csv"]),
        status,
        &["any.csv", "`ridgetone replay any.csv`"],
    );
    assert_one_line(&run(&["fit"]), status, &["FILE.csv"]);
    assert_one_line(
        &run(&["fit", "any.csv", "--harmonics", "6"]),
        status,
        &["--harmonics"],
    );
    assert_one_line(
        &run(&["emulate", "--print-scene", "any.csv", "--scene-speed", "0"]),
        status,
        &["--scene-speed", "greater than 0"],
    );
    assert_one_line(&run(&["sing"]), status, &["sing"]);
    let help = run(&["emulate", "--help"]);
    assert!(help.status.success() && stdout(&help).contains("Examples:"));
}

#[test]
fn a_reader_that_leaves_early_is_no_error() {
    use std::process::Stdio;
    let mut child = common::ridgetone()
        .args(["replay", "--json"])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    drop(child.stdout.take());
    let output = child.wait_with_output().unwrap();
    assert!(
        output.status.success() && !stderr(&output).contains("thread 'main'"),
        "{}",
        stderr(&output)
    );
}

#[test]
fn a_recording_that_is_all_slide_gives_estimates() {
    let folder = common::directory();
    let path = common::file(
        folder.path(),
        "tone.csv",
        &common::tone(2, 1000, 241.0, 5.0, 0.0),
    );
    let replay = |options: &[&str]| {
        let all = &["replay", common::text(&path), "--scale", "0.01", "--json"];
        let output = run(&[all, options].concat());
        assert!(output.status.success(), "{}", stderr(&output));
        let printed = stderr(&output);
        let lines = printed.lines();
        let told: Vec<_> = lines.filter(|line| line.contains("always")).collect();
        assert!(
            told.len() == 1 && told[0].contains("no finger touches"),
            "{printed}"
        );
        json_lines(&output)
    };
    let events = replay(&[]);
    let estimates = of_type(&events, "estimate");
    assert!(estimates.len() > 10, "{}", estimates.len());
    for estimate in estimates {
        assert!(
            (estimate["frequency_hz"].as_f64().unwrap() - 5.0).abs() < 0.01,
            "{estimate}"
        );
    }
    let slides = of_type(&events, "slide");
    assert_eq!(slides.len(), 2);
    assert!(
        slides[1]["end_s"].as_f64().unwrap() > 4.0,
        "{:?}",
        slides[1]
    );
    // With a known speed, frequencies are converted to periods.
    let events = replay(&["--speed", "15"]);
    let period_mm = slide_estimate(&events)["spatial_period_mm"]
        .as_f64()
        .unwrap();
    assert!((period_mm - 3.0).abs() < 0.01, "{period_mm}");
}

/// A recording keeps its rate, with a tone above the limit of a scan at 241 frames a second. Events
/// must contain only its own channels, and nothing that is not in the file.
#[test]
fn a_recording_keeps_its_rate_and_its_channels_and_nothing_is_invented() {
    let folder = common::directory();
    let path = common::file(
        folder.path(),
        "fast.csv",
        &common::tone(3, 8000, 2000.0, 440.25, 0.02),
    );
    let output = run(&["replay", text(&path), "--scale", "0.01", "--json"]);
    assert!(output.status.success(), "{}", stderr(&output));
    let events = json_lines(&output);
    for event in &events {
        let kind = event["type"].as_str().expect("a type");
        assert!(["slide", "estimate", "texture"].contains(&kind), "{event}");
        if kind == "estimate" {
            let off_hz = (event["frequency_hz"].as_f64().unwrap() - 440.25).abs();
            assert!(off_hz < 0.05, "{event}");
            assert_eq!(event["status"], "good");
            assert_eq!(event["channels"].as_array().unwrap().len(), 3);
            assert!(event["spatial_period_mm"].is_null(), "{event}");
        }
    }
    assert!(of_type(&events, "estimate").len() > 10);
    for never in ["firmware", "frames received", "temperature"] {
        assert!(!stderr(&output).contains(never), "{}", stderr(&output));
    }
    assert_one_line(
        &run(&["replay", text(&path), "--scale", "0.01", "--plan", "hand"]),
        2,
        &["fast.csv", "2000.00 frames a second", "leave --plan out"],
    );
}

/// Replayed raw frames must yield the same estimates to the last digit with the board's own
/// settings; with other settings, those of a board that has these settings.
#[test]
fn a_recording_of_raw_frames_is_run_again_bit_for_bit() {
    let folder = common::directory();
    let recorded = |window_s: f32| {
        let settings = Settings {
            window_s,
            ..Settings::DEFAULT
        };
        let path = folder.path().join(format!("{window_s}.rec"));
        let bytes = raw_recording::of(hal_mock::Sliding::default(), settings);
        std::fs::write(&path, bytes).expect("a file");
        path
    };
    let results = |arguments: &[&str]| {
        let mut lines = json_lines(&run(&[&["replay", "--json"], arguments].concat()));
        for line in &mut lines {
            line.as_object_mut().expect("an object").remove("sequence");
        }
        let kinds = [
            "contact", "moving", "image", "slide", "estimate", "texture", "release",
        ];
        lines.retain(|line| kinds.contains(&line["type"].as_str().expect("a type")));
        lines
    };
    let (long, short) = (recorded(1.0), recorded(0.5));
    let expected = results(&[text(&short)]);
    assert!(of_type(&expected, "estimate").len() > 6);
    assert_eq!(results(&[text(&short), "--window", "0.5"]), expected);
    assert_eq!(results(&[text(&long), "--set", "window_s=0.5"]), expected);
}

#[test]
fn a_recording_without_an_estimate_is_explained() {
    let folder = common::directory();
    let mut csv = "time_s,a,b\n".to_owned();
    for row in 0..1000 {
        // The finger presses after two seconds, then holds.
        let level = if row < 482 { 0.0 } else { 0.2 };
        let noise = 1e-4 * f64::from(row * 7919 % 13 - 6);
        csv += &format!(
            "{:.6},{:.6},{:.6}\n",
            f64::from(row) / 241.0,
            level + noise,
            noise - level
        );
    }
    let path = common::file(folder.path(), "held.csv", &csv);
    for options in [&[][..], &["--json"]] {
        let output = common::run(&[&["replay", common::text(&path)], options].concat());
        let printed = common::stderr(&output);
        assert_eq!(output.status.code(), Some(3), "{printed}");
        let last = printed.lines().last().expect("a line");
        assert!(
            last.contains("no estimate")
                && last.contains("no slide was found")
                && last.contains("always"),
            "{printed}"
        );
    }
}

/// Rows of five samples, with the time of the first or without times.
#[test]
fn rows_of_several_samples_are_played_one_after_the_other() {
    let folder = directory();
    let value = |sample: u32| {
        let noise = 1e-3 * f64::from(sample * 7919 % 13);
        (std::f64::consts::TAU * 43.3e-3 * f64::from(sample)).sin() + noise
    };
    let rows = |is_stamped: bool| -> String {
        let row = |row: u32| {
            let values: Vec<String> = (5 * row..5 * row + 5)
                .map(|sample| format!("{:.5}", value(sample)))
                .collect();
            let stamp = format!("{:.3},", 5e-3 * f64::from(row));
            format!(
                "{}{}\n",
                if is_stamped { &stamp } else { "" },
                values.join(",")
            )
        };
        let header = if is_stamped {
            "time_s,a,b,c,d,e\n"
        } else {
            "a,b,c,d,e\n"
        };
        header.to_owned() + &(0..600).map(row).collect::<String>()
    };
    for (is_stamped, options) in [(true, &[][..]), (false, &["--rate", "1000"])] {
        let path = common::file(folder.path(), "rows.csv", &rows(is_stamped));
        let given = [&["replay", text(&path), "--json", "--flatten"], options].concat();
        let events = json_lines(&run(&given));
        let estimates = of_type(&events, "estimate");
        assert!(estimates.len() > 2, "{events:?}");
        for found in estimates {
            let number = |name: &str| found[name].as_f64().unwrap_or(f64::NAN);
            let off = (number("frequency_hz") - 43.3).abs();
            assert!(off < 4.0 * number("sigma_hz") && off < 0.1, "{found}");
            assert_eq!(found["channels"].as_array().map(Vec::len), Some(1));
        }
    }
}

#[test]
fn lines_of_a_table_have_its_columns_and_units() {
    let folder = directory();
    let row = |row: u32| {
        let t_s = 1e-3 * f64::from(row);
        let x = (std::f64::consts::TAU * 43.3 * t_s).sin();
        format!(
            "{t_s:.3},{:.5},{:.5}\n",
            2.0 * x,
            x + 1e-3 * f64::from(row * 7919 % 13)
        )
    };
    let csv = "time_s,gap (mm),x\n".to_owned() + &(0..2000).map(row).collect::<String>();
    let path = common::file(folder.path(), "gap.csv", &csv);
    let printed = stdout(&run(&["replay", text(&path)]));
    let is_named = |line: &str| line.contains("most 2.00") && line.ends_with(" mm in gap (mm)");
    let estimates: Vec<&str> = printed
        .lines()
        .filter(|line| line.contains("estimate"))
        .collect();
    assert!(
        estimates.len() > 2 && estimates.iter().all(|line| is_named(line)),
        "{printed}"
    );
}
