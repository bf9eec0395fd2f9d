//! Error for a text that is not a table.

/// Reason why a text is not a table, and the line that shows it.
#[derive(Debug)]
pub struct Refused {
    pub line: Option<u64>,
    pub why: String,
}

impl Refused {
    pub fn new(line: Option<u64>, why: impl Into<String>) -> Self {
        Self {
            line,
            why: why.into(),
        }
    }
}
