//! A CSV table of numbers with a header and, perhaps, a time column.

use crate::file_error::FileError;
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
    /// Reads a CSV file: a header, then one row per scan, `time_s` in any column. Errors name the file and the line.
    pub fn load(path: impl AsRef<Path>) -> Result<Self, FileError> {
        let file = path.as_ref().display().to_string();
        let bytes = std::fs::read(path).map_err(|error| FileError::new(&file, None, error))?;
        Self::parse(&bytes, &file)
    }

    /// As [`load`](Self::load), from the bytes of a file of that name.
    pub fn parse(bytes: &[u8], file: &str) -> Result<Self, FileError> {
        let refuse = |line: u64, message: String| Err(FileError::new(file, Some(line), message));
        let records = records(bytes, file)?;
        let Some(((header_line, header), rows)) = records.split_first() else {
            return Err(FileError::new(file, None, "the file is empty"));
        };
        if header.iter().all(|field| field.parse::<f64>().is_ok()) {
            return refuse(*header_line, "no header: the first line must name the columns".into());
        }
        let times: Vec<usize> = (0..header.len()).filter(|&at| &header[at] == TIME_COLUMN).collect();
        let time_at = times.first().copied();
        if times.len() > 1 {
            return refuse(*header_line, "more than one column is called time_s".into());
        }
        if times.len() == header.len() {
            return refuse(*header_line, "no channel: the header has only a time column".into());
        }
        if rows.is_empty() {
            return refuse(*header_line, "no data after the header".into());
        }
        let names = header.iter().filter(|name| *name != TIME_COLUMN).map(str::to_owned).collect();
        let (file, time_s) = (file.to_owned(), time_at.map(|_| vec![]));
        let mut table = Self { file, names, rows: Vec::with_capacity(rows.len()), time_s };
        for (line, record) in rows {
            if record.len() != header.len() {
                return refuse(*line, format!("{} columns, the header has {}", record.len(), header.len()));
            }
            let mut row = Vec::with_capacity(record.len());
            for (column, text) in header.iter().zip(record) {
                match text.parse::<f64>() {
                    Ok(value) if value.is_finite() => row.push(value),
                    Ok(_) => return refuse(*line, format!("column {column}: {text:?} is not finite")),
                    Err(_) => return refuse(*line, format!("column {column}: {text:?} is not a number")),
                }
            }
            if let (Some(at), Some(times)) = (time_at, &mut table.time_s) {
                let time_s = row.remove(at);
                if let Some(before_s) = times.last().filter(|before_s| time_s <= **before_s) {
                    return refuse(*line, format!("time_s does not increase: {time_s} after {before_s}"));
                }
                times.push(time_s);
            }
            table.rows.push(row);
        }
        Ok(table)
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
}

/// The records that are not blank, with their line numbers.
fn records(bytes: &[u8], file: &str) -> Result<Vec<(u64, csv::StringRecord)>, FileError> {
    // Spreadsheets put a byte order mark in front.
    let bytes = bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(bytes);
    if let Err(error) = std::str::from_utf8(bytes) {
        let line = 1 + newlines(&bytes[..error.valid_up_to()]);
        return Err(FileError::new(file, Some(line), "not UTF-8 text"));
    }
    let reader = csv::ReaderBuilder::new().has_headers(false).flexible(true).trim(csv::Trim::All).from_reader(bytes);
    let (mut records, mut line, mut counted) = (Vec::new(), 1, 0);
    for record in reader.into_records() {
        let record = record.map_err(|error| FileError::new(file, None, error))?;
        // The reader's own count does not include blank lines and CR LF in front of the record's own line.
        let from = record.position().map_or(0, |position| position.byte() as usize);
        let blanks = bytes[from..].iter().take_while(|byte| matches!(byte, b'\r' | b'\n')).count();
        line += newlines(&bytes[counted..from + blanks]);
        counted = from + blanks;
        if record.len() > 1 || record.iter().any(|field| !field.is_empty()) {
            records.push((line, record));
        }
    }
    Ok(records)
}

fn newlines(bytes: &[u8]) -> u64 {
    bytes.iter().filter(|&&byte| byte == b'\n').count() as u64
}
