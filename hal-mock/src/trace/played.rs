//! The rows of a recording around the present one, numbered without gaps.

use super::clock::RowClock;
use super::row_reader::RowReader;
use crate::file_error::FileError;
use crate::scene::INPUTS;
use std::collections::VecDeque;
use std::sync::{Arc, OnceLock};

/// Longest run of blank cells of a column that is bridged, rows.
const BRIDGE_ROWS: usize = 8;

/// Why the pass that plays a recording ended before the end that the first pass found, if it did.
pub type Failure = Arc<OnceLock<FileError>>;

/// What a row has for a column.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Place {
    /// The row is missing.
    NoRow,
    /// Its cell is blank, and so are many around it.
    Blank,
    Value(f64),
}

#[derive(Clone, Copy, Debug)]
struct Row {
    /// Bridged where they are missing.
    values: [f64; INPUTS],
    /// Bit k: column k is blank.
    blank: u16,
    is_missing: bool,
}

/// Reads on as rows are asked for, and forgets those before them.
pub struct Played {
    rows: Box<dyn RowReader + Send>,
    clock: Option<RowClock>,
    /// Number and values of the row that was read last, which does not follow on the others yet.
    next: Option<(u64, Vec<f64>)>,
    read: u64,
    /// Rows of the first pass.
    rows_before: u64,
    failure: Failure,
    is_over: bool,
    /// Number of the first of `around`.
    first: u64,
    around: VecDeque<Row>,
}

impl Played {
    /// `clock` numbers rows by their stamps; without one they follow on each other. The first pass
    /// has read `rows_before` rows; if this one does not, `failure` says why.
    pub fn new(
        rows: Box<dyn RowReader + Send>,
        clock: Option<RowClock>,
        rows_before: u64,
        failure: Failure,
    ) -> Self {
        Self {
            rows_before,
            failure,
            rows,
            clock,
            next: None,
            read: 0,
            is_over: false,
            first: 0,
            around: VecDeque::new(),
        }
    }

    /// Whether a row is forgotten already.
    pub fn is_past(&self, row: u64) -> bool {
        row < self.first
    }

    /// Makes rows from `from` to `to` available, and those that bridge them; rows before may be
    /// forgotten.
    pub fn read(&mut self, from: u64, to: u64) {
        while !self.is_over && self.first + (self.around.len() as u64) <= to + BRIDGE_ROWS as u64 {
            self.push();
            while self.around.len() > 1 + BRIDGE_ROWS
                && self.first < from.saturating_sub(BRIDGE_ROWS as u64)
            {
                self.around.pop_front();
                self.first += 1;
            }
        }
    }

    pub fn place(&self, row: u64, column: usize) -> Place {
        match self.around.get(row.saturating_sub(self.first) as usize) {
            Some(row) if !row.is_missing && row.blank & 1 << column == 0 => {
                Place::Value(row.values[column])
            }
            Some(row) if !row.is_missing => Place::Blank,
            _ => Place::NoRow,
        }
    }

    /// Numbers and values, bridged where they are missing, of rows from `from` to `to`.
    pub fn values(&self, from: u64, to: u64, column: usize) -> impl Iterator<Item = (u64, f64)> {
        let numbered = (self.first..)
            .zip(&self.around)
            .skip(from.saturating_sub(self.first) as usize);
        numbered
            .take_while(move |(number, _)| *number <= to)
            .map(move |(number, row)| (number, row.values[column]))
    }

    /// Adds the row that follows, which may be a missing one.
    fn push(&mut self) {
        let number = self.first + self.around.len() as u64;
        let Some((at, next)) = self.next.take().or_else(|| self.next_row()) else {
            self.is_over = true;
            return;
        };
        let before = self.around.back().copied();
        let before = before.unwrap_or(Row {
            values: [0.0; INPUTS],
            blank: u16::MAX,
            is_missing: true,
        });
        let mut row = Row {
            blank: 0,
            is_missing: at > number || next.iter().all(|value| value.is_nan()),
            ..before
        };
        for (column, value) in next.iter().enumerate() {
            if value.is_nan() {
                row.blank |= 1 << column;
            } else {
                row.values[column] += (value - row.values[column]) / (1 + at - number) as f64;
                self.bridge(column, before.blank, row.values[column]);
            }
        }
        self.around.push_back(row);
        if at > number {
            self.next = Some((at, next));
        }
    }

    /// Bridges the blank cells of a column, if they are few, up to a value that follows.
    fn bridge(&mut self, column: usize, before: u16, value: f64) {
        let bit = 1 << column;
        if before & bit == 0 {
            return;
        }
        let count = self
            .around
            .iter()
            .rev()
            .take_while(|row| row.blank & bit != 0)
            .count();
        if count > BRIDGE_ROWS {
            return;
        }
        let start = self.around.len() - count;
        let from = start
            .checked_sub(1)
            .map_or(value, |before| self.around[before].values[column]);
        for (step, row) in self.around.range_mut(start..).enumerate() {
            row.values[column] = from + (value - from) * (step + 1) as f64 / (count + 1) as f64;
            row.blank &= !bit;
        }
    }

    /// None at the end, and at an error, which the first pass had not.
    fn next_row(&mut self) -> Option<(u64, Vec<f64>)> {
        let mut values = Vec::with_capacity(INPUTS);
        let read = match self.rows.advance() {
            Ok(true) => self.rows.values(&mut values),
            Ok(false) if self.read >= self.rows_before => return None,
            Ok(false) => Err(self.rows.refuse(&format!(
                "it ended after {} rows, and had {} before",
                self.read, self.rows_before
            ))),
            Err(error) => Err(error),
        };
        if let Err(error) = read {
            // The first error counts.
            let _ = self.failure.set(error);
            return None;
        }
        let number = match (&mut self.clock, self.rows.time_s()) {
            (Some(clock), Some(t_s)) => clock.push(t_s),
            _ => self.read,
        };
        self.read += 1;
        Some((number, values))
    }
}

#[cfg(test)]
mod tests {
    use super::super::rows::Rows;
    use super::*;

    #[test]
    fn only_rows_around_the_present_one_are_kept() {
        // A row of every ten thousand is there, and of the others a few.
        let csv: String = (0..2_000_000u64)
            .filter(|row| row % 10_000 < 3)
            .map(|row| format!("{row},{row}\n"))
            .collect();
        let rows = Rows::new(std::io::Cursor::new(format!("time_s,a\n{csv}")), "t.csv").unwrap();
        let clock = RowClock::new(&[0.0, 1.0, 2.0]);
        let mut played = Played::new(Box::new(rows), clock, 600, Failure::default());
        for row in 16..1_990_000 {
            played.read(row - 16, row + 16);
            assert!(played.around.len() < 64, "{} rows", played.around.len());
            let is_there = row % 10_000 < 3;
            assert_eq!(
                played.place(row, 0),
                if is_there {
                    Place::Value(row as f64)
                } else {
                    Place::NoRow
                }
            );
        }
    }
}
