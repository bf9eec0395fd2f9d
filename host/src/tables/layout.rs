//! Finds the layout of a table from its first lines: separator, preamble, header, units, columns.

use super::cells::{Kind, Numbers, kind};
use super::clock_time::{ClockTime, DAY_S, WORDS_MAX};
use super::head_line::{HeadLine, LineEnds, lines};
use super::header::{COMMENT, names, unit_row};
use super::look::{Look, growing, is_counter};
use super::preamble::{Stated, stated};
use super::refused::Refused;
use super::stamps::{TICKS_PER_SECOND, Unit};
use super::time_column::{
    Candidate, Likeness, Named, SplitTime, TIME_COLUMN, TimeColumn, UNITS, choose, listed, named,
    quoted,
};
use super::units::{
    Declared, bracketed, declared_time, is_count, is_unit, meanings, of_channel, per_second,
};
use super::wrapped::is_wrapped;
use crate::digits::significant;
use ridgetone_proto::settings::TAXELS;

/// Separators in the order of preference. A space stands for any white space.
const SEPARATORS: [u8; 5] = [b',', b';', b'\t', b' ', b'|'];

/// Columns of estimates that `export` writes; they are not samples.
const ESTIMATE_COLUMNS: [&str; 2] = ["frequency_hz", "sigma_hz"];

#[derive(Clone, Debug)]
pub struct Column {
    pub name: String,
    /// Unit, from the name or the row of units.
    pub unit: Option<String>,
    /// True if the column is not a channel: it has words, row numbers or times, or neither a name
    /// nor values.
    pub is_left_out: bool,
}

#[derive(Clone, Debug)]
pub struct Layout {
    pub separator: u8,
    pub columns: Vec<Column>,
    /// Byte and line at which the first row begins, including blank lines before it.
    pub byte: usize,
    pub line: u64,
    pub ends: LineEnds,
    /// Number of lines before `byte`.
    pub lines_before: u64,
    /// Line of the header, if there is one.
    pub header_line: Option<u64>,
    /// Time column, if there is one, and its unit; `None` if the unit is unknown.
    pub time: Option<(usize, Option<Unit>)>,
    /// Fraction of the time's seconds, if another column has it.
    pub fraction: Option<SplitTime>,
    /// Column that looks most like a time despite its name, and plausible units, best first.
    pub likely_time: Option<(usize, Vec<&'static str>)>,
    /// Column that counts the rows, if there is one whose name does not say so.
    pub row_counter: Option<usize>,
    /// Rate stated in the lines above the table.
    pub stated: Option<Stated>,
    /// True if the time column or its unit was found by means of the stated rate.
    pub is_by_stated: bool,
    /// True if words with numbers, such as `x:0.12` or `[0.1`, are left out.
    pub has_marked_words: bool,
    /// Units that give a time without a unit a plausible rate, best first.
    time_units: Vec<&'static str>,
    /// True if the columns are a single series with several samples per row.
    pub is_wrapped: bool,
    /// Number of rows if there are so few, and so many columns, that each row must be a channel.
    pub transposed_rows: Option<usize>,
    /// True if lines in front of the header were skipped.
    pub has_preamble: bool,
    /// True if the unit of the time was guessed from the size of its values.
    pub is_epoch: bool,
}

impl Layout {
    /// Finds the layout from the beginning of a text. The last line may be cut off unless
    /// `is_whole`.
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
            if best.as_ref().is_none_or(|(best, ..)| score > *best) {
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
        let above = String::from_utf8_lossy(&text[..found.byte]);
        found.stated = stated(&above);
        if let Some((at, line)) = factor(&above) {
            let why = format!(
                "{line:?} above the table, as MATLAB prints it, is a factor of its values, which is not read: print the table with `format long g`, or write it with `writematrix`"
            );
            return Err(Refused::new(Some(at), why));
        }
        // Of a longer file, only the first rows are here.
        let is_all = |rows: &usize| is_whole || *rows < 3;
        found.transposed_rows = found.transposed_rows.filter(is_all);
        found.find_time(&lines, time)?;
        found.find_wrapped(&lines);
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
        let fraction = |at: usize, wanted: Kind| {
            rows.iter().filter(|line| line.kinds[at] == wanted).count() as f64 / rows.len() as f64
        };
        let units = unit_row(lines, first, header.map(|at| lines[at].number));
        let unit_row_of = |at: usize| {
            let unit = units?.cells[at].trim_matches(['(', ')', '[', ']']);
            (!unit.is_empty()).then(|| unit.to_owned())
        };
        let columns = (0..width).map(|at| {
            let name = names
                .as_ref()
                .map_or(format!("column_{}", at + 1), |names| names[at].clone());
            let is_unnamed = name.is_empty() || name == COMMENT;
            let is_empty = is_unnamed && fraction(at, Kind::Missing) == 1.0;
            let words = fraction(at, Kind::Text) + fraction(at, Kind::Clock);
            Column {
                is_left_out: is_empty || words > 0.5 || is_counter(&name, &rows, at),
                unit: of_channel(&name).or_else(|| unit_row_of(at)),
                name,
            }
        });
        let columns: Vec<Column> = columns.collect();
        let has = |name: &&str| columns.iter().any(|column| column.name == **name);
        if ESTIMATE_COLUMNS.iter().all(has) {
            let why = "these are estimates, not samples: give the recording that they come from";
            return Err(Refused::new(None, why));
        }
        if let Some(at) = (0..width).find(|at| names_values(&rows, *at)) {
            let name = &columns[at].name;
            let example = &rows[0].cells[at];
            let why = format!(
                "rows of several sources follow one another, named in column {name}: choose one; in Python, d = pandas.read_csv(FILE); ridgetone.fit(d[d[{name:?}] == {example:?}])"
            );
            return Err(Refused::new(header.map(|at| lines[at].number), why));
        }
        if separator == b',' && header.is_none() && has_split_decimals(&rows) {
            let why = "decimals follow commas, which also separate the columns: write points, or separate columns by semicolons";
            return Err(Refused::new(Some(lines[first].number), why));
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
            fraction: None,
            likely_time: None,
            row_counter: None,
            stated: None,
            is_by_stated: false,
            has_marked_words: has_marked_words(&rows),
            time_units: Vec::new(),
            is_wrapped: false,
            transposed_rows: Some(rows.len()).filter(|rows| *rows <= TAXELS && width > 8 * TAXELS),
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
        // Compare bytes, not line numbers, which may repeat if line ends are mixed.
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
        let names: Vec<&str> = (self.columns.iter())
            .map(|column| column.name.as_str())
            .collect();
        let split = SplitTime::find(&names, &looks);
        let is_split = |at: usize| split.is_some_and(|split| split.has(at));
        let (at, declared) = match wanted {
            Some(TimeColumn::Nothing) => return Ok(()),
            Some(TimeColumn::Named(name, unit)) => {
                let Some(at) = find_named(&names, name) else {
                    return refuse(format!("no column {name}; there are: {}", listed(&names)));
                };
                let declared = unit.map_or_else(|| declared_time(names[at]), Declared::PerSecond);
                (at, declared)
            }
            None => {
                if let [first, second] = two_exact(&self.columns)[..] {
                    return refuse(format!(
                        "columns {first} and {second} are both called {TIME_COLUMN}"
                    ));
                }
                match (choose(&candidates(&names, &looks, &unit_at)), split) {
                    (Ok(Some(found)), _) if !is_split(found.at) => (found.at, found.named.unit),
                    (Ok(_), Some(split)) => (split.seconds, Declared::PerSecond(1.0)),
                    (Ok(_), None) => {
                        self.look_for_likely(&looks);
                        return Ok(());
                    }
                    (Err(all), Some(split)) if all.iter().all(|at| split.has(*at)) => {
                        (split.seconds, Declared::PerSecond(1.0))
                    }
                    (Err(all), _) => {
                        let all: Vec<&str> = all.iter().map(|at| names[*at]).collect();
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
        let name = names[at].to_owned();
        if look.falls {
            return refuse(format!(
                "column {name} goes back in time from row to row: sort the rows; in Python, ridgetone.fit(pandas.read_csv(FILE).sort_values({name:?}))"
            ));
        }
        if look.is_clock && rows.iter().all(|row| ends_in_video_frames(&row.cells[at])) {
            // Their number a second is not known.
            self.columns[at].is_left_out = true;
            return Ok(());
        }
        let unit = match declared {
            _ if look.is_clock => Some(Unit::Clock),
            Declared::PerSecond(unit) => Some(Unit::PerSecond(unit)),
            Declared::Unknown(unit) => {
                return refuse(format!(
                    "column {name}: the unit {unit:?} is not known: {}",
                    way_to_unit(&name, &unit, look)
                ));
            }
            Declared::Nothing => self.undeclared_unit(&name, look, unit_at(at))?,
        };
        self.fraction =
            split.filter(|split| at == split.seconds && unit == Some(Unit::PerSecond(1.0)));
        if wanted.is_none()
            && self.fraction.is_none()
            && let Some(unit) = unit
        {
            self.check_clocks(&looks, at, unit)?;
        }
        // Other columns of times are not channels.
        for column in split
            .iter()
            .flat_map(|split| [split.seconds, split.fraction])
        {
            self.columns[column].is_left_out = true;
        }
        for (column, look) in self.columns.iter_mut().zip(&looks) {
            let is_called_so = column.name == name || named(&column.name, false).is_some();
            column.is_left_out |= is_called_so && look.never_falls && look.grows > 0.0;
        }
        let date = match (self.separator, unit) {
            (b' ', Some(Unit::Clock)) => date_columns(&rows, at),
            _ => at..at + 1,
        };
        for column in &mut self.columns[date] {
            column.is_left_out = true;
        }
        self.time = Some((at, unit));
        Ok(())
    }

    /// Finds the unit of a time whose name declares none, from the row of units, the stated rate or
    /// the size of the numbers. Returns `None` if whole numbers leave the unit open.
    fn undeclared_unit(
        &mut self,
        name: &str,
        look: &Look,
        by_unit_row: Option<f64>,
    ) -> Result<Option<Unit>, Refused> {
        let refuse = |why: String| Err(Refused::new(self.header_line, why));
        if let Some(unit) = by_unit_row {
            return Ok(Some(Unit::PerSecond(unit)));
        }
        if let Some(unit) = self
            .stated
            .as_ref()
            .and_then(|stated| unit_at_rate(look, stated.hz))
        {
            self.is_by_stated = true;
            return Ok(Some(Unit::PerSecond(unit)));
        }
        if let Some(unit) = look.epoch() {
            self.is_epoch = true;
            return Ok(Some(Unit::PerSecond(unit)));
        }
        if look.is_hhmmss {
            // A count of seconds over more than a minute would also end in 60 to 99.
            let or_seconds = match look.max - look.min > 60.0 {
                true => String::new(),
                false => format!(
                    "; or --time-column {} if it counts seconds",
                    quoted(&format!("{name}:s"))
                ),
            };
            return refuse(format!(
                "column {name} has times of day as hhmmss, as GPS receivers write them: in Python, d = pandas.read_csv(FILE); t = d.pop({name:?}); d['time_s'] = t // 10000 * 3600 + t // 100 % 100 * 60 + t % 100; ridgetone.fit(d){or_seconds}"
            ));
        }
        if look.may_be_days() {
            let option = |unit: &str| quoted(&format!("{name}:{unit}"));
            return refuse(format!(
                "column {name} begins with {}, which may be days, as Excel and MATLAB count them: say so with --time-column {}, or {} if it is in seconds",
                look.first,
                option("d"),
                option("s")
            ));
        }
        if !look.is_whole && look.step > 0.0 && look.step < 1.0 / RATE_ASKED_HZ {
            let option = quoted(&format!("{name}:s"));
            return refuse(format!(
                "column {name} without a unit would give {} rows a second: say its unit with --time-column {option}, or another of {UNITS}",
                significant(1.0 / look.step, 3)
            ));
        }
        self.time_units = plausible_units(look);
        Ok((!look.is_whole).then_some(Unit::PerSecond(1.0)))
    }

    /// Returns units that give a time without a unit a plausible rate, best first.
    pub fn plausible_units(&self) -> &[&'static str] {
        &self.time_units
    }

    /// Refuses two columns of time that run at different speeds.
    fn check_clocks(&self, looks: &[Look], at: usize, unit: Unit) -> Result<(), Refused> {
        let span_s = |look: &Look, unit: Unit| match unit {
            Unit::PerSecond(per_second) => (look.last - look.first) / per_second,
            Unit::Clock => look.last - look.first,
        };
        let chosen_s = span_s(&looks[at], unit);
        for (other, look) in looks.iter().enumerate().filter(|(other, _)| *other != at) {
            let name = &self.columns[other].name;
            let unit = match (look.is_clock, declared_time(name)) {
                (true, _) => Unit::Clock,
                (false, Declared::PerSecond(unit)) => Unit::PerSecond(unit),
                _ => continue,
            };
            if named(name, false).is_none() || !look.never_falls || look.grows < 0.5 {
                continue;
            }
            let ratio = span_s(look, unit) / chosen_s;
            if ratio.is_finite() && !(1.0 / CLOCKS_DIFFER..CLOCKS_DIFFER).contains(&ratio) {
                let chosen = &self.columns[at].name;
                let why = format!(
                    "columns {chosen} and {name} disagree: {} s and {} s for the same rows; choose one with --time-column {}",
                    significant(chosen_s, 4),
                    significant(ratio * chosen_s, 4),
                    quoted(chosen)
                );
                return Err(Refused::new(self.header_line, why));
            }
        }
        Ok(())
    }

    /// If no column is named as a time, uses one that runs at the stated rate, or notes the most
    /// likely one.
    fn look_for_likely(&mut self, looks: &[Look]) {
        let units = |at: usize, name: &str| match is_count(&name.to_lowercase()) {
            true if looks[at].epoch().is_none() => Vec::new(),
            _ => plausible_units(&looks[at]),
        };
        let mut growing = growing(looks);
        let Some(at) = growing.next() else {
            return;
        };
        let look = &looks[at];
        let hz = self.stated.as_ref().map(|stated| stated.hz);
        if let Some(unit) = hz.and_then(|hz| unit_at_rate(look, hz)) {
            self.is_by_stated = true;
            self.columns[at].is_left_out = true;
            self.time = Some((at, Some(Unit::PerSecond(unit))));
        } else if look.counts_rows() {
            self.row_counter = Some(at);
            self.columns[at].is_left_out = self.columns.len() > 1;
            // A time may follow the number of the row.
            let time = growing.find(|at| !looks[*at].counts_rows());
            self.likely_time = time.map(|at| (at, units(at, &self.columns[at].name)));
        } else {
            self.likely_time = Some((at, units(at, &self.columns[at].name)));
        }
    }

    /// Returns the columns that may have samples: all channels except a likely time.
    pub fn series(&self) -> impl Iterator<Item = usize> {
        let likely = self.likely_time.as_ref().map(|(at, _)| *at);
        let columns = self.columns.iter().enumerate();
        columns
            .filter(move |(at, column)| !column.is_left_out && Some(*at) != likely)
            .map(|(at, _)| at)
    }

    /// Detects a single series with several samples per row.
    fn find_wrapped(&mut self, lines: &[HeadLine]) {
        let first = lines
            .iter()
            .position(|line| line.byte == self.byte)
            .unwrap_or(0);
        let numbers = Numbers::new(self.separator == b',');
        let values = |line: &HeadLine| {
            let channels = self.series();
            let cells = channels.map(|at| line.cells[at].as_str());
            cells
                .map(|cell| numbers.number(cell).unwrap_or(f64::NAN))
                .collect()
        };
        let rows: Vec<Vec<f64>> = rows(lines, first).take(WRAPPED_ROWS).map(values).collect();
        self.is_wrapped = is_wrapped(&rows);
    }
}

/// Number of rows examined to detect a series with several samples per row.
const WRAPPED_ROWS: usize = 400;

/// Rate above which a time without a unit is refused, hertz.
const RATE_ASKED_HZ: f64 = 1e6;

/// Ratio of durations above which two time columns disagree.
const CLOCKS_DIFFER: f64 = 1.5;

/// Plausible rates of rows, hertz.
const PLAUSIBLE_HZ: core::ops::RangeInclusive<f64> = 1.0..=1e5;

/// Returns the columns that may be the time.
fn candidates(
    names: &[&str],
    looks: &[Look],
    unit_at: &dyn Fn(usize) -> Option<f64>,
) -> Vec<Candidate> {
    let candidate = |(at, look): (usize, &Look)| {
        let by_unit = unit_at(at).map(|per_second| Named {
            likeness: Likeness::WithUnit,
            unit: Declared::PerSecond(per_second),
        });
        let by_look = look.is_clock.then_some(Named {
            likeness: Likeness::Contains,
            unit: Declared::Nothing,
        });
        let is_steady = look.is_steady && look.grows > 0.98;
        let named = named(names[at], is_steady).or(by_unit).or(by_look)?;
        (look.is_time() || named.likeness == Likeness::Exact).then_some(Candidate {
            at,
            named,
            grows: look.grows,
        })
    };
    looks.iter().enumerate().filter_map(candidate).collect()
}

/// True if a column of words names the source of each row, and different sources take turns.
fn names_values(rows: &[&HeadLine], at: usize) -> bool {
    /// Maximum number of sources, and minimum number of rows of each.
    const SOURCES_MAX: usize = 64;
    const ROWS_MIN: usize = 4;
    if rows.iter().any(|row| row.kinds[at] != Kind::Text) {
        return false;
    }
    let mut counts = std::collections::BTreeMap::new();
    for row in rows {
        *counts.entry(row.cells[at].as_str()).or_insert(0) += 1;
    }
    let changes = rows
        .windows(2)
        .filter(|pair| pair[0].cells[at] != pair[1].cells[at]);
    (2..=SOURCES_MAX).contains(&counts.len())
        && counts.values().all(|rows| *rows >= ROWS_MIN)
        && changes.count() * 2 > rows.len()
}

/// Returns the columns whose words are one date with the time of day in column `at`, as in
/// `Sat Jan 31 12:30:05 2026`.
fn date_columns(rows: &[&HeadLine], at: usize) -> core::ops::Range<usize> {
    let ends = || (at + 1..=rows[0].cells.len().min(at + 1 + WORDS_MAX)).rev();
    let spans = (at.saturating_sub(WORDS_MAX)..=at).flat_map(|from| ends().map(move |to| from..to));
    let is_clock = |span: &core::ops::Range<usize>| {
        let mut words = rows.iter().map(|row| row.cells[span.clone()].join(" "));
        words.all(|words| ClockTime::parse(&words).is_some())
    };
    spans.clone().find(is_clock).unwrap_or(at..at + 1)
}

/// True if every second column has the decimals of the one before, as in `0,004,-1,250`.
fn has_split_decimals(rows: &[&HeadLine]) -> bool {
    let width = rows[0].cells.len();
    let is_padded = |digits: &str| digits.len() > 1 && digits.starts_with('0');
    let column = |at: usize| rows.iter().map(move |row| row.cells[at].as_str());
    let is_whole = |cell: &str| cell.parse::<i64>().is_ok() && !is_padded(cell.trim_matches('-'));
    let is_fraction = |cell: &str| cell.bytes().all(|byte| byte.is_ascii_digit());
    width.is_multiple_of(2)
        && (0..width).step_by(2).all(|at| {
            column(at).all(is_whole)
                && column(at + 1).all(is_fraction)
                && column(at + 1).any(is_padded)
        })
}

/// True if the rows have words that contain numbers, or numbers with a unit.
fn has_marked_words(rows: &[&HeadLine]) -> bool {
    let is_marked = |cell: &str| {
        let is_mark = |c: char| "[](){}=:|\"".contains(c);
        let number = cell.trim_end_matches(|c: char| !c.is_ascii_digit());
        let has_unit = kind(number, false) == Kind::Number && is_unit(&cell[number.len()..]);
        has_unit || cell.contains(is_mark) && cell.contains(|c: char| c.is_ascii_digit())
    };
    let marked = rows.iter().filter(|row| {
        let mut cells = row.cells.iter().zip(&row.kinds);
        cells.any(|(cell, kind)| *kind == Kind::Text && is_marked(cell))
    });
    marked.count() * 2 > rows.len()
}

/// Finds a column by its name; a unit in brackets may be omitted.
fn find_named(names: &[&str], name: &str) -> Option<usize> {
    let exact = names.iter().position(|known| *known == name);
    exact.or_else(|| {
        let without = |known: &&str| bracketed(known).is_some_and(|(before, _)| before == name);
        names.iter().position(without)
    })
}

/// Units of time, with the number of each per second.
const TIME_UNITS: [(&str, f64); 8] = [
    ("ms", 1e3),
    ("us", 1e6),
    ("s", 1.0),
    ("ns", 1e9),
    ("min", 1.0 / 60.0),
    ("h", 1.0 / 3600.0),
    ("d", 1.0 / 86_400.0),
    ("100ns", TICKS_PER_SECOND),
];

/// Finds the unit with which a column has the given rate.
fn unit_at_rate(look: &Look, hz: f64) -> Option<f64> {
    let span = look.last - look.first;
    let hz_in = |per_second: f64| (look.rows as f64 - 1.0) / (span / per_second);
    let is_at = |per_second: &f64| (hz_in(*per_second) / hz - 1.0).abs() < 0.02;
    let units = TIME_UNITS.iter().map(|(_, per_second)| *per_second);
    units
        .filter(|_| look.is_steady && look.rows > 4)
        .find(is_at)
}

/// Returns the units that give a column a plausible rate, best first. A column with decimals is
/// most likely in seconds, at an oscilloscope's rate too.
fn plausible_units(look: &Look) -> Vec<&'static str> {
    let days = || look.may_be_days().then_some(1.0 / DAY_S);
    let known = look.epoch().or_else(days);
    let is_plausible = |(unit, per_second): &&(&str, f64)| match known {
        Some(known) => known == *per_second,
        None if look.is_hhmmss || *per_second == TICKS_PER_SECOND => false,
        None => {
            let hz = per_second / look.step;
            let is_scope = *unit == "s" && !look.is_whole && hz > *PLAUSIBLE_HZ.end();
            PLAUSIBLE_HZ.contains(&hz) || is_scope
        }
    };
    let mut units: Vec<_> = TIME_UNITS.iter().filter(is_plausible).collect();
    // Nearest to the middle of the plausible rates, in tenths of a decade.
    units.sort_by_key(|(unit, per_second)| {
        let middle = 0.5 * (PLAUSIBLE_HZ.start() * PLAUSIBLE_HZ.end()).log10();
        let off = 10.0 * ((per_second / look.step).log10() - middle).abs();
        (look.is_whole || *unit != "s", off.round() as i64)
    });
    units.into_iter().map(|(unit, _)| *unit).collect()
}

/// Returns advice on what to type if the unit of a time column is unknown.
fn way_to_unit(name: &str, unit: &str, look: &Look) -> String {
    let option = |unit: &str| quoted(&format!("{name}:{unit}"));
    if per_second(unit).is_some() {
        return format!("if it is one, say so with --time-column {}", option(unit));
    }
    if is_count(unit) {
        return format!(
            "give the rate of the rows with --rate HZ, or the length of one as UNIT, such as 10us, with --time-column {}",
            option("UNIT")
        );
    }
    let mut known = meanings(unit);
    known.sort_by_key(|unit| {
        per_second(unit).is_none_or(|unit| !PLAUSIBLE_HZ.contains(&(unit / look.step)))
    });
    match &known[..] {
        [] => {}
        [one] => return format!("say so with --time-column {}", option(one)),
        [one, other, ..] => {
            return format!(
                "it may be {one} or {other}: say which with --time-column {} or --time-column {}",
                option(one),
                option(other)
            );
        }
    }
    let plausible = plausible_units(look);
    let first = plausible.first().unwrap_or(&"s");
    format!(
        "say which with --time-column {}, or another of {UNITS}",
        option(first)
    )
}

/// Returns the numbers of all columns called `time_s`.
fn two_exact(columns: &[Column]) -> Vec<usize> {
    (0..columns.len())
        .filter(|at| columns[*at].name == TIME_COLUMN)
        .map(|at| at + 1)
        .collect()
}

/// Returns the separator declared in a first line such as `sep=;`, as spreadsheets write it, and
/// the length of this line.
fn asked_separator(text: &[u8]) -> (Option<u8>, usize) {
    let Some(line) = text.split(|byte| matches!(byte, b'\n' | b'\r')).next() else {
        return (None, 0);
    };
    match line.trim_ascii().strip_prefix(b"sep=") {
        Some([separator]) => (Some(*separator), line.len()),
        // Trimming has removed a tab.
        Some([]) => (Some(b'\t'), line.len()),
        _ => (None, 0),
    }
}

/// Scores a separator by the fraction of the text that it turns into a table. Words and a single
/// column lower the score.
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

/// Returns the most frequent number of cells in a row.
fn usual_width(lines: &[HeadLine]) -> usize {
    let mut counts = std::collections::BTreeMap::new();
    for line in lines.iter().filter(|line| line.is_data()) {
        *counts.entry(line.cells.len()).or_insert(0) += 1;
    }
    let usual = counts.into_iter().max_by_key(|(_, rows)| *rows);
    usual.map_or(0, |(width, _)| width)
}

/// Finds the first row. A line with a word where most others have numbers is a header or belongs to
/// the preamble.
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

fn rows(lines: &[HeadLine], first: usize) -> impl Iterator<Item = &HeadLine> {
    let width = lines[first].cells.len();
    lines[first..]
        .iter()
        .filter(move |line| line.cells.len() == width && line.is_data())
}

fn no_rows(lines: &[HeadLine]) -> Refused {
    let line = lines.last().map(|line| line.number);
    let is_value = |line: &&HeadLine| {
        let mut parts = line.cells[0].split(':');
        parts
            .next()
            .is_some_and(|name| name.len() > 1 && name.starts_with('>'))
            && parts.next().is_some()
    };
    let why = match lines {
        [one] if one.count(Kind::Text) > 0 => "no data after the header",
        _ if lines.iter().filter(is_value).count() * 2 > lines.len() => {
            "a value a line, as Teleplot has it: a row must have them all; in Python, d = pandas.read_csv(FILE, sep='[>:]', engine='python', names=['_', 'name', 'time_ms', 'value']); ridgetone.fit(d[d['name'] == NAME][['time_ms', 'value']])"
        }
        _ => {
            "no line with more numbers than words: this is no table of samples; other forms go through Python: ridgetone.fit(pandas.DataFrame({'time_s': ..., 'a': ...}))"
        }
    };
    Refused::new(line, why)
}

/// True for a time code such as `10:00:00:05`. A fraction of a second usually has three digits,
/// sometimes one.
fn ends_in_video_frames(cell: &str) -> bool {
    let parts: Vec<&str> = cell.split(':').collect();
    let are_numbers = cell.chars().all(|c| c.is_ascii_digit() || c == ':');
    are_numbers && parts.len() == 4 && parts[3].len() == 2
}

/// Returns the factor line that MATLAB prints above a table, such as `1.0e+03 *`, and its number.
fn factor(above: &str) -> Option<(u64, &str)> {
    let is_factor = |line: &str| {
        let number = line.strip_suffix('*').map(str::trim);
        number.is_some_and(|number| number.parse::<f64>().is_ok())
    };
    let mut lines = (1..).zip(above.lines().map(str::trim));
    lines.find(|(_, line)| is_factor(line))
}
