//! Rows of a file that must not change while it is read.

use crate::tables::{RowReader, Timing, ValueAt};
use hal_mock::FileError;
use std::fs::Metadata;
use std::io;
use std::path::{Path, PathBuf};
use std::time::SystemTime;

/// State of a file, compared to detect a change.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct State {
    bytes: u64,
    modified: Option<SystemTime>,
}

impl State {
    pub fn of(path: &Path) -> io::Result<Self> {
        let metadata: Metadata = std::fs::metadata(path)?;
        Ok(Self {
            bytes: metadata.len(),
            modified: metadata.modified().ok(),
        })
    }
}

/// Rows of a file that is checked for changes at the end and at every error. If the file has grown
/// or been replaced, this pass may have seen different rows from the pass before.
pub struct UnchangedRows {
    pub rows: Box<dyn RowReader + Send>,
    pub path: PathBuf,
    pub state: State,
}

impl RowReader for UnchangedRows {
    fn advance(&mut self) -> Result<bool, FileError> {
        let has_row = self.rows.advance();
        if let Ok(true) = has_row {
            return Ok(true);
        }
        if State::of(&self.path).ok() == Some(self.state) {
            return has_row;
        }
        let why = "it changed while it was read: wait until nobody writes it, or read a copy";
        Err(FileError::new(self.rows.file(), None, why))
    }

    fn file(&self) -> &str {
        self.rows.file()
    }

    fn names(&self) -> &[String] {
        self.rows.names()
    }

    fn time_s(&self) -> Option<f64> {
        self.rows.time_s()
    }

    fn timing(&self) -> Timing {
        self.rows.timing()
    }

    fn numbers(&self) -> Vec<usize> {
        self.rows.numbers()
    }

    fn units(&self) -> Vec<Option<String>> {
        self.rows.units()
    }

    fn is_dated(&self) -> bool {
        self.rows.is_dated()
    }

    fn way_out_of_time(&self) -> &'static str {
        self.rows.way_out_of_time()
    }

    fn refuse(&self, why: &str) -> FileError {
        self.rows.refuse(why)
    }

    fn values(&self, values: &mut Vec<f64>) -> Result<(), FileError> {
        self.rows.values(values)
    }

    fn in_memory(&self) -> Option<ValueAt> {
        self.rows.in_memory()
    }

    fn guessed(&self) -> Option<String> {
        self.rows.guessed()
    }
}

#[cfg(test)]
mod tests {
    use crate::samples::Samples;
    use std::io::Write;

    #[test]
    fn a_file_that_grows_is_refused_and_one_that_does_not_is_read() {
        let mut file = tempfile::NamedTempFile::new().expect("a file");
        for row in 0..5000 {
            writeln!(file, "{row},{row}").expect("written");
        }
        let samples = Samples::file(file.path()).expect("samples");
        let count = || {
            let mut rows = samples.open()?;
            let mut count = 0;
            while rows.advance()? {
                count += 1;
            }
            anyhow::Ok(count)
        };
        assert_eq!(count().expect("rows"), 5000);
        writeln!(file, "5000,5000").expect("written");
        let error = count().expect_err("refused").to_string();
        assert!(error.contains("changed while it was read"), "{error}");
    }
}
