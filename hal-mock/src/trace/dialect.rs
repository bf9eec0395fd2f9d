//! How a table is written: what separates its columns, what follows its decimals, and which column
//! is the time in what unit.

use core::cell::Cell;

/// Name of the column that is time in seconds.
pub const TIME_COLUMN: &str = "time_s";

/// Names that alone say that a column is the time, but not in what unit.
const TIME_NAMES: [&str; 4] = ["time", "t", "timestamp", "elapsed"];

/// Units of a time, by how many of them are a second.
const UNITS: [(&str, f64); 14] = [
    ("s", 1.0),
    ("sec", 1.0),
    ("secs", 1.0),
    ("seconds", 1.0),
    ("ms", 1e3),
    ("msec", 1e3),
    ("millis", 1e3),
    ("milliseconds", 1e3),
    ("us", 1e6),
    ("µs", 1e6),
    ("usec", 1e6),
    ("microseconds", 1e6),
    ("ns", 1e9),
    ("nanoseconds", 1e9),
];

/// What stands for a missing reading besides a blank cell and `NaN`.
const MISSING: [&str; 5] = ["NA", "N/A", "null", "NULL", "None"];

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

fn per_second(unit: &str) -> Option<f64> {
    UNITS
        .iter()
        .find(|(name, _)| *name == unit.to_lowercase())
        .map(|(_, per_second)| *per_second)
}

/// Which column is the time: its place, and its units in a second if its name says that.
/// The error names columns of which each may be it.
pub fn time_column(
    columns: &[String],
    wanted: Option<&TimeColumn>,
) -> Result<Option<(usize, Option<f64>)>, String> {
    match wanted {
        Some(TimeColumn::Nothing) => return Ok(None),
        Some(TimeColumn::Named(name, unit)) => {
            let Some(at) = columns.iter().position(|column| column == name) else {
                return Err(format!(
                    "no column {name}; there are: {}",
                    columns.join(", ")
                ));
            };
            return Ok(Some((at, unit.or_else(|| named_unit(name).flatten()))));
        }
        None => {}
    }
    let exact: Vec<usize> = (0..columns.len())
        .filter(|at| columns[*at] == TIME_COLUMN)
        .collect();
    let with_unit = || {
        (0..columns.len())
            .filter(|at| named_unit(&columns[*at]).flatten().is_some())
            .collect()
    };
    let bare = || {
        (0..columns.len())
            .filter(|at| named_unit(&columns[*at]).is_some())
            .collect()
    };
    let found: Vec<usize> = match exact.len() {
        0 => Some(with_unit())
            .filter(|found: &Vec<usize>| !found.is_empty())
            .unwrap_or_else(bare),
        _ => exact,
    };
    match found[..] {
        [] => Ok(None),
        [at] => Ok(Some((at, named_unit(&columns[at]).flatten()))),
        [first, second, ..] if columns[first] == columns[second] => {
            Err(format!("more than one column is called {}", columns[first]))
        }
        _ => {
            let names: Vec<&str> = found.iter().map(|at| columns[*at].as_str()).collect();
            Err(format!(
                "{} may all be the time: choose with --time-column NAME, or none",
                names.join(", ")
            ))
        }
    }
}

/// Whether a name is a time's: some if it is, with its units in a second if it says so. `time_ms`,
/// `t (s)`, `Time [us]`.
fn named_unit(name: &str) -> Option<Option<f64>> {
    let name = name.trim().to_lowercase();
    if TIME_NAMES.contains(&name.as_str()) {
        return Some(None);
    }
    let (base, unit) = name.split_at(name.rfind(['_', '(', '[', '/', ' '])?);
    let unit = per_second(unit.trim_matches(['_', '(', ')', '[', ']', '/', ' ']))?;
    TIME_NAMES.contains(&base.trim()).then_some(Some(unit))
}

/// What separates columns, and decimals.
#[derive(Clone, Debug)]
pub struct Dialect {
    /// A space stands for any white space.
    pub separator: char,
    /// Every line has one separator more at its end.
    pub is_trailing: bool,
    /// What has stood before decimals so far.
    decimals: Cell<Option<char>>,
}

impl Dialect {
    /// By the header, and the first row if there is one.
    pub fn of(header: &str, row: Option<&str>) -> Self {
        let mut is_quoted = false;
        let outside: String = header
            .chars()
            .filter(|c| {
                is_quoted ^= *c == '"';
                !is_quoted
            })
            .collect();
        let words = |text: &str| text.split_whitespace().count();
        let mut found = Self {
            separator: ',',
            is_trailing: false,
            decimals: Cell::new(None),
        };
        if let Some(separator) = [';', '\t', ',']
            .into_iter()
            .find(|separator| outside.contains(*separator))
        {
            found.separator = separator;
        } else if words(&outside) > 1 && row.is_some_and(|row| words(row) == words(&outside)) {
            found.separator = ' ';
        }
        found.is_trailing = !found.is_space()
            && outside
                .trim_end_matches([' ', '\r', '\n'])
                .ends_with(found.separator);
        found
    }

    /// The cells of a line.
    pub fn cells<'a>(&self, line: &'a str) -> impl Iterator<Item = &'a str> + use<'a> {
        let (separator, is_space) = (self.separator, self.is_space());
        let line = line.trim_end_matches(['\r', '\n']);
        let line = if self.is_trailing {
            line.trim_end().strip_suffix(separator).unwrap_or(line)
        } else {
            line
        };
        line.split(move |c: char| {
            if is_space {
                c.is_whitespace()
            } else {
                c == separator
            }
        })
        .map(str::trim)
        .filter(move |cell| !is_space || !cell.is_empty())
    }

    /// The number in a cell, NaN where it is missing; none where it is no number.
    pub fn number(&self, cell: &str) -> Option<f64> {
        if let Ok(value) = cell.parse::<f64>() {
            if self.separator != ',' && cell.contains('.') {
                self.note('.')?;
            }
            return Some(value);
        }
        if cell.is_empty() || MISSING.contains(&cell) {
            return Some(f64::NAN);
        }
        // `1,5` where columns are separated by something else; never beside `1.5`, where it may be
        // a thousand and more.
        let value = cell
            .replacen(',', ".", 1)
            .parse()
            .ok()
            .filter(|_| self.separator != ',' && !cell.contains('.'));
        value.filter(|_| self.note(',').is_some())
    }

    fn note(&self, decimals: char) -> Option<()> {
        let before = self.decimals.replace(Some(decimals));
        (before.is_none() || before == Some(decimals)).then_some(())
    }

    fn is_space(&self) -> bool {
        self.separator == ' '
    }

    /// What is not as in a table of our own.
    pub fn guessed(&self) -> Vec<String> {
        let separated = match self.separator {
            ';' => Some("semicolons"),
            '\t' => Some("tabs"),
            ' ' => Some("white space"),
            _ => None,
        };
        let mut guessed: Vec<String> = separated
            .map(|by| format!("columns are separated by {by}"))
            .into_iter()
            .collect();
        if self.decimals.get() == Some(',') {
            guessed.push("decimals follow a comma".into());
        }
        guessed
    }
}

/// Seconds of a date and a time such as `2026-01-31T12:30:05.25`, since 1970, or of a time of day.
pub fn clock_time_s(text: &str) -> Option<f64> {
    let (date, time) = match text.split_once(['T', ' ']) {
        Some((date, time)) => (Some(date), time),
        None => (None, text),
    };
    let mut parts = time
        .trim()
        .trim_end_matches('Z')
        .splitn(3, ':')
        .map(str::parse::<f64>);
    let (hours, minutes, seconds) = (
        parts.next()?.ok()?,
        parts.next()?.ok()?,
        parts.next().unwrap_or(Ok(0.0)).ok()?,
    );
    let mut days = 0.0;
    if let Some(date) = date {
        let mut parts = date.splitn(3, '-').map(str::parse::<i64>);
        let (year, month, day) = (
            parts.next()?.ok()?,
            parts.next()?.ok()?,
            parts.next()?.ok()?,
        );
        // Years that begin in March have their leap day at the end.
        let (year, month) = if month > 2 {
            (year, month - 3)
        } else {
            (year - 1, month + 9)
        };
        days = (year * 365 + year.div_euclid(4) - year.div_euclid(100) + year.div_euclid(400)
            - 719_469
            + (153 * month + 2) / 5
            + day) as f64;
    }
    Some(86_400.0 * days + 3600.0 * hours + 60.0 * minutes + seconds)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn columns(names: &[&str]) -> Vec<String> {
        names.iter().map(|name| (*name).to_owned()).collect()
    }

    #[test]
    fn the_time_is_found_by_its_name_or_asked_for() {
        for (names, found) in [
            (&["a", "time_s"][..], Some((1, Some(1.0)))),
            (&["time_ms", "a"], Some((0, Some(1e3)))),
            (&["Time [us]", "t"], Some((0, Some(1e6)))),
            (&["a", "t (s)"], Some((1, Some(1.0)))),
            (&["Timestamp", "a"], Some((0, None))),
            (&["t", "time_s"], Some((1, Some(1.0)))),
            (&["tension", "force (s)"], None),
        ] {
            assert_eq!(time_column(&columns(names), None), Ok(found), "{names:?}");
        }
        let both = time_column(&columns(&["t", "time", "a"]), None).unwrap_err();
        assert!(
            both.contains("t, time") && both.contains("--time-column"),
            "{both}"
        );
        let wanted = |text| TimeColumn::parse(text).unwrap();
        assert_eq!(
            time_column(&columns(&["t", "time"]), Some(&wanted("t:ms"))),
            Ok(Some((0, Some(1e3))))
        );
        assert_eq!(
            time_column(&columns(&["t", "a"]), Some(&wanted("none"))),
            Ok(None)
        );
        assert!(
            time_column(&columns(&["t"]), Some(&wanted("x")))
                .is_err_and(|why| why.contains("there are: t"))
        );
        assert!(TimeColumn::parse("t:min").is_err_and(|why| why.contains("ms")));
    }

    #[test]
    fn separators_and_decimals() {
        let dialect = |header: &str, row: &str| Dialect::of(header, Some(row));
        for (header, row, separator) in [
            ("a,b", "1,2", ','),
            ("a;b", "1,5;2", ';'),
            ("a\tb c", "1\t2", '\t'),
            ("a b", "1 2", ' '),
            ("force of it", "1", ','),
            ("\"a;b\",c", "1,2", ','),
        ] {
            assert_eq!(dialect(header, row).separator, separator, "{header}");
        }
        let semicolons = dialect("a;b;", "1,5;2;");
        assert_eq!(
            semicolons.cells("1,5; 2;\r\n").collect::<Vec<_>>(),
            ["1,5", "2"]
        );
        assert_eq!(semicolons.number("1,5"), Some(1.5));
        assert_eq!(
            semicolons.guessed(),
            [
                "columns are separated by semicolons",
                "decimals follow a comma"
            ]
        );
        // A thousand and more, or one and a half?
        assert_eq!(semicolons.number("2.5"), None);
        assert_eq!(
            dialect("a b", "1 2")
                .cells("  1   2 \n")
                .collect::<Vec<_>>(),
            ["1", "2"]
        );
        assert!(
            dialect("a,b", "").number("NA").unwrap().is_nan()
                && dialect("a,b", "").number("x").is_none()
        );
    }

    #[test]
    fn dates_are_seconds_since_1970() {
        // `date -u -d 2026-01-31T12:30:05.25 +%s.%N`
        assert_eq!(
            clock_time_s("2026-01-31T12:30:05.25Z"),
            Some(1_769_862_605.25)
        );
        assert_eq!(clock_time_s("2000-02-29 00:00:00"), Some(951_782_400.0));
        assert_eq!(clock_time_s("00:01:01.5"), Some(61.5));
        assert!(clock_time_s("yesterday").is_none());
    }
}
