//! Recordings as people have them: each is read as it is, or refused with the way out.
//!
//! The inputs are made anew by `cases/made.rs`. Where the folder `../shared/cases` has a file of
//! the same name, as instruments or people wrote it, that is judged, too.

#[path = "cases/failing.rs"]
mod failing;
#[path = "cases/made.rs"]
mod made;

mod common;

use common::{json_lines, run, stderr, text};
use std::path::{Path, PathBuf};

/// Expected result of a command.
#[derive(Clone, Copy)]
enum Expected {
    /// A good tone, hertz.
    Hz(f64),
    /// A tone, hertz, good or next to another that is named.
    Beside(f64),
    /// A good period by position, millimetres.
    Mm(f64),
    /// A good tone, hertz, and remarks with these parts.
    Noted(f64, &'static [&'static str]),
    /// A tone that cannot be trusted yet, hertz, and remarks with these parts.
    Doubted(f64, &'static [&'static str]),
    /// A refusal on one line with these parts.
    Refused(&'static [&'static str]),
}

use Expected::{Beside, Doubted, Hz, Mm, Noted, Refused};

/// File, options of `fit`, what it gives.
type Case = (&'static str, &'static [&'static str], Expected);

/// The tone of most inputs.
const TONE: Expected = Hz(12.34);

const CASES: [Case; 52] = [
    ("speed_m_s.csv", &["--speed-column", "speed_m_s"], Mm(2.5)),
    (
        "speed_m_s.csv",
        &["--speed-column", "speed_m_s:m/s"],
        Mm(2.5),
    ),
    (
        "encoder_counts.csv",
        &["--position-column", "encoder"],
        Refused(&[
            "column encoder has whole numbers without a unit",
            "--mm-per-count",
        ]),
    ),
    (
        "encoder_counts.csv",
        &["--position-column", "encoder", "--mm-per-count", "0.025"],
        Mm(2.5),
    ),
    (
        "encoder_counts.csv",
        &["--position-column", "encoder:um"],
        Mm(0.1),
    ),
    ("sine_5hz.csv", &[], Hz(5.0)),
    ("percent_time_ns.csv", &[], TONE),
    ("percent_time_ns.csv", &["--time-column", "%time:ns"], TONE),
    ("datetime_column.csv", &[], TONE),
    ("datetime_column.csv", &["--time-column", "datetime"], TONE),
    ("data.csv.gz", &[], TONE),
    ("audio.wav", &[], Hz(440.25)),
    (
        "arr.npz",
        &[],
        Refused(&["a NumPy archive", "in Python, ridgetone.fit(numpy.load("]),
    ),
    ("stamps_in_batches.csv", &[], TONE),
    ("stamps_in_batches.csv", &["--rate", "250"], TONE),
    (
        "stamps_in_batches.csv",
        &["--time-column", "none", "--rate", "250"],
        // The stamps are a channel then, with a tone of their own.
        Beside(12.34),
    ),
    ("stamps_8_and_2_ms.csv", &[], TONE),
    // Rows that come after 8 and 2 ms, taken as even, hold an image of the tone.
    ("stamps_8_and_2_ms.csv", &["--rate", "200"], Beside(12.34)),
    ("dropped_40pct.csv", &[], TONE),
    ("dropped_40pct.csv", &["--rate", "250"], TONE),
    ("random_times.csv", &[], TONE),
    ("time_us_wrap.csv", &[], TONE),
    ("iso_offset.csv", &[], TONE),
    ("date_and_time_columns.csv", &[], TONE),
    (
        "date_and_time_columns.csv",
        &["--time-column", "Time", "--columns", "ax,ay,az"],
        TONE,
    ),
    ("six_digits_time.csv", &[], TONE),
    ("local_time_dst.csv", &[], TONE),
    ("utf16le_bom.csv", &[], TONE),
    ("latin1_header.csv", &[], TONE),
    ("units_in_second_row.csv", &[], TONE),
    ("preamble_key_value.csv", &[], TONE),
    ("preamble_key_value.csv", &["--rate", "250"], TONE),
    ("percent_comments.txt", &[], TONE),
    ("labview.lvm", &[], TONE),
    ("no_header.csv", &["--rate", "250"], TONE),
    (
        "no_header.csv",
        &[],
        Refused(&["no header", "column_1, column_2, column_3", "--rate HZ"]),
    ),
    ("cr_only.csv", &[], TONE),
    ("thousands.csv", &[], TONE),
    ("text_column.csv", &[], TONE),
    (
        "text_column.csv",
        &["--columns", ".linear_acceleration.x,.linear_acceleration.y"],
        TONE,
    ),
    ("dup_channel_names.csv", &[], TONE),
    ("dup_channel_names.csv", &["--columns", "acc"], TONE),
    ("missing_dash.csv", &[], TONE),
    ("missing_n_a.csv", &[], TONE),
    ("missing_err.csv", &[], TONE),
    ("last_line_cut.csv", &[], TONE),
    ("header_repeated.csv", &[], TONE),
    ("footer_text.csv", &[], TONE),
    (
        "footer_text.csv",
        &["--columns", "bx"],
        Refused(&["no column bx", "ax, ay, az"]),
    ),
    (
        "cr_only.csv",
        &["--time-column", "when"],
        Refused(&["no column when", "time_s, ax, ay, az"]),
    ),
    (
        "speed_m_s.csv",
        &["--columns", "ax,speed_m_s", "--from", "9"],
        Refused(&["--from 9", "3.996"]),
    ),
    (
        "encoder_counts.csv",
        &["--time-column", "encoder"],
        Refused(&["--time-column encoder:ms"]),
    ),
];

/// Cases that the estimator decides, not the reader. They are judged where the folder of people's
/// files is.
const OF_THE_ESTIMATOR: [(&str, Answer); 6] = [
    ("three_axes_three_tones.csv", Answer::NotGood),
    ("four_channels_four_tones.csv", Answer::NotGood),
    ("missing_fundamental.csv", Answer::NotGood),
    ("chirp_startup.csv", Answer::NotGood),
    ("in_phase_half_shared_noise.csv", Answer::Good(12.34)),
    ("tacho_pulses.csv", Answer::Good(12.288)),
];

/// Expected answer of the estimator.
enum Answer {
    /// A tone of this frequency, hertz.
    Good(f64),
    /// Anything but a tone that can be trusted.
    NotGood,
}

/// The folder of people's files.
fn shared() -> PathBuf {
    match std::env::var_os("RIDGETONE_CASES") {
        Some(folder) => folder.into(),
        None => Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/cases"),
    }
}

/// Files of that name: the one that is made, and that of the folder of people's files.
fn files(folder: &Path, name: &str) -> Vec<PathBuf> {
    let made = folder.join(name);
    std::fs::write(&made, made::made(name)).expect("a file");
    [made, shared().join(name)]
        .into_iter()
        .filter(|path| path.exists())
        .collect()
}

/// Difference of a fit from what is expected.
fn judge(path: &Path, options: &[&str], expected: Expected) -> Option<String> {
    let output = run(&[&["fit", text(path), "--json"], options].concat());
    let beside = stderr(&output);
    let shown = format!("{} {}: {beside}", path.display(), options.join(" "));
    // A guess takes one line, and so does a refusal; a slow computer reports its progress.
    let remarks = beside.lines().filter(|line| !line.ends_with(" rows read"));
    if remarks.count() > 1 {
        return Some(shown);
    }
    let (value, parts) = match expected {
        Refused(parts) => {
            let is_explained = parts.iter().all(|part| beside.contains(part));
            return (output.status.code() != Some(1) || !is_explained).then_some(shown);
        }
        Hz(value) | Beside(value) | Mm(value) => (value, &[][..]),
        Noted(value, parts) | Doubted(value, parts) => (value, parts),
    };
    if !output.status.success() {
        return Some(shown);
    }
    let found = json_lines(&output).remove(0);
    let number = |name: &str| found[name].as_f64().unwrap_or(f64::NAN);
    let (name, sigma) = match expected {
        Mm(_) => ("period_mm", "period_sigma_mm"),
        _ => ("frequency_hz", "sigma_hz"),
    };
    let (off, sigma) = ((number(name) - value).abs(), number(sigma));
    let (is_good, is_named) = (
        found["status"] == "good",
        found["other_tone_hz"].is_number(),
    );
    let is_right = match expected {
        Doubted(..) => off < 0.01 * value && !is_good,
        Beside(_) => off < 4.0 * sigma && sigma < 1e-3 * value && (is_good || is_named),
        _ => off < 4.0 * sigma && sigma < 3e-3 * value && is_good,
    };
    let is_noted = parts.iter().all(|part| beside.contains(part));
    let json = found.to_string();
    (!is_right || !is_noted).then(|| format!("{shown}{}", &json[..json.len().min(500)]))
}

#[test]
fn files_as_people_have_them_are_fitted_or_refused_with_the_way_out() {
    let folder = common::directory();
    let mut wrong = Vec::new();
    for (name, options, expected) in CASES {
        for path in files(folder.path(), name) {
            wrong.extend(judge(&path, options, expected));
        }
    }
    assert!(
        wrong.is_empty(),
        "{} cases:\n{}",
        wrong.len(),
        wrong.join("\n")
    );
}

#[test]
fn cases_of_the_estimator_are_right() {
    for (name, answer) in OF_THE_ESTIMATOR {
        let path = shared().join(name);
        if !path.exists() {
            println!("{name} is not here: its case is not judged");
            continue;
        }
        let found = json_lines(&run(&["fit", text(&path), "--json"])).remove(0);
        let is_good = found["status"] == "good";
        let is_right = match answer {
            Answer::NotGood => !is_good,
            Answer::Good(hz) => {
                let number = |name: &str| found[name].as_f64().unwrap_or(f64::NAN);
                is_good && (number("frequency_hz") - hz).abs() < 4.0 * number("sigma_hz")
            }
        };
        assert!(is_right, "{name}: {found}");
    }
}
