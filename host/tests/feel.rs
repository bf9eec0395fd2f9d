//! `ridgetone feel` on vibrations and surfaces that are made here.

mod common;

use common::{assert_one_line, directory, file, json_lines, run, stderr, stdout, text};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use serde_json::Value;
use std::f64::consts::TAU;
use std::fmt::Write;
use std::path::{Path, PathBuf};

const RATE_HZ: f64 = 2048.0;
const ROWS: usize = 4096;
/// 100 Hz.
const REFERENCE: &str = "ra_um=0.5,rsm_mm=0.1,speed_mm_s=10";

fn number(object: &Value, name: &str) -> f64 {
    object[name]
        .as_f64()
        .unwrap_or_else(|| panic!("{name} in {object}"))
}

/// A table of channels without time stamps, at `RATE_HZ`.
fn table<const N: usize>(
    folder: &Path,
    name: &str,
    rows: usize,
    value: impl Fn(f64) -> [f64; N],
) -> PathBuf {
    let mut csv: String = (0..N)
        .map(|c| format!("{}c{c}", if c > 0 { "," } else { "" }))
        .collect();
    for row in 0..rows {
        csv.push('\n');
        for (c, value) in value(row as f64 / RATE_HZ).into_iter().enumerate() {
            let _ = write!(csv, "{}{value:.7}", if c > 0 { "," } else { "" });
        }
    }
    file(folder, name, &csv)
}

fn sine(amplitude: f64, hz: f64, t_s: f64) -> f64 {
    amplitude * (TAU * hz * t_s).sin()
}

/// A surface without a period: lines of random phase in a low and in a high band, um from peak to
/// peak.
fn surface(seed: u64, low_um: f64, high_um: f64) -> Vec<f64> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut values = vec![0.0; ROWS];
    let lines = (8..800).map(|k| (k, if k < 200 { low_um } else { high_um }));
    for (k, um) in lines {
        let (phase, um) = (
            TAU * f64::from(random.next_u32()) / 2f64.powi(32),
            um * (0.5 + f64::from(random.next_u32()) / 2f64.powi(32)),
        );
        for (row, value) in values.iter_mut().enumerate() {
            *value += um * (TAU * f64::from(k) * row as f64 / ROWS as f64 + phase).cos();
        }
    }
    values
}

fn feel(path: &Path, more: &[&str]) -> Value {
    let lines = json_lines(&run(&[
        &["feel", text(path), "--rate", "2048", "--json"],
        more,
    ]
    .concat()));
    assert_eq!(lines.len(), 1);
    lines[0].clone()
}

fn receptor<'v>(found: &'v Value, name: &str) -> &'v Value {
    let receptors = found["receptors"].as_array().expect("receptors");
    receptors
        .iter()
        .find(|receptor| receptor["receptor"] == name)
        .expect("the receptor")
}

/// A reference of 1 um from peak to peak is 0.25 V, or 0.5 V in the other channel; 30 um at 40 Hz
/// are three bins above the threshold of SA I, 43.5 f^-0.545 or 0.787 f^0.683.
#[test]
fn a_known_vibration_is_a_sum_of_logarithms() {
    let folder = directory();
    let reference = table(folder.path(), "reference.csv", ROWS, |t_s| {
        [0.25, 0.5].map(|v| 2.5 + sine(v, 100.0, t_s))
    });
    let path = table(folder.path(), "known.csv", ROWS, |t_s| {
        [0.25, 0.5].map(|v| 2.5 + sine(30.0 * v, 40.0, t_s))
    });
    let with_file = format!("{REFERENCE},file={}", text(&reference));
    let found = feel(&path, &["--reference", &with_file]);
    assert_eq!(
        (found["type"].as_str(), found["windows"].as_u64()),
        (Some("feel"), Some(1))
    );
    assert!(
        (number(&found, "reference_hz") - 100.0).abs() < 1e-3
            && (number(&found, "window_s") - 2.0).abs() < 1e-9
    );
    let threshold_um = |hz: f64| 0.787 * hz.powf(0.683);
    let side = 0.23 / 0.54;
    let decades = [(39.5, 30.0 * side), (40.0, 30.0), (40.5, 30.0 * side)]
        .map(|(hz, um)| (um / threshold_um(hz)).log10());
    let sum: f64 = decades.iter().sum();
    let sa1 = receptor(&found, "sa1");
    assert!((number(sa1, "intensity") - sum).abs() < 1e-3, "{sa1} {sum}");
    // In a window of 3 s a tone has three bins too, a third of a hertz apart.
    assert!((number(sa1, "intensity_per_hz") - sum / 3.0).abs() < 1e-3);
    let channels = found["channels"].as_array().expect("channels");
    for (channel, per_um) in channels.iter().zip([0.25, 0.5]) {
        assert!(
            (number(channel, "per_um") - per_um).abs() < 1e-4,
            "{channel}"
        );
        assert!(
            (number(receptor(channel, "sa1"), "intensity") - sum).abs() < 1e-3,
            "{channel}"
        );
    }
    let soft = &found["scores"][1];
    assert!(
        (number(soft, "score") - (5.59 - 0.002 * sum)).abs() < 1e-4,
        "{soft}"
    );
}

/// One stationary surface and one reference with a line have one score in windows from 0.2 s to
/// 3.28 s, within the uncertainty, and that is small enough to tell surfaces apart.
#[test]
fn a_score_does_not_depend_on_the_window() {
    let folder = directory();
    let mut random = ChaCha8Rng::seed_from_u64(17);
    let mut noise = |sigma: f64| -> Vec<f64> {
        let uniform = |random: &mut ChaCha8Rng| f64::from(random.next_u32()) / 2f64.powi(32);
        let twelve = |random: &mut ChaCha8Rng| (0..12).map(|_| uniform(random)).sum::<f64>() - 6.0;
        (0..8 * ROWS).map(|_| sigma * twelve(&mut random)).collect()
    };
    let (of_reference, of_surface) = (noise(0.005), noise(20.0));
    let at = |values: &[f64], t_s: f64| values[(t_s * RATE_HZ).round() as usize];
    let reference = table(folder.path(), "reference.csv", 8 * ROWS, |t_s| {
        [sine(1.0, 100.0, t_s) + at(&of_reference, t_s)]
    });
    let with_file = format!("{REFERENCE},file={}", text(&reference));
    for (name, line_um) in [("noise.csv", 0.0), ("line.csv", 40.0)] {
        let path = table(folder.path(), name, 8 * ROWS, |t_s| {
            [at(&of_surface, t_s) + sine(line_um, 250.0, t_s)]
        });
        let score = |window: &str| {
            let options = ["--reference", &with_file, "--m", "1.2", "--window", window];
            let found = feel(&path, &options);
            let rough = found["scores"].as_array().expect("scores")[0].clone();
            assert_eq!(rough["name"], "rough");
            (number(&rough, "score"), number(&rough, "score_sigma"))
        };
        let (expected, expected_sigma) = score("3");
        assert!(expected_sigma < 0.2, "{name}: {expected_sigma}");
        for window in ["0.2", "0.3", "0.41", "0.82", "1.64", "2", "3.28"] {
            let (found, sigma) = score(window);
            assert!(
                (found - expected).abs() < 2.0 * sigma.hypot(expected_sigma),
                "{name}, {window} s: {found} +- {sigma}, {expected} +- {expected_sigma}"
            );
            // In a short window a line may be narrow noise: less than one of the seven steps.
            let most = if line_um > 0.0 { 1.0 } else { 0.5 };
            assert!(sigma < most, "{name}, {window} s: {sigma}");
        }
    }
}

/// A reference that was sampled 0.9 % slower is looked up at its own rate: at the other file's, its
/// line would be three bins off.
#[test]
fn a_reference_has_its_own_rate() {
    let folder = directory();
    let stamped = |name: &str, rate_hz: f64| {
        let mut csv = String::from("time_s,a\n");
        for row in 0..4 * ROWS {
            let t_s = row as f64 / rate_hz;
            let _ = writeln!(csv, "{t_s:.6},{:.7}", sine(0.25, 100.0, t_s));
        }
        file(folder.path(), name, &csv)
    };
    let [path, slower] = [("a.csv", RATE_HZ), ("slower.csv", 0.991 * RATE_HZ)]
        .map(|(name, rate_hz)| stamped(name, rate_hz));
    let known = format!("{REFERENCE},file={}", text(&slower));
    let arguments = ["feel", text(&path), "--json", "--reference", &known];
    let found = json_lines(&run(&arguments)).remove(0);
    let per_um = number(&found["channels"][0], "per_um");
    assert!((per_um - 0.25).abs() < 1e-3, "{per_um}");
}

/// Equation 12 has 11.633 M - 16.075: nobody says 7.19 on a scale of seven steps. A file's scores
/// may be on any scale.
#[test]
fn a_score_outside_of_the_papers_scale_is_said_to_be() {
    let folder = directory();
    let path = table(folder.path(), "any.csv", ROWS, |t_s| {
        [2.5 + sine(0.25, 100.0, t_s)]
    });
    let with = |more: &[&str]| {
        let arguments = [
            &[
                "feel",
                text(&path),
                "--rate",
                "2048",
                "--reference",
                REFERENCE,
            ],
            more,
        ]
        .concat();
        let scores = json_lines(&run(&[&arguments[..], &["--json"]].concat()))[0]["scores"].clone();
        let outside: Vec<String> = scores
            .as_array()
            .expect("scores")
            .iter()
            .filter(|score| score["outside_scale"] == true)
            .map(|score| score["name"].as_str().expect("a name").to_owned())
            .collect();
        (outside, stdout(&run(&arguments)))
    };
    let remark = "outside the paper's scale of 1 to 7";
    let (outside, printed) = with(&["--m", "2"]);
    assert_eq!(outside, ["rough"]);
    let marked: Vec<&str> = printed
        .lines()
        .filter(|line| line.contains(remark))
        .collect();
    assert!(
        matches!(marked[..], [line] if line.starts_with("rough ")),
        "{printed}"
    );
    for inside in [&["--m", "1.7"][..], &[]] {
        let (outside, printed) = with(inside);
        assert!(outside.is_empty() && !printed.contains(remark), "{printed}");
    }
    let own = file(
        folder.path(),
        "own.toml",
        "window_s = 3\n[rough]\nconstant = 80\n",
    );
    let (outside, printed) = with(&["--coefficients", text(&own)]);
    assert!(
        outside.is_empty() && printed.contains("80") && !printed.contains(remark),
        "{printed}"
    );
}

#[test]
fn an_absent_receptor_is_named_and_not_zero() {
    let folder = directory();
    let path = table(folder.path(), "slow.csv", 500, |t_s| {
        [sine(1.0, 100.0 * RATE_HZ / 1000.0, t_s)]
    });
    let arguments = [
        "feel",
        text(&path),
        "--rate",
        "1000",
        "--reference",
        REFERENCE,
    ];
    let found = &json_lines(&run(&[&arguments[..], &["--json"]].concat()))[0];
    let fa2 = receptor(found, "fa2");
    assert!(fa2["intensity"].is_null() && fa2["intensity_per_hz"].is_null());
    assert!(
        fa2["absent"]
            .as_str()
            .is_some_and(|why| why.contains("FA II") && why.contains("1600")),
        "{fa2}"
    );
    assert!(
        receptor(found, "sa1")["intensity"].is_number()
            && receptor(found, "sa1")["absent"].is_null()
    );
    let printed = stdout(&run(&arguments));
    assert!(
        printed.contains("FA II needs more than 1600 rows a second")
            && printed.contains("needs the intensity of FA II")
    );
}

#[test]
fn a_reference_without_amplitude_and_other_bad_input() {
    let folder = directory();
    let other = table(folder.path(), "other.csv", ROWS, |t_s| {
        [sine(1.0, 300.3, t_s)]
    });
    let constant = table(folder.path(), "constant.csv", ROWS, |_| [2.5]);
    let good = table(folder.path(), "good.csv", ROWS, |t_s| {
        [sine(1.0, 100.0, t_s), 2.5].map(|v| v + 1.0)
    });
    let feel = |path: &Path, reference: &str, more: &[&str]| {
        run(&[
            &[
                "feel",
                text(path),
                "--rate",
                "2048",
                "--reference",
                reference,
            ],
            more,
        ]
        .concat())
    };
    for path in [&other, &constant] {
        assert_one_line(
            &feel(path, REFERENCE, &[]),
            1,
            &[
                text(path),
                "no amplitude at 100 Hz",
                "speed_mm_s over rsm_mm",
            ],
        );
    }
    // A channel without amplitude does not count, and the output says so.
    let found = json_lines(&feel(&good, REFERENCE, &["--json"])).remove(0);
    let usable = |c: usize| found["channels"][c]["usable"].as_bool();
    assert_eq!((usable(0), usable(1)), (Some(true), Some(false)));
    assert!(stdout(&feel(&good, REFERENCE, &[])).contains("c1: not used"));

    for (reference, part) in [
        (
            "ra_um=0,rsm_mm=1,speed_mm_s=1",
            "ra_um: must be greater than 0",
        ),
        ("ra_um=1,rsm_mm=1", "speed_mm_s are needed"),
        ("ra=1", "unknown ra"),
        ("ra_um", "NAME=VALUE"),
    ] {
        assert_one_line(&feel(&good, reference, &[]), 2, &["--reference", part]);
    }
    assert_one_line(
        &run(&["feel", text(&good), "--rate", "2048"]),
        2,
        &["--reference"],
    );
    assert_one_line(
        &feel(&good, "ra_um=1,rsm_mm=0.001,speed_mm_s=10", &[]),
        1,
        &["10000 Hz", "half the rate"],
    );
    assert_one_line(
        &feel(&good, REFERENCE, &["--window", "0.01"]),
        1,
        &["good.csv", "20 rows", "64"],
    );
    assert_one_line(
        &run(&["feel", text(&good), "--reference", REFERENCE]),
        1,
        &["good.csv", "--rate"],
    );
    for (factor, part) in [(1e300, "inf"), (1e-25, "e-25")] {
        let rows = format!("{factor:e}\n{:e}\n", -factor).repeat(64);
        let path = file(folder.path(), "scale.csv", &format!("a\n{rows}"));
        assert_one_line(
            &feel(&path, REFERENCE, &[]),
            1,
            &["scale.csv", "column a", part, "scale them"],
        );
    }
    let short = table(folder.path(), "short.csv", 50, |t_s| [t_s]);
    assert_one_line(
        &feel(&short, REFERENCE, &[]),
        1,
        &["short.csv", "50 rows", "64"],
    );
    let with_file = |path: &Path| format!("{REFERENCE},file={}", text(path));
    assert_one_line(
        &feel(&good, &with_file(&constant), &[]),
        1,
        &["constant.csv", "no column c1"],
    );
    assert_one_line(
        &feel(&good, REFERENCE, &["--m", "much"]),
        2,
        &["--m", "not a number"],
    );
    assert_one_line(
        &feel(&good, REFERENCE, &["--image", text(&good)]),
        1,
        &["good.csv", "no static image"],
    );
    assert_one_line(
        &feel(&good, REFERENCE, &["--coefficients", text(&good)]),
        1,
        &["good.csv"],
    );
}

/// A stamped recording of many windows, its picture, and a row that is missing.
#[test]
fn a_picture_and_stamps() {
    let folder = directory();
    let values = surface(3, 1.0, 0.1);
    let mut csv = String::from("time_s,a\n");
    for (row, value) in values.iter().enumerate().filter(|(row, _)| *row != 1000) {
        let _ = writeln!(
            csv,
            "{:.6},{}",
            row as f64 / RATE_HZ,
            if row == 2000 {
                String::new()
            } else {
                value.to_string()
            }
        );
    }
    let (path, svg) = (
        file(folder.path(), "stamped.csv", &csv),
        folder.path().join("feel.svg"),
    );
    let arguments = [
        "feel",
        text(&path),
        "--reference",
        REFERENCE,
        "--window",
        "0.25",
        "--svg",
        text(&svg),
        "--m",
        "1.2+-0.1",
    ];
    let found = json_lines(&run(&[&arguments[..], &["--json"]].concat())).remove(0);
    assert!((number(&found, "rate_hz") - RATE_HZ).abs() < 0.01);
    assert_eq!(
        ["windows", "rows", "rows_missing", "readings_missing"].map(|name| found[name].as_u64()),
        [Some(15), Some(4095), Some(1), Some(1)]
    );
    assert!(
        (number(&found, "m") - 1.2).abs() < 1e-6 && (number(&found, "m_sigma") - 0.1).abs() < 1e-6
    );
    let drawn = std::fs::read_to_string(&svg).expect("a picture");
    assert!(drawn.starts_with("<svg") && !drawn.contains("NaN") && !drawn.contains("inf"));
    // The key names what is measured, and what each threshold is with the intensity above it.
    assert!(
        drawn.contains(">spectrum<") && drawn.contains(" threshold, intensity "),
        "{drawn}"
    );
    assert!(
        [
            "FA I threshold",
            "FA II threshold",
            "SA I threshold",
            "SA II threshold"
        ]
        .iter()
        .all(|name| drawn.contains(name))
    );
}

/// M of the simulated finger: it follows the friction that drags the skin.
#[test]
fn m_by_the_static_image() {
    let folder = directory();
    let path = table(folder.path(), "any.csv", ROWS, |t_s| {
        [sine(1.0, 100.0, t_s)]
    });
    let taxels = |tangential: f64| -> String {
        let level = |taxel: usize| 0.001 + tangential * [0.5, 0.0, -0.5, 0.0][taxel % 4] * 0.001;
        let taxels = (0..16).map(|taxel| {
            format!(
                r#"{{"taxel":{taxel},"level_v":{},"sigma_v":1e-6}}"#,
                level(taxel)
            )
        });
        format!(
            r#"{{"type":"image","taxels":[{}]}}"#,
            taxels.collect::<Vec<_>>().join(",")
        )
    };
    // The last image counts; other lines are passed.
    let lines = format!(
        "{}\n{}\n{{\"type\":\"release\"}}\n",
        taxels(3.0),
        taxels(2.0)
    );
    let image = file(folder.path(), "touch.ndjson", &lines);
    let found = feel(
        &path,
        &[
            "--reference",
            REFERENCE,
            "--image",
            text(&image),
            "--image-gain",
            "1.5",
        ],
    );
    assert!(
        (number(&found, "m") - 0.75).abs() < 1e-5
            && (0.0003..0.001).contains(&number(&found, "m_sigma")),
        "{found}"
    );
    assert!(found["scores"][0]["score"].is_number());
}

/// Equation 10: the run's first 5 mm, in which the skin sticks, do not count, nor does what comes after
/// 25 mm.
#[test]
fn m_by_columns_of_the_forces() {
    let folder = directory();
    let forces = |rows: usize| {
        table(folder.path(), &format!("{rows}.csv"), rows, |t_s| {
            let (normal, slides) = (0.5, (0.5..2.5).contains(&t_s));
            let tangential = if slides {
                -0.6 * (1.0 + 0.02 * (t_s - 1.5))
            } else {
                2.0
            };
            [sine(1.0, 100.0, t_s), tangential, normal]
        })
    };
    let options = ["--reference", REFERENCE, "--forces", "c1,c2"];
    let found = feel(&forces(6200), &options);
    // A drift of 4 % over the run: quarters 1 % apart, whose mean scatters by 0.65 %.
    assert!((number(&found, "m") - 1.2).abs() < 1e-3, "{found}");
    assert!((number(&found, "m_sigma") - 0.0077).abs() < 3e-4, "{found}");
    // The forces are no vibration.
    assert_eq!(found["channels"].as_array().map(Vec::len), Some(1));
    let short = forces(4000);
    let begin = ["feel", text(&short), "--rate", "2048"];
    let refused = |options: &[&str], status, words: &[&str]| {
        assert_one_line(&run(&[&begin[..], options].concat()), status, words);
    };
    refused(&options, 1, &["5 to 25 mm", "19.5 mm"]);
    refused(&["--reference", REFERENCE, "--forces", "c1"], 2, &["F,N"]);
    refused(&["--reference", REFERENCE, "--forces", "c1,c9"], 1, &["c9"]);
}

/// Eight plates whose scores are built from equations 11 and 12 give their coefficients back, and
/// these give the scores back.
#[test]
fn eight_plates_give_the_papers_coefficients_back() {
    let folder = directory();
    let reference = table(folder.path(), "reference.csv", ROWS, |t_s| {
        [sine(1.0, 100.0, t_s)]
    });
    let with_file = format!("{REFERENCE},file={}", text(&reference));
    let measure = ["--rate", "2048", "--reference", &with_file];
    let mut random = ChaCha8Rng::seed_from_u64(9);
    let (mut exact, mut spoken, mut expected) = (
        String::from("file,soft,rough,m\n"),
        String::from("file,soft,rough,m\n"),
        Vec::new(),
    );
    for plate in 0..8u32 {
        let low_um = 10.0 * 2f64.powf(f64::from(plate * 3 % 8) / 2.0);
        let high_um = 0.2 * 2f64.powf(f64::from(plate) / 2.0);
        let values = surface(plate.into(), low_um, high_um);
        let name = format!("plate{plate}.csv");
        let path = table(folder.path(), &name, ROWS, |t_s| {
            [values[(t_s * RATE_HZ).round() as usize]]
        });
        let m = 0.8 + 0.1 * f64::from(plate * 5 % 8);
        let found = feel(&path, &["--reference", &with_file]);
        let of_3_s = |name: &str| 3.0 * number(receptor(&found, name), "intensity_per_hz");
        let (soft, rough) = (
            5.59 - 0.002 * of_3_s("sa1"),
            -16.075 + 0.011 * of_3_s("fa2") + 11.633 * m,
        );
        let _ = writeln!(exact, "{name},{soft},{rough},{m}");
        // Three people with their own opinions.
        for _ in 0..3 {
            let mut off = || 0.2 * (f64::from(random.next_u32()) / 2f64.powi(32) - 0.5);
            let _ = writeln!(spoken, "{name},{},{},{m}", soft + off(), rough + off());
        }
        expected.push((path, soft, rough, m));
    }
    let truth = [
        ("soft", vec![("sa1", -0.002)], 5.59),
        ("rough", vec![("fa2", 0.011), ("m", 11.633)], -16.075),
    ];
    for (content, share) in [(exact, 1e-3), (spoken, 0.1)] {
        let scores = file(folder.path(), "scores.csv", &content);
        let toml = folder.path().join("mine.toml");
        let train = [
            &["feel", "train", text(&scores)],
            &measure[..],
            &["-o", text(&toml), "--force"],
        ]
        .concat();
        let found = json_lines(&run(&[&train[..], &["--json"]].concat())).remove(0);
        assert_eq!(
            (found["type"].as_str(), found["recordings"].as_u64()),
            (Some("feel_train"), Some(8))
        );
        for (at, (name, coefficients, constant)) in truth.iter().enumerate() {
            let score = &found["scores"][at];
            assert_eq!(score["name"].as_str(), Some(*name));
            assert!(
                number(score, "r2") > 0.9 && number(score, "p") < 1e-3,
                "{score}"
            );
            assert!(
                (number(score, "constant") / constant - 1.0).abs() < share,
                "{score}"
            );
            let model = score["coefficients"].as_object().expect("coefficients");
            assert_eq!(
                model.keys().collect::<Vec<_>>(),
                coefficients
                    .iter()
                    .map(|(index, _)| *index)
                    .collect::<Vec<_>>(),
                "{score}"
            );
            for (index, coefficient) in coefficients {
                assert!(
                    (number(&model[*index], "value") / coefficient - 1.0).abs() < share,
                    "{score}"
                );
            }
            assert_eq!(
                score["excluded"].as_object().map(|excluded| excluded.len()),
                Some(5 - coefficients.len())
            );
        }
        // The settings file gives the scores back, within their uncertainty.
        for (path, soft, rough, m) in &expected {
            let found = feel(
                path,
                &[
                    "--reference",
                    &with_file,
                    "--m",
                    &m.to_string(),
                    "--coefficients",
                    text(&toml),
                ],
            );
            for (at, expected) in [(1, soft), (0, rough)] {
                let score = &found["scores"][at];
                assert!(
                    (number(score, "score") - expected).abs()
                        < 0.02 + 2.0 * number(score, "score_sigma"),
                    "{score} {expected}"
                );
            }
        }
        let printed = stdout(&run(&train));
        for part in [
            "soft",
            "rough",
            "R2",
            "excluded: p = ",
            "x fa2",
            "window of 3 s",
        ] {
            assert!(printed.contains(part), "{part}: {printed}");
        }
    }
}

/// A receptor that one recording cannot show is no variable; a score that nothing explains has no
/// coefficients.
#[test]
fn what_is_absent_or_explains_nothing_is_excluded() {
    let folder = directory();
    let mut csv = String::from("file,soft,odd,m\n");
    for plate in 0..6 {
        table(folder.path(), &format!("p{plate}.csv"), 500, |t_s| {
            [sine(1.0, 204.8, t_s)]
        });
        let _ = writeln!(csv, "p{plate}.csv,{},{},{plate}", 6 - plate, plate % 2);
    }
    let scores = file(folder.path(), "scores.csv", &csv);
    let train = [
        "feel",
        "train",
        text(&scores),
        "--rate",
        "1000",
        "--reference",
        REFERENCE,
    ];
    let toml = folder.path().join("mine.toml");
    let found = json_lines(&run(&[&train[..], &["--json", "-o", text(&toml)]].concat())).remove(0);
    let [soft, odd] = [0, 1].map(|at| &found["scores"][at]);
    assert!(
        (number(&soft["coefficients"]["m"], "value") + 1.0).abs() < 1e-9,
        "{soft}"
    );
    assert!(
        soft["excluded"]["fa2"]
            .as_str()
            .is_some_and(|why| why.contains("absent in") && why.contains("p0.csv"))
    );
    assert!(
        soft["excluded"]["sa1"]
            .as_str()
            .is_some_and(|why| why.contains("constant"))
    );
    assert!(
        odd["coefficients"]
            .as_object()
            .is_some_and(|model| model.is_empty())
    );
    let written = std::fs::read_to_string(&toml).expect("coefficients");
    assert!(
        written.contains("[soft]") && !written.contains("[odd]"),
        "{written}"
    );
    file(
        folder.path(),
        "scores.csv",
        "file,odd\np0.csv,1\np1.csv,0\np2.csv,1\np3.csv,1\n",
    );
    assert_one_line(&run(&train), 1, &["scores.csv", "odd", "constant"]);
}

#[test]
fn criteria_that_go_round_in_circles_are_refused() {
    let reference = "ra_um=0.5,rsm_mm=0.1,speed_mm_s=10";
    let train = |enter: &str, remove: &str| {
        let criteria = ["--enter", enter, "--remove", remove];
        let train = ["feel", "train", "none.csv", "--reference", reference];
        run(&[&train[..], &criteria].concat())
    };
    assert_one_line(&train("0.2", "0.1"), 1, &["0.2", "0.1"]);
    let output = train("1.5", "0.1");
    assert_eq!(output.status.code(), Some(2));
    assert!(stderr(&output).contains("less than 1"), "{output:?}");
}

#[test]
fn tables_of_scores_that_cannot_be_used() {
    let folder = directory();
    table(folder.path(), "a.csv", ROWS, |t_s| [sine(1.0, 100.0, t_s)]);
    for (content, parts) in [
        ("soft,rough\n1,2\n", &["no column file"][..]),
        ("file,m\na.csv,1\n", &["no score"]),
        (
            "file,soft\na.csv,much\n",
            &["line 2", "column soft", "much"],
        ),
        ("file,soft\na.csv,1\na.csv,2\n", &["1 recordings", "3"]),
        ("file,soft,soft\na.csv,1,2\n", &["\"soft\"", "another name"]),
        (
            "file,soft\na.csv,1\nb.csv,2\nc.csv,3\n",
            &["b.csv", "No such file"],
        ),
        (
            "file,soft\na.csv,1\n./a.csv,2\n././a.csv,3\n",
            &["column soft", "constant"],
        ),
        ("file,soft\na.csv\n", &["scores.csv"]),
    ] {
        let scores = file(folder.path(), "scores.csv", content);
        let output = run(&[
            "feel",
            "train",
            text(&scores),
            "--rate",
            "2048",
            "--reference",
            REFERENCE,
        ]);
        let parts = [
            &["scores.csv"][..usize::from(!parts[0].ends_with(".csv"))],
            parts,
        ]
        .concat();
        assert_one_line(&output, 1, &parts);
    }
}
