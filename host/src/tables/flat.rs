//! Reads a single series written with several samples per row, sample by sample.

use super::row_reader::{RowReader, Timing};
use super::rows::Rows;
use hal_mock::FileError;
use std::collections::VecDeque;

/// Rows whose columns are consecutive samples, presented as one column.
pub struct FlatRows<'a> {
    rows: Rows<'a>,
    names: Vec<String>,
    /// Values of the current row that have not been returned yet.
    left: VecDeque<f64>,
    next: Option<StampedRow>,
    from_s: Option<f64>,
    spacing_s: f64,
    /// Number of samples of the current row that have been returned.
    of_row: usize,
    value: f64,
    given: u64,
}

struct StampedRow {
    stamp_s: Option<f64>,
    values: Vec<f64>,
}

impl<'a> FlatRows<'a> {
    /// Reads the samples of rows that were opened as flat.
    pub fn new(rows: Rows<'a>) -> Self {
        Self {
            rows,
            names: vec!["value".into()],
            left: VecDeque::new(),
            next: None,
            from_s: None,
            spacing_s: 0.0,
            of_row: 0,
            value: f64::NAN,
            given: 0,
        }
    }

    fn read_row(&mut self) -> Result<Option<StampedRow>, FileError> {
        if !self.rows.advance()? {
            return Ok(None);
        }
        let mut values = Vec::new();
        self.rows.values(&mut values)?;
        while values.last().is_some_and(|value| value.is_nan()) {
            values.pop();
        }
        Ok(Some(StampedRow {
            stamp_s: self.rows.stamp_s(),
            values,
        }))
    }
}

impl RowReader for FlatRows<'_> {
    fn file(&self) -> &str {
        self.rows.file()
    }

    fn names(&self) -> &[String] {
        &self.names
    }

    fn advance(&mut self) -> Result<bool, FileError> {
        while self.left.is_empty() {
            let row = match self.next.take() {
                Some(row) => Some(row),
                None if self.given == 0 => self.read_row()?,
                None => None,
            };
            let Some(row) = row else {
                return Ok(false);
            };
            self.next = self.read_row()?;
            let to_s = self.next.as_ref().and_then(|next| next.stamp_s);
            if let (Some(from_s), Some(to_s)) = (row.stamp_s, to_s) {
                self.spacing_s = (to_s - from_s) / row.values.len().max(1) as f64;
            }
            (self.from_s, self.of_row, self.left) = (row.stamp_s, 0, row.values.into());
        }
        self.value = self.left.pop_front().unwrap_or(f64::NAN);
        self.of_row += 1;
        self.given += 1;
        Ok(true)
    }

    fn time_s(&self) -> Option<f64> {
        let before = self.of_row.saturating_sub(1) as f64;
        let stamped = self.from_s.map(|from_s| from_s + before * self.spacing_s);
        let stated = || Some(self.given.saturating_sub(1) as f64 / self.rows.stated_hz()?);
        stamped.or_else(stated)
    }

    fn timing(&self) -> Timing {
        self.rows.timing()
    }

    fn way_out_of_time(&self) -> &'static str {
        self.rows.way_out_of_time()
    }

    fn refuse(&self, why: &str) -> FileError {
        self.rows.refuse(why)
    }

    fn values(&self, values: &mut Vec<f64>) -> Result<(), FileError> {
        values.clear();
        values.push(self.value);
        Ok(())
    }

    fn is_dated(&self) -> bool {
        self.rows.is_dated()
    }

    fn guessed(&self) -> Option<String> {
        let flat = format!(
            "{} samples a row are read one after the other",
            self.rows.names().len()
        );
        Some(match self.rows.guessed() {
            Some(guessed) => format!("{flat}; {guessed}"),
            None => flat,
        })
    }
}
