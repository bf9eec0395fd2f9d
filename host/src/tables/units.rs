//! Finds units in the names of columns: `Time (min)`, `t_ms`, `Force [N]`.

/// Units of time: length in seconds, and names.
const TIMES: [(f64, &[&str]); 12] = [
    (
        1.0,
        &[
            "s", "sec", "secs", "second", "seconds", "sek", "sekunde", "sekunden",
        ],
    ),
    (
        1e-3,
        &[
            "ms",
            "msec",
            "msecs",
            "millis",
            "millisec",
            "millisecond",
            "milliseconds",
            "millisekunden",
        ],
    ),
    (
        1e-6,
        &[
            "us",
            "µs",
            "μs",
            "usec",
            "usecs",
            "µsec",
            "micros",
            "microsec",
            "microsecond",
            "microseconds",
            "mikrosekunden",
        ],
    ),
    (
        1e-9,
        &[
            "ns",
            "nsec",
            "nsecs",
            "nanos",
            "nanosec",
            "nanosecond",
            "nanoseconds",
        ],
    ),
    (1e-12, &["ps", "psec", "picoseconds"]),
    (1e-2, &["cs", "centiseconds"]),
    (1e-1, &["ds", "deciseconds"]),
    (1e3, &["ks", "ksec", "kiloseconds"]),
    (
        60.0,
        &["min", "mins", "minute", "minutes", "minuten", "minuto"],
    ),
    (
        3600.0,
        &["h", "hr", "hrs", "hour", "hours", "std", "stunden"],
    ),
    (86_400.0, &["d", "day", "days", "tag", "tage"]),
    (604_800.0, &["week", "weeks"]),
];

/// Words for counts other than times, at the end of the name of a time.
const NO_TIMES: [&str; 17] = [
    "tick", "ticks", "cycle", "cycles", "count", "counts", "frame", "frames", "sample", "samples",
    "jiffy", "jiffies", "step", "steps", "months", "years", "beats",
];

/// Words in brackets after a time that are not units.
const REMARKS: [&str; 26] = [
    "utc",
    "gmt",
    "local",
    "localtime",
    "formatted",
    "gps",
    "est",
    "cet",
    "cest",
    "pst",
    "iso",
    "iso8601",
    "hh",
    "mm",
    "ss",
    "hhmmss",
    "sss",
    "fff",
    "relative",
    "rel",
    "abs",
    "absolute",
    "elapsed",
    "unix",
    "epoch",
    "since",
];

/// Unit that a name or a cell declares.
#[derive(Clone, Debug, PartialEq)]
pub enum Declared {
    /// Number of units in a second.
    PerSecond(f64),
    /// Unit that is unknown or not a time.
    Unknown(String),
    Nothing,
}

/// Parses a unit of time, such as `ms`, `(min)`, `10 ms`, `1/100 s`, `1e-3 s` or `s/100`. Returns
/// the number of units per second.
pub fn per_second(unit: &str) -> Option<f64> {
    let unit = unit.trim_matches(|c: char| c.is_whitespace() || "()[]{}.".contains(c));
    let unit = unit.to_lowercase();
    if let Some((name, parts)) = unit.split_once('/')
        && let Some(whole) = per_second_of(name.trim())
    {
        return Some(whole * count(parts.trim())?);
    }
    let number = unit.trim_end_matches(char::is_alphabetic);
    let whole = per_second_of(&unit[number.len()..])?;
    Some(whole / count(number.trim())?)
}

fn per_second_of(name: &str) -> Option<f64> {
    let known = TIMES.iter().find(|(_, names)| names.contains(&name))?;
    // The inverse of 1e-3 is not exact, so it is rounded to 1e3.
    Some(match known.0 {
        seconds if seconds < 1.0 => (1.0 / seconds).round(),
        seconds => 1.0 / seconds,
    })
}

/// Parses the number in front of a unit: `10`, `1e-3`, `10^-3`, `1/100`; 1 if there is none.
fn count(text: &str) -> Option<f64> {
    let number = |text: &str| text.trim().parse::<f64>().ok();
    let count = match (text.split_once('/'), text.strip_prefix("10^")) {
        _ if text.is_empty() => 1.0,
        (Some((above, below)), _) => number(above)? / number(below)?,
        (None, Some(power)) => 10f64.powf(number(power)?),
        (None, None) => number(text)?,
    };
    (count > 0.0 && count.is_finite()).then_some(count)
}

/// Returns the name of a unit of time for messages.
pub fn unit_name(per_second: f64) -> String {
    let names = [
        (1.0, "seconds"),
        (1e3, "milliseconds"),
        (1e6, "microseconds"),
        (1e9, "nanoseconds"),
        (1.0 / 60.0, "minutes"),
        (1.0 / 3600.0, "hours"),
        (1.0 / 86_400.0, "days"),
    ];
    let known = names.iter().find(|(known, _)| *known == per_second);
    known.map_or_else(
        || {
            format!(
                "units of {} s",
                crate::digits::significant(1.0 / per_second, 3)
            )
        },
        |(_, name)| (*name).to_owned(),
    )
}

/// Returns the name before the brackets at its end, and the text in them.
pub fn bracketed(name: &str) -> Option<(&str, &str)> {
    let name = name.trim();
    let open = match name.chars().last()? {
        ')' => '(',
        ']' => '[',
        '}' => '{',
        _ => return None,
    };
    let at = name.rfind(open)?;
    Some((
        name[..at].trim(),
        name[at + 1..name.len() - 1]
            .trim_matches(|c: char| c.is_whitespace() || "()[]{}".contains(c)),
    ))
}

/// Returns a name in lower case. If its last word, after a capital, is a unit, its words are
/// separated: `timeStampMs` becomes `time stamp ms`. Two small letters must precede a capital: `mV`
/// is one word.
pub fn lower_words(name: &str) -> String {
    let name = name.trim();
    let (mut words, mut last, mut small) = (String::new(), 0, 0);
    for (at, c) in name.char_indices() {
        if c.is_uppercase() && small > 1 {
            words.push(' ');
            last = at;
        }
        small = if c.is_lowercase() { small + 1 } else { 0 };
        words.extend(c.to_lowercase());
    }
    let unit = name[last..].to_lowercase();
    match last > 0 && unit.len() > 1 && per_second_of(&unit).is_some() {
        true => words,
        false => name.to_lowercase(),
    }
}

/// Returns the unit of time that a column's name declares.
pub fn declared_time(name: &str) -> Declared {
    let lower = lower_words(name);
    let is_between = |c: char| !c.is_alphanumeric() && !matches!(c, 'µ' | 'μ');
    if let Some((_, inside)) = bracketed(&lower) {
        if let Some(known) = per_second(inside) {
            return Declared::PerSecond(known);
        }
        let words: Vec<&str> = inside
            .split(is_between)
            .filter(|word| !word.is_empty())
            .collect();
        if words.iter().any(|word| part(word).is_some()) {
            return Declared::Unknown(inside.to_owned());
        }
        if let Some(at) = words.iter().position(|word| per_second(word).is_some()) {
            // A number next to a unit multiplies or divides it; which one is unclear: `s x 100`.
            let beside = [
                at.checked_sub(1).and_then(|at| words.get(at)),
                words.get(at + 1),
            ];
            return match per_second(words[at]) {
                Some(known) if !beside.into_iter().flatten().any(|word| is_factor(word)) => {
                    Declared::PerSecond(known)
                }
                _ => Declared::Unknown(inside.to_owned()),
            };
        }
        return match words.iter().all(|word| REMARKS.contains(word)) {
            true => Declared::Nothing,
            false => Declared::Unknown(inside.to_owned()),
        };
    }
    let words: Vec<&str> = lower
        .split(is_between)
        .filter(|word| !word.is_empty())
        .collect();
    let [_, .., before, last] = words[..] else {
        return match words[..] {
            [_, last] => declared_last(&lower, "", last),
            _ => Declared::Nothing,
        };
    };
    declared_last(&lower, before, last)
}

/// Returns the unit that the last word of a name declares.
fn declared_last(name: &str, before: &str, last: &str) -> Declared {
    match per_second(last) {
        // Without brackets, the 10 in `10 us` may also be the number of a column.
        Some(_) if is_factor(before) || is_factor(last) => {
            let from = name.find(|c: char| c.is_ascii_digit()).unwrap_or(0);
            Declared::Unknown(name[from..].to_owned())
        }
        Some(known) => Declared::PerSecond(known),
        None if NO_TIMES.contains(&last) => Declared::Unknown(last.to_owned()),
        // `time_us_x100`
        None if last.len() > 1
            && last.starts_with('x')
            && is_factor(last)
            && per_second(before).is_some() =>
        {
            Declared::Unknown(format!("{before} {last}"))
        }
        None => Declared::Nothing,
    }
}

/// True for a factor of a unit, `10` or `x100`, or for a multiplication sign.
fn is_factor(word: &str) -> bool {
    word == "x"
        || word
            .trim_start_matches('x')
            .starts_with(|c: char| c.is_ascii_digit())
}

/// Words for a part of a unit, as in `hundredths of a second`.
const PARTS: [(&str, &str); 5] = [
    ("half", "2"),
    ("tenth", "10"),
    ("hundredth", "100"),
    ("thousandth", "1000"),
    ("millionth", "1000000"),
];

/// Returns the number of parts in a whole for a word such as `hundredths`.
fn part(word: &str) -> Option<&'static str> {
    let word = word.strip_suffix('s').unwrap_or(word);
    let known = PARTS.iter().find(|(known, _)| *known == word)?;
    Some(known.1)
}

/// Returns the possible meanings of a unit that is not clear: `sec x 100` is a hundredth of a
/// second or 100 s, `hundredths of a second` is `s/100`, and `m` is a minute or a millisecond.
pub fn meanings(unit: &str) -> Vec<String> {
    if unit == "m" {
        return vec!["min".into(), "ms".into()];
    }
    let mut words = unit.split(|c: char| !c.is_alphanumeric());
    let Some(known) = words.clone().find(|word| per_second_of(word).is_some()) else {
        return Vec::new();
    };
    if let Some(parts) = words.clone().find_map(part) {
        return vec![format!("{known}/{parts}")];
    }
    let factors = |word: &str| {
        let number = word.trim_start_matches('x');
        number.parse::<u32>().ok().filter(|factor| *factor > 0)
    };
    words.find_map(factors).map_or_else(Vec::new, |factor| {
        vec![format!("{known}/{factor}"), format!("{factor}{known}")]
    })
}

pub fn is_count(unit: &str) -> bool {
    unit.split(|c: char| !c.is_alphanumeric())
        .any(|word| NO_TIMES.contains(&word))
}

/// Returns the unit in a channel's name, such as `Force [N]`, `ain0_mV` or `v (V)`.
pub fn of_channel(name: &str) -> Option<String> {
    if let Some((before, inside)) = bracketed(name) {
        return (!before.is_empty() && !inside.is_empty()).then(|| inside.to_owned());
    }
    const SUFFIXES: [&str; 16] = [
        "V", "mV", "uV", "g", "mg", "N", "mN", "kPa", "Pa", "mm", "m", "deg", "degC", "mA", "A",
        "counts",
    ];
    let (_, suffix) = name.rsplit_once(['_', ' '])?;
    SUFFIXES.contains(&suffix).then(|| suffix.to_owned())
}

/// Units that may have a prefix.
const UNITS: [&str; 26] = [
    "V", "A", "N", "g", "m", "s", "Pa", "Hz", "W", "J", "C", "K", "T", "F", "Ohm", "ohm", "Ω",
    "\u{2126}", "bar", "rad", "gauss", "G", "Nm", "Vrms", "volts", "LSB",
];

/// Units without a prefix, and words used instead of a unit.
const UNITS_ALONE: [&str; 34] = [
    "%", "°", "°C", "°F", "deg", "degC", "degF", "degrees", "rpm", "psi", "lb", "lbf", "lbs",
    "kgf", "in", "inch", "inches", "ft", "ppm", "dB", "counts", "count", "raw", "bits", "Volts",
    "Volt", "Newtons", "newtons", "Newton", "px", "a.u.", "au", "-", "n/a",
];

/// Prefixes of units, including none. Micro has two code points.
const PREFIXES: [&str; 13] = [
    "", "G", "M", "k", "h", "d", "c", "m", "u", "µ", "μ", "n", "p",
];

/// True for a unit of any quantity, such as `mV`, `[m/s^2]`, `N·m`, `°/s` or `ms`, and for `-`.
pub fn is_unit(cell: &str) -> bool {
    let cell = cell.trim_matches(|c: char| c.is_whitespace() || "()[]{}".contains(c));
    let is_known = |part: &str| {
        let part = part.trim_end_matches(|c: char| c.is_ascii_digit() || "^-²³⁻¹".contains(c));
        let mut prefixes = UNITS.iter().filter_map(|unit| part.strip_suffix(unit));
        prefixes.any(|prefix| PREFIXES.contains(&prefix))
            || UNITS_ALONE.contains(&part)
            || per_second(part).is_some()
    };
    UNITS_ALONE.contains(&cell)
        || !cell.is_empty() && cell.split(['/', '*', '·', ' ']).all(is_known)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_of_time_are_known_or_named() {
        use Declared::{Nothing, PerSecond, Unknown};
        for (name, expected) in [
            ("Time (min)", PerSecond(1.0 / 60.0)),
            ("timestamp_min", PerSecond(1.0 / 60.0)),
            ("time in minutes", PerSecond(1.0 / 60.0)),
            ("Zeit (Minuten)", PerSecond(1.0 / 60.0)),
            ("Time(min.)", PerSecond(1.0 / 60.0)),
            ("Elapsed (h)", PerSecond(1.0 / 3600.0)),
            ("Time (days)", PerSecond(1.0 / 86_400.0)),
            ("time (ks)", PerSecond(1e-3)),
            ("Time (10 ms)", PerSecond(100.0)),
            ("Time (1/100 s)", PerSecond(100.0)),
            ("time(1e-3 s)", PerSecond(1e3)),
            ("Time [10^-3 s]", PerSecond(1e3)),
            ("time (ms/10)", PerSecond(1e4)),
            ("Time (sec x 100)", Unknown("sec x 100".into())),
            ("Time (x 1000 s)", Unknown("x 1000 s".into())),
            ("time x10 ms", Unknown("10 ms".into())),
            ("Time in 1/10 s", Unknown("1/10 s".into())),
            ("time_10us", Unknown("10us".into())),
            ("time2_s", PerSecond(1.0)),
            ("Timestamp[nanosec]", PerSecond(1e9)),
            ("Time (s since start)", PerSecond(1.0)),
            ("t (µs)", PerSecond(1e6)),
            ("time_s", PerSecond(1.0)),
            ("Time (UTC)", Nothing),
            ("Time (HH:MM:SS.fff)", Nothing),
            ("time", Nothing),
            ("time_2", Nothing),
            ("Time (fortnights)", Unknown("fortnights".into())),
            ("time_ticks", Unknown("ticks".into())),
            ("timestampMs", PerSecond(1e3)),
            ("TimeStampNs", PerSecond(1e9)),
            ("TimeUS", PerSecond(1e6)),
            ("elapsedSeconds", PerSecond(1.0)),
            ("SampleTimeFine", Nothing),
            ("Time (mS)", PerSecond(1e3)),
            ("time_us_x100", Unknown("us x100".into())),
        ] {
            assert_eq!(declared_time(name), expected, "{name}");
        }
        for (unit, expected) in [
            ("us x100", &["us/100", "100us"][..]),
            ("sec x 100", &["sec/100", "100sec"]),
            ("hundredths of a second", &["second/100"]),
            ("m", &["min", "ms"]),
            ("furlongs", &[]),
        ] {
            assert_eq!(meanings(unit), expected, "{unit}");
            assert!(expected.iter().all(|unit| per_second(unit).is_some()));
        }
        assert_eq!(of_channel("Force [N]").as_deref(), Some("N"));
        assert_eq!(of_channel("ain0_mV").as_deref(), Some("mV"));
        assert_eq!(of_channel("ain0"), None);
        assert_eq!(of_channel("(x)"), None);
        for unit in [
            "mV", "[m/s^2]", "N·m", "°/s", "m/s²", "µm", "ms", "-", "%", "rad s^-1", "n/a", "kΩ",
        ] {
            assert!(is_unit(unit), "{unit}");
        }
        for name in [
            "ax", "left", "x", "time", "", "force/x", "mm V x", "AIN", "m s left",
        ] {
            assert!(!is_unit(name), "{name}");
        }
    }
}
