//! Finds the rate of rows stated above a table: `Interval= 0.005 s`, `fs 3700`, `200 sps`.

use super::units::per_second;

/// Words before a number that make it a rate.
const RATES: [&str; 27] = [
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
    "samples per second",
    "abtastrate",
    "abtastfrequenz",
    "rate",
    "sampling",
];

/// Those of [`RATES`] and [`INTERVALS`] that mean something else after another word, as in
/// `laser repetition rate`, `autosave interval` or `accelerometer FS`.
const ALONE: [&str; 7] = ["rate", "sampling", "fs", "odr", "interval", "delta", "dt"];

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
const OTHERS: [&str; 12] = [
    "baud", "bit", "cutoff", "filter", "heart", "refresh", "wheel", "screen", "video", "report",
    "flush", "save",
];

/// Words for processing that makes the rows slower than the stated rate.
const THINNED: [&str; 3] = ["decimation", "downsampl", "averaging"];

/// Values after one of these words that mean no such processing.
const UNTHINNED: [&str; 5] = ["off", "no", "none", "0", "1"];

/// Units of a rate, in hertz.
const UNITS: [(&str, f64); 28] = [
    ("hz", 1.0),
    ("hertz", 1.0),
    ("khz", 1e3),
    ("k", 1e3),
    ("mhz", 1e6),
    ("ghz", 1e9),
    ("sps", 1.0),
    ("ksps", 1e3),
    ("msps", 1e6),
    ("gsps", 1e9),
    ("sa/s", 1.0),
    ("ksa/s", 1e3),
    ("msa/s", 1e6),
    ("gsa/s", 1e9),
    ("s/s", 1.0),
    ("ks/s", 1e3),
    ("ms/s", 1e6),
    ("samples/s", 1.0),
    ("samples/sec", 1.0),
    ("samples/second", 1.0),
    ("samples/min", 1.0 / 60.0),
    ("samples/minute", 1.0 / 60.0),
    ("samples/hour", 1.0 / 3600.0),
    ("rows/s", 1.0),
    ("fps", 1.0),
    ("frames/s", 1.0),
    ("1/s", 1.0),
    ("1/min", 1.0 / 60.0),
];

/// A rate, and the line that states it.
#[derive(Clone, Debug, PartialEq)]
pub struct Stated {
    pub hz: f64,
    pub line: String,
}

/// Returns the rate stated in the lines; `None` if there is none, if rates differ, or if the rows
/// may be slower than the rate.
pub fn stated(text: &str) -> Option<Stated> {
    if text.lines().any(is_thinned) {
        return None;
    }
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

/// True if a line says that the rows are slower than the stated rate; `Averaging: off` and
/// `Decimation: 1` do not.
fn is_thinned(line: &str) -> bool {
    let lower = line.to_lowercase();
    let after = THINNED.iter().find_map(|word| lower.split_once(word));
    after.is_some_and(|(_, after)| {
        let tokens = tokens(after);
        let value = tokens.iter().rfind(|token| *token != SEPARATOR);
        !value.is_some_and(|value| UNTHINNED.contains(&value.as_str()))
    })
}

fn rates(line: &str) -> Vec<f64> {
    let tokens = tokens(&line.to_lowercase());
    let mut found = Vec::new();
    for (at, token) in tokens.iter().enumerate() {
        let Some(value) = number(token).filter(|value| *value > 0.0) else {
            continue;
        };
        let (key, key_unit) = key(&tokens[..at]);
        if OTHERS.iter().any(|other| key.contains(other)) {
            continue;
        }
        let unit = match unit(&tokens[at + 1..]) {
            "" => key_unit.unwrap_or_default(),
            unit => unit,
        };
        let by_rate = hz_of(unit).map(|hz| value * hz);
        let by_interval = per_second(unit).map(|per_second| per_second / value);
        let per_sample = unit.strip_suffix("/sample").and_then(per_second);
        let hz = if let Some(per_second) = per_sample {
            Some(per_second / value)
        } else if ends(&key, &INTERVALS) {
            by_interval.or(unit.is_empty().then_some(1.0 / value))
        } else if ends(&key, &RATES) {
            // Some programs state the interval here: `Sample rate: 5 ms`.
            let by_short = by_interval.filter(|_| per_second(unit) > Some(1.0));
            let hz = by_rate.or(by_short);
            hz.or(unit.is_empty().then_some(value))
        } else {
            let is_of_samples = unit.ends_with("sps") || unit.starts_with("samples/");
            by_rate.filter(|_| is_of_samples)
        };
        found.extend(hz.filter(|hz| (1e-3..1e10).contains(hz)));
    }
    found
}

/// Words that name a number, and their unit if the last of them is one: `Sample Interval (ms)`.
fn key(before: &[String]) -> (String, Option<&str>) {
    let is_break = |word: &String| word == SEPARATOR || number(word).is_some();
    let end = before
        .iter()
        .rposition(|word| word != SEPARATOR && word != EQUALS)
        .map_or(0, |at| at + 1);
    let start = before[..end]
        .iter()
        .rposition(is_break)
        .map_or(0, |at| at + 1);
    let parts = before[start.max(end.saturating_sub(5))..end].iter();
    let mut words: Vec<&str> = parts
        .filter(|word| *word != EQUALS)
        .flat_map(|word| word.split('_'))
        .map(|word| word.trim_start_matches(['/', '#', '%']))
        .filter(|word| !word.is_empty())
        .collect();
    let is_whole = ends(&words.join(" "), &RATES);
    let last = words.last().copied();
    let unit = last.filter(|word| words.len() > 1 && !is_whole && is_unit_of_rows(word));
    if unit.is_some() {
        words.pop();
    }
    (words.join(" "), unit)
}

/// Returns the unit after a number; empty if a key, another number or the end of the line follows.
/// The unit may be in the next cell.
fn unit(after: &[String]) -> &str {
    let is_key = after.get(1).is_some_and(|word| word == EQUALS);
    let is_cell = after.first().is_some_and(|word| word == SEPARATOR);
    let word = after.iter().find(|word| *word != SEPARATOR);
    let word = word.map_or("", |word| word.trim_end_matches('.'));
    let word = ["/channel", "/chan", "/ch"]
        .iter()
        .find_map(|of| word.strip_suffix(of))
        .unwrap_or(word);
    if is_key || number(word).is_some() || is_cell && !is_unit_of_rows(word) {
        return "";
    }
    word
}

/// Returns the factor from a unit of a rate to hertz.
fn hz_of(unit: &str) -> Option<f64> {
    UNITS
        .iter()
        .find(|(name, _)| *name == unit)
        .map(|(_, hz)| *hz)
}

/// True for a unit of a rate or of an interval.
fn is_unit_of_rows(word: &str) -> bool {
    hz_of(word).is_some() || per_second(word).is_some()
}

/// True if a key is one of the `known` words, or ends with one that is not in [`ALONE`].
fn ends(key: &str, known: &[&str]) -> bool {
    known.iter().any(|word| {
        key.strip_suffix(word).is_some_and(|before| {
            before.is_empty() || before.ends_with(' ') && !ALONE.contains(word)
        })
    })
}

/// Tokens for a comma or a semicolon, and for an equals sign or a colon.
const SEPARATOR: &str = ";";
const EQUALS: &str = "=";

fn number(token: &str) -> Option<f64> {
    token
        .starts_with(|c: char| c.is_ascii_digit() || c == '.')
        .then(|| token.parse().ok())?
}

/// Splits a line into words, numbers and separators; a unit directly after a number is a separate
/// word. `12'800` and `10 000` are one number each. `25,600` is not a number, because its comma
/// may be a decimal comma or separate thousands.
fn tokens(line: &str) -> Vec<String> {
    let chars: Vec<char> = line.chars().collect();
    let is_digit = |at: Option<usize>| {
        at.and_then(|at| chars.get(at))
            .is_some_and(char::is_ascii_digit)
    };
    let is_group =
        |at: usize| (1..4).all(|step| is_digit(Some(at + step))) && !is_digit(Some(at + 4));
    let mut spaced = String::new();
    for (at, c) in chars.iter().enumerate() {
        let before = at.checked_sub(1);
        let word = spaced.rsplit(' ').next().unwrap_or_default();
        let is_short = matches!(word.len(), 1..=3) && word.chars().all(|c| c.is_ascii_digit());
        let is_thousands = is_short && !word.starts_with('0') && is_group(at);
        match c {
            ' ' | '\'' | '\u{a0}' | '\u{2009}' | '\u{202f}' if is_thousands => {}
            // Keep the comma: the word is then not read as a number.
            ',' if is_thousands => spaced.push(','),
            ',' if is_digit(before) && is_digit(Some(at + 1)) => spaced.push('.'),
            ',' | ';' => spaced.push_str(" ; "),
            '=' | ':' => spaced.push_str(" = "),
            '"' | '(' | ')' | '[' | ']' | '\'' | '\t' => spaced.push(' '),
            c if c.is_alphabetic() && is_digit(before) => {
                // A digit that ends a word stays with it.
                let after = chars.get(at + 1);
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
            ("Sampling frequency: 12'800 Hz", Some(12_800.0)),
            ("Sample rate: 10 000 Hz", Some(10_000.0)),
            ("Sample Rate: 25,600 Hz", None),
            ("Sample rate = 51.2k", Some(51_200.0)),
            (
                "Recorded 3 May 2024. Sampling rate: 2 kHz. 16 bit.",
                Some(2000.0),
            ),
            ("Sample Rate: 2 kSa/s", Some(2000.0)),
            ("Sampling Rate,500 MSa/s", Some(5e8)),
            ("Sample rate: 2.5 kHz/channel", Some(2500.0)),
            ("Logging rate: 60 samples/min", Some(1.0)),
            ("Sample rate: 5 ms", Some(200.0)),
            ("Sample rate: 500 s", None),
            ("Sample Interval (ms): 5", Some(200.0)),
            ("SAMPLING_INTERVAL_S: 0.005000", Some(200.0)),
            ("Abtastrate [Hz];500", Some(500.0)),
            ("Samples per second: 400", Some(400.0)),
            ("ODR 104 Hz, FS 4 g", Some(104.0)),
            ("fs=200 channels=3", Some(200.0)),
            ("Data rate: 9600 bps", None),
            ("MPU6050 accel FS=8 g", None),
            ("FS=8 g", None),
            ("I2C rate: 400 kHz", None),
            ("Autosave interval: 60 s", None),
            ("Scan rate: 100 mV/s", None),
            ("Laser repetition rate: 10 Hz", None),
            ("Sample Rate: 1000 Hz\nDecimation: 10", None),
            ("Sample Rate: 1000 Hz\nAveraging filter", None),
            ("Sample Rate: 1000 Hz\nDecimation: 1", Some(1000.0)),
            ("Averaging,Off,\nSample Rate,1000", Some(1000.0)),
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
