//! `fit`: the joint fit alone, on any table of channels.

use crate::grid::Grid;
use crate::speed::Column;
use anyhow::{Context, Result, bail, ensure};
use hal_mock::Table as Rows;
use ridgetone_proto::settings::TAXELS;
use ridgetone_proto::telemetry::{Abscissa, Status};
use ridgetone_tone::{FRAMES_MAX, Fitter, FrameSpan, HARMONICS_MAX, Table};
use serde::Serialize;

/// Channels are scaled to about a real one's span in codes. Quantization to 1 is then far below any file's residuals.
const SPAN_CODES: f64 = 1e6;

/// Which rows and columns to fit, and how.
#[derive(Clone, Debug, Default)]
pub struct Selection {
    /// Rows per second; needed where the file has no `time_s`.
    pub rate_hz: Option<f64>,
    /// First time to use, seconds as in `time_s`; without that column row / rate.
    pub from_s: Option<f64>,
    pub to_s: Option<f64>,
    /// Names of the columns to use; all if empty.
    pub columns: Vec<String>,
    /// Most harmonics, the fundamental included, 1 to 5; 5 if none.
    pub harmonics: Option<u8>,
    /// The column to fit by place with, if not by time.
    pub place: Option<Column>,
    pub interferer_hz: Option<f64>,
}

/// One channel's part of the result, in the file's unit, with the fundamental where there is a tone.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ChannelResult {
    pub name: String,
    /// False for a constant column or a ramp, which the fit leaves out.
    pub usable: bool,
    /// Level at the window's centre.
    pub offset: Option<f64>,
    pub amplitude: Option<f64>,
    /// At the window's centre: amplitude x cos(2 pi f t + phase).
    pub phase_rad: Option<f32>,
    pub residual: Option<f64>,
}

#[derive(Clone, Debug, PartialEq)]
pub struct TableFit {
    pub rate_hz: f64,
    pub window_s: f64,
    pub rows: usize,
    /// Rows missing between them, by the time stamps.
    pub rows_missing: usize,
    pub status: Status,
    pub abscissa: Abscissa,
    /// Frequency and its standard deviation, hertz, or cycles per millimetre by place; none without a tone.
    pub tone: Option<(f64, f64)>,
    pub harmonics: u8,
    pub channels: Vec<ChannelResult>,
}

pub fn fit(rows: &Rows, selection: &Selection) -> Result<TableFit> {
    let file = rows.file();
    let columns = columns(rows, selection)?;
    if let Some(rate_hz) = selection.rate_hz {
        ensure!(rate_hz.is_finite() && rate_hz > 0.0, "--rate {rate_hz}: must be greater than 0 Hz");
    }
    let (first, end) = window(file, &times(rows, selection)?, selection)?;
    let grid = match rows.time_s() {
        Some(time_s) => Grid::from_stamps(&time_s[first..end], selection.rate_hz, |row| {
            format!("row {} (time_s {})", first + row + 1, time_s[first + row])
        })
        .map_err(|error| error.context(file.to_owned()))?,
        None => Grid::even(end - first, given_rate_hz(file, selection)?),
    };
    ensure!(
        grid.slots() <= FRAMES_MAX,
        "{file}: {} rows in the window, at most {FRAMES_MAX} can be fitted: choose a part with --from and --to",
        grid.slots()
    );

    let scaled = Scaled::new(&rows.rows()[first..end], &columns, &grid);
    if let Some(c) = scaled.units.iter().position(|unit| !unit.is_finite()) {
        bail!("{file}: column {}: its values are too far apart to be fitted", rows.names()[columns[c]]);
    }
    let mut source = Table { values: &scaled.values, valid: &scaled.valid };
    let places = match &selection.place {
        Some(column) => {
            let at = named(rows, column.name())?;
            let values: Vec<f64> = rows.rows()[first..end].iter().map(|row| row[at]).collect();
            column.places_mm(&values, &grid)
        }
        None => Vec::new(),
    };
    let place = |frame: u32| places.get(frame as usize).copied().unwrap_or(f32::NAN);
    let mut span = FrameSpan::new(&mut source, 0, grid.slots() as u32).with_quantization(1.0);
    if let Some(interferer_hz) = selection.interferer_hz {
        span = span.with_interferer((interferer_hz / grid.rate_hz) as f32);
    }
    if let Some(column) = &selection.place {
        let Some(along) = span.along(&place) else {
            bail!("{file}: by column {} the finger does not move in this part", column.name());
        };
        span = along;
    }
    let harmonics = selection.harmonics.unwrap_or(HARMONICS_MAX as u8);
    let Ok(found) = Fitter::new(harmonics).fit(&mut span) else {
        bail!("{file}: the fit did not reach all rows");
    };

    let (abscissa, per_unit) = match selection.place {
        Some(_) => (Abscissa::Place, 1.0),
        None => (Abscissa::Time, grid.rate_hz),
    };
    let has_tone = found.status.has_tone();
    let channels = columns.iter().enumerate().map(|(c, column)| {
        let (channel, unit, zero) = (found.channels[c], scaled.units[c], scaled.zeros[c]);
        let usable = found.usable & 1 << c != 0;
        ChannelResult {
            name: rows.names()[*column].clone(),
            usable,
            offset: usable.then(|| zero + f64::from(channel.offset) * unit),
            amplitude: (usable && has_tone).then(|| f64::from(channel.amplitude) * unit),
            phase_rad: (usable && has_tone).then_some(channel.phase_rad),
            residual: usable.then(|| f64::from(channel.residual) * unit),
        }
    });
    Ok(TableFit {
        rate_hz: grid.rate_hz,
        window_s: grid.slots() as f64 / grid.rate_hz,
        rows: end - first,
        rows_missing: grid.missing(),
        status: ridgetone::estimator::reported_status(found.status),
        abscissa,
        tone: has_tone.then(|| (f64::from(found.frequency) * per_unit, f64::from(found.sigma) * per_unit)),
        harmonics: found.harmonics,
        channels: channels.collect(),
    })
}

fn named(rows: &Rows, name: &str) -> Result<usize> {
    let (file, names) = (rows.file(), rows.names());
    match names.iter().position(|known| known == name) {
        Some(at) => Ok(at),
        None => bail!("{file}: no column {name}; there are: {}", names.join(", ")),
    }
}

fn columns(rows: &Rows, selection: &Selection) -> Result<Vec<usize>> {
    let file = rows.file();
    let mut columns = Vec::new();
    for name in &selection.columns {
        let at = named(rows, name)?;
        ensure!(!columns.contains(&at), "{file}: --columns names {name} twice");
        columns.push(at);
    }
    if selection.columns.is_empty() {
        let place = selection.place.as_ref().map(Column::name);
        columns = (0..rows.names().len()).filter(|at| Some(rows.names()[*at].as_str()) != place).collect();
    }
    let count = columns.len();
    ensure!(count <= TAXELS, "{file}: {count} channels, at most {TAXELS} are fitted together: choose with --columns");
    Ok(columns)
}

/// Times of the rows, seconds: their stamps, or by the given rate.
fn times(rows: &Rows, selection: &Selection) -> Result<Vec<f64>> {
    if let Some(time_s) = rows.time_s() {
        return Ok(time_s.to_vec());
    }
    let rate_hz = given_rate_hz(rows.file(), selection)?;
    Ok((0..rows.rows().len()).map(|row| row as f64 / rate_hz).collect())
}

/// The rate of rows without stamps.
fn given_rate_hz(file: &str, selection: &Selection) -> Result<f64> {
    selection.rate_hz.with_context(|| format!("{file}: no column time_s: give the rate of the rows with --rate HZ"))
}

/// First row of the window and the one after its last.
fn window(file: &str, times: &[f64], selection: &Selection) -> Result<(usize, usize)> {
    let count = times.len();
    if selection.from_s.is_none() && selection.to_s.is_none() {
        return Ok((0, count));
    }
    let (begin_s, last_s) = (times[0], times[count - 1]);
    // A row lasts until the next one would come.
    let lasts_s = if count > 1 { 1.001 * (last_s - begin_s) / (count - 1) as f64 } else { 0.0 };
    let (from_s, to_s) = (selection.from_s.unwrap_or(begin_s), selection.to_s.unwrap_or(last_s));
    let data = format!("the data goes from {begin_s} to {last_s} s");
    ensure!(from_s >= begin_s - lasts_s && from_s <= last_s, "{file}: --from {from_s} s is outside the data: {data}");
    ensure!(to_s >= begin_s && to_s <= last_s + lasts_s, "{file}: --to {to_s} s is outside the data: {data}");
    ensure!(from_s < to_s, "{file}: --from {from_s} s is not before --to {to_s} s");
    let first = times.partition_point(|t_s| *t_s < from_s);
    let end = times.partition_point(|t_s| *t_s <= to_s);
    ensure!(first < end, "{file}: no row from {from_s} to {to_s} s");
    Ok((first, end))
}

/// The rows as the library takes them.
struct Scaled {
    values: Vec<[f32; TAXELS]>,
    valid: Vec<u16>,
    /// First value of each channel: subtracted before anything is rounded to f32.
    zeros: Vec<f64>,
    /// File units per unit of `values`.
    units: Vec<f64>,
}

impl Scaled {
    fn new(rows: &[Vec<f64>], columns: &[usize], grid: &Grid) -> Self {
        let mut scaled = Self {
            values: vec![[0.0; TAXELS]; grid.slots()],
            valid: vec![0; grid.slots()],
            zeros: Vec::new(),
            units: Vec::new(),
        };
        for (c, column) in columns.iter().enumerate() {
            let column = || rows.iter().map(|row| row[*column]);
            let zero = column().next().unwrap_or(0.0);
            let (least, greatest) = column().fold((zero, zero), |(l, g), value| (value.min(l), value.max(g)));
            let span = greatest - least;
            // The fit leaves a constant channel out, whatever its unit.
            let unit = if span > f64::MIN_POSITIVE * SPAN_CODES { span / SPAN_CODES } else { 1.0 };
            for (place, value) in grid.places.iter().zip(column()) {
                scaled.values[*place][c] = ((value - zero) / unit) as f32;
                scaled.valid[*place] |= 1 << c;
            }
            scaled.zeros.push(zero);
            scaled.units.push(unit);
        }
        scaled
    }
}
