//! Overview of a recording: its touches, and every channel over the whole length, thinned to the
//! columns of a screen.

use crate::harmonics::{Frequencies, Reading, powers};
use crate::part::{Part, Selection, columns};
use crate::samples::Samples;
use crate::tables::date;
use crate::touch_part;
use crate::touch_times::Touches;
use anyhow::{Result, ensure};
use serde::Serialize;
use std::f64::consts::TAU;

/// All rows of a recording, in memory.
pub struct Recorded {
    names: Vec<String>,
    units: Vec<Option<String>>,
    is_dated: bool,
    times_s: Vec<f64>,
    /// Values by column; NaN stands for a missing reading.
    columns: Vec<Vec<f64>>,
    /// Median of each column.
    levels: Vec<f64>,
    touches: Touches,
}

/// Thinned rows of a part. For each step, each column has its minimum and maximum, in the order in
/// which they occurred.
#[derive(Debug, Serialize)]
pub struct Overview<'a> {
    names: &'a [String],
    units: &'a [Option<String>],
    /// True if times are seconds since 1970.
    is_dated: bool,
    rows: usize,
    /// Mean rate of the rows, hertz.
    rate_hz: f64,
    /// Times of the first and last row of the recording, seconds.
    from_s: f64,
    until_s: f64,
    touches: &'a Touches,
    /// Level of each channel, to which `values` are relative.
    levels: &'a [f64],
    t_s: Vec<f64>,
    values: Vec<Vec<Option<f32>>>,
}

/// Numbers of columns and frequencies in a spectrogram.
const COLUMNS: usize = 240;
const BINS: usize = 96;

/// Maximum number of channels that a spectrogram averages.
const CHANNELS: usize = 16;

/// Number of the darkest shade in a spectrogram, and the range of all shades, decibels.
const SHADES: u8 = 7;
pub const RANGE_DB: f64 = 35.0;

/// Power over time and frequency, in shades.
#[derive(Clone, Debug, Serialize)]
pub struct Spectrogram {
    pub from_s: f64,
    pub until_s: f64,
    pub max_hz: f64,
    /// Length of the windows, seconds.
    pub window_s: f64,
    /// Columns of equal width from `from_s` to `until_s`. Each has shades from 0 to 7 (most power)
    /// at equal steps of frequency from 0 to `max_hz`.
    pub levels: Vec<Vec<u8>>,
}

/// Converts powers to shades. The highest shade starts near the 99.5th percentile of all powers.
fn levels(decibels: &[Vec<f64>]) -> Vec<Vec<u8>> {
    let mut all: Vec<f64> = decibels.iter().flatten().copied().collect();
    all.retain(|db| db.is_finite());
    all.sort_by(f64::total_cmp);
    let top = all.get(all.len() * 995 / 1000).copied().unwrap_or(0.0);
    let shade = |db: &f64| {
        let fraction = 1.0 + (db - top) / RANGE_DB;
        (f64::from(SHADES) * fraction.clamp(0.0, 1.0)).round() as u8
    };
    let column = |column: &Vec<f64>| column.iter().map(shade).collect();
    decibels.iter().map(column).collect()
}

impl Recorded {
    /// Reads all rows. Fails if they take more than `max_bytes`.
    pub fn read(samples: &Samples, selection: &Selection, max_bytes: usize) -> Result<Self> {
        let mut rows = samples.open()?;
        let chosen = columns(&*rows, selection)?;
        let row_bytes = size_of::<f64>() * (1 + rows.names().len());
        let max = max_bytes / row_bytes;
        let part = Part::read(&mut *rows, selection, max, &mut |_| {})?;
        ensure!(
            part.rows() > 1,
            "{}: one row alone has no rate and no tone",
            samples.name()
        );
        let columns: Vec<Vec<f64>> = chosen
            .iter()
            .map(|at| part.column(*at).into_owned())
            .collect();
        let units = rows.units();
        Ok(Self {
            names: chosen.iter().map(|at| rows.names()[*at].clone()).collect(),
            units: chosen.iter().map(|at| units[*at].clone()).collect(),
            is_dated: rows.is_dated() && date(part.times_s[0]).is_some(),
            levels: columns.iter().map(|values| middle(values)).collect(),
            // Treat files of other instruments, and files without a rate, as having no touches.
            touches: touch_part::touches(samples, selection).unwrap_or_default(),
            times_s: part.times_s,
            columns,
        })
    }

    /// Returns the times of the first and last row, seconds.
    pub fn ends_s(&self) -> (f64, f64) {
        (self.times_s[0], self.times_s[self.times_s.len() - 1])
    }

    /// Returns the mean rate of the rows, hertz.
    pub fn rate_hz(&self) -> f64 {
        let (from_s, until_s) = self.ends_s();
        (self.times_s.len() - 1) as f64 / (until_s - from_s)
    }

    /// Computes the mean power of the channels over time and frequency, from windows of at most
    /// `window_s`.
    pub fn spectrogram(&self, window_s: f64, max_hz: f64) -> Spectrogram {
        let (from_s, until_s) = self.ends_s();
        let step_hz = max_hz / BINS as f64;
        // In a longer window, a line between two frequencies would be too narrow to be seen.
        let window_s = window_s.min(1.0 / step_hz).min(until_s - from_s);
        let apart_s = (until_s - from_s) / COLUMNS as f64;
        let frequencies = Frequencies {
            first: 0.5 * step_hz,
            step: step_hz,
            count: BINS,
        };
        let mut decibels: Vec<Vec<f64>> = Vec::new();
        for column in 0..COLUMNS {
            let middle_s = from_s + (column as f64 + 0.5) * apart_s;
            let begin = self
                .times_s
                .partition_point(|t_s| *t_s < middle_s - 0.5 * window_s);
            let end = self
                .times_s
                .partition_point(|t_s| *t_s <= middle_s + 0.5 * window_s);
            // Draw nothing where half of the rows or more are missing.
            let is_full = (end - begin) as f64 > 0.5 * window_s * self.rate_hz();
            let mut power = vec![0.0; BINS];
            for values in self.columns.iter().take(if is_full { CHANNELS } else { 0 }) {
                let part = &values[begin..end];
                let known = part.iter().filter(|value| !value.is_nan());
                let (sum, count) = known.fold((0.0, 0.0), |(sum, n), v| (sum + v, n + 1.0));
                let mean = sum / f64::max(count, 1.0);
                let readings = part.iter().zip(&self.times_s[begin..end]);
                let readings = readings.filter(|(value, _)| !value.is_nan());
                let readings = readings.map(|(value, t_s)| {
                    let turn = TAU * (t_s - middle_s) / window_s;
                    Reading {
                        at: t_s - middle_s,
                        value: (value - mean) * (0.5 + 0.5 * turn.cos()),
                    }
                });
                for (power, found) in power.iter_mut().zip(powers(readings, frequencies)) {
                    *power += found;
                }
            }
            decibels.push(power.iter().map(|power| 10.0 * power.log10()).collect());
        }
        Spectrogram {
            from_s,
            until_s,
            max_hz,
            window_s,
            levels: levels(&decibels),
        }
    }

    pub fn contacts(&self) -> usize {
        self.touches.contacts_s.len()
    }

    /// Thins the rows between two times, plus one row at either end, to at most `steps` steps.
    pub fn overview(&self, from_s: f64, until_s: f64, steps: usize) -> Overview<'_> {
        let begin = self.times_s.partition_point(|t_s| *t_s < from_s);
        let end = self.times_s.partition_point(|t_s| *t_s <= until_s);
        let rows = begin.saturating_sub(1)..(end + 1).min(self.times_s.len());
        let length = rows.len().div_ceil(steps.max(1)).max(1);
        // With one or two rows per step there is nothing to thin.
        let length = if length <= 2 { 1 } else { length };
        let starts: Vec<usize> = rows.clone().step_by(length).collect();
        let step_of = |start: &usize| *start..(*start + length).min(rows.end);
        let last = self.times_s.len() - 1;
        let t_s = starts.iter().flat_map(|start| {
            let step = step_of(start);
            let second = (step.len() > 1).then(|| self.times_s[start + step.len() / 2]);
            [self.times_s[*start]].into_iter().chain(second)
        });
        let values = self
            .columns
            .iter()
            .zip(&self.levels)
            .map(|(column, level)| {
                let relative = |value: f64| (!value.is_nan()).then_some((value - level) as f32);
                let thinned = starts.iter().flat_map(|start| {
                    let step = step_of(start);
                    let [first, second] = extremes(&column[step.clone()]);
                    let second = (step.len() > 1).then(|| relative(second));
                    [relative(first)].into_iter().chain(second)
                });
                thinned.collect()
            });
        Overview {
            names: &self.names,
            units: &self.units,
            is_dated: self.is_dated,
            rows: self.times_s.len(),
            rate_hz: self.rate_hz(),
            from_s: self.times_s[0],
            until_s: self.times_s[last],
            touches: &self.touches,
            levels: &self.levels,
            t_s: t_s.collect(),
            values: values.collect(),
        }
    }
}

/// Returns the minimum and maximum in the order in which they occur; NaN if there is no value.
fn extremes(values: &[f64]) -> [f64; 2] {
    let known = || {
        values
            .iter()
            .enumerate()
            .filter(|(_, value)| !value.is_nan())
    };
    let min = known().min_by(|a, b| a.1.total_cmp(b.1));
    let max = known().max_by(|a, b| a.1.total_cmp(b.1));
    match (min, max) {
        (Some((at, min)), Some((later, max))) if at <= later => [*min, *max],
        (Some((_, min)), Some((_, max))) => [*max, *min],
        _ => [f64::NAN; 2],
    }
}

/// Returns the median; 0 if there is no value.
fn middle(values: &[f64]) -> f64 {
    let mut known: Vec<f64> = values.iter().copied().filter(|v| !v.is_nan()).collect();
    if known.is_empty() {
        return 0.0;
    }
    let at = known.len() / 2;
    *known.select_nth_unstable_by(at, f64::total_cmp).1
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Arc;

    /// Asserts that thinning keeps every spike and adds no value, for any number of steps.
    #[test]
    fn thinned_rows_keep_the_extremes_of_every_step() {
        let value = |row: usize, column: usize| match (row, column) {
            (4321, 0) => 900.0,
            (777, 1) => f64::NAN,
            _ => 1e6 + ((row * 7919 + column) % 101) as f64,
        };
        let samples = Samples::array(
            "rows",
            vec!["a".into(), "b".into()],
            10_000,
            Arc::new(value),
            Some(Arc::new(|row| 5.0 + 0.001 * row as f64)),
        );
        let selection = Selection::default();
        let recorded = Recorded::read(&samples, &selection, 1 << 20).expect("rows");
        for (from_s, until_s, steps) in [
            (5.0, 20.0, 300),
            (9.0, 9.9, 50),
            (9.3, 9.35, 1000),
            (5.0, 20.0, 1),
        ] {
            let thin = recorded.overview(from_s, until_s, steps);
            let inside = thin
                .t_s
                .iter()
                .all(|t_s| (from_s..=until_s + 0.01).contains(t_s));
            assert!(inside || from_s > 5.0, "{from_s}");
            assert!(thin.t_s.len() <= 2 * steps.max(60), "{}", thin.t_s.len());
            assert!(thin.t_s.is_sorted() && thin.values[0].len() == thin.t_s.len());
            let min = thin.values[0]
                .iter()
                .flatten()
                .copied()
                .fold(f32::MAX, f32::min);
            assert!((f64::from(min) + thin.levels[0] - 900.0).abs() < 0.1);
        }
        let near = recorded.overview(5.776, 5.778, 100);
        assert_eq!(
            near.values[1]
                .iter()
                .filter(|value| value.is_none())
                .count(),
            1
        );
        let why = Recorded::read(&samples, &selection, 1 << 17).err();
        assert!(why.is_some_and(|why| why.to_string().contains("at most")));
    }
}
