//! How a table is laid out, by its first lines: separator, preamble, header, units, columns.

use super::cells::Kind;
use super::head_line::{HeadLine, LineEnds, lines};
use super::header::{COMMENT, names, unit_row};
use super::look::{Look, is_counter, likely_time};
use super::refused::Refused;
use super::stamps::Unit;
use super::time_column::{
    Candidate, Likeness, Named, TIME_COLUMN, TimeColumn, choose, named, per_second, quoted,
};

/// Separators in the order of preference. A space stands for any white space.
const SEPARATORS: [u8; 4] = [b',', b';', b'\t', b' '];

/// Columns of estimates, as `export` writes them: they are no samples.
const ESTIMATE_COLUMNS: [&str; 2] = ["frequency_hz", "sigma_hz"];

/// A column of the table.
#[derive(Clone, Debug)]
pub struct Column {
    pub name: String,
    /// It is no channel: its values are words, it counts rows, it is a time, or it has neither a
    /// name nor a value.
    pub is_left_out: bool,
}

/// The layout of a table.
#[derive(Clone, Debug)]
pub struct Layout {
    pub separator: u8,
    pub columns: Vec<Column>,
    /// Where the first row begins, blank lines in front of it included, and its line.
    pub byte: usize,
    pub line: u64,
    pub ends: LineEnds,
    /// Lines in front of `byte`.
    pub lines_before: u64,
    /// Where the header is; none if there is none.
    pub header_line: Option<u64>,
    /// The column that is the time and its unit, none if nothing says it.
    pub time: Option<(usize, Option<Unit>)>,
    /// The column that looks most like a time among those that are none.
    pub likely_time: Option<usize>,
    /// Whether all its values are whole: seconds would have decimals.
    pub is_likely_whole: bool,
    /// Whether lines were passed over in front of the header.
    pub has_preamble: bool,
    /// The time's unit is guessed from its size.
    pub is_epoch: bool,
}

impl Layout {
    /// Finds the layout of a text that begins so; its last line may be cut unless it is `whole`.
    pub fn find(text: &[u8], is_whole: bool, time: Option<&TimeColumn>) -> Result<Self, Refused> {
        let (asked, skip) = asked_separator(text);
        let text = &text[skip..];
        if text.iter().all(u8::is_ascii_whitespace) {
            return Err(Refused::new(None, "the file is empty"));
        }
        let separators: &[u8] = asked
            .as_ref()
            .map_or(&SEPARATORS[..], core::slice::from_ref);
        let mut best: Option<(f64, u8, Vec<HeadLine>)> = None;
        for separator in separators {
            let lines = lines(text, *separator, is_whole);
            let score = score(&lines);
            if best.as_ref().is_none_or(|(most, ..)| score > *most) {
                best = Some((score, *separator, lines));
            }
        }
        let Some((_, separator, lines)) = best else {
            return Err(Refused::new(None, "the file is empty"));
        };
        let mut found = Self::of(&lines, separator)?;
        found.ends = LineEnds::of(text);
        found.lines_before = text[..found.byte]
            .iter()
            .filter(|byte| **byte == b'\n')
            .count() as u64;
        found.find_time(&lines, time)?;
        found.byte += skip;
        Ok(found)
    }

    fn of(lines: &[HeadLine], separator: u8) -> Result<Self, Refused> {
        let width = usual_width(lines);
        let Some(first) = first_row(lines, width) else {
            return Err(no_rows(lines));
        };
        let rows: Vec<&HeadLine> = rows(lines, first).collect();
        let (names, header) = names(lines, first)?;
        let share = |at: usize, wanted: Kind| {
            rows.iter().filter(|line| line.kinds[at] == wanted).count() as f64 / rows.len() as f64
        };
        let columns = (0..width).map(|at| {
            let name = names
                .as_ref()
                .map_or(format!("column_{}", at + 1), |names| names[at].clone());
            let is_unnamed = name.is_empty() || name == COMMENT;
            let is_empty = is_unnamed && share(at, Kind::Missing) == 1.0;
            let words = share(at, Kind::Text) + share(at, Kind::Clock);
            Column {
                is_left_out: is_empty || words > 0.5 || is_counter(&name, &rows, at),
                name,
            }
        });
        let columns: Vec<Column> = columns.collect();
        let has = |name: &&str| columns.iter().any(|column| column.name == **name);
        if ESTIMATE_COLUMNS.iter().all(has) {
            let why = "these are estimates, not samples: give the recording that they come from";
            return Err(Refused::new(None, why));
        }
        let header_at = header.unwrap_or(first);
        Ok(Self {
            separator,
            columns,
            byte: lines[first].byte,
            line: lines[first].number,
            ends: LineEnds::Lf,
            lines_before: 0,
            header_line: header.map(|at| lines[at].number),
            time: None,
            likely_time: None,
            is_likely_whole: false,
            has_preamble: lines[..header_at].iter().any(|line| !line.is_comment()),
            is_epoch: false,
        })
    }

    fn find_time(
        &mut self,
        lines: &[HeadLine],
        wanted: Option<&TimeColumn>,
    ) -> Result<(), Refused> {
        let refuse = |why: String| Err(Refused::new(self.header_line, why));
        // Not by its number: where ends of lines are mixed, two may have the same.
        let first = lines
            .iter()
            .position(|line| line.byte == self.byte)
            .unwrap_or(0);
        let rows: Vec<&HeadLine> = rows(lines, first).collect();
        let units = unit_row(lines, first, self.header_line);
        let unit_at = |at: usize| units.and_then(|units| per_second(&units.cells[at]));
        let looks: Vec<Look> = (0..self.columns.len())
            .map(|at| Look::new(&rows, at))
            .collect();
        let names = || -> Vec<&str> {
            self.columns
                .iter()
                .map(|column| column.name.as_str())
                .collect()
        };
        let (at, unit) = match wanted {
            Some(TimeColumn::Nothing) => return Ok(()),
            Some(TimeColumn::Named(name, unit)) => {
                let Some(at) = self.columns.iter().position(|column| column.name == *name) else {
                    return refuse(format!(
                        "no column {name}; there are: {}",
                        names().join(", ")
                    ));
                };
                (
                    at,
                    unit.or_else(|| named(name).and_then(|named| named.per_second)),
                )
            }
            None => {
                let mut candidates = Vec::new();
                for (at, look) in looks.iter().enumerate() {
                    let by_unit = unit_at(at).map(|per_second| Named {
                        likeness: Likeness::WithUnit,
                        per_second: Some(per_second),
                    });
                    let by_look = look.is_clock.then_some(Named {
                        likeness: Likeness::Contains,
                        per_second: None,
                    });
                    let named = named(&self.columns[at].name).or(by_unit).or(by_look);
                    let named =
                        named.filter(|named| look.is_time() || named.likeness == Likeness::Exact);
                    candidates.extend(named.map(|named| Candidate {
                        at,
                        named,
                        grows: look.grows,
                    }));
                }
                if let [first, second] = two_exact(&self.columns)[..] {
                    return refuse(format!(
                        "columns {first} and {second} are both called {TIME_COLUMN}"
                    ));
                }
                match choose(&candidates) {
                    Ok(Some(found)) => (found.at, found.named.per_second),
                    Ok(None) => {
                        self.likely_time = likely_time(&looks);
                        self.is_likely_whole =
                            self.likely_time.is_some_and(|at| looks[at].is_whole);
                        return Ok(());
                    }
                    Err(all) => {
                        let all: Vec<&str> = all.iter().map(|at| names()[*at]).collect();
                        return refuse(format!(
                            "{} may all be the time: choose with --time-column {}, or none",
                            all.join(", "),
                            quoted(all[0])
                        ));
                    }
                }
            }
        };
        if self.columns.len() == 1 {
            return refuse("no channel: the table has only a time column".into());
        }
        let look = &looks[at];
        let unit = if look.is_clock {
            Some(Unit::Clock)
        } else {
            let said = unit.or_else(|| unit_at(at));
            self.is_epoch = said.is_none() && look.epoch().is_some();
            let guessed = || look.epoch().or((!look.is_whole).then_some(1.0));
            said.or_else(guessed).map(Unit::PerSecond)
        };
        // A column beside it that is a time, too, is no channel.
        for (column, look) in self.columns.iter_mut().zip(&looks) {
            let is_time = named(&column.name).is_some() && look.never_falls && look.grows > 0.0;
            column.is_left_out |= is_time;
        }
        self.columns[at].is_left_out = true;
        self.time = Some((at, unit));
        Ok(())
    }
}

/// Columns that are both called `time_s`.
fn two_exact(columns: &[Column]) -> Vec<usize> {
    (0..columns.len())
        .filter(|at| columns[*at].name == TIME_COLUMN)
        .map(|at| at + 1)
        .collect()
}

/// Spreadsheets may begin with a line that says what separates columns.
fn asked_separator(text: &[u8]) -> (Option<u8>, usize) {
    let Some(line) = text.split(|byte| matches!(byte, b'\n' | b'\r')).next() else {
        return (None, 0);
    };
    match line.trim_ascii().strip_prefix(b"sep=") {
        Some([separator]) => (Some(*separator), line.len()),
        // A tab would be trimmed.
        Some([]) => (Some(b'\t'), line.len()),
        _ => (None, 0),
    }
}

/// How much of the text is a table with this separator. Words count against it, and so does a
/// single column.
fn score(lines: &[HeadLine]) -> f64 {
    let width = usual_width(lines);
    let rows = lines
        .iter()
        .filter(|line| line.cells.len() == width && line.is_data());
    let sum: f64 = rows
        .map(|line| 1.0 - 1.5 * line.count(Kind::Text) as f64 / width as f64)
        .sum();
    if width > 1 {
        1.0 + sum
    } else {
        sum / (1.0 + sum)
    }
}

/// The number of cells that most rows have.
fn usual_width(lines: &[HeadLine]) -> usize {
    let mut counts = std::collections::BTreeMap::new();
    for line in lines.iter().filter(|line| line.is_data()) {
        *counts.entry(line.cells.len()).or_insert(0) += 1;
    }
    let most = counts.into_iter().max_by_key(|(_, rows)| *rows);
    most.map_or(0, |(width, _)| width)
}

/// The first row: a line with a word where most others have numbers gives names, or belongs to a
/// preamble.
fn first_row(lines: &[HeadLine], width: usize) -> Option<usize> {
    let ends = lines.iter().rposition(HeadLine::ends_header);
    let begin = ends.map_or(0, |end| end + 1);
    let may_be = |line: &&HeadLine| line.is_data() && line.cells.len() == width;
    let has_numbers = (0..width).map(|at| {
        let all = lines[begin..].iter().filter(may_be);
        let (words, others): (Vec<Kind>, _) = all
            .map(|line| line.kinds[at])
            .filter(|kind| *kind != Kind::Missing)
            .partition(|kind| *kind == Kind::Text);
        others.len() >= words.len().max(1)
    });
    let has_numbers: Vec<bool> = has_numbers.collect();
    let is_row = |line: &HeadLine| {
        let mut cells = line.kinds.iter().zip(&has_numbers);
        !cells.any(|(kind, has_numbers)| *has_numbers && *kind == Kind::Text)
    };
    (begin..lines.len()).find(|at| may_be(&&lines[*at]) && is_row(&lines[*at]))
}

/// The rows among the first lines.
fn rows(lines: &[HeadLine], first: usize) -> impl Iterator<Item = &HeadLine> {
    let width = lines[first].cells.len();
    lines[first..]
        .iter()
        .filter(move |line| line.cells.len() == width && line.is_data())
}

fn no_rows(lines: &[HeadLine]) -> Refused {
    let line = lines.last().map(|line| line.number);
    let why = match lines {
        [one] if one.count(Kind::Text) > 0 => "no data after the header",
        _ => "no line with more numbers than words: this is no table of samples",
    };
    Refused::new(line, why)
}
