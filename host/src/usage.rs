//! A command that makes no sense, as opposed to one that fails: the process exits with status 2 instead of 1.

use std::fmt;

/// The command line requests something impossible; the text says why.
#[derive(Debug)]
pub struct UsageError(pub String);

impl fmt::Display for UsageError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for UsageError {}
