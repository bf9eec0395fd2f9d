//! Classifies a column by its first rows: time, row counter, or neither.

use super::cells::{Kind, Numbers};
use super::clock_time::ClockTime;
use super::head_line::HeadLine;
use super::stamps::{Stamps, TICKS_PER_SECOND, Unit, are_ticks};

/// Range of plausible times, seconds since 1970: the years 2000 to 2100.
const EPOCH_S: core::ops::Range<f64> = 946_684_800.0..4_102_444_800.0;

/// Properties of a column in the first rows.
pub struct Look {
    pub is_clock: bool,
    pub is_whole: bool,
    pub first: f64,
    pub last: f64,
    pub min: f64,
    pub max: f64,
    /// Median step.
    pub step: f64,
    pub rows: usize,
    /// Fraction of the rows in which the column grows, and true if it grows steadily.
    pub grows: f64,
    pub is_steady: bool,
    pub never_falls: bool,
    /// True if the times run backwards.
    pub falls: bool,
    /// True if all numbers are times of day without colons, such as `102030.25`.
    pub is_hhmmss: bool,
}

impl Look {
    pub fn new(rows: &[&HeadLine], at: usize) -> Self {
        let numbers = Numbers::default();
        // The kind of a date without separators is a number, so try to parse it.
        let is_time = |row: &&&HeadLine| {
            row.kinds[at] == Kind::Clock || ClockTime::parse(&row.cells[at]).is_some()
        };
        let is_clock = rows.iter().filter(is_time).count() * 2 > rows.len();
        let mut stamps = Stamps::new(if is_clock {
            Unit::Clock
        } else {
            Unit::PerSecond(1.0)
        });
        let cells = || rows.iter().map(|row| row.cells[at].as_str());
        let read: Vec<f64> = cells()
            .filter_map(|cell| stamps.seconds(cell, &numbers))
            .collect();
        let steps: Vec<f64> = read.windows(2).map(|pair| pair[1] - pair[0]).collect();
        let grown = steps.iter().filter(|step| **step > 0.0).count();
        let mut sorted = steps.clone();
        sorted.sort_by(f64::total_cmp);
        let (small, step, large) = match sorted[..] {
            [] => (0.0, 0.0, 0.0),
            _ => {
                let at = |tenth: usize| sorted[sorted.len() * tenth / 10];
                (at(1), at(5), at(9))
            }
        };
        Self {
            is_clock,
            is_whole: read.iter().all(|value| value.fract() == 0.0),
            first: read.first().copied().unwrap_or(f64::NAN),
            last: read.last().copied().unwrap_or(f64::NAN),
            min: read.iter().copied().fold(f64::INFINITY, f64::min),
            max: read.iter().copied().fold(f64::NEG_INFINITY, f64::max),
            step,
            falls: steps.len() > 3 && steps.iter().all(|step| *step < 0.0),
            rows: read.len(),
            grows: grown as f64 / steps.len().max(1) as f64,
            is_hhmmss: rows.len() > 2 && cells().all(is_hhmmss),
            never_falls: steps.iter().all(|step| *step >= 0.0),
            is_steady: small > 0.0 && large < 3.0 * small,
        }
    }

    /// True if the column may be a time: it grows, runs backwards, or has too few rows to tell.
    pub fn is_time(&self) -> bool {
        self.rows > 0 && (self.grows > 0.0 || self.falls || self.rows < 3)
    }

    pub fn counts_rows(&self) -> bool {
        self.is_whole && self.is_steady && self.step == 1.0
    }

    /// True if the column may count days since 1900, as spreadsheets do, or since the year 0, as
    /// MATLAB does. Read as seconds, it would have an implausibly high rate.
    pub fn may_be_days(&self) -> bool {
        let is_date = (20_000.0..80_000.0).contains(&self.first)
            || (700_000.0..780_000.0).contains(&self.first);
        is_date && !self.is_whole && self.step > 0.0 && self.step < 1e-3
    }

    /// Returns the units per second of a number that counts from 1970.
    pub fn epoch(&self) -> Option<f64> {
        let is_now = |per_second: &f64| EPOCH_S.contains(&(self.first / per_second));
        // Seconds are not tried: they may be microseconds since a board's start.
        let ticks = || are_ticks(self.first).then_some(TICKS_PER_SECOND);
        [1e3, 1e6, 1e9].into_iter().find(is_now).or_else(ticks)
    }

    /// True if the column may have the whole seconds of a clock.
    pub fn may_be_seconds(&self) -> bool {
        let is_dated = EPOCH_S.contains(&self.first);
        self.is_whole && !self.is_clock && self.never_falls && (self.grows > 0.0 || is_dated)
    }
}

/// True for a number such as `102030.25` that may be a time of day, as GPS receivers write it.
fn is_hhmmss(cell: &str) -> bool {
    let (digits, _) = cell.split_once(['.', ',']).unwrap_or((cell, ""));
    let below = |from: usize, limit: u32| {
        let part = digits.get(from..from + 2);
        part.is_some_and(|part| part.parse::<u32>().is_ok_and(|part| part < limit))
    };
    digits.len() == 6 && below(0, 24) && below(2, 60) && below(4, 60)
}

/// Words in the names of columns that count rows.
const COUNTERS: [&str; 12] = [
    "index", "seq", "sequence", "sample", "samples", "row", "number", "packet", "frame", "count",
    "counter", "subframe",
];

/// Words for numbers that may repeat in several rows, such as that of a frame with several samples.
const REPEATED: [&str; 5] = ["frame", "subframe", "index", "packet", "row"];

/// True if name and values show that a column numbers the rows; the numbers may restart.
pub fn is_counter(name: &str, rows: &[&HeadLine], at: usize) -> bool {
    let number = |row: &HeadLine| row.cells[at].parse::<f64>().ok();
    let name = name.to_lowercase();
    let mut words = name.split(|c: char| !c.is_alphanumeric());
    let is_word = |known: &[&str], word: &str| {
        known
            .iter()
            .any(|known| word == *known || known.len() > 4 && word.ends_with(known))
    };
    let is_named = name.is_empty() || words.clone().any(|word| is_word(&COUNTERS, word));
    let may_repeat = words.any(|word| is_word(&REPEATED, word));
    let begin = rows.first().and_then(|row| number(row));
    let counts_on = |pair: &&[&HeadLine]| match (number(pair[0]), number(pair[1])) {
        (Some(before), Some(value)) => {
            let is_repeated = value == before || value < before && Some(value) <= begin;
            value - before == 1.0 || may_repeat && is_repeated
        }
        _ => false,
    };
    let counted = rows.windows(2).filter(counts_on).count();
    is_named && rows.len() > 1 && counted as f64 >= 0.95 * (rows.len() - 1) as f64
}

/// Finds the columns that grow steadily.
pub fn growing(looks: &[Look]) -> impl Iterator<Item = usize> {
    (0..looks.len()).filter(|at| {
        let look = &looks[*at];
        look.is_steady && look.grows > 0.98 && look.rows > 4
    })
}
