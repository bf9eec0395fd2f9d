//! `fit`: the joint fit alone, on any table of channels.

mod bridge;

use crate::grid::Grid;
use crate::part::Part;
pub use crate::part::{Selection, columns, named};
use crate::speed::{Column, Quantity};
use crate::tone::{Tone, WithSigma};
use anyhow::{Result, bail, ensure};
use hal_mock::RowReader;
use ridgetone_proto::settings::TAXELS;
use ridgetone_proto::telemetry::{Abscissa, Status};
use ridgetone_tone::{FRAMES_MAX, Fit, Fitter, FrameSpan, HARMONICS_MAX, Table};
use serde::Serialize;

/// Channels are scaled to about a real one's span in codes. Quantization to 1 is then far below any
/// file's residuals.
const SPAN_CODES: f64 = 1e6;

/// A given rate that differs from the time stamps by more than this share gives a warning.
const RATES_DIFFER: f64 = 0.01;

/// Blank cells are bridged where less than this share of the rows has all readings.
const WHOLE_SHARE_MIN: f64 = 0.95;

/// One channel's part of the result, in the file's unit, with the fundamental where there is a
/// tone.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct ChannelResult {
    /// Name of the column.
    pub name: String,
    /// False for a constant column or a ramp, which the fit leaves out.
    pub usable: bool,
    /// Level at the window's centre.
    pub offset: Option<f64>,
    /// Amplitude of the fundamental.
    pub amplitude: Option<f64>,
    /// Phase of the fundamental at the window's centre: amplitude x cos(2 pi f t + phase).
    pub phase_rad: Option<f32>,
    /// Standard deviation of the residual.
    pub residual: Option<f64>,
}

/// Which part of a recording was fitted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum FittedPart {
    /// The slide that was found in it.
    Slide,
    /// All of it.
    Whole,
    /// From the time and to the time that were given.
    Given,
}

/// The fit of a table. Frequency and deviations are in hertz, or by place in cycles per millimetre.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct TableFit {
    /// Rows a second.
    pub rate_hz: f64,
    /// Standard deviation of the rate by the time stamps.
    pub rate_sigma_hz: f64,
    /// The rate by the time stamps, if there are any.
    #[serde(skip)]
    pub stamped_hz: Option<f64>,
    /// Which part of the recording was fitted.
    pub part: FittedPart,
    /// Time of the part's first row.
    pub from_s: f64,
    /// Time of the part's last row.
    pub to_s: f64,
    /// Length of the part that was fitted.
    pub window_s: f64,
    /// Rows that were fitted.
    pub rows: usize,
    /// Rows missing between them, by the time stamps.
    pub rows_missing: usize,
    /// Blank cells in the rows.
    pub readings_missing: usize,
    /// Whether cycles are counted in time or by place.
    pub abscissa: Abscissa,
    /// The standard deviation of the frequency counts that of the rate.
    #[serde(flatten)]
    pub tone: Tone<f64>,
    /// How far the fit can be trusted.
    pub status: Status,
    /// Harmonics in the fit, the fundamental included.
    pub harmonics: u8,
    /// The columns.
    pub channels: Vec<ChannelResult>,
    /// What was guessed of how the table is written.
    #[serde(skip)]
    pub guessed: Option<String>,
}

impl TableFit {
    /// What to look at, if the selection's rate is not that of the stamps.
    pub fn warning(&self, selection: &Selection) -> Option<String> {
        let (rate_hz, stamped_hz) = (selection.rate_hz?, self.stamped_hz?);
        let differ = (rate_hz / stamped_hz - 1.0).abs() > RATES_DIFFER;
        differ
            .then(|| format!("--rate {rate_hz} Hz is used, though time_s gives {stamped_hz:.4} Hz"))
    }
}

/// Fits a part of a table; no row behind the part is read. `progress` takes the rows that have been
/// read.
pub fn fit(
    rows: &mut dyn RowReader,
    selection: &Selection,
    progress: &mut dyn FnMut(u64),
) -> Result<TableFit> {
    if let Some(rate_hz) = selection.rate_hz {
        ensure!(
            rate_hz.is_finite() && rate_hz > 0.0,
            "--rate {rate_hz}: must be greater than 0 Hz"
        );
    }
    if let Some(harmonics) = selection.harmonics {
        ensure!(
            (1..=HARMONICS_MAX).contains(&harmonics.into()),
            "--harmonics {harmonics}: must be 1 to {HARMONICS_MAX}"
        );
    }
    let columns = columns(rows, selection)?;
    let part = Part::read(rows, selection, FRAMES_MAX, progress)?;
    let file = rows.file();
    let grid = Grid::of(&part, rows, selection)?;
    ensure!(
        grid.slots() <= FRAMES_MAX,
        "{file}: {} rows in the window, at most {FRAMES_MAX} can be fitted: choose a part with --from and --to",
        grid.slots()
    );

    let scaled = Scaled::new(&part, &columns, &grid);
    if let Some(c) = scaled.units.iter().position(|unit| !unit.is_finite()) {
        bail!(
            "{file}: column {}: its values are too far apart to be fitted",
            rows.names()[columns[c]]
        );
    }
    let places = match &selection.place {
        Some(column) => {
            let at = named(rows, column.name())?;
            let values: Vec<f64> = part.column(at).collect();
            let is_blank = |end: Option<&f64>| end.is_some_and(|value| value.is_nan());
            let is_cut = is_blank(values.first()) || is_blank(values.last());
            ensure!(
                !is_cut,
                "{file}: column {}: blank in the first or the last row of this part",
                column.name()
            );
            let places = column.places_mm(&values, &grid);
            places.map_err(|why| anyhow::anyhow!("{file}: {why}"))?
        }
        // Uneven times are places, in seconds.
        None => grid.uneven_s.iter().map(|t_s| *t_s as f32).collect(),
    };
    let place = |frame: u32| places.get(frame as usize).copied().unwrap_or(f32::NAN);
    let harmonics = selection.harmonics.unwrap_or(HARMONICS_MAX as u8);
    let fit = |scaled: &Scaled| {
        let mut source = Table {
            values: &scaled.values,
            valid: &scaled.valid,
        };
        let mut span = FrameSpan::new(&mut source, 0, grid.slots() as u32).with_quantization(1.0);
        if let Some(interferer_hz) = selection.interferer_hz {
            span = span.with_interferer((interferer_hz / grid.rate_hz) as f32);
        }
        if !places.is_empty() {
            let Some(along) = span.along(&place) else {
                match &selection.place {
                    Some(column) => bail!(
                        "{file}: by column {} the finger does not move in this part",
                        column.name()
                    ),
                    None => bail!("{file}: the time stands still in this part"),
                }
            };
            span = along;
        }
        let Ok(found) = Fitter::new(harmonics).fit(&mut span) else {
            bail!("{file}: the fit did not reach all rows");
        };
        Ok(found)
    };
    // Few rows with blank cells cost less left out than bridged; and a fast tone cannot be bridged.
    let mut bridged = None;
    if places.is_empty() && scaled.whole_share() < WHOLE_SHARE_MIN {
        let scaled = scaled.bridged();
        let found = fit(&scaled)?;
        let is_slow = f64::from(found.frequency) <= bridge::TONE_MAX;
        bridged = (found.status.has_tone() && is_slow).then_some((found, scaled));
    }
    let (mut found, scaled) = match bridged {
        Some(bridged) => bridged,
        None => (fit(&scaled)?, scaled),
    };
    let of_readings = scaled.sigma_factor(&found);
    for sigma in [
        &mut found.sigma,
        &mut found.movement.sigma_of_mean,
        &mut found.movement.wander_sigma,
        &mut found.movement.chirp_sigma,
    ] {
        *sigma *= of_readings;
    }

    let rate_share = grid.rate_sigma_hz / grid.rate_hz;
    // Places that are given need no time.
    let (abscissa, per_unit, scale_share) = match selection.place {
        Some(ref column) if column.quantity() == Quantity::Position => (Abscissa::Place, 1.0, 0.0),
        Some(_) => (Abscissa::Place, 1.0, rate_share),
        None if !grid.uneven_s.is_empty() => (Abscissa::Time, 1.0, 0.0),
        None => (Abscissa::Time, grid.rate_hz, rate_share),
    };
    let (frequency, sigma) = (
        f64::from(found.frequency) * per_unit,
        f64::from(found.sigma) * per_unit,
    );
    let has_tone = found.status.has_tone();
    let tone = Tone::new(
        abscissa,
        has_tone.then(|| WithSigma {
            value: frequency,
            sigma: sigma.hypot(frequency * scale_share),
        }),
        has_tone.then(|| ridgetone::movement(&found, per_unit as f32)),
        ridgetone::other_tone(&found, per_unit as f32),
        // An interferer is in time, by place too.
        found.interferer.map(|cycles| cycles * grid.rate_hz as f32),
    );
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
        rate_sigma_hz: grid.rate_sigma_hz,
        stamped_hz: grid.stamped_hz,
        part: if selection.from_s.is_some() || selection.to_s.is_some() {
            FittedPart::Given
        } else {
            FittedPart::Whole
        },
        from_s: part.times_s[0],
        to_s: part.times_s[part.rows() - 1],
        window_s: grid.slots() as f64 / grid.rate_hz,
        rows: part.rows(),
        rows_missing: grid.missing(),
        readings_missing: columns.len() * part.rows() - scaled.readings,
        abscissa,
        tone,
        status: ridgetone::reported_status(found.status),
        harmonics: found.harmonics,
        channels: channels.collect(),
        guessed: joined(
            rows.guessed(),
            selection.place.as_ref().and_then(Column::guessed),
        ),
    })
}

/// Two remarks as one.
fn joined(one: Option<String>, other: Option<String>) -> Option<String> {
    match (one, other) {
        (Some(one), Some(other)) => Some(format!("{one}; {other}")),
        (one, other) => one.or(other),
    }
}

/// The rows as the library takes them.
#[derive(Clone)]
struct Scaled {
    values: Vec<[f32; TAXELS]>,
    valid: Vec<u16>,
    /// First value of each channel: subtracted before anything is rounded to f32.
    zeros: Vec<f64>,
    /// File units per unit of `values`.
    units: Vec<f64>,
    /// Readings of the file.
    readings: usize,
    /// Of each channel, those that others beside them stand for.
    bridged: [usize; TAXELS],
}

impl Scaled {
    fn new(part: &Part, columns: &[usize], grid: &Grid) -> Self {
        let mut scaled = Self {
            values: vec![[0.0; TAXELS]; grid.slots()],
            valid: vec![0; grid.slots()],
            zeros: Vec::new(),
            units: Vec::new(),
            readings: 0,
            bridged: [0; TAXELS],
        };
        for (c, column) in columns.iter().enumerate() {
            let readings = || {
                grid.places
                    .iter()
                    .copied()
                    .zip(part.column(*column))
                    .filter(|(_, v)| !v.is_nan())
            };
            let zero = readings().next().map_or(0.0, |(_, value)| value);
            let (least, greatest) = readings()
                .map(|(_, value)| value)
                .fold((zero, zero), |(l, g), value| (value.min(l), value.max(g)));
            let span = greatest - least;
            // The fit leaves a constant channel out, whatever its unit.
            let unit = if span > f64::MIN_POSITIVE * SPAN_CODES {
                span / SPAN_CODES
            } else {
                1.0
            };
            for (place, value) in readings() {
                scaled.values[place][c] = ((value - zero) / unit) as f32;
                scaled.valid[place] |= 1 << c;
                scaled.readings += 1;
            }
            scaled.zeros.push(zero);
            scaled.units.push(unit);
        }
        scaled
    }

    /// Share of the rows that have all readings of the channels that have any.
    fn whole_share(&self) -> f64 {
        let all = self.valid.iter().fold(0, |all, valid| all | valid);
        let count =
            |is: &dyn Fn(u16) -> bool| self.valid.iter().filter(|valid| is(**valid)).count() as f64;
        count(&|valid| valid == all) / count(&|valid| valid != 0).max(1.0)
    }

    /// The same with single readings bridged; of a row that is missing nothing is known.
    fn bridged(&self) -> Self {
        let mut bridged = self.clone();
        for c in 0..self.units.len() {
            let readings = self.values.iter().zip(&self.valid);
            let known: Vec<_> = readings
                .map(|(values, valid)| (valid & 1 << c != 0).then_some(f64::from(values[c])))
                .collect();
            for (slot, value) in bridge::bridged(&known)
                .into_iter()
                .filter(|(slot, _)| self.valid[*slot] != 0)
            {
                bridged.values[slot][c] = value as f32;
                bridged.valid[slot] |= 1 << c;
                bridged.bridged[c] += 1;
            }
        }
        bridged
    }

    /// By what factor bridged values make sigma larger: they add no information. Their share counts
    /// in each channel, weighted as the channel is.
    fn sigma_factor(&self, found: &Fit) -> f32 {
        let (mut all, mut bridged) = (f64::MIN_POSITIVE, 0.0);
        for (c, count) in self
            .bridged
            .iter()
            .enumerate()
            .filter(|(c, _)| found.usable & 1 << c != 0)
        {
            let channel = &found.channels[c];
            let weight = f64::from(channel.amplitude / channel.residual.max(f32::MIN_POSITIVE))
                .powi(2)
                .min(1e30);
            all += weight;
            bridged += weight * (*count as f64 / self.values.len().max(1) as f64);
        }
        (1.0 / (1.0 - bridged / all).max(0.1)).sqrt() as f32
    }
}

#[cfg(test)]
mod tests;
