//! `fit`: runs only the joint fit, on any table of channels.

mod bridge;
mod estimate;
mod groups;
mod long;
mod means;
mod scaled;

use crate::clipped::{is_clipped, wraps_at};
use crate::digits::significant;
use crate::grid::Grid;
pub use crate::part::{Band, Selection, columns, named};
use crate::part::{Part, named_in};
use crate::speed::{Column, Quantity};
use crate::tables::RowReader;
use crate::tone::{Domain, Tone, WithSigma};
use crate::usage::NoEstimate;
use anyhow::{Result, bail, ensure};
use estimate::{Estimated, Motion};
use ridgetone_proto::settings::TAXELS;
use ridgetone_proto::telemetry::{OtherTone, Status};
use ridgetone_tone::{FRAMES_MAX, HARMONICS_MAX};
use scaled::Channels;
use serde::Serialize;

/// Relative difference between the supplied rate and that of the stamps above which a warning is
/// shown.
const RATES_DIFFER: f64 = 0.01;

/// One channel's part of the result, in the file's unit, with the fundamental where there is a
/// tone.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct ChannelResult {
    /// Name of the column.
    pub name: String,
    /// Unit of offset, amplitude and residual, if the table has one.
    #[serde(skip)]
    pub unit: Option<String>,
    /// False for a constant column or a ramp, which the fit leaves out.
    pub usable: bool,
    /// True if its readings end at a limit: the tone is then larger than the amplitude.
    pub clipped: bool,
    /// Level at the window's centre.
    pub offset: Option<f64>,
    /// Amplitude of the fundamental.
    pub amplitude: Option<f64>,
    /// Phase of the fundamental at the window's centre: amplitude x cos(2 pi f t + phase).
    pub phase_rad: Option<f32>,
    /// Standard deviation of the residual.
    pub residual: Option<f64>,
}

/// Part of a recording that was fitted.
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

/// The fit of a table. Frequency and deviations are in hertz, or by position in cycles per
/// millimetre.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct TableFit {
    /// Number of rows per second.
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
    /// Domain in which cycles are counted: time or position.
    pub domain: Domain,
    /// The standard deviation of the frequency counts that of the rate.
    #[serde(flatten)]
    pub tone: Tone,
    /// Confidence in the fit.
    pub status: Status,
    /// Harmonics in the fit, the fundamental included.
    pub harmonics: u8,
    /// Groups of at most 16 channels that were fitted by themselves; 1 for up to 16 channels.
    pub groups: usize,
    /// The columns.
    pub channels: Vec<ChannelResult>,
    /// Times are seconds since 1970, and shown as dates.
    #[serde(skip)]
    pub is_dated: bool,
    /// True if rows were fitted at the times of their stamps though a grid was found.
    #[serde(skip)]
    pub is_at_own_times: bool,
    /// Guesses about the table's format.
    #[serde(skip)]
    pub guessed: Option<String>,
}

impl TableFit {
    /// Returns the sum of the logarithms of the channels' residuals; `None` without a tone.
    fn log_residuals(&self) -> Option<f64> {
        self.tone.frequency()?;
        let residuals = self.channels.iter().filter_map(|channel| channel.residual);
        Some(
            residuals
                .map(|residual| residual.max(f64::MIN_POSITIVE).ln())
                .sum(),
        )
    }

    /// Returns a warning if the selected rate differs from that of the stamps.
    pub fn warning(&self, selection: &Selection) -> Option<String> {
        let (rate_hz, stamped_hz) = (selection.rate_hz?, self.stamped_hz?);
        let differ = (rate_hz / stamped_hz - 1.0).abs() > RATES_DIFFER;
        differ
            .then(|| format!("--rate {rate_hz} Hz is used, though time_s gives {stamped_hz:.4} Hz"))
    }
}

/// Fits a part of a table without reading rows after the part. `progress` takes the number of rows
/// read so far.
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
    let part = Part::read(rows, selection, usize::MAX, progress)?;
    let table = TableHead::of(rows);
    let mut found = fit_part(&table, &part, &columns, selection)?;
    let without = groups::without_one(&table, &part, &columns, selection, &found)?;
    found.guessed = joined([found.guessed, without]);
    Ok(found)
}

/// Properties of a table that a fit needs in addition to the rows.
#[derive(Clone, Debug)]
pub struct TableHead {
    file: String,
    names: Vec<String>,
    units: Vec<Option<String>>,
    guessed: Option<String>,
    is_dated: bool,
}

impl TableHead {
    /// Takes the properties from `rows`, which must have been read up to the end of the part.
    pub fn of(rows: &dyn RowReader) -> Self {
        Self {
            file: rows.file().to_owned(),
            names: rows.names().to_vec(),
            units: rows.units(),
            guessed: rows.guessed(),
            is_dated: rows.is_dated(),
        }
    }

    pub fn file(&self) -> &str {
        &self.file
    }
}

/// Fits the given columns of a part, in groups if the estimator cannot take all of them at once.
pub fn fit_part(
    table: &TableHead,
    part: &Part,
    columns: &[usize],
    selection: &Selection,
) -> Result<TableFit> {
    if part.rows() == 1 {
        let why = format!("{}: one row alone has no rate and no tone", table.file);
        return Err(NoEstimate(why).into());
    }
    match columns.len() <= TAXELS {
        true => fit_group(table, part, columns, selection),
        false => groups::fit(table, part, columns, selection),
    }
}

/// Fits at most 16 columns, on an even grid or at the times of the stamps, whichever matches a tone
/// better.
fn fit_group(
    table: &TableHead,
    part: &Part,
    columns: &[usize],
    selection: &Selection,
) -> Result<TableFit> {
    let grid = Grid::of(part, &table.file, selection)?;
    let found = fit_on(&grid, table, part, columns, selection)?;
    let is_in_time = selection.position.is_none() && part.rows() <= FRAMES_MAX;
    let own_times = is_in_time.then(|| grid.at_own_times(&part.times_s));
    let Some(own_times) = own_times.flatten() else {
        return Ok(found);
    };
    let mut own = fit_on(&own_times, table, part, columns, selection)?;
    let is_closer = match (own.log_residuals(), found.log_residuals()) {
        (Some(own), Some(found)) => own < found,
        (own, _) => own.is_some(),
    };
    if !is_closer {
        return Ok(found);
    }
    own.is_at_own_times = true;
    let remark = format!(
        "the spacing of the rows scatters by {} %: they are fitted at their own times",
        significant(100.0 * grid.scatter, 2)
    );
    own.guessed = joined([own.guessed, Some(remark)]);
    Ok(own)
}

/// Fits at most 16 columns on a grid.
fn fit_on(
    grid: &Grid,
    table: &TableHead,
    part: &Part,
    columns: &[usize],
    selection: &Selection,
) -> Result<TableFit> {
    let file = &table.file;
    let position = selection.position_in(&table.names);
    let scaled = Channels::new(part, columns, grid);
    if let Some(c) = scaled.units.iter().position(|unit| !unit.is_finite()) {
        bail!(
            "{file}: column {}: its values are too far apart to be fitted",
            table.names[columns[c]]
        );
    }
    let positions = match &position {
        Some(column) => {
            let at = named_in(file, &table.names, column.name())?;
            let values = part.column(at);
            let is_blank = |end: Option<&f64>| end.is_some_and(|value| value.is_nan());
            let is_cut = is_blank(values.first()) || is_blank(values.last());
            ensure!(
                !is_cut,
                "{file}: column {}: blank in the first or the last row of this part",
                column.name()
            );
            if let Some(alignment) = &selection.alignment {
                ensure!(
                    values.iter().all(|value| !value.is_nan()),
                    "{file}: {} has a gap in this part: choose a part with --from and --to, or windows with --window",
                    alignment.file
                );
            }
            let positions = grid.positions_mm(column, &values);
            positions.map_err(|why| anyhow::anyhow!("{file}: {why}"))?
        }
        // Uneven times are passed to the fit as positions, in seconds.
        None => grid.uneven_s.iter().map(|t_s| *t_s as f32).collect(),
    };
    let delays = selection.alignment.as_ref().map(|alignment| {
        let mut skew_frames = [0.0; TAXELS];
        for (skew, column) in skew_frames.iter_mut().zip(columns) {
            *skew = alignment.skew_frames.get(*column).copied().unwrap_or(0.0);
        }
        ridgetone_tone::Delays {
            frames: skew_frames,
            low_pass: (alignment.low_pass_s * grid.rate_hz) as f32,
        }
    });
    let motion = Motion { positions, delays };
    let Estimated {
        found,
        slots_per_frame,
        shift,
        note,
    } = long::estimate(file, &scaled, &motion, grid, selection)?;
    let frames_per_s = grid.rate_hz / slots_per_frame as f64;

    let rate_fraction = grid.rate_sigma_hz / grid.rate_hz;
    let delay_fraction = selection.alignment.as_ref().map_or(0.0, |alignment| {
        alignment.sigma_fraction(&motion.positions, grid.rate_hz)
    });
    // A position column does not depend on the sample rate, so the rate's uncertainty does not
    // enter.
    let (domain, per_unit, scale_fraction) = match position {
        Some(ref column) if column.quantity() == Quantity::Position => (Domain::Position, 1.0, 0.0),
        Some(_) => (Domain::Position, 1.0, rate_fraction),
        None if !grid.uneven_s.is_empty() => (Domain::Time, 1.0, 0.0),
        None => (Domain::Time, frames_per_s, rate_fraction),
    };
    let (frequency, sigma) = (
        (f64::from(found.frequency) + shift) * per_unit,
        f64::from(found.sigma) * per_unit,
    );
    let has_tone = found.status.has_tone();
    let tone = Tone::new(
        domain,
        has_tone.then(|| WithSigma {
            value: frequency,
            sigma: sigma.hypot(frequency * scale_fraction.hypot(delay_fraction)),
        }),
        has_tone.then(|| ridgetone_finger::movement(&found, per_unit as f32)),
        ridgetone_finger::other_tone(&found, per_unit as f32).map(|other| OtherTone {
            frequency: other.frequency + (shift * per_unit) as f32,
            ..other
        }),
        // An interferer is fitted in time, even if the tone is fitted by position.
        found.interferer.map(|cycles| cycles * frames_per_s as f32),
    );
    let mut wrapping = Vec::new();
    let channels = columns.iter().enumerate().map(|(c, column)| {
        let (channel, unit, zero) = (found.channels[c], scaled.units[c], scaled.zeros[c]);
        let usable = found.usable & 1 << c != 0;
        let name = &table.names[*column];
        let values = part.column(*column);
        if let Some(period) = wraps_at(&values) {
            let period = significant(period, 4);
            wrapping.push(format!("column {name} begins again at {period}, as angles do: unwrap it, in Python with numpy.unwrap(x, period={period})"));
        }
        ChannelResult {
            name: name.clone(),
            unit: table.units.get(*column).cloned().flatten(),
            usable,
            clipped: usable && is_clipped(&values),
            offset: usable.then(|| zero + f64::from(channel.offset) * unit),
            amplitude: (usable && has_tone).then(|| f64::from(channel.amplitude) * unit),
            phase_rad: (usable && has_tone).then_some(channel.phase_rad),
            residual: usable.then(|| f64::from(channel.residual) * unit),
        }
    });
    let channels: Vec<ChannelResult> = channels.collect();
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
        domain,
        tone,
        status: ridgetone_finger::reported_status(found.status),
        harmonics: found.harmonics,
        groups: 1,
        channels,
        is_dated: table.is_dated,
        is_at_own_times: false,
        guessed: joined([
            table.guessed.clone(),
            position.as_ref().and_then(Column::guessed),
            note,
            (!wrapping.is_empty()).then(|| wrapping.join("; ")),
        ]),
    })
}

/// Joins the remarks with semicolons; `None` if there are none.
pub fn joined<const N: usize>(remarks: [Option<String>; N]) -> Option<String> {
    let remarks: Vec<String> = remarks.into_iter().flatten().collect();
    (!remarks.is_empty()).then(|| remarks.join("; "))
}

#[cfg(test)]
mod tests;
