//! Converts lines of a log to plain rows: lines with a terminal's stamps, labels, units, brackets
//! or JSON objects.
//!
//! A line consists of numbers with text around them. If nearly all lines have the same text, it
//! names the columns: `x:0.12,y:0.3`, `0.10 s,1.2 N`, `[0.1 0.2]`, `{"a": 1, "b": 2}`.

use super::clock_time::ClockTime;
use super::units::bracketed;
use std::io::{self, BufRead, BufReader, Read};

/// Minimum fraction of the first lines that must have the same form.
const LIKE_MIN: f64 = 0.8;

/// Minimum number of lines that must have the form.
const LINES_MIN: usize = 3;

/// Maximum length of a line, bytes.
const LINE_MAX: u64 = 1 << 16;

/// Maximum number of numbers in a line.
const NUMBERS_MAX: usize = 512;

/// Words for a missing reading.
const MISSING: [&str; 5] = ["nan", "null", "none", "inf", "ovf"];

/// Form of the lines.
#[derive(Clone, Debug, PartialEq)]
pub struct Form {
    has_stamp: bool,
    /// Names of the numbers, with their units in brackets; `None` if no text names them.
    names: Option<Vec<String>>,
    count: usize,
    /// The line above the first one in this form, if it names the columns.
    header: Option<String>,
}

/// A line: its stamp, its numbers, and the text before each number and after the last.
struct Line<'a> {
    stamp: Option<&'a str>,
    numbers: Vec<&'a str>,
    texts: Vec<&'a str>,
}

impl Form {
    /// Returns the form of nearly all lines. With `needs_stamp`, there is none unless the lines
    /// have stamps.
    pub fn of(text: &str, needs_stamp: bool) -> Option<Self> {
        let lines: Vec<&str> = text
            .lines()
            .filter(|line| !line.trim().is_empty())
            .collect();
        // The last line may be cut off, and the first lines may have a different form.
        let example = Line::of(lines.get(lines.len().saturating_sub(2))?)?;
        let (form, names) = (Self::of_line(&example), example.names());
        let is_like = |line: &&&str| {
            Line::of(line).is_some_and(|line| Self::of_line(&line) == form && line.names() == names)
        };
        let alike = lines.iter().filter(is_like).count();
        let is_enough = alike >= LINES_MIN && alike as f64 >= LIKE_MIN * (lines.len() - 1) as f64;
        let above = lines.iter().position(|line| is_like(&line));
        let above = above.and_then(|first| lines.get(first.checked_sub(1)?));
        let named = above.map_or_else(|| form.clone(), |above| form.clone().under(above));
        (is_enough && (form.has_stamp || !needs_stamp)).then_some(named)
    }

    /// Takes the names from a header, but keeps the units found in the cells.
    fn under(mut self, header: &str) -> Self {
        let separators: &[char] = &[',', ';', '\t'];
        let cells: Vec<&str> = header
            .split(separators)
            .map(|cell| cell.trim_matches([' ', '"']))
            .collect();
        let is_header = cells.len() == self.count && cells.iter().all(|cell| !cell.is_empty());
        if is_header && Line::of(header).is_none() {
            let units = self.names.take().unwrap_or_default();
            let unit_at = |at: usize| {
                units
                    .get(at)
                    .and_then(|name| bracketed(name))
                    .map(|(_, unit)| unit)
            };
            let names = cells
                .iter()
                .enumerate()
                .map(|(at, name)| match unit_at(at) {
                    Some(unit) if bracketed(name).is_none() => format!("{name} ({unit})"),
                    _ => (*name).to_owned(),
                });
            self.names = Some(names.collect());
            self.header = Some(header.trim().to_owned());
        }
        self
    }

    fn of_line(line: &Line) -> Self {
        Self {
            has_stamp: line.stamp.is_some(),
            names: line.names(),
            count: line.numbers.len(),
            header: None,
        }
    }

    fn plain_header(&self) -> Option<String> {
        let names: Vec<String> = match (&self.names, self.has_stamp) {
            (None, false) => return None,
            (None, true) => (1..=self.count).map(|at| format!("column_{at}")).collect(),
            (Some(names), _) => names.clone(),
        };
        let quoted = names
            .iter()
            .map(|name| format!("\"{}\"", name.replace('"', "'")));
        let time = self.has_stamp.then(|| "time".to_owned());
        Some(time.into_iter().chain(quoted).collect::<Vec<_>>().join(","))
    }

    /// Returns the number of values in a line, without the time stamp.
    pub fn count(&self) -> usize {
        self.count
    }

    pub fn added_lines(&self) -> u64 {
        u64::from(self.plain_header().is_some())
    }

    /// Describes how the lines were read.
    pub fn guessed(&self) -> String {
        let stamp = if self.has_stamp {
            "the time is the stamp in front of each line"
        } else {
            ""
        };
        let labels = match &self.names {
            Some(names) => format!(
                "text around the numbers names the columns: {}",
                names.join(", ")
            ),
            None if self.has_stamp => String::new(),
            None => "brackets around the rows are left out".into(),
        };
        [stamp.to_owned(), labels]
            .into_iter()
            .filter(|part| !part.is_empty())
            .collect::<Vec<_>>()
            .join("; ")
    }

    /// Converts a line to a plain row; a line in a different form is left unchanged.
    fn plain(&self, text: &str) -> String {
        // The header line is already part of the table.
        if self.header.as_deref() == Some(text.trim()) {
            return String::new();
        }
        match Line::of(text) {
            Some(line)
                if line.numbers.len() == self.count && line.stamp.is_some() == self.has_stamp =>
            {
                let numbers = line.numbers.iter().map(|number| number.to_string());
                let stamp = line.stamp.map(|stamp| format!("\"{stamp}\""));
                stamp
                    .into_iter()
                    .chain(numbers)
                    .collect::<Vec<_>>()
                    .join(",")
            }
            _ => text.to_owned(),
        }
    }

    /// Reads the lines of an input as plain rows under a header.
    pub fn read<'a>(self, input: Box<dyn Read + Send + 'a>) -> impl Read + Send + 'a {
        let header = self
            .plain_header()
            .map_or(String::new(), |header| header + "\n");
        PlainLines {
            input: BufReader::new(input),
            form: self,
            made: header.into_bytes(),
            given: 0,
        }
    }
}

impl<'a> Line<'a> {
    fn of(text: &'a str) -> Option<Self> {
        let (stamp, mut rest) = stamped(text.trim());
        let (mut numbers, mut texts) = (Vec::new(), Vec::new());
        loop {
            let Some((from, to)) = number(rest, numbers.is_empty()) else {
                texts.push(rest);
                break;
            };
            texts.push(&rest[..from]);
            numbers.push(&rest[from..to]);
            rest = &rest[to..];
            if numbers.len() > NUMBERS_MAX {
                return None;
            }
        }
        (!numbers.is_empty()).then_some(Self {
            stamp,
            numbers,
            texts,
        })
    }

    /// Returns names of the numbers from the text around them, with units in brackets.
    fn names(&self) -> Option<Vec<String>> {
        const EDGES: &[char] = &[
            ' ', '\t', ',', ';', ':', '=', '|', '"', '\'', '(', ')', '[', ']', '{', '}', '<', '>',
        ];
        let count = self.numbers.len();
        let (mut names, mut units) = (vec![String::new(); count], vec![String::new(); count]);
        let first = self.texts[0].trim_matches(EDGES);
        let is_labelled = !first.is_empty();
        for (at, text) in self.texts.iter().enumerate() {
            let (unit, label) = match text.find([',', ';', '|', '\t']) {
                _ if at == 0 => ("", *text),
                Some(split) => (&text[..split], &text[split..]),
                None if is_labelled && at < count => ("", *text),
                None => (*text, ""),
            };
            if at > 0 {
                units[at - 1] = unit.trim_matches(EDGES).to_owned();
            }
            if at < count {
                let label = label.trim_matches(EDGES);
                // `"acc": {"x": 0.1`
                let parts = label
                    .split(['"', '{', '[', ':', ' '])
                    .filter(|part| !part.is_empty());
                names[at] = match label.contains('"') {
                    true => parts.collect::<Vec<_>>().join("."),
                    false => label.to_owned(),
                };
            }
        }
        // One label may name several numbers: `X,Y,Z= 1,2,3`.
        let shared: Vec<&str> = first
            .split([',', '/', ' '])
            .filter(|name| !name.is_empty())
            .collect();
        if shared.len() == count && count > 1 && names[1..].iter().all(String::is_empty) {
            names = shared.into_iter().map(str::to_owned).collect();
        }
        if names.iter().chain(&units).all(String::is_empty) {
            return None;
        }
        let mut before = (String::new(), 1);
        let named = names
            .into_iter()
            .zip(units)
            .enumerate()
            .map(|(at, (name, unit))| {
                let name = match name.as_str() {
                    "" if before.0.is_empty() => format!("column_{}", at + 1),
                    "" => {
                        before.1 += 1;
                        format!("{}_{}", before.0, before.1)
                    }
                    name => {
                        before = (name.to_owned(), 1);
                        name.to_owned()
                    }
                };
                match unit.as_str() {
                    "" => name,
                    unit => format!("{name} ({unit})"),
                }
            });
        Some(named.collect())
    }
}

/// Splits off a stamp that a terminal puts in front of a line, such as `14:14:15.657 -> ` or
/// `[14:14:15.657] `.
fn stamped(line: &str) -> (Option<&str>, &str) {
    let split = match line.strip_prefix('[') {
        Some(inside) => inside.split_once(']'),
        None => line.split_once("->"),
    };
    match split {
        Some((stamp, rest)) if ClockTime::parse(stamp.trim()).is_some() => {
            let rest = rest.trim_start();
            (
                Some(stamp.trim()),
                rest.strip_prefix("->").unwrap_or(rest).trim_start(),
            )
        }
        _ => (None, line),
    }
}

/// Finds the first number of a text that does not directly follow a letter. A word for a missing
/// reading counts as a number, but not in front of the line's first number.
fn number(text: &str, is_first: bool) -> Option<(usize, usize)> {
    let bytes = text.as_bytes();
    let is_word = |at: usize| {
        at < bytes.len()
            && (bytes[at].is_ascii_alphanumeric() || bytes[at] == b'_' || bytes[at] >= 0x80)
    };
    let mut at = 0;
    while at < bytes.len() {
        if at > 0 && (is_word(at - 1) || bytes[at - 1] == b'.') {
            at += 1;
            continue;
        }
        if let Some(length) = number_length(&bytes[at..]) {
            return Some((at, at + length));
        }
        if !is_first {
            let word = bytes[at..]
                .iter()
                .take_while(|byte| byte.is_ascii_alphabetic())
                .count();
            let lower = text[at..at + word].to_ascii_lowercase();
            if MISSING.contains(&lower.as_str()) && !is_word(at + word) {
                return Some((at, at + word));
            }
        }
        at += 1;
    }
    None
}

/// Returns the length of the number that a text begins with, bytes.
fn number_length(text: &[u8]) -> Option<usize> {
    let sign = usize::from(text.first().is_some_and(|byte| matches!(byte, b'+' | b'-')));
    let digits = |from: usize, is: &dyn Fn(&u8) -> bool| {
        text[from.min(text.len())..]
            .iter()
            .take_while(|byte| is(byte))
            .count()
    };
    let is_digit = |byte: &u8| byte.is_ascii_digit();
    if text[sign..].starts_with(b"0x") || text[sign..].starts_with(b"0X") {
        let hex = digits(sign + 2, &|byte| byte.is_ascii_hexdigit());
        return (hex > 0).then_some(sign + 2 + hex);
    }
    let whole = digits(sign, &is_digit);
    let mut end = sign + whole;
    let mut decimals = 0;
    if text.get(end) == Some(&b'.') {
        decimals = digits(end + 1, &is_digit);
        if whole + decimals > 0 {
            end += 1 + decimals;
        }
    }
    if whole + decimals == 0 {
        return None;
    }
    if matches!(text.get(end), Some(b'e' | b'E')) {
        let sign = usize::from(matches!(text.get(end + 1), Some(b'+' | b'-')));
        let exponent = digits(end + 1 + sign, &is_digit);
        if exponent > 0 {
            end += 1 + sign + exponent;
        }
    }
    Some(end)
}

struct PlainLines<R> {
    input: BufReader<R>,
    form: Form,
    made: Vec<u8>,
    /// Number of bytes of `made` that have been returned.
    given: usize,
}

impl<R: Read> Read for PlainLines<R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        if self.given == self.made.len() {
            let mut line = Vec::new();
            if self
                .input
                .by_ref()
                .take(LINE_MAX)
                .read_until(b'\n', &mut line)?
                == 0
            {
                return Ok(0);
            }
            let text = String::from_utf8_lossy(&line);
            self.made = (self.form.plain(text.trim_end_matches(['\r', '\n'])) + "\n").into_bytes();
            self.given = 0;
        }
        let count = buffer.len().min(self.made.len() - self.given);
        buffer[..count].copy_from_slice(&self.made[self.given..self.given + count]);
        self.given += count;
        Ok(count)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plain(line: &str) -> Option<String> {
        let text = format!("{line}\n").repeat(5);
        let form = Form::of(&text, false)?;
        let mut read = String::new();
        form.read(Box::new(io::Cursor::new(line.to_owned())))
            .read_to_string(&mut read)
            .ok()?;
        Some(read)
    }

    #[test]
    fn lines_with_labels_units_and_stamps_are_plain_rows() {
        for (line, expected) in [
            ("x:0.12,y:-0.3", "\"x\",\"y\"\n0.12,-0.3\n"),
            ("x=0.12 y=-.3", "\"x\",\"y\"\n0.12,-.3\n"),
            (
                "ch1 value:67.7 mark 0 second :0.010",
                "\"ch1 value\",\"mark\",\"second\"\n67.7,0,0.010\n",
            ),
            (
                "0.10 s,1.2 N",
                "\"column_1 (s)\",\"column_2 (N)\"\n0.10,1.2\n",
            ),
            (
                "0.10s 52.3%",
                "\"column_1 (s)\",\"column_2 (%)\"\n0.10,52.3\n",
            ),
            ("Fx: 1.5 N, Fy: 2e-3 N", "\"Fx (N)\",\"Fy (N)\"\n1.5,2e-3\n"),
            ("[0.1 0.2 -3]", "0.1,0.2,-3\n"),
            ("(0.1, 0.2)", "0.1,0.2\n"),
            ("| 0.1 | 0.2 |", "0.1,0.2\n"),
            (
                "14:14:15.657 -> 1.2\t3.4",
                "time,\"column_1\",\"column_2\"\n\"14:14:15.657\",1.2,3.4\n",
            ),
            (
                "[14:14:15.657] a:1 b:2",
                "time,\"a\",\"b\"\n\"14:14:15.657\",1,2\n",
            ),
            (
                "14:14:15.657 ->  X,Y,Z= -1.84,2.93,-9.22",
                "time,\"X\",\"Y\",\"Z\"\n\"14:14:15.657\",-1.84,2.93,-9.22\n",
            ),
            (
                "{\"mlx\": 149, \"mly\": 1080}",
                "\"mlx\",\"mly\"\n149,1080\n",
            ),
            (
                "{\"t\":0.1,\"v\":[1,null,3]}",
                "\"t\",\"v\",\"v_2\",\"v_3\"\n0.1,1,null,3\n",
            ),
            ("adc 0x0A3F", "\"adc\"\n0x0A3F\n"),
        ] {
            assert_eq!(plain(line).as_deref(), Some(expected), "{line}");
        }
        let cells = "time,force\n10 ms,1 N\n20 ms,2 N\n30 ms,3 N\n40 ms,4 N\n";
        let form = Form::of(cells, false).expect("units in cells");
        let mut read = String::new();
        let lines = form.read(Box::new(io::Cursor::new(cells)));
        io::BufReader::new(lines)
            .read_to_string(&mut read)
            .expect("text");
        assert!(
            read.starts_with("\"time (ms)\",\"force (N)\"\n\n10,1\n20,2\n"),
            "{read}"
        );
        assert_eq!(plain("no numbers at all"), None);
        let prose = "Take 2 of them\nor 3 if there are 4\nbut never 5, 6 or 7\nand so on until 8\n";
        assert_eq!(Form::of(prose, false), None);
    }
}
