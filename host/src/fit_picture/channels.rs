//! The channels of a fit: readings, the fitted tone with its harmonics, and the residual.

use crate::chart::strips::{Points, Strip};
use crate::clipped::is_clipped;
use crate::digits::significant;
use crate::grid::Grid;
use crate::harmonics::{self, about_line};
use crate::part::{Part, columns, named};
use crate::samples::Samples;
use crate::table_fit::{ChannelResult, Selection, TableFit};
use crate::tone::Domain;
use anyhow::{Result, anyhow};
use std::ops::RangeInclusive;

const CLOSE_PERIODS: f64 = 4.0;

const CURVE_STEPS: u32 = 160;

/// Rows and channels of a fit. The axis is the recording's time in seconds, or millimetres from the
/// first row.
pub struct Fitted {
    pub range: RangeInclusive<f64>,
    /// Rows per second or per millimetre.
    pub density: f64,
    /// A few periods around the middle; `None` without a tone.
    pub close: Option<RangeInclusive<f64>>,
    pub strips: Vec<Strip>,
}

impl Fitted {
    /// Reads the fitted rows again, and fits each channel at the frequency that was found.
    pub fn read(samples: &Samples, selection: &Selection, fit: &TableFit) -> Result<Self> {
        let mut rows = samples.open()?;
        let part_of = Selection {
            from_s: Some(fit.from_s),
            to_s: Some(fit.to_s),
            ..selection.clone()
        };
        let columns = columns(&*rows, &part_of)?;
        let part = Part::read(&mut *rows, &part_of, fit.rows.max(1), &mut |_| {})?;
        let mut grid = Grid::of(&part, rows.file(), &part_of)?;
        if let Some(own_times) = grid
            .at_own_times(&part.times_s)
            .filter(|_| fit.is_at_own_times)
        {
            grid = own_times;
        }
        let at = positions_of_rows(&part, &grid, &*rows, &part_of)?;
        let from = at.iter().copied().fold(f64::INFINITY, f64::min);
        let to = at.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let to = if to > from { to } else { from + 1.0 };
        let close = fit.tone.frequency().map(|tone| {
            let (centre, half) = (0.5 * (from + to), 0.5 * (to - from));
            let half = (0.5 * CLOSE_PERIODS / tone.value).min(half);
            centre - half..=centre + half
        });
        let strips = columns.iter().zip(&fit.channels).map(|(column, found)| {
            let readings = readings(&at, &part.column(*column));
            let mut strip = strip(readings, found);
            strip.name.clone_from(&rows.names()[*column]);
            if let (Some(close), true) = (&close, found.usable) {
                add_fit(&mut strip, close, fit);
            }
            strip
        });
        Ok(Self {
            strips: strips.collect(),
            range: from..=to,
            density: at.len().saturating_sub(1) as f64 / (to - from),
            close,
        })
    }
}

/// Returns the positions of the rows along the axis of the fit.
fn positions_of_rows(
    part: &Part,
    grid: &Grid,
    rows: &dyn crate::tables::RowReader,
    selection: &Selection,
) -> Result<Vec<f64>> {
    if let Some(column) = selection.position_in(rows.names()) {
        let values = part.column(named(rows, column.name())?);
        let positions = grid.positions_mm(&column, &values);
        let positions = positions.map_err(|why| anyhow!("{}: {why}", rows.file()))?;
        let at_row = |slot: &usize| positions[*slot].into();
        return Ok(grid.places.iter().map(at_row).collect());
    }
    let first_s = part.times_s[0];
    Ok((0..part.rows())
        .map(|row| first_s + grid.between_s(0, row))
        .collect())
}

/// Returns values relative to the first known one; NaN is a missing reading.
fn readings(at: &[f64], values: &[f64]) -> Points {
    let known = at.iter().copied().zip(values.iter().copied());
    let known: Points = known.filter(|(_, value)| !value.is_nan()).collect();
    let zero = known.first().map_or(0.0, |(_, value)| *value);
    let from_zero = known.into_iter().map(|(at, value)| (at, value - zero));
    from_zero.collect()
}

fn strip(readings: Points, found: &ChannelResult) -> Strip {
    let values: Vec<f64> = readings.iter().map(|(_, value)| *value).collect();
    let note = match (found.usable, is_clipped(&values)) {
        (false, _) => "not usable",
        (true, true) => "clipped",
        (true, false) => "",
    };
    let amplitude = found.amplitude.map(|value| significant(value, 3));
    Strip {
        note,
        readings,
        amplitude: amplitude.unwrap_or_default(),
        ..Strip::default()
    }
}

/// Adds the fitted curve in the close-up, and the residual.
fn add_fit(strip: &mut Strip, close: &RangeInclusive<f64>, fit: &TableFit) {
    let Some(tone) = fit.tone.frequency() else {
        return;
    };
    let centre = 0.5 * (close.start() + close.end());
    let step = (close.end() - close.start()) / f64::from(CURVE_STEPS);
    let curve_at = (0..=CURVE_STEPS).map(|number| close.start() + step * f64::from(number));
    let curve_at: Vec<f64> = curve_at.collect();
    let at = strip.readings.iter().map(|(at, _)| at).chain(&curve_at);
    let at: Vec<f64> = at.map(|at| at - centre).collect();
    // A small signal on a large level would lose digits in single precision, so use the span as the
    // unit.
    let span = span(&strip.readings);
    let values = strip.readings.iter().map(|(_, v)| Some((v / span) as f32));
    let unknown = curve_at.iter().map(|_| None);
    let values: Vec<Option<f32>> = values.chain(unknown).collect();
    let interferer = fit.tone.interferer_hz.map(f64::from);
    let interferer = interferer.filter(|_| fit.domain == Domain::Time);
    let found = harmonics::fit(&at, &values, tone.value, fit.harmonics, interferer);
    let Some(found) = found else { return };
    let fitted = found.fit_v.iter().map(|value| span * f64::from(*value));
    let mut fitted = fitted.collect::<Vec<f64>>().into_iter();
    let readings = strip.readings.iter().zip(fitted.by_ref());
    strip.residual = readings.map(|((at, v), fit)| (*at, v - fit)).collect();
    strip.curve = curve_at.iter().copied().zip(fitted).collect();
    let squares: f64 = strip.residual.iter().map(|(_, left)| left * left).sum();
    let all = variance(&strip.readings) * strip.readings.len() as f64;
    strip.explained = (all > 0.0).then(|| (1.0 - squares / all).clamp(0.0, 1.0));
}

/// Returns the difference between maximum and minimum; 1 if all values are equal.
fn span(points: &Points) -> f64 {
    let values = || points.iter().map(|(_, value)| *value);
    let span = values().fold(f64::NEG_INFINITY, f64::max) - values().fold(f64::INFINITY, f64::min);
    if span > 0.0 { span } else { 1.0 }
}

/// Returns the variance of readings about their straight line.
pub fn variance(points: &Points) -> f64 {
    let span = span(points);
    let scaled = points.iter().map(|(_, value)| Some((value / span) as f32));
    let squares = about_line(&scaled.collect::<Vec<Option<f32>>>());
    span * span * squares / points.len().max(1) as f64
}
