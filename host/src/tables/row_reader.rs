//! Rows of samples, wherever they come from.

use hal_mock::FileError;
use std::sync::Arc;

/// Number of rows read between two reports of progress.
pub const PROGRESS_ROWS: u64 = 1 << 14;

/// Reads rows of samples in order, from a CSV file, raw frames of a board, or an array.
pub trait RowReader {
    /// Returns the name of the source for errors.
    fn file(&self) -> &str;

    /// Names of the columns without the time.
    fn names(&self) -> &[String];

    /// Moves to the next row. Returns false at the end; fails for a table without any row.
    fn advance(&mut self) -> Result<bool, FileError>;

    /// Returns the time stamp of the current row in seconds; `None` without stamps.
    fn time_s(&self) -> Option<f64>;

    /// Returns whether rows have time stamps, or why they have none.
    fn timing(&self) -> Timing {
        Timing::Stamped
    }

    /// Numbers of the columns in the file, from 1, in the order of [`names`](Self::names).
    fn numbers(&self) -> Vec<usize> {
        (1..=self.names().len()).collect()
    }

    /// Returns the units of the columns, in the order of [`names`](Self::names), where declared.
    fn units(&self) -> Vec<Option<String>> {
        vec![None; self.names().len()]
    }

    /// True if stamps of the size of seconds since 1970 are dates.
    fn is_dated(&self) -> bool {
        false
    }

    /// Returns advice in case the time column was guessed wrongly, as the end of a sentence.
    fn way_out_of_time(&self) -> &'static str {
        ""
    }

    /// Returns an error about the current row.
    fn refuse(&self, why: &str) -> FileError {
        FileError::new(self.file(), None, why)
    }

    /// Reads the values of the current row, in the order of [`names`](Self::names). NaN stands for
    /// a missing reading.
    fn values(&self, values: &mut Vec<f64>) -> Result<(), FileError>;

    /// Returns a function for the value at a row, from 0, and column, if all rows are in memory and
    /// so need not be copied.
    fn in_memory(&self) -> Option<ValueAt> {
        None
    }

    /// Returns guesses about the format of the rows, as the beginning of a sentence.
    fn guessed(&self) -> Option<String> {
        None
    }
}

/// Presence of time stamps in the rows.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Timing {
    /// Every row has a stamp.
    Stamped,
    /// No column is the time; the text says what was found and what to type.
    Absent(String),
    /// The unit of the time column is unknown; the text says what to type.
    Unclear(String),
}

/// Minimum backward step of the time at which a new recording begins, seconds.
const RESTART_S: f64 = 1.0;

/// Fails if a stamp is not later than the one before.
pub fn check_order(rows: &dyn RowReader, before_s: f64, time_s: f64) -> Result<(), FileError> {
    if time_s > before_s {
        return Ok(());
    }
    let restart = match before_s - time_s > RESTART_S {
        true => format!(" (two recordings in one file? --to {before_s} fits the first)"),
        false => String::new(),
    };
    Err(rows.refuse(&format!(
        "the time does not increase: {time_s} s after {before_s} s{restart}{}",
        rows.way_out_of_time()
    )))
}

/// Function that returns the value at a row and column, both from 0.
pub type ValueAt = Arc<dyn Fn(usize, usize) -> f64 + Send + Sync>;

/// Function that opens rows from the first one; called once for each pass over them.
pub type OpenRows = Arc<dyn Fn() -> Result<Box<dyn RowReader + Send>, FileError> + Send + Sync>;
