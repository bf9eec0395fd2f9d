//! `ridgetone touch`: files, what is refused, and the page in a browser, which `cargo xtask test
//! --all` installs.
#![cfg(target_os = "linux")]

#[path = "../../host/tests/common/mod.rs"]
mod common;
#[path = "touch/page.rs"]
mod page;

use common::{assert_one_line, directory, file, run, stderr, text};
use std::f64::consts::TAU;
use std::path::Path;
use std::process::Command;

/// A texture in whose middle the paper's law has a plateau.
fn texture(folder: &Path) -> String {
    text(&file(
        folder,
        "texture.toml",
        "period_mm = 1.4\nperiod_sigma_mm = 0.001\n",
    ))
    .to_owned()
}

/// Equations 2 and 3 of Okamoto et al. in f64, over the actuator's greatest amplitude.
fn share(x: f64) -> f64 {
    (30770.0 * x.powi(4) - 162_663.0 * x.powi(3) + 309_743.0 * x * x - 248_938.0 * x + 72298.0)
        / 6000.0
}

/// What a program of somebody else reads in the file: Python's `wave`.
#[test]
fn a_wav_is_the_papers_sine() {
    let folder = directory();
    let out = folder.path().join("out.wav");
    let made = run(&[
        "touch",
        &texture(folder.path()),
        "--speed-mm-s",
        "140",
        "--for",
        "1.5",
        "-o",
        text(&out),
    ]);
    assert!(
        made.status.success() && stderr(&made).contains("100.0 Hz"),
        "{}",
        stderr(&made)
    );
    let script = "import sys, wave\nw = wave.open(sys.argv[1])\nprint(*w.getparams()[:4])\n\
        b = w.readframes(w.getnframes())\nprint(*[int.from_bytes(b[n:n + 2], 'little', signed=True) for n in range(0, len(b), 2)])";
    let read = Command::new("python3")
        .args(["-c", script, text(&out)])
        .output()
        .expect("Python 3 is there");
    let read = common::stdout(&read);
    let (header, samples) = read.split_once('\n').expect("two lines");
    assert_eq!(header, "1 2 48000 72000");
    let samples: Vec<f64> = samples
        .split_whitespace()
        .map(|y| y.parse::<f64>().expect("a number") / 32767.0)
        .collect();
    for (n, y) in samples.iter().enumerate().skip(4800).take(60_000) {
        // 140 mm/s over 1.4 mm.
        let expected = share(1.4) * (TAU * 100.0 * n as f64 / 48_000.0).sin();
        assert!((y - expected).abs() < 0.01, "{n}: {y} {expected}");
    }
    // The raw samples are those of the file.
    let raw = run(&[
        "touch",
        &texture(folder.path()),
        "--speed-mm-s",
        "140",
        "--for",
        "1.5",
        "-o",
        "-",
    ]);
    assert_eq!(raw.stdout, std::fs::read(&out).expect("a file")[44..]);
    let again = run(&[
        "touch",
        &texture(folder.path()),
        "--speed-mm-s",
        "140",
        "-o",
        text(&out),
    ]);
    assert_one_line(&again, 1, &["out.wav", "--force"]);
}

#[test]
fn an_ahap_has_the_intensity_of_the_law_and_follows_the_hand() {
    let folder = directory();
    let pattern = |name: &str, more: &[&str]| -> Vec<[f64; 3]> {
        let out = folder.path().join(name);
        let texture = texture(folder.path());
        let made = run(&[
            &["touch", &texture, "--speed-mm-s", "140", "-o", text(&out)],
            more,
        ]
        .concat());
        assert!(made.status.success(), "{}", stderr(&made));
        let pattern: serde_json::Value =
            serde_json::from_slice(&std::fs::read(&out).expect("a file")).expect("JSON");
        assert_eq!(pattern["Version"], 1.0);
        let events = pattern["Pattern"]
            .as_array()
            .expect("events")
            .iter()
            .map(|event| {
                let event = &event["Event"];
                assert_eq!(
                    (&event["EventType"], &event["EventDuration"]),
                    (&"HapticContinuous".into(), &0.05.into())
                );
                let value = |n: usize| {
                    event["EventParameters"][n]["ParameterValue"]
                        .as_f64()
                        .expect("a number")
                };
                [event["Time"].as_f64().expect("a time"), value(0), value(1)]
            });
        events.collect()
    };
    let steady = pattern("steady.ahap", &[]);
    assert_eq!(steady.len(), 40);
    for (n, [t_s, intensity, sharpness]) in steady.iter().enumerate().skip(1).take(37) {
        assert!((t_s - 0.05 * n as f64).abs() < 1e-9, "{t_s}");
        // 100 Hz is at 20 of 150.
        assert!(
            (intensity - share(1.4)).abs() < 2e-3 && (sharpness - 20.0 / 150.0).abs() < 2e-3,
            "{steady:?}"
        );
    }
    // A hand that turns once a second is at rest at 0, 0.5 and 1 s, and 120 ms later with the
    // delay.
    let turning = pattern("turning.ahap", &["--turns-hz", "1"]);
    let delayed = pattern("delayed.ahap", &["--turns-hz", "1", "--delay-ms", "100"]);
    assert!(turning[20][2] == 0.0 && turning[25][2] > 0.4, "{turning:?}");
    for n in 8..36 {
        assert!((turning[n][2] - delayed[n + 2][2]).abs() < 2e-3, "{n}");
    }
}

#[test]
fn what_is_impossible_is_refused_on_one_line() {
    let folder = directory();
    let good = texture(folder.path());
    let out = folder.path().join("out.wav");
    let to = ["--speed-mm-s", "100", "-o", text(&out)];
    for (content, words) in [
        (
            "period_mm = nan\n",
            &["bad.toml", "period_mm", "0.05 to 100"][..],
        ),
        ("period_mm = 0.0\n", &["period_mm = 0", "0.05 to 100"]),
        ("period_mm = 1.0\npower = inf\n", &["power"]),
        ("period_mm = 1.0\npower = -1.0\n", &["power = -1"]),
        ("speed = 3\n", &["bad.toml", "period_mm"]),
    ] {
        let bad = file(folder.path(), "bad.toml", content);
        let refused = run(&[&["touch", text(&bad)], &to[..]].concat());
        let printed = stderr(&refused);
        assert!(
            refused.status.code() == Some(1) && words.iter().all(|word| printed.contains(word)),
            "{printed}"
        );
    }
    let refused = |arguments: &[&str], words: &[&str]| {
        assert_one_line(
            &run(&[&["touch", good.as_str()], arguments].concat()),
            2,
            words,
        );
    };
    refused(&[&to[..], &["--slew-v-s", "0.1"]].concat(), &["slew_v_s"]);
    refused(&[&to[..], &["--cutoff-hz", "1e6"]].concat(), &["cutoff_hz"]);
    refused(&[&to[..], &["--delay-ms", "-1"]].concat(), &["--delay-ms"]);
    refused(
        &[&to[..], &["--delay-ms", "NaN"]].concat(),
        &["not a number"],
    );
    refused(
        &[&to[..], &["--jitter-ms", "900"]].concat(),
        &["--jitter-ms 900", "0 to 500"],
    );
    refused(&[&to[..], &["--turns-hz", "99"]].concat(), &["--turns-hz"]);
    refused(&[&to[..], &["--for", "1e9"]].concat(), &["--for"]);
    refused(&["--speed-mm-s", "100"], &["-o out.wav"]);
    refused(&["-o", text(&out)], &["--speed-mm-s"]);
    refused(
        &["--speed-mm-s", "100", "-o", "out.mp3"],
        &["out.mp3", ".wav"],
    );
    refused(&["--emulated"], &["--emulated"]);
    refused(
        &[&to[..], &["--carrier-hz", "100"]].concat(),
        &["--carrier-hz", "150 to 250"],
    );
    let ahap = [
        "--speed-mm-s",
        "100",
        "-o",
        "out.ahap",
        "--carrier-hz",
        "200",
    ];
    refused(&ahap, &["--carrier-hz", ".wav"]);
    assert!(!out.exists());
}

/// 140 mm/s over 1.4 mm are 100 Hz, which a tone of 200 Hz carries.
#[test]
fn a_carrier_sounds_as_loud_as_the_texture_is_high() {
    let folder = directory();
    let arguments = ["--speed-mm-s", "140", "--carrier-hz", "200", "-o", "-"];
    let raw = run(&[&["touch", &texture(folder.path())], &arguments[..]].concat());
    assert!(raw.status.success(), "{}", stderr(&raw));
    let samples = raw.stdout.chunks_exact(2);
    let samples = samples.map(|b| f64::from(i16::from_le_bytes([b[0], b[1]])) / 32767.0);
    for (n, y) in samples.enumerate().skip(4800).take(60_000) {
        let t_s = n as f64 / 48_000.0;
        let surface = 0.5 + 0.5 * (TAU * 100.0 * t_s).sin();
        let expected = share(1.4) * surface * (TAU * 200.0 * t_s).sin();
        assert!((y - expected).abs() < 0.01, "{n}: {y} {expected}");
    }
}

/// Never a step beyond the slew, even of an actuator that is far slower than the texture.
#[test]
fn a_slow_actuator_is_not_driven_faster() {
    let folder = directory();
    let arguments = [
        "--speed-mm-s",
        "300",
        "--turns-hz",
        "2",
        "--delay-ms",
        "120",
        "--jitter-ms",
        "40",
        "-o",
        "-",
    ];
    let raw = run(&[
        &["touch", &texture(folder.path()), "--slew-v-s", "9000"],
        &arguments[..],
    ]
    .concat());
    assert!(raw.status.success(), "{}", stderr(&raw));
    let samples: Vec<f64> = raw
        .stdout
        .chunks_exact(2)
        .map(|b| f64::from(i16::from_le_bytes([b[0], b[1]])) / 32767.0)
        .collect();
    let most = samples
        .windows(2)
        .map(|pair| (pair[1] - pair[0]).abs())
        .fold(0.0, f64::max);
    // 9000 V/s over 75 V and 48 kHz, and the rounding of two samples.
    assert!((0.002..0.0025 + 1.0 / 32767.0).contains(&most), "{most}");
}
