//! Tests that an error is reported on one line that names its location, and that no half-written
//! file remains.

mod common;

use common::{assert_one_line, directory, file, run, text, tone};

#[test]
fn files_that_are_no_tables() {
    let folder = directory();
    let in_file = |name: &str, content: &str| file(folder.path(), name, content);
    let missing = folder.path().join("missing.csv");
    let rows: String = (0..40).map(|row| format!("0.{row:02},{row}\n")).collect();
    let backwards = format!("time_s,a\n{rows}0.005,3\n");
    let cases = [
        (missing, vec!["missing.csv", "No such file"]),
        (in_file("empty.csv", ""), vec!["empty.csv", "empty"]),
        (
            in_file("header.csv", "time_s,a\n"),
            vec!["header.csv", "no data"],
        ),
        (
            in_file("columns.csv", "time_s,a,b\n0,1,2\n0.1,3\n"),
            vec!["columns.csv", "line 3", "2 columns", "3"],
        ),
        (
            in_file("words.csv", "these are\nno numbers\n"),
            vec!["words.csv", "line 2", "no table"],
        ),
        (
            in_file("nan.csv", "time_s,a\n0,1\nNaN,1\n"),
            vec!["nan.csv", "line 3", "column time_s", "NaN"],
        ),
        (
            in_file("est.csv", "t_s,frequency_hz,sigma_hz\n0,1,0.1\n"),
            vec!["est.csv", "these are estimates"],
        ),
        (
            // The row comes too late to be sorted into its place.
            in_file("backwards.csv", &backwards),
            vec!["backwards.csv", "line 42", "does not increase", "--rate HZ"],
        ),
        (
            in_file("binary.csv", "time_s,a\n0,\u{0}\n"),
            vec!["binary.csv", "neither text nor a recording"],
        ),
    ];
    for (path, parts) in &cases {
        assert_one_line(&run(&["fit", text(path)]), 1, parts);
        assert_one_line(&run(&["replay", text(path)]), 1, parts);
    }
    assert_one_line(&run(&["fit", text(folder.path())]), 1, &["directory"]);
}

/// The error message for such recordings contains a `fit` command that accepts them.
#[test]
fn recordings_outside_the_rates_of_touch_are_refused_with_a_command_that_works() {
    let folder = directory();
    for (name, rate_hz, rows) in [
        ("hourly.csv", 1.0 / 800.0, 200),
        ("slow one.csv", 100.0, 400),
        ("fast.csv", 44_100.0, 60_000),
    ] {
        let path = file(
            folder.path(),
            name,
            &tone(1, rows, rate_hz, 0.05 * rate_hz, 0.0),
        );
        let refused = run(&["replay", text(&path)]);
        assert_one_line(&refused, 1, &[name, "rows a second", "180 to 23740"]);
        let message = common::stderr(&refused);
        let command = message
            .split('`')
            .find_map(|part| part.strip_prefix("ridgetone fit --window "))
            .expect("a command");
        let (window, file) = command.split_once(' ').expect("a file");
        let file = file.trim_matches('\'');
        let fit = run(&["fit", "--window", window, file, "--json"]);
        assert!(fit.status.success(), "{}", common::stderr(&fit));
        let good = common::json_lines(&fit);
        assert!(
            good.iter().any(|line| line["status"] == "good"),
            "{name}: {good:?}"
        );
    }
}

#[test]
fn windows_outside_the_data() {
    let folder = directory();
    let path = file(folder.path(), "tone.csv", &tone(2, 400, 100.0, 5.0, 0.0));
    let fit = |arguments: &[&str]| run(&[&["fit", text(&path)], arguments].concat());
    assert_one_line(&fit(&["--to", "5"]), 1, &["tone.csv", "--to 5", "3.99"]);
    assert_one_line(&fit(&["--from", "4.5"]), 1, &["tone.csv", "--from 4.5"]);
    assert_one_line(&fit(&["--from", "-1"]), 1, &["tone.csv", "--from -1"]);
    assert_one_line(
        &fit(&["--from", "2", "--to", "1"]),
        1,
        &["--from 2", "--to 1"],
    );
    assert!(fit(&["--from", "0", "--to", "4"]).status.success());
    assert_one_line(
        &fit(&["--columns", "c0,c9"]),
        1,
        &["tone.csv", "c9", "c0, c1"],
    );
    assert_one_line(&fit(&["--columns", "c0,c0"]), 1, &["c0 twice"]);
}

#[test]
fn windows_longer_than_the_recording() {
    let folder = directory();
    let path = file(folder.path(), "short.csv", &tone(2, 160, 200.0, 5.0, 0.0));
    assert_one_line(
        &run(&["replay", text(&path)]),
        1,
        &["short.csv", "0.8", "1 s", "--window"],
    );
    // The recording is played, but contains no touch.
    let played = run(&["replay", text(&path), "--window", "0.5"]);
    assert_eq!(played.status.code(), Some(3));
}

#[test]
fn too_many_uneven_rows_and_a_pause() {
    let folder = directory();
    let mut uneven = String::from("time_s,a");
    for row in 0..65_538 {
        let t_s = f64::from(row / 2) * 0.001 + f64::from(row % 2) * 0.0008;
        uneven += &format!("\n{t_s:.4},{:.3}", (31.4 * t_s).sin());
    }
    let long = file(folder.path(), "long.csv", &uneven);
    assert_one_line(
        &run(&["fit", text(&long), "--whole"]),
        1,
        &["long.csv", "65538", "65536", "--from", "--window"],
    );
    assert!(
        run(&["fit", text(&long), "--from", "0.0015"])
            .status
            .success()
    );

    let table = tone(1, 200, 100.0, 5.0, 0.0);
    let paused = table.replace("\n1.000000,", "\n61.000000,");
    let rows: Vec<&str> = paused.lines().take(102).collect();
    let paused = file(folder.path(), "paused.csv", &rows.join("\n"));
    assert_one_line(
        &run(&["fit", text(&paused)]),
        1,
        &["paused.csv", "row 101", "gap of 60.0100 s"],
    );
}

#[test]
fn values_out_of_reach() {
    let folder = directory();
    let path = file(
        folder.path(),
        "huge.csv",
        "time_s,a\n0,-1e308\n1,1e308\n2,0\n",
    );
    assert_one_line(&run(&["fit", text(&path)]), 1, &["huge.csv", "column a"]);
    let many = file(folder.path(), "many.csv", &tone(17, 20, 100.0, 5.0, 0.0));
    assert_one_line(
        &run(&["replay", text(&many)]),
        1,
        &["many.csv", "17 channels"],
    );
}

#[test]
fn a_file_is_written_whole_or_not_at_all() {
    let folder = directory();
    let nowhere = folder.path().join("no/such/folder/scene.csv");
    assert_one_line(
        &run(&["emulate", "--print-scene", text(&nowhere)]),
        1,
        &["scene.csv"],
    );
    let taken = folder.path().join("taken");
    std::fs::create_dir(&taken).unwrap();
    assert_one_line(
        &run(&["emulate", "--print-scene", text(&taken)]),
        1,
        &["taken"],
    );
    let found: Vec<_> = std::fs::read_dir(folder.path())
        .unwrap()
        .map(|entry| entry.unwrap().file_name())
        .collect();
    assert_eq!(found, ["taken"]);
}

#[test]
fn inputs_that_would_play_for_ever() {
    let folder = directory();
    let month = file(
        folder.path(),
        "month.csv",
        "time_s,a\n0,1\n2592000,2\n5184000,1\n",
    );
    assert_one_line(
        &run(&["replay", text(&month)]),
        1,
        &["month.csv", "rows a second", "ridgetone fit --window"],
    );
    assert_one_line(
        &run(&["replay", "--scene-speed", "1e-6"]),
        1,
        &["scene", "3600 s"],
    );
    let scene = folder.path().join("scene.csv");
    assert_one_line(
        &run(&[
            "emulate",
            "--scene-speed",
            "1e-6",
            "--print-scene",
            text(&scene),
        ]),
        1,
        &["scene", "3600 s"],
    );
    assert!(!scene.exists());
}

/// An endless device must be read only up to a limit, with little memory.
#[cfg(target_os = "linux")]
#[test]
fn devices_that_never_end_are_refused() {
    for device in ["/dev/zero", "/dev/urandom"] {
        for arguments in [
            &["fit", device][..],
            &[
                "calibrate",
                &format!("2.6={device}"),
                &format!("3.6={device}"),
            ],
            &["replay", device],
            &["replay", "--settings", device],
            &["replay", "--scene", device],
            &["fit", device, "--positions", device],
            &["export", device, "--format", "ndjson"],
            &["monitor", "--plain", "--file", device],
            &["emulate", "--elf", device],
        ] {
            let mut limited = std::process::Command::new("sh");
            limited.args(["-c", r#"ulimit -v 2000000; exec timeout 60 "$0" "$@""#]);
            let program = common::ridgetone().get_program().to_owned();
            let output = limited
                .arg(program)
                .args(arguments)
                .output()
                .expect("it runs");
            let code = output.status.code();
            assert_eq!(code, Some(1), "{arguments:?}: {}", common::stderr(&output));
        }
    }
}

/// Scenes with physically impossible sizes must be refused.
#[test]
fn scenes_that_no_thing_has_are_refused() {
    let folder = directory();
    let out = folder.path().join("scene.csv");
    for (key, value) in [
        ("snr_db", "-1e9"),
        ("speed_mm_s", "1e30"),
        ("[finger]\nforce_n", "1e30"),
        ("[finger]\nmodulus_mpa", "1e-30"),
        ("[hand]\nswing_hz", "1e9"),
    ] {
        let scene = file(folder.path(), "a.toml", &format!("{key} = {value}\n"));
        let name = key.lines().last().expect("a key");
        let scene = run(&["emulate", text(&scene), "--print-scene", text(&out)]);
        assert_one_line(&scene, 1, &["a.toml", name]);
    }
    assert!(!out.exists());
}

#[test]
fn a_grating_too_fine_for_the_scan_is_reported() {
    let output = run(&["replay", "--period", "0.2", "--json"]);
    assert!(output.status.success());
    assert!(
        common::stderr(&output).contains("150.0 Hz is too fast"),
        "{}",
        common::stderr(&output)
    );
}
