//! Tests commands that show, record and query a board, with the emulated board.

use crate::common::{directory, json_lines, run, stderr, stdout, text};

#[test]
#[ignore = "needs the emulator: cargo xtask test"]
fn the_emulated_board_is_recorded_with_raw_frames_from_which_the_library_gets_the_same_tone() {
    let folder = directory();
    let recording = folder.path().join("touch.rec");
    let recorded = run(&["record", "--emulated", "--raw", "-o", text(&recording)]);
    assert!(recorded.status.success(), "{}", stderr(&recorded));
    assert!(
        stderr(&recorded).contains("0 lost, 0 damaged"),
        "{}",
        stderr(&recorded)
    );
    let events = json_lines(&run(&["replay", text(&recording), "--json"]));
    let tone = |lines: &[serde_json::Value]| {
        // While raw frames are sent, the board has no time to fit the whole slide, whose frames are
        // overwritten.
        let last = lines
            .iter()
            .rfind(|line| line["type"] == "estimate" && line["status"] == "good")
            .expect("an estimate");
        last["frequency_hz"].as_f64().expect("a tone")
    };
    let numbers: Vec<u64> = events
        .iter()
        .filter(|line| line["type"] == "raw")
        .filter_map(|line| line["number"].as_u64())
        .collect();
    assert!(
        numbers.len() > 1000 && numbers.windows(2).all(|pair| pair[1] == pair[0] + 1),
        "{}",
        numbers.len()
    );
    let again = json_lines(&run(&[
        "replay",
        text(&recording),
        "--set",
        "window_s=1",
        "--json",
    ]));
    // The tone must be that of the first scene, 15 mm/s over 3.6 mm, on the board and from its
    // frames.
    for found in [tone(&events), tone(&again)] {
        assert!((found / (15.0 / 3.6) - 1.0).abs() < 1e-3, "{found} Hz");
    }
}

#[test]
#[ignore = "needs the emulator: cargo xtask test"]
fn the_emulated_board_reports_its_settings_takes_others_and_refuses_what_is_out_of_bounds() {
    let folder = directory();
    let found = run(&["settings", "get", "--emulated"]);
    assert!(found.status.success(), "{}", stderr(&found));
    let file = crate::common::file(folder.path(), "finger.toml", &stdout(&found));
    assert_eq!(
        ridgetone_host::settings_form::load(&file).expect("settings"),
        Default::default()
    );
    let set = run(&["settings", "set", "--emulated", "window_s=0.5", "--keep"]);
    assert!(
        set.status.success() && stderr(&set).contains("in force and stored"),
        "{}",
        stderr(&set)
    );
    let file = crate::common::file(
        folder.path(),
        "short.toml",
        "window_s = 0.5\nstride_s = 0.5\n",
    );
    let lines = run(&[
        "monitor",
        "--emulated",
        "--once",
        "--json",
        "--settings",
        text(&file),
    ]);
    let lines = json_lines(&lines);
    let windows: Vec<f64> = lines
        .iter()
        .filter(|line| line["span"] == "window")
        .filter_map(|line| line["window_s"].as_f64())
        .collect();
    assert!(
        windows.len() >= 3 && windows.iter().all(|window_s| (window_s - 0.5).abs() < 0.01),
        "{windows:?}"
    );
}

/// With settings from a file, the firmware must report the same for the default scene as the
/// library on the PC.
#[test]
#[ignore = "needs the emulator: cargo xtask test"]
fn an_emulated_run_takes_a_file_of_settings_as_a_replay_does() {
    let folder = directory();
    let file = crate::common::file(
        folder.path(),
        "short.toml",
        "window_s = 0.5\nharmonics = 2\n",
    );
    let estimates = |command: &str| {
        let output = run(&[
            command,
            "--json",
            "--settings",
            text(&file),
            "--stride",
            "0.125",
        ]);
        assert!(output.status.success(), "{}", stderr(&output));
        let mut lines = json_lines(&output);
        lines.retain_mut(|line| {
            // Sequence numbers differ, because they include replies.
            line.as_object_mut().expect("an object").remove("sequence");
            line["type"] == "estimate"
        });
        lines
    };
    let found = estimates("emulate");
    assert!(found.len() > 10, "{}", found.len());
    // The board stamps some conversions a microsecond later than the replay, whose chip starts at a
    // whole microsecond.
    let here = estimates("replay");
    assert_eq!(found.len(), here.len());
    for (found, here) in found.iter().zip(&here) {
        for key in ["span", "status", "harmonics"] {
            assert_eq!(found[key], here[key], "{found} {here}");
        }
        let of = |key: &str| [found, here].map(|line| line[key].as_f64().expect("a number"));
        let ([hz, here_hz], [t_s, here_t_s]) = (of("frequency_hz"), of("t_s"));
        assert!((hz / here_hz - 1.0).abs() < 5e-6, "{found} {here}");
        assert!((t_s - here_t_s).abs() < 1.5e-6, "{found} {here}");
    }
    let demo = run(&["demo", "--settings", text(&file)]);
    assert!(
        demo.status.success() && stdout(&demo).contains("6.06"),
        "{}",
        stderr(&demo)
    );
}

#[test]
#[ignore = "needs the emulator: cargo xtask test"]
fn each_message_of_an_emulated_run_has_the_time_at_which_it_left_the_board() {
    let output = run(&["emulate", "--json"]);
    assert!(output.status.success(), "{}", stderr(&output));
    let lines = json_lines(&output);
    let (truth, messages) = lines.split_last().expect("lines");
    let of = |line: &serde_json::Value, key: &str| line[key].as_f64();
    let (mut before_s, mut events) = (0.0, 0);
    for message in messages {
        let left_s = of(message, "left_s").expect("a time");
        assert!(left_s >= before_s, "{message}");
        before_s = left_s;
        if let Some(after_s) = of(message, "reported_after_s") {
            // Time on the line, including packets queued before the event.
            let waited_s = left_s - of(message, "t_s").expect("a time") - after_s;
            assert!((-0.001..0.03).contains(&waited_s), "{waited_s}: {message}");
            events += 1;
        }
        for (key, of_truth) in [("start_s", "slide_start_s"), ("end_s", "slide_end_s")] {
            if let Some(t_s) = of(message, key).filter(|_| message["type"] == "slide") {
                let off_s = t_s - of(truth, of_truth).expect("a time");
                assert!(off_s.abs() < 0.02, "{off_s}: {message}");
            }
        }
    }
    assert!(truth["type"] == "truth" && events >= 4, "{truth} {events}");
}

#[test]
#[ignore = "needs the emulator: cargo xtask test"]
fn the_emulated_board_obeys_commands() {
    for request in ["start", "stop", "restart"] {
        let done = run(&["command", request, "--emulated"]);
        assert!(
            done.status.success() && stderr(&done).contains("emulated board: "),
            "{request:?}: {}",
            stderr(&done)
        );
    }
}

/// The emulated board must pass its check, which gives a reason for each point that it does not
/// judge.
#[test]
#[ignore = "needs the emulator: cargo xtask test"]
fn the_emulated_board_passes_its_check() {
    let folder = directory();
    let report = folder.path().join("check.json");
    let lines = json_lines(&run(&[
        "check",
        "--emulated",
        "--for",
        "5",
        "--json",
        "-o",
        text(&report),
    ]));
    let (summary, checks) = lines.split_last().expect("lines");
    let verdicts = |verdict: &str| -> Vec<&str> {
        checks
            .iter()
            .filter(|check| check["verdict"] == verdict)
            .filter_map(|check| check["name"].as_str())
            .collect()
    };
    assert_eq!(verdicts("skipped"), ["noise"], "{checks:?}");
    assert_eq!(
        (verdicts("pass").len(), &summary["verdict"]),
        (checks.len() - 1, &"pass".into()),
        "{checks:?}"
    );
    let whole: serde_json::Value =
        serde_json::from_slice(&std::fs::read(&report).expect("a report")).expect("JSON");
    assert_eq!(&whole["summary"], summary);
    let again = run(&["check", "--emulated", "-o", text(&report)]);
    crate::common::assert_one_line(&again, 1, &["exists"]);
}
