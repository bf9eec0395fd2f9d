//! What can be wrong with a trace, each in one line that names the file and, where there is one, the line (from 1).

/// Why a trace could not be read.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs, reason = "the fields are what the messages say")]
pub enum TraceError {
    /// The file could not be read.
    #[error("{file}: {error}")]
    Io { file: String, error: std::io::Error },
    /// Not a byte, or nothing but blank lines.
    #[error("{file}: the file is empty")]
    Empty { file: String },
    /// The first line is all numbers.
    #[error("{file}: line {line}: no header: the first line must name the columns")]
    NoHeader { file: String, line: u64 },
    /// There is a header and nothing else.
    #[error("{file}: line {line}: no data after the header")]
    HeaderOnly { file: String, line: u64 },
    /// No column but the time.
    #[error("{file}: line {line}: no channel: the header has only a time column")]
    NoChannels { file: String, line: u64 },
    /// Two columns are called `time_s`.
    #[error("{file}: line {line}: more than one column is called time_s")]
    TwoTimes { file: String, line: u64 },
    /// A row is longer or shorter than the header.
    #[error("{file}: line {line}: {found} columns, the header has {wanted}")]
    ColumnCount { file: String, line: u64, found: usize, wanted: usize },
    /// A field is no number.
    #[error("{file}: line {line}: column {column}: {text:?} is not a number")]
    NotANumber { file: String, line: u64, column: String, text: String },
    /// A field is NaN or infinite.
    #[error("{file}: line {line}: column {column}: {text:?} is not finite")]
    NotFinite { file: String, line: u64, column: String, text: String },
    /// The time of a row is not later than that of the row before.
    #[error("{file}: line {line}: time_s does not increase: {time_s} after {before_s}")]
    TimeNotIncreasing { file: String, line: u64, time_s: f64, before_s: f64 },
    /// A byte sequence that is not UTF-8.
    #[error("{file}: line {line}: not UTF-8 text")]
    NotUtf8 { file: String, line: u64 },
    /// More columns than the chip has inputs; only when a table becomes a scene.
    #[error("{file}: line 1: {channels} channels, the chip has 16")]
    TooManyChannels { file: String, channels: usize },
    /// The rate of rows is no positive number.
    #[error("{file}: scan rate {scan_rate_hz} Hz: must be greater than 0")]
    ScanRate { file: String, scan_rate_hz: f64 },
}
