//! A CSV table of numbers, read row by row: nothing but the present line is in memory.

use crate::file_error::FileError;
use std::fs::File;
use std::io::{BufRead, BufReader, Read};
use std::path::Path;
use std::sync::Arc;

/// Name of the column that is time in seconds.
pub const TIME_COLUMN: &str = "time_s";

/// Rows that are read between two reports of progress.
pub const PROGRESS_ROWS: u64 = 1 << 14;

/// Bytes of the longest line that is read: a file without lines is no table.
const LINE_MAX: u64 = 1 << 22;

/// Bytes read from a file at once.
const BUFFER: usize = 1 << 17;

/// Rows of samples, one after the other: of a CSV file, of a board's raw frames, of an array.
pub trait RowReader {
    /// The name of what is read, as errors give it.
    fn file(&self) -> &str;

    /// Names of the columns without the time.
    fn names(&self) -> &[String];

    /// Moves to the next row. False at the end; a table without any row is refused.
    fn advance(&mut self) -> Result<bool, FileError>;

    /// Time of the present row in seconds, strictly increasing; none without stamps.
    fn time_s(&self) -> Option<f64>;

    /// Reads the values of the present row, in the order of [`names`](Self::names). NaN stands for a missing reading.
    fn values(&self, values: &mut Vec<f64>) -> Result<(), FileError>;

    /// The value of any row, from 0, and column, where all rows are in memory: a reader need not copy them.
    fn in_memory(&self) -> Option<ValueAt> {
        None
    }
}

/// A value by its row and its column, both from 0.
pub type ValueAt = Arc<dyn Fn(usize, usize) -> f64 + Send + Sync>;

/// Opens rows from the first one on; it is called once for each pass over them.
pub type OpenRows = Arc<dyn Fn() -> Result<Box<dyn RowReader + Send>, FileError> + Send + Sync>;

/// A reader of a header and then one row per scan, with `time_s` in any column. Errors name the file and the line.
///
/// A value is read when it is asked for: rows that are only passed cost little.
#[derive(Debug)]
pub struct Rows<R> {
    file: String,
    names: Vec<String>,
    columns: Vec<String>,
    time_at: Option<usize>,
    input: R,
    /// Number of the latest line, from 1.
    line: u64,
    text: String,
    before_s: Option<f64>,
    has_rows: bool,
}

impl Rows<BufReader<File>> {
    /// Opens a file and reads its header.
    pub fn open(path: impl AsRef<Path>) -> Result<Self, FileError> {
        let file = path.as_ref().display().to_string();
        let input = File::open(path).map_err(|error| FileError::new(&file, None, error))?;
        Self::new(BufReader::with_capacity(BUFFER, input), &file)
    }
}

impl<R: BufRead> Rows<R> {
    /// Reads the header of a table in a file of that name.
    pub fn new(input: R, file: &str) -> Result<Self, FileError> {
        let (names, columns, file) = (Vec::new(), Vec::new(), file.to_owned());
        let (text, before_s, has_rows) = (String::new(), None, false);
        let mut rows = Self { file, names, columns, time_at: None, input, line: 0, text, before_s, has_rows };
        if !rows.next_line()? {
            return Err(FileError::new(&rows.file, None, "the file is empty"));
        }
        let mut reader = csv::ReaderBuilder::new();
        let mut header = csv::StringRecord::new();
        let read =
            reader.has_headers(false).trim(csv::Trim::All).from_reader(rows.text.as_bytes()).read_record(&mut header);
        read.map_err(|error| FileError::new(&rows.file, Some(1), error))?;
        if header.iter().all(|field| field.parse::<f64>().is_ok()) {
            return Err(rows.refuse("no header: the first line must name the columns"));
        }
        rows.columns = header.iter().map(str::to_owned).collect();
        rows.names = header.iter().filter(|name| *name != TIME_COLUMN).map(str::to_owned).collect();
        rows.time_at = header.iter().position(|name| name == TIME_COLUMN);
        match header.len() - rows.names.len() {
            0 | 1 if !rows.names.is_empty() => Ok(rows),
            0 | 1 => Err(rows.refuse("no channel: the header has only a time column")),
            _ => Err(rows.refuse("more than one column is called time_s")),
        }
    }

    fn number(&self, column: &str, text: &str) -> Result<f64, FileError> {
        match text.parse::<f64>() {
            Ok(value) if value.is_infinite() => Err(self.refuse(&format!("column {column}: {text:?} is not finite"))),
            Ok(value) => Ok(value),
            Err(_) if text.is_empty() => Ok(f64::NAN),
            Err(_) => Err(self.refuse(&format!("column {column}: {text:?} is not a number"))),
        }
    }

    /// Reads a line that is not blank. False at the end.
    fn next_line(&mut self) -> Result<bool, FileError> {
        loop {
            let mut bytes = std::mem::take(&mut self.text).into_bytes();
            bytes.clear();
            let read = self.input.by_ref().take(LINE_MAX).read_until(b'\n', &mut bytes);
            if read.map_err(|error| FileError::new(&self.file, None, error))? == 0 {
                return Ok(false);
            }
            self.line += 1;
            if bytes.len() as u64 == LINE_MAX {
                return Err(self.refuse("a line of 4 MB: this is no table"));
            }
            // Spreadsheets put a byte order mark in front.
            if self.line == 1 && bytes.starts_with(b"\xEF\xBB\xBF") {
                bytes.drain(..3);
            }
            self.text = String::from_utf8(bytes).map_err(|_| self.refuse("not UTF-8 text"))?;
            // No number needs its quotes, and only a name may have a comma in them.
            if !self.columns.is_empty() && self.text.contains('"') {
                self.text = self.text.replace('"', "");
            }
            if !self.text.trim().is_empty() {
                return Ok(true);
            }
        }
    }

    fn wrong_count(&self) -> FileError {
        let fields = self.text.split(',').count();
        self.refuse(&format!("{fields} columns, the header has {}", self.columns.len()))
    }

    fn refuse(&self, message: &str) -> FileError {
        FileError::new(&self.file, Some(self.line), message)
    }
}

impl<R: BufRead> RowReader for Rows<R> {
    fn advance(&mut self) -> Result<bool, FileError> {
        if !self.next_line()? {
            return if self.has_rows { Ok(false) } else { Err(self.refuse("no data after the header")) };
        }
        self.has_rows = true;
        if let Some(at) = self.time_at {
            let Some(text) = self.text.split(',').nth(at).map(str::trim) else { return Err(self.wrong_count()) };
            let time_s = self.number(TIME_COLUMN, text)?;
            if time_s.is_nan() {
                return Err(self.refuse(&format!("column {TIME_COLUMN}: {text:?} is no time")));
            }
            if let Some(before_s) = self.before_s.filter(|before_s| time_s <= *before_s) {
                return Err(self.refuse(&format!("time_s does not increase: {time_s} after {before_s}")));
            }
            self.before_s = Some(time_s);
        }
        Ok(true)
    }

    fn time_s(&self) -> Option<f64> {
        self.before_s
    }

    fn values(&self, values: &mut Vec<f64>) -> Result<(), FileError> {
        values.clear();
        let mut fields = 0;
        for (at, text) in self.text.split(',').enumerate() {
            fields += 1;
            if let Some(column) = self.columns.get(at).filter(|_| self.time_at != Some(at)) {
                values.push(self.number(column, text.trim())?);
            }
        }
        if fields == self.columns.len() { Ok(()) } else { Err(self.wrong_count()) }
    }

    fn file(&self) -> &str {
        &self.file
    }

    fn names(&self) -> &[String] {
        &self.names
    }
}
