//! Parses the cells of a table.

use super::clock_time::ClockTime;
use core::cell::Cell;

/// Lower-case words for a missing reading. Blank cells and values that are not finite are also
/// missing readings.
const MISSING: [&str; 17] = [
    "-", "--", "---", "na", "n/a", "#n/a", "null", "none", "nil", "err", "error", "#error", "inf",
    "overflow", "ovl", "ol", "?",
];

/// Separators of groups of three digits, other than a comma.
const GROUP_MARKS: [char; 5] = [' ', '\u{A0}', '\u{202F}', '\'', '\u{2019}'];

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    Number,
    Missing,
    /// A date with a time of day, or a time of day.
    Clock,
    Text,
}

/// Reads the numbers of a table, of which either all or none have decimals after a comma.
#[derive(Clone, Debug, Default)]
pub struct Numbers {
    /// True if commas separate columns, so that an unquoted cell has no comma.
    pub is_comma_separator: bool,
    /// Decimal separator found so far.
    decimals: Cell<Option<u8>>,
}

impl Numbers {
    pub fn new(is_comma_separator: bool) -> Self {
        Self {
            is_comma_separator,
            decimals: Cell::new(None),
        }
    }

    /// Parses the number in a cell: NaN if the reading is missing, `None` if it is not a number.
    #[inline]
    pub fn number(&self, cell: &str) -> Option<f64> {
        let value = match cell.parse::<f64>() {
            Ok(value) => {
                if value.is_finite() && !self.is_comma_separator && cell.contains('.') {
                    self.note(b'.')?;
                }
                value
            }
            Err(_) => self.unusual(cell)?,
        };
        Some(if value.is_finite() { value } else { f64::NAN })
    }

    fn unusual(&self, cell: &str) -> Option<f64> {
        if is_missing(cell) {
            return Some(f64::NAN);
        }
        if let Some(plain) = plain(cell) {
            return self.number(&plain);
        }
        if let Some(value) = hexadecimal(cell).or_else(|| fortran(cell)) {
            return Some(value);
        }
        if !cell.contains(',') {
            return None;
        }
        if let Some((whole, decimals)) = cell.split_once(',')
            && whole.contains('.')
            && is_grouped(whole, '.')
            && !self.is_comma_separator
        {
            let value = format!("{}.{decimals}", whole.replace('.', "")).parse();
            return value.ok().filter(|_| self.note(b',').is_some());
        }
        let has_point = cell.contains('.');
        if let Some(value) = without_thousands(cell)
            && (has_point || self.is_comma_separator && self.decimals.get() != Some(b','))
        {
            return self.note(b'.').map(|()| value);
        }
        // `1,5` is a decimal, but not in a table with `1.5`, where the comma may separate
        // thousands.
        let value = cell.replacen(',', ".", 1).parse().ok();
        value.filter(|_| !has_point && self.note(b',').is_some())
    }

    fn note(&self, decimals: u8) -> Option<()> {
        let known = self.decimals.get().unwrap_or(decimals);
        self.decimals.set(Some(known));
        (known == decimals).then_some(())
    }

    pub fn has_decimal_commas(&self) -> bool {
        self.decimals.get() == Some(b',')
    }
}

/// Parses a number of Fortran, such as `1.5D+02`.
fn fortran(cell: &str) -> Option<f64> {
    let at = cell.find(['D', 'd'])?;
    let value: f64 = cell.replacen(['D', 'd'], "e", 1).parse().ok()?;
    cell[..at].contains('.').then_some(value)
}

/// Parses a number such as `0x0A3F`.
fn hexadecimal(cell: &str) -> Option<f64> {
    let digits = cell.strip_prefix("0x").or(cell.strip_prefix("0X"))?;
    let value = u64::from_str_radix(digits, 16).ok()?;
    Some(value as f64)
}

/// Replaces a Unicode minus by a hyphen, or removes separators between thousands.
fn plain(cell: &str) -> Option<String> {
    if let Some(size) = cell.strip_prefix('\u{2212}') {
        return Some(format!("-{size}"));
    }
    let end = cell.find(['.', ',']).unwrap_or(cell.len());
    let mark = cell[..end].chars().find(|c| GROUP_MARKS.contains(c))?;
    is_grouped(&cell[..end], mark).then(|| cell.replace(mark, ""))
}

/// Parses numbers with groups of three digits, such as `10,273.937` and `1,234,567`.
fn without_thousands(cell: &str) -> Option<f64> {
    let (whole, decimals) = cell.split_once('.').unwrap_or((cell, ""));
    (is_grouped(whole, ',') && !decimals.contains(','))
        .then(|| cell.replace(',', "").parse().ok())?
}

/// True if a whole number has groups of three digits.
fn is_grouped(whole: &str, mark: char) -> bool {
    let mut groups = whole.trim_start_matches(['+', '-']).split(mark);
    let is_digits = |group: &str| group.bytes().all(|byte| byte.is_ascii_digit());
    let first = groups.next().unwrap_or_default();
    let is_first = (1..=3).contains(&first.len()) && first != "0" && is_digits(first);
    is_first && groups.all(|group| group.len() == 3 && is_digits(group))
}

/// True if a cell stands for a missing reading.
fn is_missing(cell: &str) -> bool {
    cell.is_empty() || MISSING.iter().any(|mark| mark.eq_ignore_ascii_case(cell))
}

pub fn kind(cell: &str, is_comma_separator: bool) -> Kind {
    match Numbers::new(is_comma_separator).number(cell) {
        Some(value) if value.is_nan() => Kind::Missing,
        Some(_) => Kind::Number,
        None if ClockTime::parse(cell).is_some() => Kind::Clock,
        None => Kind::Text,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_points_or_commas_and_thousands() {
        let commas = || Numbers::new(true);
        let others = || Numbers::new(false);
        for (numbers, cell, value) in [
            (commas(), "1.5", Some(1.5)),
            (commas(), "10,273.937", Some(10_273.937)),
            (commas(), "-1,234,567", Some(-1_234_567.0)),
            (commas(), "1,5", Some(1.5)),
            (others(), "1,5", Some(1.5)),
            (others(), "10,273.9", Some(10_273.9)),
            (others(), "0,125", Some(0.125)),
            (commas(), "\u{2212}1.5", Some(-1.5)),
            (others(), "10 273,9", Some(10_273.9)),
            (others(), "-1'234'567.5", Some(-1_234_567.5)),
            (others(), "\u{2212}10\u{A0}273", Some(-10_273.0)),
            (others(), "10 27", None),
            (others(), "-1.234.567,5", Some(-1_234_567.5)),
            (commas(), "-1.5D+02", Some(-150.0)),
            (commas(), "5D", None),
            (commas(), "12d3", None),
            (commas(), "\u{2212}\u{2212}1", None),
            (commas(), "1,2,3", None),
            (commas(), "two", None),
            (commas(), "0x0A3F", Some(2623.0)),
            (commas(), "0xyz", None),
        ] {
            assert_eq!(numbers.number(cell), value, "{cell}");
        }
        // `1,5` could be a decimal, or a number with a thousands separator.
        let numbers = others();
        assert_eq!(
            (numbers.number("1,5"), numbers.number("2.5")),
            (Some(1.5), None)
        );
    }

    #[test]
    fn missing_readings_have_many_names() {
        for cell in [
            "", "-", "NA", "n/a", "NaN", "-inf", "1e999", "-1,5e999", "ERR", "--", "null",
        ] {
            assert_eq!(kind(cell, true), Kind::Missing, "{cell}");
        }
        for (cell, expected) in [
            ("1e-3", Kind::Number),
            ("2024-01-05 07:53:54.000", Kind::Clock),
            ("imu_link", Kind::Text),
        ] {
            assert_eq!(kind(cell, true), expected, "{cell}");
        }
    }
}
