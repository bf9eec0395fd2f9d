//! The channels of a fit: readings, the fitted tone with its harmonics, and what is left.

use crate::grid::Grid;
use crate::harmonics::{self, about_line};
use crate::part::{Part, columns, named};
use crate::samples::Samples;
use crate::table_fit::{Selection, TableFit};
use crate::tone::Domain;
use anyhow::{Result, anyhow};

/// Periods in the close-up.
const CLOSE_PERIODS: f64 = 4.0;

/// Points of the fitted curve in the close-up.
const CURVE_POINTS: usize = 160;

/// Counted events differ by chance if they differ by less, in standard deviations.
const BY_CHANCE: f64 = 3.0;

/// Two values of one axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Range {
    pub from: f64,
    pub to: f64,
}

impl Range {
    pub fn contains(&self, at: f64) -> bool {
        (self.from..=self.to).contains(&at)
    }
}

/// What was fitted.
pub struct Fitted {
    /// Horizontal coordinate of each row: seconds in the time of the recording, or millimetres from the first
    /// row.
    pub at: Vec<f64>,
    /// Rows over their length: a second, or a millimetre.
    pub density: f64,
    /// A few periods around the middle; none without a tone.
    pub close: Option<Range>,
    pub channels: Vec<Channel>,
}

/// A channel. Values are from its first reading on, in units of its span.
pub struct Channel {
    pub name: String,
    /// Readings at the rows; none where they are missing.
    pub readings: Vec<Option<f32>>,
    /// What the fit leaves of them, zero where they are missing; none without a tone.
    pub residual: Option<Vec<f64>>,
    /// The fitted curve in the close-up, with its horizontal coordinates.
    pub curve: Vec<(f64, f64)>,
    /// Share of the readings' variance about their straight line that the fit explains.
    pub share: Option<f64>,
    /// Variance of the readings about their straight line.
    pub variance: f64,
    pub is_clipped: bool,
}

impl Fitted {
    /// The rows that were fitted, read once more.
    pub fn read(samples: &Samples, selection: &Selection, fit: &TableFit) -> Result<Self> {
        let mut rows = samples.open()?;
        let part_of = Selection {
            from_s: Some(fit.from_s),
            to_s: Some(fit.to_s),
            ..selection.clone()
        };
        let columns = columns(&*rows, &part_of)?;
        let part = Part::read(&mut *rows, &part_of, fit.rows.max(1), &mut |_| {})?;
        let grid = Grid::of(&part, rows.file(), &part_of)?;
        let at = positions_of_rows(&part, &grid, &*rows, &part_of)?;
        let readings = columns
            .iter()
            .map(|column| (rows.names()[*column].clone(), part.column(*column)))
            .map(|(name, values)| Channel::new(name, values.into_owned()));
        Ok(Self::new(at, readings.collect(), fit))
    }

    /// With the fit at its frequency. Readings are at the places `at`.
    pub fn new(at: Vec<f64>, channels: Vec<Channel>, fit: &TableFit) -> Self {
        let (least, most) = at
            .iter()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(least, most), at| {
                (least.min(*at), most.max(*at))
            });
        let (centre, half) = (0.5 * (least + most), 0.5 * (most - least));
        let close = fit.tone.frequency().map(|tone| {
            let half = (0.5 * CLOSE_PERIODS / tone.value).min(half);
            Range {
                from: centre - half,
                to: centre + half,
            }
        });
        let mut fitted = Self {
            density: at.len().saturating_sub(1) as f64 / (2.0 * half).max(f64::MIN_POSITIVE),
            at,
            close,
            channels,
        };
        if let (Some(close), Some(tone)) = (close, fit.tone.frequency()) {
            let step = (close.to - close.from) / (CURVE_POINTS - 1) as f64;
            let curve_at = (0..CURVE_POINTS).map(|point| close.from + step * point as f64);
            let curve_at: Vec<f64> = curve_at.collect();
            let both = fitted.at.iter().chain(&curve_at).map(|at| at - centre);
            let wave = Wave {
                at: both.collect(),
                frequency: tone.value,
                harmonics: fit.harmonics,
                interferer: fit
                    .tone
                    .interferer_hz
                    .filter(|_| fit.domain == Domain::Time)
                    .map(f64::from),
            };
            let usable = fit.channels.iter().map(|channel| channel.usable);
            for (channel, is_usable) in fitted.channels.iter_mut().zip(usable) {
                if is_usable {
                    channel.fit(&wave, &curve_at);
                }
            }
        }
        fitted
    }

    pub fn range(&self) -> Range {
        let (from, to) = self
            .at
            .iter()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(from, to), at| {
                (from.min(*at), to.max(*at))
            });
        let to = if to > from { to } else { from + 1.0 };
        Range { from, to }
    }
}

/// Where the rows are along the axis of the fit.
fn positions_of_rows(
    part: &Part,
    grid: &Grid,
    rows: &dyn hal_mock::RowReader,
    selection: &Selection,
) -> Result<Vec<f64>> {
    if let Some(column) = &selection.position {
        let values = part.column(named(rows, column.name())?);
        let positions = column.positions_mm(&values, grid);
        let positions = positions.map_err(|why| anyhow!("{}: {why}", rows.file()))?;
        let at_row = |slot: &usize| positions[*slot].into();
        return Ok(grid.places.iter().map(at_row).collect());
    }
    let first_s = part.times_s[0];
    Ok((0..part.rows())
        .map(|row| first_s + grid.between_s(0, row))
        .collect())
}

/// The tone to fit, and where.
struct Wave {
    /// From the middle: the rows, then the points of the curve.
    at: Vec<f64>,
    frequency: f64,
    harmonics: u8,
    interferer: Option<f64>,
}

impl Channel {
    /// A column; NaN is a missing reading.
    pub fn new(name: String, values: Vec<f64>) -> Self {
        let known = || values.iter().copied().filter(|value| !value.is_nan());
        let zero = known().next().unwrap_or(0.0);
        let (least, most) = known().fold((zero, zero), |(least, most), value| {
            (value.min(least), value.max(most))
        });
        let span = most - least;
        let unit = if span > 0.0 { span } else { 1.0 };
        let scaled = |value: &f64| (!value.is_nan()).then(|| ((value - zero) / unit) as f32);
        let readings: Vec<Option<f32>> = values.iter().map(scaled).collect();
        let count = readings.iter().flatten().count();
        Self {
            name,
            residual: None,
            curve: Vec::new(),
            share: None,
            variance: about_line(&readings) / count.max(1) as f64,
            is_clipped: is_clipped(known().collect()),
            readings,
        }
    }

    fn fit(&mut self, wave: &Wave, curve_at: &[f64]) {
        let nothing = std::iter::repeat_n(None, curve_at.len());
        let readings: Vec<Option<f32>> = self.readings.iter().copied().chain(nothing).collect();
        let found = harmonics::fit(
            &wave.at,
            &readings,
            wave.frequency,
            wave.harmonics,
            wave.interferer,
        );
        let Some(found) = found else { return };
        let (at_rows, at_curve) = found.fit_v.split_at(self.readings.len());
        let residual = self.readings.iter().zip(at_rows).map(|(reading, fit)| {
            reading.map_or(0.0, |reading| f64::from(reading) - f64::from(*fit))
        });
        let residual: Vec<f64> = residual.collect();
        let squares: f64 = residual.iter().map(|left| left * left).sum();
        let all = about_line(&self.readings);
        self.share = (all > 0.0).then(|| (1.0 - squares / all).clamp(0.0, 1.0));
        self.curve = curve_at
            .iter()
            .copied()
            .zip(at_curve.iter().map(|fit| f64::from(*fit)))
            .collect();
        self.residual = Some(residual);
    }
}

/// Whether readings end at a limit: more of them have the least or the greatest value than a sine's
/// have for the number of those beside it. Of a sine whose readings are rounded, 1 + sqrt(2) as many
/// at most have the outermost value as the next one: it is over a height h for a time that grows
/// with the root of h.
fn is_clipped(mut values: Vec<f64>) -> bool {
    values.sort_by(f64::total_cmp);
    let at_end = |values: &mut dyn Iterator<Item = &f64>| {
        let (mut counts, mut levels) = ([0.0, 0.0], Vec::new());
        for value in values {
            if levels.last() != Some(value) {
                levels.push(*value);
            }
            match counts.get_mut(levels.len() - 1) {
                Some(count) => *count += 1.0,
                None => break,
            }
        }
        let most = 1.0 + 2f64.sqrt();
        let more = counts[0] - most * counts[1];
        levels.len() > 2 && more > BY_CHANCE * (counts[0] + most * most * counts[1]).sqrt()
    };
    at_end(&mut values.iter()) || at_end(&mut values.iter().rev())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn clipped_readings_are_told_from_a_rounded_sine_and_from_a_square_wave() {
        let sine = |step: f64, limit: f64| -> Vec<f64> {
            let value = |row: usize| (0.0137 * row as f64).sin().clamp(-limit, limit);
            (0..5000)
                .map(|row| (value(row) / step).round() * step)
                .collect()
        };
        for step in [1e-9, 1e-3, 0.01, 0.03, 0.1, 0.3] {
            assert!(!is_clipped(sine(step, 2.0)), "{step}");
        }
        for (step, limit) in [(1e-9, 0.99), (1e-3, 0.9), (0.01, 0.5), (0.03, 0.5)] {
            assert!(is_clipped(sine(step, limit)), "{step} {limit}");
        }
        let square = (0..1000).map(|row| f64::from(row / 10 % 2)).collect();
        assert!(!is_clipped(square));
        assert!(!is_clipped(vec![1.0; 100]) && !is_clipped(Vec::new()));
    }
}
