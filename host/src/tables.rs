//! Reads tables of samples as text, row by row, in the layouts that instruments, loggers and people
//! write.

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
pub use rounding::{Spacing, spacing};
pub use row_reader::{OpenRows, PROGRESS_ROWS, RowReader, Timing, ValueAt, check_order};
pub use rows::{Rows, TableForm};
pub use table::Table;
pub use time_column::{SplitTime, TIME_COLUMN, TimeColumn, listed};
pub use units::{bracketed, of_channel, per_second};

/// Parses a date or time of day in any form found in tables. Returns seconds since 1970 or
/// midnight.
pub fn seconds_of(text: &str) -> Option<f64> {
    clock_time::ClockTime::parse(text).map(clock_time::ClockTime::seconds)
}

pub use clock_time::date;

/// True if a column's name is that of a time.
pub fn is_time(name: &str) -> bool {
    time_column::named(name, false).is_some()
}

/// Returns the unit declared by the name of a time column, in seconds; `None` if there is none. The
/// error is an unknown unit.
pub fn declared_seconds(name: &str) -> Result<Option<f64>, String> {
    let known = time_column::named(name, false).map(|named| named.unit);
    match known.unwrap_or_else(|| units::declared_time(name)) {
        units::Declared::PerSecond(per_second) => Ok(Some(per_second.recip())),
        units::Declared::Unknown(unit) => Err(unit),
        units::Declared::Nothing => Ok(None),
    }
}

#[cfg(test)]
mod tests;
