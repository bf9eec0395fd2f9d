//! Recorded traces as CSV: read as tables, played as scenes, written from scenes.

mod clock;
mod rows;
mod table;
mod write;

pub use clock::RowClock;
pub use rows::{Rows, TIME_COLUMN};
pub use table::Table;
pub use write::write_csv;

use crate::file_error::FileError;
use crate::scene::{INPUTS, Scene};
use std::path::Path;

/// A table played to the chip: its column k is on AINk, inputs without a column are at 0 V.
///
/// Between rows the voltage is linear, outside of them constant. The last row lasts as long as the one before it.
#[derive(Clone, Debug, PartialEq)]
pub struct Trace {
    table: Table,
    /// Times of the rows, from 0, and the end of the last.
    times_s: Vec<f64>,
    end_s: f64,
    scale: f64,
}

impl Trace {
    /// Reads a trace in volts from a CSV file; without a `time_s` column row k is at k / `scan_rate_hz`.
    pub fn load(path: impl AsRef<Path>, scan_rate_hz: f64) -> Result<Self, FileError> {
        Self::from_table(Table::load(path)?, scan_rate_hz)
    }

    /// Makes a table of at most 16 columns a trace, in volts. The rate must be positive, also where it is not used.
    pub fn from_table(table: Table, scan_rate_hz: f64) -> Result<Self, FileError> {
        let channels = table.names().len();
        if channels > INPUTS {
            return Err(FileError::new(table.file(), Some(1), format!("{channels} channels, the chip has {INPUTS}")));
        }
        if !(scan_rate_hz.is_finite() && scan_rate_hz > 0.0) {
            let message = format!("scan rate {scan_rate_hz} Hz: must be greater than 0");
            return Err(FileError::new(table.file(), None, message));
        }
        let times_s: Vec<f64> = match table.time_s() {
            Some(times) => times.iter().map(|time_s| time_s - times[0]).collect(),
            None => (0..table.rows().len()).map(|row| row as f64 / scan_rate_hz).collect(),
        };
        let last_s = times_s[times_s.len() - 1];
        let lasts_s = times_s.iter().rev().nth(1).map_or(1.0 / scan_rate_hz, |before_s| last_s - before_s);
        Ok(Self { table, times_s, end_s: last_s + lasts_s, scale: 1.0 })
    }

    /// Volts per unit of the table, default 1.
    pub fn with_scale(mut self, volts_per_unit: f64) -> Self {
        self.scale = volts_per_unit;
        self
    }

    /// The table as read.
    pub fn table(&self) -> &Table {
        &self.table
    }

    /// Times of the rows in seconds after the first row.
    pub fn times_s(&self) -> &[f64] {
        &self.times_s
    }
}

impl Scene for Trace {
    fn volts(&mut self, input: u8, t_s: f64) -> f64 {
        let rows = self.table.rows();
        let column = usize::from(input);
        if column >= self.table.names().len() {
            return 0.0;
        }
        // The last row not later than t_s, or the first row.
        let at = self.times_s.partition_point(|row_s| *row_s <= t_s).saturating_sub(1);
        let here = rows[at][column];
        let value = match rows.get(at + 1) {
            Some(next) => {
                let (from_s, to_s) = (self.times_s[at], self.times_s[at + 1]);
                here + (next[column] - here) * ((t_s - from_s) / (to_s - from_s)).clamp(0.0, 1.0)
            }
            None => here,
        };
        self.scale * value
    }

    fn end_s(&self) -> f64 {
        self.end_s
    }
}
