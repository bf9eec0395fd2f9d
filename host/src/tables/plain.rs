//! Converts lines of a log to plain rows: lines with a terminal's stamps, labels, units, brackets
//! or JSON objects.
//!
//! A line consists of numbers with text around them. If nearly all lines have the same text, it
//! names the columns: `x:0.12,y:0.3`, `0.10 s,1.2 N`, `[0.1 0.2]`, `{"a": 1, "b": 2}`.

use super::clock_time::{ClockTime, WORDS_MAX};
use super::units::bracketed;
use std::borrow::Cow;
use std::io::{self, BufRead, BufReader, Read};

/// Minimum fraction of the first lines that must have the same form.
const LIKE_MIN: f64 = 0.8;

/// Minimum number of lines that must have the form.
const LINES_MIN: usize = 3;

/// Maximum length of a line, bytes.
const LINE_MAX: u64 = 1 << 16;

/// Maximum number of numbers in a line.
const NUMBERS_MAX: usize = 512;

/// Number of lines in which decimal commas are looked for.
const LINES_LOOKED_AT: usize = 200;

/// Words for a missing reading.
const MISSING: [&str; 5] = ["nan", "null", "none", "inf", "ovf"];

/// Form of the lines.
#[derive(Clone, Debug, PartialEq)]
pub struct Form {
    has_stamp: bool,
    /// Decimal separator of the numbers.
    decimals: u8,
    /// Text around the numbers of each line; `None` if it names none of them.
    labels: Option<Vec<Label>>,
    count: usize,
    /// Names in the line above the first one in this form, and that line.
    header: Option<(Vec<String>, String)>,
}

/// Text around a number.
#[derive(Clone, Debug, PartialEq)]
struct Label {
    name: String,
    unit: String,
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
        let text = uncoloured(text);
        let lines: Vec<&str> = text
            .lines()
            .filter(|line| !line.trim().is_empty())
            .collect();
        let decimals = decimals(&lines);
        // The last line may be cut off, and the first lines may have a different form.
        let example = Line::of(lines.get(lines.len().saturating_sub(2))?, decimals)?;
        let form = Self::of_line(&example, decimals);
        let is_like = |line: &&&str| {
            Line::of(line, decimals).is_some_and(|line| form.difference(&line) != Some(""))
        };
        let alike = lines.iter().filter(is_like).count();
        let is_enough = alike >= LINES_MIN && alike as f64 >= LIKE_MIN * (lines.len() - 1) as f64;
        let first = lines.iter().position(|line| is_like(&line)).unwrap_or(0);
        let headers = lines[..first].iter().rev();
        let header = headers.filter_map(|line| form.header_in(line)).next();
        let named = Self { header, ..form };
        (is_enough && (named.has_stamp || !needs_stamp)).then_some(named)
    }

    /// Returns the names in a line above the rows, and the line.
    fn header_in(&self, line: &str) -> Option<(Vec<String>, String)> {
        let separators: &[char] = &[',', ';', '\t'];
        let cells = line
            .split(separators)
            .map(|cell| cell.trim_matches([' ', '"']).to_owned());
        let mut names: Vec<String> = cells.collect();
        if self.has_stamp && names.len() == self.count + 1 {
            names.remove(0);
        }
        let is_header = names.len() == self.count && names.iter().all(|name| !name.is_empty());
        let has_number = Line::of(line, self.decimals).is_some();
        (is_header && !has_number).then(|| (names, line.trim().to_owned()))
    }

    fn of_line(line: &Line, decimals: u8) -> Self {
        Self {
            has_stamp: line.stamp.is_some(),
            decimals,
            labels: line.labels(),
            count: line.numbers.len(),
            header: None,
        }
    }

    /// Returns the unit in which a line differs from the form; empty if the line has another form.
    fn difference<'a>(&self, line: &'a Line) -> Option<&'a str> {
        if line.numbers.len() != self.count || line.stamp.is_some() != self.has_stamp {
            return Some("");
        }
        let labels = line.labels();
        let own = self.labels.iter().flatten();
        let pairs = own.zip(labels.iter().flatten());
        let is_named_so = pairs.clone().all(|(own, label)| own.name == label.name);
        if labels.is_some() != self.labels.is_some() || !is_named_so {
            return Some("");
        }
        let other = pairs
            .enumerate()
            .find(|(_, (own, label))| own.unit != label.unit);
        other.map(|(at, _)| line.unit(at))
    }

    /// Returns the names of the numbers, with their units in brackets; `None` if no text names
    /// them.
    fn names(&self) -> Option<Vec<String>> {
        let labels = self.labels.as_ref();
        let label = |at: usize| labels.and_then(|labels| labels.get(at));
        let name = |at: usize| match &self.header {
            Some((names, _)) => names[at].as_str(),
            None => label(at).map_or("", |label| label.name.as_str()),
        };
        let named = |at: usize| match label(at).map_or("", |label| label.unit.as_str()) {
            unit if unit.is_empty() || bracketed(name(at)).is_some() => name(at).to_owned(),
            unit => format!("{} ({unit})", name(at)),
        };
        let has_names = labels.is_some() || self.header.is_some();
        has_names.then(|| (0..self.count).map(named).collect())
    }

    fn plain_header(&self) -> Option<String> {
        let names: Vec<String> = match (self.names(), self.has_stamp) {
            (None, false) => return None,
            (None, true) => (1..=self.count).map(|at| format!("column_{at}")).collect(),
            (Some(names), _) => names,
        };
        let quoted = names
            .iter()
            .map(|name| format!("\"{}\"", name.replace('"', "'")));
        let time = self.has_stamp.then(|| "time".to_owned());
        Some(time.into_iter().chain(quoted).collect::<Vec<_>>().join(","))
    }

    /// Returns the number of values in a line, including the time stamp.
    pub fn columns(&self) -> usize {
        self.count + usize::from(self.has_stamp)
    }

    pub fn added_lines(&self) -> u64 {
        u64::from(self.plain_header().is_some())
    }

    /// Describes how the lines were read.
    pub fn guessed(&self) -> String {
        let stamp = if self.has_stamp {
            "the time is the stamp in each line"
        } else {
            ""
        };
        let labels = match self.names() {
            Some(names) => format!(
                "text around the numbers names the columns: {}",
                names.join(", ")
            ),
            None if self.has_stamp => String::new(),
            None => "brackets around the rows are left out".into(),
        };
        let decimals = match self.decimals {
            b',' => "decimals follow a comma",
            _ => "",
        };
        [stamp.to_owned(), labels, decimals.to_owned()]
            .into_iter()
            .filter(|part| !part.is_empty())
            .collect::<Vec<_>>()
            .join("; ")
    }

    /// Converts a line to a plain row; `None` if the line has a different form. Fails if a number
    /// has another unit than in the other lines.
    fn row(&self, text: &str) -> io::Result<Option<String>> {
        let Some(line) = Line::of(text, self.decimals) else {
            return Ok(None);
        };
        match self.difference(&line) {
            None => {
                let numbers = line.numbers.iter().map(|number| number.replace(',', "."));
                let stamp = line.stamp.map(|stamp| format!("\"{stamp}\""));
                let cells: Vec<String> = stamp.into_iter().chain(numbers).collect();
                Ok(Some(cells.join(",")))
            }
            Some("") => Ok(None),
            Some(unit) => Err(io::Error::new(
                io::ErrorKind::InvalidData,
                format!(
                    "the line {:?} has the unit {unit:?}, which others do not: write each column in one unit",
                    text.trim()
                ),
            )),
        }
    }

    /// Reads the lines of an input as plain rows, the first one under a header.
    pub fn read<'a>(self, input: Box<dyn Read + Send + 'a>) -> impl Read + Send + 'a {
        PlainLines {
            input: BufReader::new(input),
            header: self.plain_header(),
            form: self,
            made: Vec::new(),
            given: 0,
        }
    }
}

impl<'a> Line<'a> {
    fn of(text: &'a str, decimals: u8) -> Option<Self> {
        let (mut front, stamp, mut rest) = stamped(text.trim());
        // A time of day of unknown form would be split into numbers.
        if clock_in(front).is_some() || clock_in(rest).is_some() {
            return None;
        }
        let (mut numbers, mut texts) = (Vec::new(), Vec::new());
        loop {
            // Text directly in front of the stamp is dropped.
            let rest = match number(front, numbers.is_empty(), decimals) {
                Some(_) => &mut front,
                None => &mut rest,
            };
            let Some((from, to)) = number(rest, numbers.is_empty(), decimals) else {
                texts.push(*rest);
                break;
            };
            let (text, number) = (&rest[..from], &rest[from..to]);
            *rest = &rest[to..];
            // The uncertainty of the number before.
            if !numbers.is_empty() && matches!(text.trim(), "\u{b1}" | "+-" | "+/-") {
                continue;
            }
            texts.push(text);
            numbers.push(number);
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

    /// Splits the text in front of a number into the unit of the number before and a label.
    fn split(&self, at: usize) -> (&'a str, &'a str) {
        let text = self.texts[at];
        let is_labelled = !self.texts[0].trim_matches(EDGES).is_empty();
        let end = match text.find([',', ';', '|', '\t']) {
            _ if at == 0 => 0,
            Some(end) => end,
            None if is_labelled && at < self.numbers.len() => 0,
            None => text.len(),
        };
        let (unit, label) = text.split_at(end);
        (unit.trim_matches(EDGES), label.trim_matches(EDGES))
    }

    fn unit(&self, at: usize) -> &'a str {
        self.split(at + 1).0
    }

    /// Returns the names and units of the numbers from the text around them.
    fn labels(&self) -> Option<Vec<Label>> {
        let count = self.numbers.len();
        let first = self.split(0).1;
        // `>force:1627551892437:1.2` with milliseconds, as Teleplot has it
        if let Some(name) = self.texts[0].trim_start().strip_prefix('>')
            && self.texts[1] == ":"
            && count == 2
        {
            let label = |name: &str, unit: &str| Label {
                name: name.to_owned(),
                unit: unit.to_owned(),
            };
            let name = name.trim_end_matches(':');
            return Some(vec![label("time", "ms"), label(name, self.unit(1))]);
        }
        let named = |at: usize| {
            let label = self.split(at).1;
            // `"acc": {"x": 0.1`, after other keys with words
            let keys = label.rsplit(',').next().unwrap_or_default();
            let parts = keys
                .split(['"', '{', '[', ':', ' '])
                .filter(|part| !part.is_empty());
            match label.contains('"') {
                true => parts.collect::<Vec<_>>().join("."),
                false => label.to_owned(),
            }
        };
        let mut names: Vec<String> = (0..count).map(named).collect();
        // One label may name several numbers: `X,Y,Z= 1,2,3`.
        let shared: Vec<&str> = first
            .split([',', '/', ' '])
            .filter(|name| !name.is_empty())
            .collect();
        if shared.len() == count && count > 1 && names[1..].iter().all(String::is_empty) {
            names = shared.into_iter().map(str::to_owned).collect();
        }
        let has_unit = (0..count).any(|at| !self.unit(at).is_empty());
        if names.iter().all(String::is_empty) && !has_unit {
            return None;
        }
        let mut before = (String::new(), 1);
        let labelled = names.into_iter().enumerate().map(|(at, name)| Label {
            name: match name.as_str() {
                "" if before.0.is_empty() => format!("column_{}", at + 1),
                "" => {
                    before.1 += 1;
                    format!("{}_{}", before.0, before.1)
                }
                name => {
                    before = (name.to_owned(), 1);
                    name.to_owned()
                }
            },
            unit: self.unit(at).to_owned(),
        });
        Some(labelled.collect())
    }
}

/// Characters around labels and units that belong to neither.
const EDGES: &[char] = &[
    ' ', '\t', ',', ';', ':', '=', '|', '"', '\'', '(', ')', '[', ']', '{', '}', '<', '>', '\u{a7}',
];

/// Removes the colours of a terminal.
fn uncoloured(text: &str) -> Cow<'_, str> {
    if !text.contains("\x1b[") {
        return text.into();
    }
    let mut parts = text.split("\x1b[");
    let mut plain = parts.next().unwrap_or_default().to_owned();
    for part in parts {
        plain += part
            .trim_start_matches(|c: char| c.is_ascii_digit() || c == ';')
            .get(1..)
            .unwrap_or_default();
    }
    plain.into()
}

/// Returns the decimal separator of the numbers in lines. Decimals follow a comma if no number has
/// a point, if something else separates the numbers, and if the digits behind the commas are not whole
/// numbers: some begin with a zero, or there are as many in each line.
fn decimals(lines: &[&str]) -> u8 {
    let lines = || lines.iter().take(LINES_LOOKED_AT);
    let read = |decimals: u8| lines().filter_map(move |line| Line::of(line, decimals));
    let has = |mut lines: Box<dyn Iterator<Item = Line>>, mark: char| {
        lines.any(|line| line.numbers.iter().any(|number| number.contains(mark)))
    };
    if has(Box::new(read(b'.')), '.') || !has(Box::new(read(b',')), ',') {
        return b'.';
    }
    let is_separated = |line: Line| {
        let between = &line.texts[1..line.numbers.len()];
        between
            .iter()
            .all(|text| !text.trim().is_empty() && text.trim() != ",")
    };
    let places = |line: &Line| -> Vec<usize> {
        let decimals = line.numbers.iter().map(|number| number.split_once(','));
        decimals
            .map(|parts| parts.map_or(0, |(_, decimals)| decimals.len()))
            .collect()
    };
    let example = read(b',')
        .next_back()
        .map_or(Vec::new(), |line| places(&line));
    let is_fixed = example.len() > 1 && read(b',').all(|line| places(&line) == example);
    let begins_with_zero = |number: &&str| {
        let decimals = number.split_once(',').map_or("", |(_, decimals)| decimals);
        decimals.len() > 1 && decimals.starts_with('0')
    };
    let has_zero = read(b',').any(|line| line.numbers.iter().any(begins_with_zero));
    if read(b',').all(is_separated) && (is_fixed || has_zero) {
        b','
    } else {
        b'.'
    }
}

/// Returns the position of the first time of day with two colons: that of its hour's last digit.
fn clock_in(text: &str) -> Option<usize> {
    let is_clock = |part: &[u8]| {
        let mut marks = part.iter().zip(b"0:00:00");
        marks.all(|(byte, mark)| match mark {
            b':' => byte == mark,
            _ => byte.is_ascii_digit(),
        })
    };
    text.as_bytes().windows(7).position(is_clock)
}

/// Splits a line at the longest date or time of day around its first time of day. Returns the text
/// before, the stamp, and the text after.
fn split_at_clock(line: &str) -> Option<(&str, &str, &str)> {
    let at = clock_in(line)?;
    let is_edge = |c: char| c.is_whitespace() || ",;|\"'()[]{}<>=".contains(c);
    let word_at = |end: usize| {
        let word = line[..end].rsplit(is_edge).next();
        end - word.map_or(0, str::len)
    };
    let mut starts = vec![word_at(at)];
    for _ in 0..WORDS_MAX {
        let before = line[..starts[starts.len() - 1]].trim_end_matches(' ');
        starts.push(word_at(before.len()));
    }
    let last = line[at..]
        .find(is_edge)
        .map_or(line.len(), |edge| at + edge);
    // Python's logging puts milliseconds after a comma.
    let last = match line.as_bytes()[last..] {
        [b',', a, b, c, b' ', ..] if [a, b, c].iter().all(u8::is_ascii_digit) => last + 4,
        _ => last,
    };
    let mut ends = vec![last];
    for _ in 0..WORDS_MAX {
        let from = ends[ends.len() - 1];
        let blanks = line[from..].len() - line[from..].trim_start_matches(' ').len();
        let end = line[from + blanks..].find(is_edge);
        ends.push(end.map_or(line.len(), |edge| from + blanks + edge));
    }
    let spans = starts
        .iter()
        .rev()
        .flat_map(|from| ends.iter().rev().map(move |to| (*from, *to)));
    let mut clocks = spans.filter(|(from, to)| ClockTime::parse(line[*from..*to].trim()).is_some());
    let (from, to) = clocks.next()?;
    Some((&line[..from], line[from..to].trim(), &line[to..]))
}

/// Splits a line at its stamp. A terminal may put it in front, such as `14:14:15.657 -> ` or
/// `[14:14:15.657] `; a log may have a date or a time of day with two colons anywhere. Returns the
/// text before, the stamp, and the text after.
fn stamped(line: &str) -> (&str, Option<&str>, &str) {
    // A sentence of NMEA 0183 ends with its checksum: `$PXDR,0.5*4A`.
    let line = match line.rsplit_once('*') {
        Some((sentence, checksum)) if line.starts_with('$') && checksum.len() == 2 => sentence,
        _ => line,
    };
    let split = match line.strip_prefix('[') {
        Some(inside) => inside.split_once(']'),
        None => line.split_once("->"),
    };
    match split {
        Some((stamp, rest)) if ClockTime::parse(stamp.trim()).is_some() => {
            let rest = rest.trim_start();
            (
                "",
                Some(stamp.trim()),
                rest.strip_prefix("->").unwrap_or(rest).trim_start(),
            )
        }
        _ => match split_at_clock(line) {
            Some((front, stamp, rest)) => (front, Some(stamp), rest),
            None => ("", None, line),
        },
    }
}

/// Finds the first number of a text that does not directly follow a letter. A word for a missing
/// reading counts as a number, but not in front of the line's first number.
fn number(text: &str, is_first: bool, decimals: u8) -> Option<(usize, usize)> {
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
        if let Some(length) = number_length(&bytes[at..], decimals) {
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
fn number_length(text: &[u8], decimal_mark: u8) -> Option<usize> {
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
    let decimals = match text.get(end) {
        Some(mark) if *mark == decimal_mark => digits(end + 1, &is_digit),
        _ => 0,
    };
    if whole + decimals == 0 || decimal_mark == b',' && whole == 0 {
        return None;
    }
    if decimals > 0 || decimal_mark == b'.' && text.get(end) == Some(&b'.') {
        end += 1 + decimals;
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
    /// Names of the columns, until they have been returned.
    header: Option<String>,
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
            let text = uncoloured(text.trim_end_matches(['\r', '\n']));
            let named = self.form.header.as_ref().map(|(_, line)| line.as_str());
            let line = match self.form.row(&text)? {
                Some(row) => match self.header.take() {
                    Some(header) => format!("{header}\n{row}"),
                    None => row,
                },
                // The names in this line are part of the header.
                None if named == Some(text.trim()) => String::new(),
                // Other lines are no rows, whatever commas they have. Without labels, one may be a
                // header.
                None if text.contains(',') && self.form.plain_header().is_some() => {
                    format!("\"{}\"", text.replace('"', "'"))
                }
                None => text.into_owned(),
            };
            self.made = (line + "\n").into_bytes();
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
                "0.5 \u{b1} 0.1 V,2 +- 0.3 N",
                "\"column_1 (V)\",\"column_2 (N)\"\n0.5,2\n",
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
            (
                "{\"id\": 7, \"ts\": \"2026-01-31T12:30:05.25Z\", \"dev\": \"a1\", \"ax\": 0.1}",
                "time,\"id\",\"ax\"\n\"2026-01-31T12:30:05.25Z\",7,0.1\n",
            ),
            ("a\u{a0}12:30:05.25 x=1", "time,\"x\"\n\"12:30:05.25\",1\n"),
            (
                "Feb  1 12:30:05.25 host imu: x=1 y=2",
                "time,\"host imu: x\",\"y\"\n\"Feb  1 12:30:05.25\",1,2\n",
            ),
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
            read.starts_with("\n\"time (ms)\",\"force (N)\"\n10,1\n20,2\n"),
            "{read}"
        );
        assert_eq!(plain("no numbers at all"), None);
        assert_eq!(plain("day 3 of 2026_01_31-12:30:05.25, 0.5"), None);
        let prose = "Take 2 of them\nor 3 if there are 4\nbut never 5, 6 or 7\nand so on until 8\n";
        assert_eq!(Form::of(prose, false), None);
    }
}
