//! Which column is the time, and in what unit.

/// Name of the column that is time in seconds.
pub const TIME_COLUMN: &str = "time_s";

/// Words of a name that say that a column is the time, but not in what unit.
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

/// Names that are a time as a whole.
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

/// Units of a time, by how many of them are a second.
const UNITS: [(&str, f64); 25] = [
    ("s", 1.0),
    ("sec", 1.0),
    ("secs", 1.0),
    ("second", 1.0),
    ("seconds", 1.0),
    ("ms", 1e3),
    ("msec", 1e3),
    ("msecs", 1e3),
    ("millis", 1e3),
    ("millisec", 1e3),
    ("millisecond", 1e3),
    ("milliseconds", 1e3),
    ("us", 1e6),
    ("µs", 1e6),
    ("μs", 1e6),
    ("usec", 1e6),
    ("usecs", 1e6),
    ("micros", 1e6),
    ("microsec", 1e6),
    ("microseconds", 1e6),
    ("ns", 1e9),
    ("nsec", 1e9),
    ("nanos", 1e9),
    ("nanosec", 1e9),
    ("nanoseconds", 1e9),
];

/// The column that somebody says is the time.
#[derive(Clone, Debug, PartialEq)]
pub enum TimeColumn {
    /// None is.
    Nothing,
    /// The one of this name, with how many of its units are a second; none if its name or its
    /// numbers have to say.
    Named(String, Option<f64>),
}

impl TimeColumn {
    /// `NAME`, `NAME:UNIT` or `none`.
    pub fn parse(text: &str) -> Result<Self, String> {
        if text == "none" {
            return Ok(Self::Nothing);
        }
        let Some((name, unit)) = text.rsplit_once(':') else {
            return Ok(Self::Named(text.to_owned(), None));
        };
        match per_second(unit) {
            Some(unit) => Ok(Self::Named(name.to_owned(), Some(unit))),
            None => Err(format!("unit {unit:?}: choose s, ms, us or ns")),
        }
    }
}

/// How many of a unit are a second, by its name, in brackets or not.
pub fn per_second(unit: &str) -> Option<f64> {
    let unit = unit.trim_matches(|c: char| c.is_whitespace() || "()[]{}".contains(c));
    let unit = unit.to_lowercase();
    let known = UNITS.iter().find(|(name, _)| *name == unit);
    known.map(|(_, per_second)| *per_second)
}

/// The unit's name as messages give it.
pub fn unit_name(per_second: f64) -> &'static str {
    match per_second {
        1e3 => "milliseconds",
        1e6 => "microseconds",
        1e9 => "nanoseconds",
        _ => "seconds",
    }
}

/// How much a name says that its column is the time.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Likeness {
    /// Beside other words: `RX Date/Time`.
    Contains,
    /// `Timestamp`.
    Bare,
    /// `t [ms]`.
    WithUnit,
    /// `time_s`.
    Exact,
}

/// What a name says about a column that may be the time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Named {
    pub likeness: Likeness,
    /// Its units in a second, if the name says so.
    pub per_second: Option<f64>,
}

/// Whether a name is a time's: `time_ms`, `%time`, `t (s)`, `stamp_ns`, `Timestamp[nanosec]`.
pub fn named(name: &str) -> Option<Named> {
    let make = |likeness, per_second| {
        Some(Named {
            likeness,
            per_second,
        })
    };
    if name == TIME_COLUMN {
        return make(Likeness::Exact, Some(1.0));
    }
    let name = name.trim().to_lowercase();
    if let Some((_, unit)) = TIME_NAMES.iter().find(|(known, _)| *known == name) {
        return make(Likeness::WithUnit, *unit);
    }
    let words: Vec<&str> = name
        .split(|c: char| !c.is_alphanumeric())
        .filter(|word| !word.is_empty())
        .collect();
    let unit = words.last().and_then(|last| per_second(last));
    // Beside another word than a unit it may be a temperature.
    let is_t = matches!((&words[..], unit), (["t"], _) | (["t", _], Some(_)));
    if !is_t && !words.iter().any(|word| TIME_WORDS.contains(word)) {
        return None;
    }
    match (unit, &words[..]) {
        (Some(unit), [..]) => make(Likeness::WithUnit, Some(unit)),
        (None, [_]) => make(Likeness::Bare, None),
        _ => make(Likeness::Contains, None),
    }
}

/// A column that may be the time.
#[derive(Clone, Copy, Debug)]
pub struct Candidate {
    pub at: usize,
    pub named: Named,
    /// Share of the first rows in which it grows.
    pub grows: f64,
}

/// The time among the candidates: of those that grow the one that says so most clearly. The error
/// has those of which each may be it.
pub fn choose(candidates: &[Candidate]) -> Result<Option<Candidate>, Vec<usize>> {
    /// Rows of one column may repeat a stamp that another refines.
    const ABOUT: f64 = 0.02;
    let most = candidates
        .iter()
        .map(|found| found.grows)
        .fold(0.0, f64::max);
    let grow =
        |found: &&Candidate| found.grows >= most - ABOUT || found.named.likeness == Likeness::Exact;
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
        [one] => Ok(Some(*one)),
        _ => Err(all.iter().map(|found| found.at).collect()),
    }
}

/// A word of a command line: in quotes where a shell would split or change it.
pub fn quoted(word: &str) -> String {
    let is_plain = |c: char| c.is_alphanumeric() || "_-.:/%+,".contains(c);
    if word.chars().all(is_plain) {
        word.to_owned()
    } else {
        format!("'{}'", word.replace('\'', "'\\''"))
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
            assert_eq!(
                named(name).map(|named| named.per_second),
                expected,
                "{name}"
            );
        }
    }

    #[test]
    fn the_clearest_name_of_a_column_that_grows_is_the_time() {
        let candidates = |names: &[(&str, f64)]| -> Vec<Candidate> {
            let named = names.iter().enumerate().filter_map(|(at, (name, grows))| {
                Some(Candidate {
                    at,
                    named: named(name)?,
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
        assert!(TimeColumn::parse("t:min").is_err_and(|why| why.contains("s, ms, us or ns")));
    }
}
