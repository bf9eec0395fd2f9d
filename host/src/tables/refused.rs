//! Why a text is no table.

/// Why a text is no table, and the line that shows it.
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
