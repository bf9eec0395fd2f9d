//! Rows of samples, wherever they come from.

use hal_mock::FileError;
use std::sync::Arc;

/// Rows that are read between two reports of progress.
pub const PROGRESS_ROWS: u64 = 1 << 14;

/// Rows of samples, one after the other: of a CSV file, of a board's raw frames, of an array.
pub trait RowReader {
    /// The name of what is read, as errors give it.
    fn file(&self) -> &str;

    /// Names of the columns without the time.
    fn names(&self) -> &[String];

    /// Moves to the next row. False at the end; a table without any row is refused.
    fn advance(&mut self) -> Result<bool, FileError>;

    /// Time of the present row in seconds, as it is stamped; none without stamps.
    fn time_s(&self) -> Option<f64>;

    /// Time stamps of the rows, or why there are none.
    fn timing(&self) -> Timing {
        Timing::Stamped
    }

    /// Numbers of the columns in the file, from 1, in the order of [`names`](Self::names).
    fn numbers(&self) -> Vec<usize> {
        (1..=self.names().len()).collect()
    }

    /// Units of the columns, in the order of [`names`](Self::names), as far as the file says them.
    fn units(&self) -> Vec<Option<String>> {
        vec![None; self.names().len()]
    }

    /// True if stamps of the size of seconds since 1970 are dates.
    fn is_dated(&self) -> bool {
        false
    }

    /// Advice if the time column was guessed wrongly, as the end of a sentence.
    fn way_out_of_time(&self) -> &'static str {
        ""
    }

    /// An error about the present row.
    fn refuse(&self, why: &str) -> FileError {
        FileError::new(self.file(), None, why)
    }

    /// Reads the values of the present row, in the order of [`names`](Self::names). NaN stands for
    /// a missing reading.
    fn values(&self, values: &mut Vec<f64>) -> Result<(), FileError>;

    /// The value of any row, from 0, and column, where all rows are in memory: a reader need not
    /// copy them.
    fn in_memory(&self) -> Option<ValueAt> {
        None
    }

    /// Guesses about the format of the rows, as the beginning of a sentence.
    fn guessed(&self) -> Option<String> {
        None
    }
}

/// Presence of time stamps in the rows.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Timing {
    /// Each has one.
    Stamped,
    /// No column is the time: what there is, and what to type.
    Absent(String),
    /// A column is the time, but nothing says its unit: what to type.
    Unclear(String),
}

/// Seconds by which a time goes back where another recording begins.
const RESTART_S: f64 = 1.0;

/// Refuses a stamp that does not follow on the one before it.
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

/// A value by its row and its column, both from 0.
pub type ValueAt = Arc<dyn Fn(usize, usize) -> f64 + Send + Sync>;

/// Opens rows from the first one on; it is called once for each pass over them.
pub type OpenRows = Arc<dyn Fn() -> Result<Box<dyn RowReader + Send>, FileError> + Send + Sync>;
