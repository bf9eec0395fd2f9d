//! Why a file is refused.

use std::fmt;

/// A file that cannot be read or means nothing, in one line that names the file and, where there is one, the line.
#[derive(Debug)]
pub struct FileError {
    file: String,
    /// From 1.
    line: Option<u64>,
    message: String,
}

impl FileError {
    pub(crate) fn new(file: &str, line: Option<u64>, message: impl fmt::Display) -> Self {
        Self { file: file.to_owned(), line, message: message.to_string() }
    }
}

impl fmt::Display for FileError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: ", self.file)?;
        if let Some(line) = self.line {
            write!(f, "line {line}: ")?;
        }
        f.write_str(&self.message)
    }
}

impl std::error::Error for FileError {}
