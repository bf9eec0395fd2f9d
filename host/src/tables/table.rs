//! A whole table in memory.

use super::row_reader::{RowReader, check_order};
use super::rows::Rows;
use hal_mock::FileError;
use std::path::Path;

/// A table with at least one row and one column.
#[derive(Clone, Debug, PartialEq)]
pub struct Table {
    file: String,
    names: Vec<String>,
    rows: Vec<Vec<f64>>,
    time_s: Option<Vec<f64>>,
}

impl Table {
    pub fn load(path: impl AsRef<Path>) -> Result<Self, FileError> {
        Self::read(Rows::open(path)?)
    }

    /// Like [`load`](Self::load), from bytes; errors call the file `file`.
    pub fn parse(bytes: &[u8], file: &str) -> Result<Self, FileError> {
        Self::read(Rows::new(bytes, file)?)
    }

    fn read(mut source: impl RowReader) -> Result<Self, FileError> {
        let (mut rows, mut times) = (Vec::new(), Vec::new());
        while source.advance()? {
            let mut row = Vec::with_capacity(source.names().len());
            source.values(&mut row)?;
            rows.push(row);
            if let (Some(before_s), Some(time_s)) = (times.last(), source.time_s()) {
                check_order(&source, *before_s, time_s)?;
            }
            times.extend(source.time_s());
        }
        let time_s = Some(times).filter(|times| !times.is_empty());
        Ok(Self {
            file: source.file().to_owned(),
            names: source.names().to_vec(),
            rows,
            time_s,
        })
    }

    pub fn file(&self) -> &str {
        &self.file
    }

    /// Names of the columns without the time.
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// The rows, each as long as [`names`](Self::names), in the file's unit. NaN stands for a
    /// missing reading.
    pub fn rows(&self) -> &[Vec<f64>] {
        &self.rows
    }

    /// Times of the rows in seconds as in the file, strictly increasing.
    pub fn time_s(&self) -> Option<&[f64]> {
        self.time_s.as_deref()
    }
}
