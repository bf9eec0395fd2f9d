//! Splits the first lines of a text into cells with a given separator.

use super::cells::{Kind, kind};
use csv::{ByteRecord, StringRecord};
use encoding_rs::WINDOWS_1252;

/// One of the first lines of a table.
pub struct HeadLine {
    pub number: u64,
    pub byte: usize,
    pub cells: Vec<String>,
    pub kinds: Vec<Kind>,
}

impl HeadLine {
    pub fn count(&self, wanted: Kind) -> usize {
        self.kinds.iter().filter(|kind| **kind == wanted).count()
    }

    /// True if the line has more numbers and times than words, and is not a comment.
    pub fn is_data(&self) -> bool {
        let values = self.count(Kind::Number) + self.count(Kind::Clock);
        values > self.count(Kind::Text) && !self.is_comment()
    }

    /// True if a LabVIEW header ends on this line; a file may have two headers.
    pub fn ends_header(&self) -> bool {
        self.cells[0] == "***End_of_Header***"
    }

    pub fn is_comment(&self) -> bool {
        is_comment(self.cells.first().map_or("", String::as_str))
    }
}

/// True if a line with this first cell is a comment.
pub fn is_comment(cell: &str) -> bool {
    cell.starts_with(['#', '%'])
}

/// True for a line that only separates rows, such as `|:---|---:|`, `+----+----+` or `==== ====`.
pub fn is_rule<'a>(mut cells: impl Iterator<Item = &'a str> + Clone) -> bool {
    let is_line = |cell: &str| cell.len() > 2 && cell.contains(['-', '=']);
    cells.clone().any(is_line) && cells.all(|cell| cell.chars().all(|c| "-=+:|".contains(c)))
}

pub fn records<R: std::io::Read>(input: R, separator: u8) -> csv::Reader<R> {
    csv::ReaderBuilder::new()
        .has_headers(false)
        .flexible(true)
        .delimiter(separator)
        .from_reader(input)
}

/// Returns the cells of a record. With spaces as separators, empty cells are dropped; lines around
/// the row are no cells.
pub fn cells(record: &StringRecord, separator: u8) -> impl Iterator<Item = &str> {
    let is_framed = separator == b'|' && record.get(0).is_some_and(|cell| cell.trim().is_empty());
    let edge = usize::from(is_framed);
    record
        .iter()
        .take(record.len().saturating_sub(edge))
        .skip(edge)
        .map(str::trim_ascii)
        .filter(move |cell| separator != b' ' || !cell.is_empty())
}

/// Decodes a record: UTF-8, or Windows-1252 for instruments that do not write valid UTF-8.
pub fn as_text(record: ByteRecord) -> StringRecord {
    StringRecord::from_byte_record(record).unwrap_or_else(|error| {
        let decoded = |cell| WINDOWS_1252.decode_without_bom_handling(cell).0;
        error.into_byte_record().iter().map(decoded).collect()
    })
}

/// Line endings.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LineEnds {
    Lf,
    CrLf,
    Cr,
}

impl LineEnds {
    pub fn of(text: &[u8]) -> Self {
        match text.iter().position(|byte| *byte == b'\n') {
            Some(at) if at > 0 && text[at - 1] == b'\r' => Self::CrLf,
            Some(_) => Self::Lf,
            None => Self::Cr,
        }
    }

    /// Returns the line of the last record read. The reader's line before the record ignores blank
    /// lines; its line after the record is one too high after LF, and right after the CR of CR LF.
    pub fn line<R: std::io::Read>(
        self,
        reader: &csv::Reader<R>,
        record: &ByteRecord,
    ) -> Option<u64> {
        let before = record.position()?.line();
        let after = reader.position().line();
        match self {
            Self::Lf => Some(before.max(after - 1)),
            Self::CrLf => Some(before.max(after)),
            Self::Cr => None,
        }
    }
}

pub fn lines(text: &[u8], separator: u8, is_whole: bool) -> Vec<HeadLine> {
    let mut reader = records(text, separator);
    let ends = LineEnds::of(text);
    let (mut record, mut lines) = (ByteRecord::new(), Vec::new());
    while reader.read_byte_record(&mut record).unwrap_or(false) {
        let line = ends.line(&reader, &record);
        let byte = record.position().map_or(0, csv::Position::byte) as usize;
        let read = as_text(core::mem::take(&mut record));
        let cells: Vec<String> = cells(&read, separator).map(Into::into).collect();
        if cells.iter().all(String::is_empty) || is_rule(cells.iter().map(String::as_str)) {
            continue;
        }
        lines.push(HeadLine {
            number: line.unwrap_or(lines.len() as u64 + 1),
            byte,
            kinds: cells
                .iter()
                .map(|cell| kind(cell, separator == b','))
                .collect(),
            cells,
        });
    }
    if !is_whole && lines.len() > 1 {
        lines.pop();
    }
    lines
}
