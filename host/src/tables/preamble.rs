//! Finds the rate of rows stated above a table: `Interval= 0.005 s`, `fs 3700`, `200 sps`.

use super::units::per_second;

/// Words before a number that make it a rate.
const RATES: [&str; 22] = [
    "sample rate",
    "sampling rate",
    "samplerate",
    "samplingrate",
    "update rate",
    "data rate",
    "scan rate",
    "output rate",
    "acquisition rate",
    "logging rate",
    "capture rate",
    "recording rate",
    "frame rate",
    "framerate",
    "sampling frequency",
    "sample frequency",
    "sampling freq",
    "fs",
    "odr",
    "srate",
    "sfreq",
    "frequency of sampling",
];

/// Words before a number that make it an interval.
const INTERVALS: [&str; 14] = [
    "interval",
    "sample interval",
    "sampling interval",
    "dt",
    "delta t",
    "delta x",
    "sample period",
    "sampling period",
    "sample time",
    "time step",
    "timestep",
    "delta",
    "tinterval",
    "time increment",
];

/// Words that mark a rate or an interval as unrelated to the rows.
const OTHERS: [&str; 11] = [
    "baud", "bit", "cutoff", "filter", "heart", "refresh", "wheel", "screen", "video", "report",
    "flush",
];

/// Units of a rate, in hertz.
const UNITS: [(&str, f64); 12] = [
    ("hz", 1.0),
    ("khz", 1e3),
    ("sps", 1.0),
    ("ksps", 1e3),
    ("samples/s", 1.0),
    ("samples/sec", 1.0),
    ("samples/second", 1.0),
    ("rows/s", 1.0),
    ("fps", 1.0),
    ("frames/s", 1.0),
    ("s/s", 1.0),
    ("1/s", 1.0),
];

/// A rate, and the line that states it.
#[derive(Clone, Debug, PartialEq)]
pub struct Stated {
    pub hz: f64,
    pub line: String,
}

/// Returns the rate stated in the lines; `None` if there is none, or if rates differ.
pub fn stated(text: &str) -> Option<Stated> {
    let mut found: Option<Stated> = None;
    for line in text.lines() {
        for hz in rates(line) {
            match &found {
                Some(known) if (hz / known.hz - 1.0).abs() > 0.01 => return None,
                Some(_) => {}
                None => {
                    let line = line.split_whitespace().collect::<Vec<_>>().join(" ");
                    found = Some(Stated {
                        hz,
                        line: line
                            .trim_matches(['/', '#', '%', ' '])
                            .chars()
                            .take(60)
                            .collect(),
                    });
                }
            }
        }
    }
    found
}

fn rates(line: &str) -> Vec<f64> {
    let line = line.to_lowercase();
    let tokens = tokens(&line);
    let mut found = Vec::new();
    for (at, token) in tokens.iter().enumerate() {
        let Some(value) = number(token).filter(|value| *value > 0.0) else {
            continue;
        };
        let start = tokens[..at]
            .iter()
            .rposition(|word| number(word).is_some())
            .map_or(0, |at| at + 1);
        let words = &tokens[start.max(at.saturating_sub(4))..at];
        let key = words.join(" ").replace('_', " ");
        let key = key.trim_start_matches(['/', '#', '%', ' ']);
        let unit = tokens.get(at + 1).map_or("", String::as_str);
        let hz_of = |unit: &str| {
            UNITS
                .iter()
                .find(|(name, _)| *name == unit)
                .map(|(_, hz)| *hz)
        };
        if OTHERS.iter().any(|other| key.contains(other)) {
            continue;
        }
        let ends = |known: &[&str]| {
            known.iter().any(|word| {
                key.strip_suffix(" hz")
                    .unwrap_or(key)
                    .strip_suffix(word)
                    .is_some_and(|before| before.is_empty() || before.ends_with(' '))
            })
        };
        let per_sample = unit.strip_suffix("/sample").and_then(per_second);
        let hz = if let Some(per_second) = per_sample {
            Some(per_second / value)
        } else if ends(&INTERVALS) {
            match unit {
                "" => Some(1.0 / value),
                unit => per_second(unit)
                    .map(|per_second| per_second / value)
                    .or_else(|| number(unit).map(|_| 1.0 / value)),
            }
        } else if ends(&RATES) {
            hz_of(unit)
                .or_else(|| {
                    (unit.is_empty() || !UNITS.iter().any(|(name, _)| unit.ends_with(name)))
                        .then_some(1.0)
                })
                .map(|hz| value * hz)
        } else if matches!(unit, "sps" | "ksps")
            || unit.starts_with("samples/s")
            || key.ends_with("rate") && unit.ends_with("hz")
        {
            hz_of(unit).map(|hz| value * hz)
        } else {
            None
        };
        found.extend(hz.filter(|hz| (1e-3..1e8).contains(hz)));
    }
    found
}

fn number(token: &str) -> Option<f64> {
    token
        .starts_with(|c: char| c.is_ascii_digit() || c == '.')
        .then(|| token.parse().ok())?
}

/// Splits a line into words and numbers; a unit directly after a number is a separate word.
fn tokens(line: &str) -> Vec<String> {
    let chars: Vec<char> = line.chars().collect();
    let mut spaced = String::new();
    for (at, c) in chars.iter().enumerate() {
        let before = at.checked_sub(1).map(|at| chars[at]);
        let after = chars.get(at + 1);
        let is_digit = |c: Option<char>| c.is_some_and(|c| c.is_ascii_digit());
        match c {
            ',' if is_digit(before) && is_digit(after.copied()) => spaced.push('.'),
            ',' | ';' | '=' | ':' | '"' | '(' | ')' | '[' | ']' | '\'' => spaced.push(' '),
            c if c.is_alphabetic() && is_digit(before) => {
                // A digit that ends a word stays with it.
                let word = spaced.rsplit(' ').next().unwrap_or_default();
                if number(word).is_some()
                    && !matches!((c, after), ('e', Some('-' | '+' | '0'..='9')))
                {
                    spaced.push(' ');
                }
                spaced.push(*c);
            }
            c => spaced.push(*c),
        }
    }
    spaced.split_whitespace().map(str::to_owned).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rates_and_intervals_are_found_and_other_numbers_are_not() {
        for (line, expected) in [
            ("Interval=\t0.005 s", Some(200.0)),
            ("// Update Rate: 200.0Hz", Some(200.0)),
            ("5 msec/sample", Some(200.0)),
            (
                "fs 2000;frames_per_buffer None;samples_per_frame 50;refresh_rate_hz None",
                Some(2000.0),
            ),
            (
                "TIMESERIES XX_TEST__BHZ_R, 1600 samples, 200 sps, 2026-01-20T02:00:04.5",
                Some(200.0),
            ),
            ("NPTS=  4000, DT=   .0050 SEC,", Some(200.0)),
            ("Sample Interval,0.004,", Some(250.0)),
            ("%Sample Rate = 250 Hz", Some(250.0)),
            ("sampling_rate: 1.5 kHz", Some(1500.0)),
            (
                "\"Sample Rate\",\"200.000\",\"Hz\",,\"Duration\",\"8.0\",\"s\"",
                Some(200.0),
            ),
            ("Delta_X\t0,004\t0,004", Some(250.0)),
            ("EMG (5 - 250 Hz)", None),
            ("baud rate 115200", None),
            ("low-pass filter cutoff frequency 50 Hz", None),
            ("refresh rate 60 Hz", None),
            ("Samples\t1000\t1000", None),
            ("Interval= 1e-3 s\nfs 50", None),
            ("10.000 V", None),
        ] {
            let found = stated(line).map(|stated| stated.hz);
            let is_right = match (found, expected) {
                (Some(found), Some(expected)) => (found / expected - 1.0).abs() < 1e-9,
                (found, expected) => found == expected,
            };
            assert!(is_right, "{line}: {found:?}");
        }
    }
}
