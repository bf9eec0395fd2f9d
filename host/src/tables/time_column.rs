//! Finds the time column and its unit.

use super::look::Look;
use super::units::{Declared, bracketed, declared_time, lower_words, per_second};

/// Name of the column that is time in seconds.
pub const TIME_COLUMN: &str = "time_s";

/// Words in a name that mark a column as time but do not declare a unit.
const TIME_WORDS: [&str; 18] = [
    "time",
    "timer",
    "timestamp",
    "timestamps",
    "datetime",
    "stamp",
    "tow",
    "elapsed",
    "clock",
    "epoch",
    "utc",
    "uptime",
    "zeit",
    "zeitstempel",
    "temps",
    "tiempo",
    "tempo",
    "tijd",
];

/// Accepted units of time.
pub const UNITS: &str = "s, ms, us, ns, min, h or d";

/// Names of a time that may also mean something different, such as a minimum or a height.
const TIME_NAMES_IF_STEADY: [&str; 9] = [
    "min", "minutes", "h", "hr", "hours", "d", "days", "s", "sec",
];

/// Complete names of a time, with units per second.
const TIME_NAMES: [(&str, Option<f64>); 11] = [
    ("x_value", Some(1.0)),
    ("second", Some(1.0)),
    ("seconds", Some(1.0)),
    ("millis", Some(1e3)),
    ("milliseconds", Some(1e3)),
    ("ms", Some(1e3)),
    ("micros", Some(1e6)),
    ("microseconds", Some(1e6)),
    ("us", Some(1e6)),
    ("nanos", Some(1e9)),
    ("nanoseconds", Some(1e9)),
];

/// Time column chosen by the user.
#[derive(Clone, Debug, PartialEq)]
pub enum TimeColumn {
    /// There is no time column.
    Nothing,
    /// Name of the column, and units per second; `None` if the unit must be found from the name or
    /// the numbers.
    Named(String, Option<f64>),
}

impl TimeColumn {
    /// Parses `NAME`, `NAME:UNIT` or `none`.
    pub fn parse(text: &str) -> Result<Self, String> {
        if text == "none" {
            return Ok(Self::Nothing);
        }
        let Some((name, unit)) = text.rsplit_once(':') else {
            return Ok(Self::Named(text.to_owned(), None));
        };
        match per_second(unit) {
            Some(unit) => Ok(Self::Named(name.to_owned(), Some(unit))),
            // The name itself may contain a colon.
            None if unit.contains([' ', '(', '[']) => Ok(Self::Named(text.to_owned(), None)),
            None => Err(format!("unit {unit:?}: choose {UNITS}")),
        }
    }
}

/// Confidence, from its name, that a column is the time.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Likeness {
    /// A word for time among other words: `RX Date/Time`.
    Contains,
    /// `Timestamp`.
    Bare,
    /// A short name with a unit: `t [ms]`.
    WithUnit,
    /// `time_s`.
    Exact,
}

/// Unit and confidence that a name gives to a possible time column.
#[derive(Clone, Debug, PartialEq)]
pub struct Named {
    pub likeness: Likeness,
    pub unit: Declared,
}

/// Recognises the name of a time column and its unit: `time_ms`, `%time`, `t (s)`, `stamp_ns`,
/// `Timestamp[nanosec]`. `min`, `h` and `Ticks (10 us)` count only if the column grows steadily.
pub fn named(name: &str, is_steady: bool) -> Option<Named> {
    let make = |likeness, unit| Some(Named { likeness, unit });
    if name == TIME_COLUMN {
        return make(Likeness::Exact, Declared::PerSecond(1.0));
    }
    let name = lower_words(name);
    if let Some((_, Some(unit))) = TIME_NAMES.iter().find(|(known, _)| *known == name) {
        return make(Likeness::WithUnit, Declared::PerSecond(*unit));
    }
    if is_steady
        && TIME_NAMES_IF_STEADY.contains(&name.as_str())
        && let Some(unit) = per_second(&name)
    {
        return make(Likeness::WithUnit, Declared::PerSecond(unit));
    }
    let words: Vec<&str> = name
        .split(|c: char| !c.is_alphanumeric())
        .filter(|word| !word.is_empty())
        .collect();
    let unit = declared_time(&name);
    let is_counted =
        is_steady && bracketed(&name).is_some_and(|(_, unit)| per_second(unit).is_some());
    // `t` next to a word that is not a unit may be a temperature.
    let is_t = match (&words[..], &unit) {
        (["t"], _) => true,
        (["t", ..], Declared::PerSecond(_)) => words.len() == 2 || name.contains(['(', '[']),
        _ => false,
    };
    if !is_t && !words.iter().any(|word| TIME_WORDS.contains(word)) {
        // `Ticks (10 us)`
        return is_counted.then_some(Named {
            likeness: Likeness::Contains,
            unit,
        });
    }
    match (&unit, &words[..]) {
        (Declared::Nothing, [_]) => make(Likeness::Bare, unit),
        (Declared::Nothing, _) => make(Likeness::Contains, unit),
        _ => make(Likeness::WithUnit, unit),
    }
}

/// Time in two columns, such as `stamp.sec` and `stamp.nanosec`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SplitTime {
    pub seconds: usize,
    pub fraction: usize,
    /// Number of units of the fraction per second.
    pub per_second: f64,
}

impl SplitTime {
    /// Finds a column of whole seconds and one of its fraction.
    pub fn find(names: &[&str], looks: &[Look]) -> Option<Self> {
        let fits = |split: &Self| {
            let (seconds, fraction) = (&looks[split.seconds], &looks[split.fraction]);
            let is_in_range = fraction.min >= 0.0 && fraction.max < split.per_second;
            seconds.may_be_seconds() && fraction.is_whole && is_in_range
        };
        Self::named(names).into_iter().find(fits)
    }

    /// Returns all pairs of columns whose names differ only in the unit, seconds and a smaller one.
    pub fn named(names: &[&str]) -> Vec<Self> {
        let units = names.iter().enumerate().filter_map(|(at, name)| {
            let name = lower_words(name);
            let unit = name.rsplit(|c: char| !c.is_alphanumeric()).next()?;
            let per_second = per_second(unit)?;
            Some((at, name[..name.len() - unit.len()].to_owned(), per_second))
        });
        let units: Vec<(usize, String, f64)> = units.collect();
        let whole = units.iter().filter(|(.., per_second)| *per_second == 1.0);
        let pairs = whole.flat_map(|(seconds, before, _)| {
            let same = units
                .iter()
                .filter(move |(_, name, per_second)| name == before && *per_second > 1.0);
            same.map(|(fraction, _, per_second)| Self {
                seconds: *seconds,
                fraction: *fraction,
                per_second: *per_second,
            })
        });
        pairs.collect()
    }

    pub fn has(&self, column: usize) -> bool {
        column == self.seconds || column == self.fraction
    }
}

/// A column that may be the time.
#[derive(Clone, Debug)]
pub struct Candidate {
    pub at: usize,
    pub named: Named,
    /// Fraction of the first rows in which the column grows.
    pub grows: f64,
}

/// Chooses the time column: among the candidates that grow, the one with the clearest name. The
/// error lists the candidates if the choice is ambiguous.
pub fn choose(candidates: &[Candidate]) -> Result<Option<Candidate>, Vec<usize>> {
    /// Difference in growth to tolerate: one column may repeat stamps that a finer column resolves.
    const ABOUT: f64 = 0.02;
    let max = candidates
        .iter()
        .map(|found| found.grows)
        .fold(0.0, f64::max);
    let grow =
        |found: &&Candidate| found.grows >= max - ABOUT || found.named.likeness == Likeness::Exact;
    let best = candidates
        .iter()
        .filter(grow)
        .map(|found| found.named.likeness)
        .max();
    let all: Vec<&Candidate> = candidates
        .iter()
        .filter(grow)
        .filter(|found| Some(found.named.likeness) == best)
        .collect();
    match all[..] {
        [] => Ok(None),
        [one] => Ok(Some(one.clone())),
        _ => Err(all.iter().map(|found| found.at).collect()),
    }
}

/// Quotes a word of a command line if a shell would split or change it.
pub fn quoted(word: &str) -> String {
    let is_plain = |c: char| c.is_alphanumeric() || "_-.:/%+,".contains(c);
    if word.chars().all(is_plain) {
        word.to_owned()
    } else {
        format!("'{}'", word.replace('\'', "'\\''"))
    }
}

/// Lists names for a message; of many, the first ones.
pub fn listed(names: &[impl AsRef<str>]) -> String {
    const SHOWN: usize = 24;
    let shown: Vec<&str> = names.iter().take(SHOWN).map(AsRef::as_ref).collect();
    let shown = shown.join(", ");
    match names.len().saturating_sub(SHOWN) {
        0 => shown,
        others => format!("{shown} and {others} others"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_say_that_they_are_a_time_and_in_what_unit() {
        for (name, expected) in [
            ("time_s", Some(Some(1.0))),
            ("time_ms", Some(Some(1e3))),
            ("timeStampMs", Some(Some(1e3))),
            ("elapsedSeconds", Some(Some(1.0))),
            ("Time [us]", Some(Some(1e6))),
            ("t (s)", Some(Some(1.0))),
            ("Timestamp", Some(None)),
            ("%time", Some(None)),
            ("__time", Some(None)),
            ("timer", Some(None)),
            ("micros", Some(Some(1e6))),
            ("datetime", Some(None)),
            ("stamp_ns", Some(Some(1e9))),
            ("Timestamp[nanosec]", Some(Some(1e9))),
            ("tow(msec)", Some(Some(1e3))),
            ("Relative Time (s)", Some(Some(1.0))),
            ("Latest: Time (s)", Some(Some(1.0))),
            ("RX Date/Time", Some(None)),
            ("Second", Some(Some(1.0))),
            ("X_Value", Some(Some(1.0))),
            ("Zeit (ms)", Some(Some(1e3))),
            ("tension", None),
            ("force (s)", None),
            ("ain0", None),
            ("T_°C", None),
        ] {
            let found = named(name, false).map(|named| match named.unit {
                Declared::PerSecond(unit) => Some(unit),
                _ => None,
            });
            assert_eq!(found, expected, "{name}");
        }
    }

    #[test]
    fn a_count_of_times_is_one_if_it_grows() {
        for name in ["Ticks (10 us)", "counter [ms]"] {
            assert_eq!(named(name, false), None, "{name}");
            let found = named(name, true).map(|found| found.likeness);
            assert_eq!(found, Some(Likeness::Contains), "{name}");
        }
    }

    #[test]
    fn the_clearest_name_of_a_column_that_grows_is_the_time() {
        let candidates = |names: &[(&str, f64)]| -> Vec<Candidate> {
            let named = names.iter().enumerate().filter_map(|(at, (name, grows))| {
                Some(Candidate {
                    at,
                    named: named(name, false)?,
                    grows: *grows,
                })
            });
            named.collect()
        };
        let chosen = |names: &[(&str, f64)]| {
            choose(&candidates(names)).map(|found| found.map(|found| found.at))
        };
        assert_eq!(chosen(&[("t", 1.0), ("time_s", 1.0)]), Ok(Some(1)));
        assert_eq!(chosen(&[("time", 1.0), ("stamp.secs", 0.01)]), Ok(Some(0)));
        assert_eq!(
            chosen(&[("Timestamp", 1.0), ("Timestamp (Formatted)", 1.0)]),
            Ok(Some(0))
        );
        assert_eq!(chosen(&[("t", 1.0), ("time", 1.0)]), Err(vec![0, 1]));
        assert_eq!(chosen(&[("ax", 1.0)]), Ok(None));
    }

    #[test]
    fn a_column_can_be_asked_for() {
        assert_eq!(TimeColumn::parse("none"), Ok(TimeColumn::Nothing));
        assert_eq!(
            TimeColumn::parse("%time:ns"),
            Ok(TimeColumn::Named("%time".into(), Some(1e9)))
        );
        assert_eq!(
            TimeColumn::parse("t:min"),
            Ok(TimeColumn::Named("t".into(), Some(1.0 / 60.0)))
        );
        assert_eq!(
            TimeColumn::parse("Latest: Time (s)"),
            Ok(TimeColumn::Named("Latest: Time (s)".into(), None))
        );
        assert!(TimeColumn::parse("t:furlong").is_err_and(|why| why.contains(UNITS)));
    }
}
