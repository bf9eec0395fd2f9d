//! Reads a table of samples row by row; only the rows of one stamp are in memory.

use super::cells::Numbers;
use super::head_line::{as_text, cells, is_comment, is_rule, records};
use super::layout::{Column, Layout};
use super::plain::Form;
use super::refused::Refused;
use super::row_reader::{RowReader, Timing};
use super::stamps::{Stamps, TICKS_PER_SECOND, Unit};
use super::time_column::{TIME_COLUMN, TimeColumn, UNITS, listed, quoted};
use super::units::unit_name;
use crate::digits::significant;
use core::cell::RefCell;
use csv::{ByteRecord, StringRecord};
use hal_mock::FileError;
use std::collections::VecDeque;
use std::fs::File;
use std::io::{Cursor, Read};
use std::path::Path;

/// Bytes from which the layout of a table is found.
const HEAD: u64 = 1 << 16;

/// Bytes at the start of a file that are searched for a zero, which text does not contain.
const LOOK: usize = 4096;

/// Number of rows within which a row that is out of order is sorted.
const REORDERED: usize = 16;

/// Maximum number of rows with the same stamp; with more, the column is not a clock.
const BATCH_MAX: usize = 1 << 14;

/// Options for reading a table.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TableForm {
    /// The column that is the time.
    pub time: Option<TimeColumn>,
    /// True if rows have consecutive samples of a single series.
    pub is_flat: bool,
    /// True if the user has chosen the columns, which are then channels.
    pub has_columns: bool,
}

impl TableForm {
    /// Default options, with this column as the time.
    pub fn timed(time: Option<TimeColumn>) -> Self {
        Self {
            time,
            ..Self::default()
        }
    }
}

/// Rows of a table in any layout that `Layout` finds. A line that is not a row is skipped and
/// counted; a cell without a number is a missing reading. Rows with the same stamp are spread
/// evenly up to the next stamp.
///
/// Values are parsed only on request, so skipping rows costs little.
pub struct Rows<'a> {
    file: String,
    names: Vec<String>,
    layout: Layout,
    numbers: Numbers,
    stamps: Option<Stamps>,
    /// A single reader type, so that it is compiled here, with this crate's optimization.
    reader: csv::Reader<Box<dyn Read + Send + 'a>>,
    present: Row,
    /// Rows read in advance: one row, or all rows with the same stamp.
    ahead: VecDeque<Row>,
    /// Records to read the next rows into.
    spare: Vec<ByteRecord>,
    /// Form of the lines, if they are first converted to plain rows.
    plain: Option<Form>,
    is_flat: bool,
    /// Step between stamps in seconds, and number of rows that shared the previous stamp.
    step_s: f64,
    shared: usize,
    is_over: bool,
    /// Number of rows that came after a row with a later stamp.
    reordered: u64,
    rows: u64,
    has_batches: bool,
    skipped: u64,
    /// Reason why the first skipped line was skipped.
    first_skipped: Option<FileError>,
    /// First word that was taken for a missing reading.
    word: RefCell<Option<String>>,
}

/// Error of a table with both `1.5` and `1,5`.
const OTHER_DECIMALS: &str = "is not a number beside the others: decimals follow either points or commas, and nothing else has any";

/// True if a cell that could not be read looks like a number.
fn is_numeric(cell: &str) -> bool {
    let is_part = |c: char| c.is_ascii_digit() || matches!(c, '.' | ',' | '-' | '+' | 'e' | 'E');
    cell.contains(['.', ',']) && cell.chars().all(is_part)
}

#[derive(Default)]
struct Row {
    record: StringRecord,
    time_s: Option<f64>,
    line: Option<u64>,
    /// True if the row has its own time and not a stamp shared with other rows.
    is_spread: bool,
}

impl<'a> Rows<'a> {
    /// Opens a file and finds its layout.
    pub fn open(path: impl AsRef<Path>) -> Result<Self, FileError> {
        let file = path.as_ref().display().to_string();
        let input = File::open(path).map_err(|error| FileError::new(&file, None, error))?;
        Self::new(input, &file)
    }

    /// Finds the layout of a table; errors call the file `file`.
    pub fn new(input: impl Read + Send + 'a, file: &str) -> Result<Self, FileError> {
        Self::with(input, file, &TableForm::default())
    }

    /// Like [`new`](Self::new), with options.
    pub fn with(
        input: impl Read + Send + 'a,
        file: &str,
        form: &TableForm,
    ) -> Result<Self, FileError> {
        Self::boxed(Box::new(input), file, form, None)
    }

    fn boxed(
        mut input: Box<dyn Read + Send + 'a>,
        file: &str,
        form: &TableForm,
        plain: Option<Form>,
    ) -> Result<Self, FileError> {
        let mut head = Vec::new();
        let read = input.by_ref().take(HEAD).read_to_end(&mut head);
        read.map_err(|error| FileError::new(file, None, error))?;
        // A device with random bytes never ends, and some of its lines would look like rows.
        if head.iter().take(LOOK).any(|byte| *byte == 0) {
            return Err(FileError::new(file, None, "not text: write it as CSV"));
        }
        // Spreadsheets put a byte order mark in front.
        if head.starts_with(b"\xEF\xBB\xBF") {
            head.drain(..3);
        }
        let is_whole = (head.len() as u64) < HEAD - 3;
        let found = Layout::find(&head, is_whole, form.time.as_ref());
        if plain.is_none()
            && let Some(lines) = plain_form(&head, &found)
        {
            let all = Box::new(Cursor::new(head).chain(input));
            return Self::boxed(Box::new(lines.clone().read(all)), file, form, Some(lines));
        }
        let layout = found.map_err(|refused| FileError::new(file, refused.line, refused.why))?;
        let is_chosen = form.is_flat || form.has_columns;
        if let Some(rows) = layout.transposed_rows.filter(|_| !is_chosen) {
            return Err(FileError::new(
                file,
                Some(layout.line),
                transposed(&layout, rows),
            ));
        }
        let channels = layout.columns.iter().filter(|column| !column.is_left_out);
        let names: Vec<String> = channels.map(|column| column.name.clone()).collect();
        if names.is_empty() {
            let why = "no channel: the table has only a time column, or words";
            return Err(FileError::new(file, layout.header_line, why));
        }
        if layout.is_wrapped && !is_chosen {
            return Err(FileError::new(file, Some(layout.line), wrapped(&layout)));
        }
        let mut begin = Cursor::new(head);
        begin.set_position(layout.byte as u64);
        let input: Box<dyn Read + Send + 'a> = Box::new(begin.chain(input));
        Ok(Self {
            file: file.to_owned(),
            names,
            numbers: Numbers::new(layout.separator == b','),
            stamps: layout.time.and_then(|(_, unit)| unit).map(Stamps::new),
            reader: records(input, layout.separator),
            layout,
            plain,
            is_flat: form.is_flat,
            present: Row::default(),
            ahead: VecDeque::new(),
            spare: Vec::new(),
            step_s: 0.0,
            shared: 0,
            is_over: false,
            reordered: 0,
            rows: 0,
            has_batches: false,
            skipped: 0,
            first_skipped: None,
            word: RefCell::new(None),
        })
    }

    /// Returns the stamp of the current row, if there is one.
    pub fn stamp_s(&self) -> Option<f64> {
        self.present.time_s
    }

    /// Returns the rate stated in the lines above the table, if no column is the time.
    pub fn stated_hz(&self) -> Option<f64> {
        let stated = self.layout.stated.as_ref()?;
        self.layout.time.is_none().then_some(stated.hz)
    }

    /// Reads the next row, skipping lines that are not rows. Returns false at the end.
    fn read_row(&mut self) -> Result<bool, FileError> {
        let mut record = self.spare.pop().unwrap_or_default();
        loop {
            let read = self.reader.read_byte_record(&mut record);
            if !read.map_err(|error| FileError::new(&self.file, None, error))? {
                self.is_over = true;
                return Ok(false);
            }
            let mut row = Row {
                line: self.line_of(&record),
                record: as_text(record),
                time_s: None,
                is_spread: false,
            };
            match self.examine(&mut row) {
                Some(why) => {
                    if !why.is_empty() {
                        self.skip(&row, &why);
                    }
                    record = row.record.into_byte_record();
                }
                None => {
                    self.insert(row);
                    return Ok(true);
                }
            }
        }
    }

    /// Inserts a row into the rows ahead, sorted by stamp.
    fn insert(&mut self, row: Row) {
        let is_later = |before: &Row| match (before.time_s, row.time_s) {
            (Some(before_s), Some(t_s)) => before_s > t_s,
            _ => false,
        };
        let at = self
            .ahead
            .iter()
            .rposition(|before| !is_later(before))
            .map_or(0, |at| at + 1);
        // A row that is too early for the rows ahead goes to the end, and is refused later for its
        // order.
        let is_here = at == self.ahead.len() || at > 0 && !self.ahead[at - 1].is_spread;
        if is_here {
            self.reordered += u64::from(at < self.ahead.len());
            self.ahead.insert(at, row);
        } else {
            self.ahead.push_back(row);
        }
    }

    /// Returns the reason why a record is not a row; empty if the record need not be counted.
    fn examine(&mut self, row: &mut Row) -> Option<String> {
        let separator = self.layout.separator;
        let wanted = self.layout.columns.len();
        let first = row.record.get(0).unwrap_or_default();
        let is_blank = || cells(&row.record, separator).all(str::is_empty);
        // Most rows begin with a digit: look no further.
        let may_be_rule = |c: char| "-=+:| ".contains(c);
        let is_rule = || first.starts_with(may_be_rule) && is_rule(row.record.iter());
        if is_comment(first.trim_ascii()) || is_blank() || is_rule() {
            return Some(String::new());
        }
        let found = cells(&row.record, separator).count();
        let last_is_out = self
            .layout
            .columns
            .last()
            .is_some_and(|column| column.is_left_out);
        let is_longer = found == wanted + 1
            && cells(&row.record, separator)
                .last()
                .is_some_and(|last| last.is_empty());
        let is_shorter = found + 1 == wanted && last_is_out || self.is_flat && found < wanted;
        if found != wanted && !is_longer && !is_shorter {
            return Some(format!("{found} columns, where others have {wanted}"));
        }
        match (self.layout.time, &mut self.stamps) {
            (Some((at, _)), Some(stamps)) => {
                let cell = cells(&row.record, separator).nth(at).unwrap_or_default();
                row.time_s = stamps.seconds(cell, &self.numbers);
                if let Some(split) = self.layout.fraction {
                    let cell = cells(&row.record, separator).nth(split.fraction);
                    let part = cell.and_then(|cell| self.numbers.number(cell));
                    let part = part.filter(|part| (0.0..split.per_second).contains(part));
                    let add = |seconds: f64| Some(seconds + part? / split.per_second);
                    row.time_s = row.time_s.and_then(add);
                }
                let name = &self.layout.columns[at].name;
                row.time_s.is_none().then(|| match is_numeric(cell) {
                    true => format!("column {name}: {cell:?} {OTHER_DECIMALS}"),
                    false => format!("column {name}: {cell:?} is no time"),
                })
            }
            _ => {
                let has_value = |(cell, column): (&str, &Column)| {
                    !column.is_left_out && self.numbers.number(cell).is_some()
                };
                let is_row = cells(&row.record, separator)
                    .zip(&self.layout.columns)
                    .any(has_value);
                (!is_row).then(|| "no number".into())
            }
        }
    }

    fn skip(&mut self, row: &Row, why: &str) {
        self.skipped += 1;
        if self.first_skipped.is_none() {
            self.first_skipped = Some(FileError::new(&self.file, row.line, why));
        }
    }

    /// Returns the line of the last record read. The reader does not count lines before the first
    /// row, except for a blank line directly in front of it.
    fn line_of(&self, record: &ByteRecord) -> Option<u64> {
        let line = self.layout.ends.line(&self.reader, record)?;
        let added = self.plain.as_ref().map_or(0, Form::added_lines);
        Some((line + self.layout.lines_before).saturating_sub(added))
    }

    /// Reads all rows with the next stamp, and spreads them evenly up to the stamp after. The first
    /// and last stamp of a recording may have lost rows, so their rows use the spacing of adjacent
    /// rows.
    fn read_batch(&mut self) -> Result<(), FileError> {
        let reads = |rows: &mut Self, count: usize| -> Result<bool, FileError> {
            if count > BATCH_MAX {
                let why = format!(
                    "{count} rows have the time of the first: choose another --time-column, or none and --rate HZ"
                );
                return Err(FileError::new(&rows.file, None, why));
            }
            Ok(!rows.is_over && rows.read_row()?)
        };
        while self.ahead.len() < REORDERED && reads(self, 0)? {}
        let Some(from_s) = self.ahead.front().and_then(|row| row.time_s) else {
            return Ok(());
        };
        let shared = |rows: &Self, from: usize| {
            let stamp = rows.ahead.get(from).and_then(|row| row.time_s);
            let same = rows
                .ahead
                .iter()
                .skip(from)
                .take_while(|row| row.time_s == stamp);
            same.count()
        };
        let mut count = shared(self, 0);
        while count == self.ahead.len() && reads(self, count)? {
            count = shared(self, 0);
        }
        let next_s = self.ahead.get(count).and_then(|row| row.time_s);
        if let Some(next_s) = next_s.filter(|next_s| *next_s > from_s) {
            self.step_s = next_s - from_s;
        }
        if count > 1 {
            self.has_batches = true;
            let is_first = self.shared == 0;
            let is_last = next_s.is_none();
            let beside = if is_first {
                let mut next = shared(self, count);
                while count + next == self.ahead.len() && reads(self, next)? {
                    next = shared(self, count);
                }
                // The next line may be the last one, and cut off.
                if self.ahead.len() > count + next {
                    next
                } else {
                    0
                }
            } else {
                self.shared
            };
            let is_cut = (is_first || is_last) && beside > count;
            let spacing_s = self.step_s / if is_cut { beside } else { count } as f64;
            let begin_s = match (is_first && is_cut, next_s) {
                (true, Some(next_s)) => next_s - count as f64 * spacing_s,
                _ => from_s,
            };
            for (number, row) in self.ahead.iter_mut().take(count).enumerate() {
                row.time_s = Some(begin_s + spacing_s * number as f64);
            }
        }
        self.shared = count;
        self.ahead
            .iter_mut()
            .take(count)
            .for_each(|row| row.is_spread = true);
        Ok(())
    }

    fn number(&self, column: usize, cell: &str) -> Result<f64, FileError> {
        if let Some(value) = self.numbers.number(cell) {
            return Ok(value);
        }
        let name = &self.layout.columns[column].name;
        if is_numeric(cell) {
            return Err(self.refuse(&format!("column {name}: {cell:?} {OTHER_DECIMALS}")));
        }
        let mut word = self.word.borrow_mut();
        if word.is_none() {
            let line = self.present.line.unwrap_or(self.rows);
            *word = Some(format!(
                "{cell:?} in line {line}, column {name}, is taken for a missing reading"
            ));
        }
        Ok(f64::NAN)
    }

    /// Fails if most lines of a file are not rows, because the layout was not recognised.
    fn check_skipped(&mut self) -> Result<(), FileError> {
        if self.skipped >= self.rows
            && let Some(error) = self.first_skipped.take()
        {
            return Err(error);
        }
        Ok(())
    }

    fn column_names(&self) -> String {
        let columns = self.layout.columns.iter();
        let names: Vec<&str> = columns.map(|column| column.name.as_str()).collect();
        listed(&names)
    }
}

impl RowReader for Rows<'_> {
    fn advance(&mut self) -> Result<bool, FileError> {
        if self.ahead.front().is_none_or(|row| !row.is_spread) {
            self.read_batch()?;
        }
        let Some(row) = self.ahead.pop_front() else {
            self.check_skipped()?;
            return Ok(false);
        };
        let before = std::mem::replace(&mut self.present, row);
        self.spare.push(before.record.into_byte_record());
        self.rows += 1;
        Ok(true)
    }

    fn time_s(&self) -> Option<f64> {
        let stated = || Some((self.rows.saturating_sub(1)) as f64 / self.stated_hz()?);
        self.present.time_s.or_else(stated)
    }

    fn timing(&self) -> Timing {
        let name = |at: usize| self.layout.columns[at].name.as_str();
        match self.layout.time {
            Some((_, Some(_))) => Timing::Stamped,
            Some((at, None)) => {
                let units = self.layout.plausible_units();
                let option = quoted(&format!("{}:{}", name(at), units.first().unwrap_or(&"ms")));
                Timing::Unclear(format!(
                    "column {} has whole numbers without a unit: say which with --time-column {option}{}, or give --rate HZ",
                    name(at),
                    others(units)
                ))
            }
            None if self.layout.stated.is_some() => Timing::Stamped,
            None => {
                let header = if self.layout.header_line.is_none() {
                    "no header, and "
                } else {
                    ""
                };
                let counts = |at: usize| format!("; {} counts the rows", name(at));
                let counted = self.layout.row_counter.map_or(String::new(), counts);
                let guess = match &self.layout.likely_time {
                    Some((at, units)) if !units.is_empty() => {
                        let option = quoted(&format!("{}:{}", name(*at), units[0]));
                        format!(
                            "{counted}; {} grows steadily: if it is the time, --time-column {option}{}",
                            name(*at),
                            others(units)
                        )
                    }
                    _ => counted,
                };
                Timing::Absent(format!(
                    "{header}no column {TIME_COLUMN} or of another name that says time; there are: {}{guess}; give the rate of the rows with --rate HZ",
                    self.column_names()
                ))
            }
        }
    }

    fn numbers(&self) -> Vec<usize> {
        let columns = (1..).zip(&self.layout.columns);
        let channels = columns.filter(|(_, column)| !column.is_left_out);
        channels.map(|(number, _)| number).collect()
    }

    fn units(&self) -> Vec<Option<String>> {
        let channels = self
            .layout
            .columns
            .iter()
            .filter(|column| !column.is_left_out);
        channels.map(|column| column.unit.clone()).collect()
    }

    fn is_dated(&self) -> bool {
        matches!(
            self.layout.time,
            Some((_, Some(Unit::Clock | Unit::PerSecond(_))))
        )
    }

    fn values(&self, values: &mut Vec<f64>) -> Result<(), FileError> {
        values.clear();
        let columns = self.layout.columns.iter().enumerate();
        for (cell, (at, column)) in cells(&self.present.record, self.layout.separator).zip(columns)
        {
            if !column.is_left_out {
                values.push(self.number(at, cell)?);
            }
        }
        Ok(())
    }

    fn file(&self) -> &str {
        &self.file
    }

    fn names(&self) -> &[String] {
        &self.names
    }

    fn way_out_of_time(&self) -> &'static str {
        "; if it is none, override it with --rate HZ, or choose another --time-column"
    }

    fn refuse(&self, why: &str) -> FileError {
        FileError::new(&self.file, self.present.line, why)
    }

    fn guessed(&self) -> Option<String> {
        let mut guessed = Vec::new();
        let separated = match self.layout.separator {
            b';' => Some("semicolons"),
            b'\t' => Some("tabs"),
            b' ' => Some("white space"),
            b'|' => Some("vertical bars"),
            _ => None,
        };
        guessed.extend(separated.map(|by| format!("columns are separated by {by}")));
        if self.numbers.has_decimal_commas() {
            guessed.push("decimals follow a comma".into());
        }
        if self.layout.has_preamble && self.plain.is_none() {
            guessed.push(format!(
                "the header is on line {}",
                self.layout.header_line.unwrap_or(self.layout.line)
            ));
        }
        if self.layout.header_line.is_none() {
            guessed.push("no header: columns are named column_1, column_2, ...".into());
        }
        let left_out = |(at, column): (usize, &Column)| {
            let is_fraction = self.layout.fraction.is_some_and(|split| split.has(at));
            let is_time = is_fraction || self.layout.time.is_some_and(|(time, _)| time == at);
            (column.is_left_out && !is_time && !column.name.is_empty()).then(|| column.name.clone())
        };
        let left_out: Vec<String> = self
            .layout
            .columns
            .iter()
            .enumerate()
            .filter_map(left_out)
            .collect();
        if !left_out.is_empty() {
            guessed.push(format!(
                "left out as words, counters or other times: {}",
                left_out.join(", ")
            ));
        }
        guessed.extend(self.plain.as_ref().map(Form::guessed));
        if let Some(stated) = &self.layout.stated
            && (self.layout.time.is_none() || self.layout.is_by_stated)
        {
            let hz = significant(stated.hz, 6);
            guessed.push(format!(
                "the rate of {hz} Hz is stated above the table: {:?}",
                stated.line
            ));
        }
        if self.reordered > 0 {
            let rows = if self.reordered == 1 {
                "row was"
            } else {
                "rows were"
            };
            guessed.push(format!(
                "{} {rows} out of order and sorted by time",
                self.reordered
            ));
        }
        if let Some((at, Some(unit))) = self.layout.time {
            let name = match self.layout.columns[at].name.as_str() {
                "" => "without a name",
                name => name,
            };
            let unit = match unit {
                Unit::Clock => "as a date or a time of day".to_owned(),
                Unit::PerSecond(TICKS_PER_SECOND) => "in units of 100 ns".to_owned(),
                Unit::PerSecond(per_second) if self.layout.is_epoch => {
                    format!("in {} since 1970, by its size", unit_name(per_second))
                }
                Unit::PerSecond(per_second) => format!("in {}", unit_name(per_second)),
            };
            let fraction = self.layout.fraction.map_or(String::new(), |split| {
                let name = &self.layout.columns[split.fraction].name;
                format!(", with its fraction in column {name}")
            });
            if name != TIME_COLUMN || !fraction.is_empty() {
                guessed.push(format!("column {name} is the time {unit}{fraction}"));
            }
        }
        guessed.extend(
            self.stamps
                .iter()
                .flat_map(Stamps::guessed)
                .map(str::to_owned),
        );
        if self.has_batches {
            guessed.push("rows that share a stamp are spread evenly".into());
        }
        guessed.extend(self.word.borrow().clone());
        if let Some(first) = &self.first_skipped {
            let lines = if self.skipped == 1 {
                "line is"
            } else {
                "lines are"
            };
            guessed.push(format!(
                "{} {lines} skipped: {}",
                self.skipped,
                first.place_and_reason()
            ));
        }
        (!guessed.is_empty()).then(|| guessed.join("; "))
    }
}

/// Lists the units of time other than the one suggested.
fn others(units: &[&str]) -> String {
    match units {
        [_, others @ ..] if !others.is_empty() => format!(" (or {})", others.join(", ")),
        [] => format!(" (or another of {UNITS})"),
        _ => String::new(),
    }
}

/// Returns advice for a table whose rows are channels.
fn transposed(layout: &Layout, rows: usize) -> String {
    let names = if layout.columns[0].is_left_out {
        ", index_col=0"
    } else {
        ""
    };
    format!(
        "{rows} rows of {} columns: each row seems to be a channel; in Python, ridgetone.fit(pandas.read_csv(FILE, header=None{names}).T), with rate_hz=HZ if none of them is the time",
        layout.columns.len()
    )
}

/// Returns advice for a series with several samples per row.
fn wrapped(layout: &Layout) -> String {
    let numbers: Vec<usize> = layout.series().map(|at| at + 1).collect();
    let rate = match (&layout.stated, &layout.likely_time) {
        _ if layout.time.is_some() => String::new(),
        (Some(stated), _) => format!(", at the stated {} Hz", significant(stated.hz, 6)),
        (None, Some((at, units))) if !units.is_empty() => {
            let option = quoted(&format!("{}:{}", layout.columns[*at].name, units[0]));
            format!(" and --time-column {option} (or --rate HZ)")
        }
        _ => " and --rate HZ".to_owned(),
    };
    format!(
        "its {} columns continue one another, as one series with {} samples a row: read it so with --flatten{rate}; if they are channels, say so with --columns {}-{}",
        numbers.len(),
        numbers.len(),
        numbers[0],
        numbers[numbers.len() - 1]
    )
}

/// Returns the form of lines that must be converted before they can be read as a table.
fn plain_form(head: &[u8], found: &Result<Layout, Refused>) -> Option<Form> {
    let text = String::from_utf8_lossy(head);
    let begins = |mark: &str| text.trim_start().starts_with(mark);
    let has_colours = text.contains("\x1b[");
    if (text.contains("->") || begins("[") || has_colours)
        && let Some(form) = Form::of(&text, !has_colours)
    {
        return Some(form);
    }
    match found {
        Err(_) => Form::of(&text, false),
        Ok(layout) if layout.has_marked_words => {
            let form = Form::of(&text, false)?;
            let channels = layout
                .columns
                .iter()
                .filter(|column| !column.is_left_out)
                .count();
            (form.columns() > channels + usize::from(layout.time.is_some())).then_some(form)
        }
        Ok(_) => None,
    }
}
