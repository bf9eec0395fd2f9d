//! Errors of files.

use crate::printable;
use std::fmt::{self, Display, Formatter};

/// A file that cannot be read or is invalid. The message is one line with the file's name and, if
/// known, the line number.
#[derive(Debug)]
pub struct FileError {
    file: String,
    /// Line number, from 1.
    line: Option<u64>,
    message: String,
}

impl FileError {
    /// Creates an error in the named file, at a line counted from 1.
    pub fn new(file: &str, line: Option<u64>, message: impl Display) -> Self {
        Self {
            file: file.to_owned(),
            line,
            message: message.to_string(),
        }
    }

    /// The error without the file's name.
    pub fn place_and_reason(&self) -> String {
        let line = self
            .line
            .map_or_else(String::new, |line| format!("line {line}: "));
        format!("{line}{}", self.message)
    }
}

impl Display for FileError {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let line = format!("{}: {}", self.file, self.place_and_reason());
        f.write_str(&printable(&line))
    }
}

impl std::error::Error for FileError {}
