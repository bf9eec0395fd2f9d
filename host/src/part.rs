//! The part of a table that is used. Rows are read up to the end of the part, and only rows in the
//! part are kept.

use crate::alignment::Alignment;
use crate::speed::Column;
use crate::tables::{PROGRESS_ROWS, RowReader, Timing, ValueAt, bracketed, check_order, listed};
use crate::usage::UsageError;
use anyhow::{Result, bail, ensure};
use clap::ValueEnum;
use hal_mock::escaped;
use ridgetone_proto::settings::Declared;
use std::borrow::Cow;
use std::ops::RangeInclusive;

/// Rows and columns to fit, and options of the fit.
#[derive(Clone, Debug, Default)]
pub struct Selection {
    /// Rows per second; needed if the file has no `time_s`.
    pub rate_hz: Option<f64>,
    /// First time to use, seconds: `time_s`, or row / rate if the file has no `time_s`.
    pub from_s: Option<f64>,
    pub to_s: Option<f64>,
    /// Columns to use: names, numbers or ranges of numbers; all columns if empty.
    pub columns: Vec<String>,
    /// Maximum number of harmonics including the fundamental, 1 to 5; `None` means 5.
    pub harmonics: Option<u8>,
    /// Column of positions or speeds, for a fit in the spatial domain.
    pub position: Option<Column>,
    /// Skew and delay of the positions, if they come from a separate file.
    pub alignment: Option<Alignment>,
    pub interferer_hz: Option<f64>,
    /// Frequencies to search for the tone.
    pub band: Band,
    /// Other signals in the rows, next to the tone.
    pub declared: Declared,
}

impl Selection {
    /// Returns the position or speed column with its full name.
    pub fn position_in(&self, names: &[String]) -> Option<Column> {
        let position = self.position.clone();
        position.map(|column| column.resolved(names))
    }
}

/// Parts of the default scene that can be excluded.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Exclude {
    /// The tone is a single sine, whatever --harmonics says.
    Overtones,
    /// Levels have a slope alone.
    CurvedBaseline,
    /// Noise is white.
    ColouredNoise,
    /// Noise is independent between channels.
    SharedNoise,
    /// No single value is far off.
    Impulses,
    /// All of these: the lean scene, whose fit is the fastest.
    All,
}

impl Exclude {
    /// Finds a part by its name. Words may be joined by `-` or `_`.
    pub fn named(name: &str) -> Result<Self, UsageError> {
        Self::from_str(&name.replace('_', "-"), false).map_err(|_| {
            let all = Self::value_variants().iter();
            let names =
                all.filter_map(|known| Some(known.to_possible_value()?.get_name().to_owned()));
            let names = names.collect::<Vec<_>>().join(", ");
            UsageError(format!(
                "--exclude {}: must be one of {names}",
                escaped(name)
            ))
        })
    }

    /// Excludes the part from the declared scene.
    pub fn leave_out(self, declared: &mut Declared) {
        let place = match self {
            Self::Overtones => &mut declared.overtones,
            Self::CurvedBaseline => &mut declared.curved_baseline,
            Self::ColouredNoise => &mut declared.coloured_noise,
            Self::SharedNoise => &mut declared.shared_noise,
            Self::Impulses => &mut declared.impulses,
            Self::All => {
                let all = Self::value_variants().iter();
                all.filter(|other| **other != Self::All)
                    .for_each(|other| other.leave_out(declared));
                return;
            }
        };
        *place = false;
    }
}

/// Bounds of a frequency, hertz.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Band {
    pub min_hz: Option<f64>,
    pub max_hz: Option<f64>,
}

impl Band {
    /// Creates a band. Fails if the bounds are not in ascending order.
    pub fn new(min_hz: Option<f64>, max_hz: Option<f64>) -> Result<Self, UsageError> {
        match (min_hz, max_hz) {
            (Some(min_hz), Some(max_hz)) if min_hz >= max_hz => Err(UsageError(format!(
                "--min-hz {min_hz} is not below --max-hz {max_hz}"
            ))),
            _ => Ok(Self { min_hz, max_hz }),
        }
    }

    /// True if there is no bound.
    pub fn is_open(&self) -> bool {
        *self == Self::default()
    }
}

#[derive(Default)]
pub struct Part {
    /// Number of rows of the file before this part.
    pub before: u64,
    /// Times of the rows, seconds: from their stamps, or from the given rate.
    pub times_s: Vec<f64>,
    pub is_stamped: bool,
    values: Values,
}

/// Values of the rows; NaN stands for a missing reading.
enum Values {
    /// Copied, by column.
    Read(Vec<Vec<f64>>),
    /// Not copied: the caller has them in memory.
    InMemory(ValueAt),
}

impl Default for Values {
    fn default() -> Self {
        Self::Read(Vec::new())
    }
}

/// Adds a row's values to their columns.
pub fn push_row(columns: &mut [Vec<f64>], row: &[f64]) {
    for (column, value) in columns.iter_mut().zip(row) {
        column.push(*value);
    }
}

impl Part {
    /// Creates a part from rows that were already read; `columns` has the values by column.
    pub fn of_rows(before: u64, times_s: Vec<f64>, columns: Vec<Vec<f64>>) -> Self {
        Self {
            before,
            times_s,
            is_stamped: true,
            values: Values::Read(columns),
        }
    }

    /// Reads the columns that the selection uses, at most `most` rows. `progress` is called with
    /// the number of rows read so far.
    pub fn read(
        rows: &mut dyn RowReader,
        selection: &Selection,
        max: usize,
        progress: &mut dyn FnMut(u64),
    ) -> Result<Self> {
        let file = rows.file().to_owned();
        let (from_s, to_s) = (
            selection.from_s.unwrap_or(f64::NEG_INFINITY),
            selection.to_s.unwrap_or(f64::INFINITY),
        );
        ensure!(
            from_s < to_s,
            "{file}: --from {from_s} s is not before --to {to_s} s"
        );
        let mut part = Self::default();
        let (mut read, mut begin_s, mut last_s) = (0u64, 0.0, 0.0);
        let mut is_whole = true;
        let (mut values, in_memory) = (Vec::new(), rows.in_memory());
        let mut kept = vec![Vec::new(); rows.names().len()];
        let mut used = columns(rows, selection)?;
        if let Some(position) = selection.position_in(rows.names()) {
            let at = named(rows, position.name()).ok();
            used.extend(at.filter(|at| !used.contains(at)));
        }
        // Rows after the part are not read: they may belong to a different recording.
        while (read == 0 || last_s < to_s) && rows.advance()? {
            let stamp_s = rows.time_s();
            part.is_stamped = stamp_s.is_some();
            let t_s = match stamp_s {
                Some(t_s) => t_s,
                None => read as f64 / given_rate_hz(rows, selection)?,
            };
            if read == 0 {
                begin_s = t_s;
            } else if selection.rate_hz.is_none() {
                let spacing_s = (last_s - begin_s) / (read - 1).max(1) as f64;
                if t_s <= last_s && last_s + spacing_s > to_s {
                    is_whole = false;
                    break;
                }
                check_order(rows, last_s, t_s)?;
            }
            if t_s > to_s {
                is_whole = false;
                break;
            }
            last_s = t_s;
            read += 1;
            if read % PROGRESS_ROWS == 0 {
                progress(read);
            }
            if t_s < from_s {
                part.before += 1;
                continue;
            }
            ensure!(
                part.rows() < max,
                "{file}: {} rows or more in the window, at most {max} can be taken: choose a part with --from and --to",
                max + 1
            );
            // Called even for values in memory, because it refuses values that are not finite.
            rows.values(&mut values)?;
            if in_memory.is_none() {
                used.iter().for_each(|at| kept[*at].push(values[*at]));
            }
            part.times_s.push(t_s);
        }
        is_whole &= last_s < to_s;
        // A row lasts for one mean interval.
        let lasts_s = if read > 1 {
            1.001 * (last_s - begin_s) / (read - 1) as f64
        } else {
            0.0
        };
        let data = match is_whole {
            true => format!("the data goes from {begin_s} to {last_s} s"),
            false => format!("the data begins at {begin_s} s"),
        };
        let is_late = from_s > last_s && is_whole;
        let is_early = from_s < begin_s - lasts_s && selection.from_s.is_some();
        ensure!(
            !is_early && !is_late,
            "{file}: --from {from_s} s is outside the data: {data}"
        );
        let is_beyond = is_whole && to_s > last_s + lasts_s && selection.to_s.is_some();
        ensure!(
            read > 0 && !is_beyond,
            "{file}: --to {to_s} s is outside the data: {data}"
        );
        ensure!(part.rows() > 0, "{file}: no row from {from_s} to {to_s} s");
        part.values = in_memory.map_or(Values::Read(kept), Values::InMemory);
        Ok(part)
    }

    pub fn rows(&self) -> usize {
        self.times_s.len()
    }

    /// Returns a value by its row in the part and its column.
    pub fn value(&self, row: usize, column: usize) -> f64 {
        match &self.values {
            Values::Read(columns) => columns[column][row],
            Values::InMemory(value_at) => value_at(self.before as usize + row, column),
        }
    }

    pub fn column(&self, column: usize) -> Cow<'_, [f64]> {
        match &self.values {
            Values::Read(columns) => Cow::Borrowed(&columns[column]),
            Values::InMemory(value_at) => {
                let rows = self.before as usize..self.before as usize + self.rows();
                rows.map(|row| value_at(row, column)).collect()
            }
        }
    }
}

/// Returns the rate of rows without time stamps. Fails if no rate was given.
pub fn given_rate_hz(rows: &dyn RowReader, selection: &Selection) -> Result<f64> {
    match (selection.rate_hz, rows.timing()) {
        (Some(rate_hz), _) => Ok(rate_hz),
        (None, Timing::Absent(why) | Timing::Unclear(why)) => bail!("{}: {why}", rows.file()),
        (None, Timing::Stamped) => bail!("{}: a row has no time", rows.file()),
    }
}

pub fn named(rows: &dyn RowReader, name: &str) -> Result<usize> {
    named_in(rows.file(), rows.names(), name)
}

/// Returns the index of a column among the names in a file.
pub fn named_in(file: &str, names: &[String], name: &str) -> Result<usize> {
    let without_unit = || {
        let is_it = |at: &usize| bracketed(&names[*at]).is_some_and(|(before, _)| before == name);
        (0..names.len()).filter(is_it).collect::<Vec<usize>>()
    };
    let mut all = all_named(names, name);
    if all.is_empty() {
        all = without_unit();
    }
    match all[..] {
        [] => bail!("{file}: no column {name}; there are: {}", listed(names)),
        [at] => Ok(at),
        _ => bail!("{file}: more than one column is called {name}: give them other names"),
    }
}

fn all_named(names: &[String], name: &str) -> Vec<usize> {
    (0..names.len()).filter(|at| names[*at] == name).collect()
}

/// Returns the indices of the columns to use. A name selects all columns that have it. Columns may
/// also be given by number, from 1, or as a range of numbers: `3-8`.
pub fn columns(rows: &dyn RowReader, selection: &Selection) -> Result<Vec<usize>> {
    let file = rows.file();
    let mut columns = Vec::new();
    for name in &selection.columns {
        let mut all = all_named(rows.names(), name);
        if all.is_empty() {
            all = match range(name) {
                Some(range) => numbered(rows, name, range)?,
                None => vec![named(rows, name)?],
            };
        }
        ensure!(
            all.iter().all(|at| !columns.contains(at)),
            "{file}: --columns names {name} twice"
        );
        columns.extend(all);
    }
    if selection.columns.is_empty() {
        let position = selection.position_in(rows.names());
        let position = position.as_ref().map(Column::name);
        columns = (0..rows.names().len())
            .filter(|at| Some(rows.names()[*at].as_str()) != position)
            .collect();
    }
    Ok(columns)
}

/// Parses column numbers: `5` or `3-8`.
fn range(text: &str) -> Option<RangeInclusive<usize>> {
    let (from, to) = text.split_once('-').unwrap_or((text, text));
    Some(from.trim().parse().ok()?..=to.trim().parse().ok()?)
}

/// Returns the indices of the columns with these numbers in the file. A range skips columns that
/// are not channels.
fn numbered(rows: &dyn RowReader, text: &str, range: RangeInclusive<usize>) -> Result<Vec<usize>> {
    let numbers = rows.numbers();
    let is_in = |at: &usize| range.contains(&numbers[*at]);
    let found: Vec<usize> = (0..numbers.len()).filter(is_in).collect();
    let last = numbers.last().copied().unwrap_or(0);
    let is_inside = *range.start() > 0 && range.start() <= range.end() && *range.end() <= last;
    if found.is_empty() || !is_inside {
        let shown = numbers.iter().zip(rows.names());
        let shown: Vec<String> = shown
            .map(|(number, name)| format!("{number} {name}"))
            .collect();
        bail!(
            "{}: no columns {text}; there are: {}",
            rows.file(),
            listed(&shown)
        );
    }
    Ok(found)
}
