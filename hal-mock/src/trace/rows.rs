//! A CSV table of numbers, read row by row: nothing but the present line is in memory.

use super::dialect::{Dialect, TIME_COLUMN, TimeColumn, clock_time_s, time_column};
use super::row_reader::RowReader;
use crate::file_error::FileError;
use std::fs::File;
use std::io::{BufRead, BufReader, Read};
use std::path::Path;

/// Bytes of the longest line that is read: a file without lines is no table.
const LINE_MAX: u64 = 1 << 22;

/// Bytes read from a file at once.
const BUFFER: usize = 1 << 17;

/// A reader of a header and then one row per scan, with the time in any column. Errors name the
/// file and the line.
///
/// Columns are separated by commas, semicolons, tabs or white space; where it is not commas,
/// decimals may follow a comma. The time is `time_s`, or a column whose name says so: `t`,
/// `time_ms`, `Time [us]`. The header may be a comment.
///
/// A value is read when it is asked for: rows that are only passed cost little.
pub struct Rows<'a> {
    file: String,
    names: Vec<String>,
    columns: Vec<String>,
    dialect: Dialect,
    time_at: Option<usize>,
    /// Units of the time in a second; none if nothing says it.
    per_second: Option<f64>,
    /// Of one type, so that the reader is compiled here, with this crate's optimization.
    input: Box<dyn BufRead + Send + 'a>,
    /// Number of the present line, from 1.
    line: u64,
    text: String,
    /// The line after the header and its number, as long as it is not the present one.
    peeked: Option<(u64, String)>,
    before_s: Option<f64>,
    has_rows: bool,
}

impl<'a> Rows<'a> {
    /// Opens a file and reads its header.
    pub fn open(path: impl AsRef<Path>) -> Result<Self, FileError> {
        Self::open_with(path, None)
    }

    /// The same where somebody says which column is the time.
    pub fn open_with(path: impl AsRef<Path>, time: Option<&TimeColumn>) -> Result<Self, FileError> {
        let file = path.as_ref().display().to_string();
        let input = File::open(path).map_err(|error| FileError::new(&file, None, error))?;
        Self::with(BufReader::with_capacity(BUFFER, input), &file, time)
    }

    /// Reads the header of a table in a file of that name.
    pub fn new(input: impl BufRead + Send + 'a, file: &str) -> Result<Self, FileError> {
        Self::with(input, file, None)
    }

    /// The same where somebody says which column is the time.
    pub fn with(
        input: impl BufRead + Send + 'a,
        file: &str,
        time: Option<&TimeColumn>,
    ) -> Result<Self, FileError> {
        Self::boxed(Box::new(input), file, time)
    }

    fn boxed(
        input: Box<dyn BufRead + Send + 'a>,
        file: &str,
        time: Option<&TimeColumn>,
    ) -> Result<Self, FileError> {
        let mut rows = Self {
            file: file.to_owned(),
            names: Vec::new(),
            columns: Vec::new(),
            dialect: Dialect::of("", None),
            time_at: None,
            per_second: None,
            input,
            line: 0,
            text: String::new(),
            peeked: None,
            before_s: None,
            has_rows: false,
        };
        if !rows.next_line()? {
            return Err(FileError::new(&rows.file, None, "the file is empty"));
        }
        // Spreadsheets say so in front of the header.
        let separator = rows
            .text
            .trim()
            .strip_prefix("sep=")
            .and_then(|separator| separator.chars().next());
        if separator.is_some() && !rows.next_line()? {
            return Err(rows.refuse("no data after its first line"));
        }
        let (line, header) = rows.header()?;
        let peeked = rows.peeked.as_ref().map(|(_, text)| text.as_str());
        rows.dialect = Dialect::of(&header, peeked);
        rows.dialect.separator = separator.unwrap_or(rows.dialect.separator);
        rows.columns = match rows.dialect.separator {
            ' ' => header.split_whitespace().map(str::to_owned).collect(),
            separator => {
                let mut reader = csv::ReaderBuilder::new();
                let mut record = csv::StringRecord::new();
                reader
                    .has_headers(false)
                    .trim(csv::Trim::All)
                    .delimiter(separator as u8);
                let read = reader
                    .from_reader(header.as_bytes())
                    .read_record(&mut record);
                read.map_err(|error| FileError::new(&rows.file, Some(line), error))?;
                record.iter().map(str::to_owned).collect()
            }
        };
        if rows.dialect.is_trailing {
            rows.columns.pop();
        }
        let refuse = |why: &str| FileError::new(&rows.file, Some(line), why);
        if rows.columns.iter().all(|name| {
            rows.dialect
                .number(name)
                .is_some_and(|value| !value.is_nan())
        }) {
            return Err(refuse("no header: the first line must name the columns"));
        }
        let time = time_column(&rows.columns, time).map_err(|why| refuse(&why))?;
        if time.is_some() && rows.columns.len() == 1 {
            return Err(refuse("no channel: the header has only a time column"));
        }
        let named = |(at, _): &(usize, &String)| Some(*at) != time.map(|(at, _)| at);
        rows.names = rows
            .columns
            .iter()
            .enumerate()
            .filter(named)
            .map(|(_, name)| name.clone())
            .collect();
        (rows.time_at, rows.per_second) = (time.map(|(at, _)| at), time.and_then(|(_, unit)| unit));
        Ok(rows)
    }

    /// The header's line and its number. It may be the last of some comments; then the first row is
    /// read already.
    fn header(&mut self) -> Result<(u64, String), FileError> {
        let mut comment = None;
        while self.text.trim_start().starts_with('#') {
            comment = Some((
                self.line,
                self.text
                    .trim_start()
                    .trim_start_matches(['#', ' '])
                    .to_owned(),
            ));
            if !self.next_line()? {
                return comment.ok_or_else(|| self.refuse("no header"));
            }
        }
        let (line, text) = (self.line, std::mem::take(&mut self.text));
        if let Some((at, comment)) = comment {
            let dialect = Dialect::of(&comment, Some(&text));
            if dialect
                .cells(&text)
                .all(|cell| dialect.number(cell).is_some() || clock_time_s(cell).is_some())
            {
                self.peeked = Some((line, text));
                return Ok((at, comment));
            }
        }
        if self.next_line()? {
            self.peeked = Some((self.line, std::mem::take(&mut self.text)));
        }
        Ok((line, text))
    }

    fn number(&self, column: &str, text: &str) -> Result<f64, FileError> {
        match self.dialect.number(text) {
            Some(value) if value.is_infinite() => {
                Err(self.refuse(&format!("column {column}: {text:?} is not finite")))
            }
            Some(value) => Ok(value),
            None if self.dialect.separator != ',' && text.contains([',', '.']) => {
                let why = "is not a number beside the others: decimals follow either points or commas, and nothing else has any";
                Err(self.refuse(&format!("column {column}: {text:?} {why}")))
            }
            None => Err(self.refuse(&format!("column {column}: {text:?} is not a number"))),
        }
    }

    /// The present row's time, seconds.
    fn stamp_s(&self, at: usize) -> Result<f64, FileError> {
        let name = &self.columns[at];
        let Some(text) = self.dialect.cells(&self.text).nth(at) else {
            return Err(self.wrong_count());
        };
        let time_s = match Some(text)
            .filter(|text| text.contains(':'))
            .and_then(clock_time_s)
        {
            Some(time_s) => time_s,
            None => self.number(name, text)? / self.per_second.unwrap_or(1.0),
        };
        if time_s.is_nan() {
            return Err(self.refuse(&format!("column {name}: {text:?} is no time")));
        }
        let Some(before_s) = self.before_s else {
            return Ok(time_s);
        };
        let shown = if name == TIME_COLUMN {
            TIME_COLUMN.to_owned()
        } else {
            format!("column {name}")
        };
        if time_s <= before_s {
            let way_out = if name == TIME_COLUMN {
                ""
            } else {
                "; if it is no time, say --time-column none"
            };
            return Err(self.refuse(&format!(
                "{shown} does not increase: {time_s} after {before_s}{way_out}"
            )));
        }
        let is_whole = time_s.fract() == 0.0 && before_s.fract() == 0.0;
        if self.per_second.is_none() && is_whole && !text.contains(':') {
            let why = "whole numbers without a unit: say which with --time-column";
            return Err(self.refuse(&format!(
                "{shown}: {why} {name}:ms (or s, us, ns), or --time-column none"
            )));
        }
        Ok(time_s)
    }

    /// Reads a line that is not blank. False at the end.
    fn next_line(&mut self) -> Result<bool, FileError> {
        if let Some((line, text)) = self.peeked.take() {
            // It was read before the columns were known.
            (self.line, self.text) = (line, text.replace('"', ""));
            return Ok(true);
        }
        loop {
            let mut bytes = std::mem::take(&mut self.text).into_bytes();
            bytes.clear();
            let read = self
                .input
                .by_ref()
                .take(LINE_MAX)
                .read_until(b'\n', &mut bytes);
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
            self.text = String::from_utf8(bytes)
                .map_err(|_| self.refuse("not UTF-8 text: save it as such"))?;
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
        let (cells, columns) = (self.dialect.cells(&self.text).count(), self.columns.len());
        let is_comma = self.dialect.separator == ',' && cells == 2 * columns;
        let way_out = if is_comma {
            "; if commas are decimals, separate columns by semicolons"
        } else {
            ""
        };
        self.refuse(&format!(
            "{cells} columns, the header has {columns}{way_out}"
        ))
    }

    fn refuse(&self, message: &str) -> FileError {
        FileError::new(&self.file, Some(self.line), message)
    }
}

impl RowReader for Rows<'_> {
    fn advance(&mut self) -> Result<bool, FileError> {
        if !self.next_line()? {
            return if self.has_rows {
                Ok(false)
            } else {
                Err(self.refuse("no data after the header"))
            };
        }
        self.has_rows = true;
        if let Some(at) = self.time_at {
            let time_s = self.stamp_s(at)?;
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
        for (at, text) in self.dialect.cells(&self.text).enumerate() {
            fields += 1;
            if let Some(column) = self.columns.get(at).filter(|_| self.time_at != Some(at)) {
                values.push(self.number(column, text)?);
            }
        }
        if fields == self.columns.len() {
            Ok(())
        } else {
            Err(self.wrong_count())
        }
    }

    fn file(&self) -> &str {
        &self.file
    }

    fn names(&self) -> &[String] {
        &self.names
    }

    fn guessed(&self) -> Option<String> {
        let mut guessed = self.dialect.guessed();
        let time = self
            .time_at
            .map(|at| &self.columns[at])
            .filter(|name| *name != TIME_COLUMN);
        if let Some(name) = time {
            let unit = match self.per_second.unwrap_or(1.0) {
                1e3 => "milliseconds",
                1e6 => "microseconds",
                1e9 => "nanoseconds",
                _ => "seconds",
            };
            guessed.push(format!("column {name} is the time in {unit}"));
        }
        (!guessed.is_empty()).then(|| guessed.join("; "))
    }
}
