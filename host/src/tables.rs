//! Tables of samples as text, in the layouts that instruments, loggers and people write: read row by
//! row, in seconds and numbers.

mod cells;
mod clock;
mod clock_time;
mod flat;
mod head_line;
mod header;
mod layout;
mod look;
mod plain;
mod preamble;
mod refused;
mod rounding;
mod row_reader;
mod rows;
mod stamps;
mod table;
mod time_column;
mod units;
mod wrapped;

pub use clock::RowClock;
pub use flat::FlatRows;
pub use rounding::spacing_sigma_s;
pub use row_reader::{OpenRows, PROGRESS_ROWS, RowReader, Timing, ValueAt, check_order};
pub use rows::{Rows, TableForm};
pub use table::Table;
pub use time_column::{TIME_COLUMN, TimeColumn};
pub use units::{bracketed, of_channel};

/// Seconds of a date or a time of day in any of the forms that tables have: since 1970, or midnight.
pub fn seconds_of(text: &str) -> Option<f64> {
    clock_time::ClockTime::parse(text).map(clock_time::ClockTime::seconds)
}

pub use clock_time::date;

#[cfg(test)]
mod tests;
