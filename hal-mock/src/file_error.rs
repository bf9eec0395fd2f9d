//! Why a file is refused.

use crate::printable;
use std::fmt::{self, Display, Formatter};

/// A file that cannot be read or means nothing, in one line that names the file and, where there is
/// one, the line.
#[derive(Debug)]
pub struct FileError {
    file: String,
    /// From 1.
    line: Option<u64>,
    message: String,
}

impl FileError {
    /// An error in a file of that name, at a line counted from 1.
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
