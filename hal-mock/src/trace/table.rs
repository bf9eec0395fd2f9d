//! A CSV table of numbers with a header and, perhaps, a time column.

use super::TraceError;
use std::io::Read;
use std::path::Path;

/// Name of the column that is time in seconds.
pub const TIME_COLUMN: &str = "time_s";

/// A table with at least one row and one column. Any number of columns.
#[derive(Clone, Debug, PartialEq)]
pub struct Table {
    file: String,
    names: Vec<String>,
    rows: Vec<Vec<f64>>,
    time_s: Option<Vec<f64>>,
}

impl Table {
    /// Reads a CSV file: a header, then one row per scan; `time_s` may be any of the columns, blank lines are skipped.
    ///
    /// # Errors
    /// Every way a file can be wrong is a [`TraceError`] of its own.
    pub fn load(path: impl AsRef<Path>) -> Result<Self, TraceError> {
        let path = path.as_ref();
        let file = path.display().to_string();
        match std::fs::read(path) {
            Ok(bytes) => Self::parse(&bytes, &file),
            Err(error) => Err(TraceError::Io { file, error }),
        }
    }

    /// As [`load`](Self::load), from a reader; `file` is what errors call it.
    ///
    /// # Errors
    /// As [`load`](Self::load).
    pub fn read(mut reader: impl Read, file: &str) -> Result<Self, TraceError> {
        let mut bytes = Vec::new();
        match reader.read_to_end(&mut bytes) {
            Ok(_) => Self::parse(&bytes, file),
            Err(error) => Err(TraceError::Io { file: file.to_owned(), error }),
        }
    }

    /// The file's name, as errors give it.
    pub fn file(&self) -> &str {
        &self.file
    }

    /// Names of the columns without the time.
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// The rows, each as long as [`names`](Self::names), in the file's unit.
    pub fn rows(&self) -> &[Vec<f64>] {
        &self.rows
    }

    /// Times of the rows in seconds as in the file, strictly increasing.
    pub fn time_s(&self) -> Option<&[f64]> {
        self.time_s.as_deref()
    }

    fn parse(bytes: &[u8], file: &str) -> Result<Self, TraceError> {
        let file = || file.to_owned();
        // Spreadsheets put a byte order mark in front.
        let bytes = bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(bytes);
        if let Err(error) = std::str::from_utf8(bytes) {
            let line = 1 + newlines(&bytes[..error.valid_up_to()]);
            return Err(TraceError::NotUtf8 { file: file(), line });
        }
        let mut reader =
            csv::ReaderBuilder::new().has_headers(false).flexible(true).trim(csv::Trim::All).from_reader(bytes);
        let mut lines = Lines { bytes, counted: 0, line: 1 };
        let mut header: Option<Header> = None;
        let mut table = Self { file: file(), names: Vec::new(), rows: Vec::new(), time_s: None };
        let mut record = csv::StringRecord::new();
        while reader.read_record(&mut record).map_err(|e| TraceError::Io { file: file(), error: e.into() })? {
            let line = lines.of(&record);
            if record.iter().all(str::is_empty) && record.len() == 1 {
                continue; // a line of blanks
            }
            match &header {
                None => {
                    let read = Header::read(&record, line, &table.file)?;
                    table.names = read.channel_names();
                    table.time_s = read.time_at.map(|_| Vec::new());
                    header = Some(read);
                }
                Some(header) => header.read_row(&record, line, &mut table)?,
            }
        }
        match header {
            None => Err(TraceError::Empty { file: file() }),
            Some(header) if table.rows.is_empty() => Err(TraceError::HeaderOnly { file: file(), line: header.line }),
            Some(_) => Ok(table),
        }
    }
}

/// The columns as the file has them.
struct Header {
    line: u64,
    columns: Vec<String>,
    time_at: Option<usize>,
}

impl Header {
    fn read(record: &csv::StringRecord, line: u64, file: &str) -> Result<Self, TraceError> {
        let file = file.to_owned();
        if record.iter().all(|field| field.parse::<f64>().is_ok()) {
            return Err(TraceError::NoHeader { file, line });
        }
        let columns: Vec<String> = record.iter().map(str::to_owned).collect();
        let mut times = (0..columns.len()).filter(|&at| columns[at] == TIME_COLUMN);
        let time_at = times.next();
        if times.next().is_some() {
            return Err(TraceError::TwoTimes { file, line });
        }
        if time_at.is_some() && columns.len() == 1 {
            return Err(TraceError::NoChannels { file, line });
        }
        Ok(Self { line, columns, time_at })
    }

    fn channel_names(&self) -> Vec<String> {
        let channels = self.columns.iter().enumerate().filter(|(at, _)| Some(*at) != self.time_at);
        channels.map(|(_, name)| name.clone()).collect()
    }

    fn read_row(&self, record: &csv::StringRecord, line: u64, table: &mut Table) -> Result<(), TraceError> {
        let file = || table.file.clone();
        if record.len() != self.columns.len() {
            let (found, wanted) = (record.len(), self.columns.len());
            return Err(TraceError::ColumnCount { file: file(), line, found, wanted });
        }
        let mut row = Vec::with_capacity(record.len());
        let mut time_s = None;
        for (at, text) in record.iter().enumerate() {
            let (column, text_owned) = (|| self.columns[at].clone(), || text.to_owned());
            let Ok(value) = text.parse::<f64>() else {
                return Err(TraceError::NotANumber { file: file(), line, column: column(), text: text_owned() });
            };
            if !value.is_finite() {
                return Err(TraceError::NotFinite { file: file(), line, column: column(), text: text_owned() });
            }
            if Some(at) == self.time_at {
                time_s = Some(value);
            } else {
                row.push(value);
            }
        }
        if let (Some(time_s), Some(times)) = (time_s, &mut table.time_s) {
            if let Some(&before_s) = times.last().filter(|&&before_s| time_s <= before_s) {
                return Err(TraceError::TimeNotIncreasing { file: table.file.clone(), line, time_s, before_s });
            }
            times.push(time_s);
        }
        table.rows.push(row);
        Ok(())
    }
}

/// Line numbers of records. The reader's own count is of where it stopped after the record before, which blank lines
/// and CR LF put in front of the record's own line.
struct Lines<'a> {
    bytes: &'a [u8],
    counted: usize,
    line: u64,
}

impl Lines<'_> {
    fn of(&mut self, record: &csv::StringRecord) -> u64 {
        let from = record.position().map_or(0, |position| position.byte() as usize);
        let blanks = self.bytes[from..].iter().take_while(|byte| matches!(byte, b'\r' | b'\n')).count();
        self.line += newlines(&self.bytes[self.counted..from + blanks]);
        self.counted = from + blanks;
        self.line
    }
}

fn newlines(bytes: &[u8]) -> u64 {
    bytes.iter().filter(|&&byte| byte == b'\n').count() as u64
}
