//! A recording to what is felt over it: windows, the reference, the receptors of each channel and
//! of all together.

use crate::grid::Grid;
use crate::part::Part;
use crate::samples::Samples;
use crate::table_fit::{Selection, columns};
use anyhow::{Result, bail, ensure};
use ridgetone_feel::{
    Conversion, Firing, Indices, MeanFiring, POINTS_MAX, Reference, SpectralLine, Windows,
    amplitude_spectrum, points,
};
use std::ops::Range;

/// Most rows of a recording: seven minutes at 10 kHz, half a gigabyte of sixteen channels.
const ROWS_MAX: usize = 1 << 22;

/// Share by which the rates of a recording and of its reference may differ: in a bin of another
/// width a surface without a period has another amplitude.
pub const RATES_DIFFER: f64 = 0.01;

/// Amplitudes that f32 can square together with the noise next to them.
const SQUARED: Range<f32> = 1e-15..1e15;

/// The surface that gives the sensor's unit in micrometres.
#[derive(Clone, Debug)]
pub struct KnownSurface {
    pub surface: Reference,
    /// Its recording; the recording itself if none.
    pub samples: Option<Samples>,
}

/// What to read of a recording.
#[derive(Clone, Debug)]
pub struct Options {
    pub selection: Selection,
    /// Longest window, seconds.
    pub window_s: Option<f64>,
    pub reference: KnownSurface,
}

#[derive(Clone, Debug)]
pub struct Channel {
    pub name: String,
    /// Absent if the reference has no amplitude in this channel, which then does not count.
    pub conversion: Option<Conversion>,
    pub firing: MeanFiring,
}

/// What is felt over a recording.
#[derive(Clone, Debug)]
pub struct Felt {
    pub file: String,
    pub rate_hz: f64,
    pub rows: usize,
    pub rows_missing: usize,
    pub readings_missing: usize,
    pub window_s: f64,
    pub reference: Reference,
    pub channels: Vec<Channel>,
    /// The mean of the channels that count, and the standard deviation of their conversion,
    /// decades.
    pub firing: MeanFiring,
    pub log_sigma: f32,
    /// Mean amplitudes of these channels from bin 0 on, um from peak to peak.
    pub spectrum_um: Vec<f64>,
    /// What was guessed of how the table is written.
    pub guessed: Option<String>,
}

impl Felt {
    /// The indices as a window of `as_window_s` would have them; one of a second has a bin each
    /// hertz.
    pub fn indices(&self, as_window_s: f64, m: Option<(f32, f32)>) -> Indices {
        Indices::new(
            &self.firing,
            self.log_sigma,
            Windows {
                measured_s: self.window_s as f32,
                wanted_s: as_window_s as f32,
            },
            m,
        )
    }

    pub fn bins(&self) -> usize {
        self.spectrum_um.len()
    }

    pub fn bin_hz(&self) -> f64 {
        self.window_s.recip()
    }
}

/// The samples of a part of a recording, channel by channel.
struct Loaded {
    file: String,
    rate_hz: f64,
    rows: usize,
    rows_missing: usize,
    readings_missing: usize,
    channels: Vec<(String, Vec<f32>)>,
    guessed: Option<String>,
}

/// Measures what is felt. `progress` takes the rows that have been read.
pub fn measure(
    samples: &Samples,
    options: &Options,
    progress: &mut dyn FnMut(u64),
) -> Result<Felt> {
    let samples = Loaded::read(samples, &options.selection, progress)?;
    let other = options
        .reference
        .samples
        .as_ref()
        .map(|other| Loaded::read(other, &options.selection, progress));
    let other = other.transpose()?;
    let reference = other.as_ref().unwrap_or(&samples);
    ensure!(
        (reference.rate_hz / samples.rate_hz - 1.0).abs() < RATES_DIFFER,
        "{}: {:.6} rows a second, and the reference has {:.6}: both need one rate",
        samples.file,
        samples.rate_hz,
        reference.rate_hz
    );
    let wanted = options.window_s.map_or(POINTS_MAX, |window_s| {
        (window_s * samples.rate_hz).round() as usize
    });
    let rows = samples.slots().min(reference.slots()).min(wanted);
    let Some(window) = points(rows) else {
        bail!(
            "{}: {rows} rows in a window, at least 64 are needed",
            samples.file
        )
    };
    let (window_s, bin_hz) = (
        window as f64 / samples.rate_hz,
        (samples.rate_hz / window as f64) as f32,
    );

    let surface = options.reference.surface;
    let hz = surface.frequency_hz();
    let half = window as f32 / 2.0 * bin_hz;
    ensure!(
        (bin_hz..half).contains(&hz),
        "--reference: {hz} Hz (speed_mm_s over rsm_mm) is not between {bin_hz} Hz, a cycle a window, and {half} Hz, half the rate"
    );
    let mut channels = Vec::new();
    for (name, _) in &samples.channels {
        let Some((_, values)) = reference.channels.iter().find(|(known, _)| known == name) else {
            bail!("{}: no column {name}", reference.file)
        };
        let conversion = conversion(&surface, values, window, hz / bin_hz);
        channels.push(Channel {
            name: name.clone(),
            conversion,
            firing: MeanFiring::default(),
        });
    }
    let used: Vec<f32> = channels
        .iter()
        .filter_map(|channel| Some(channel.conversion?.log_sigma))
        .collect();
    ensure!(
        !used.is_empty(),
        "{}: the reference has no amplitude at {hz} Hz (speed_mm_s over rsm_mm) in any column: choose a recording in \
         which the finger slides over it",
        reference.file
    );

    let (mut firing, mut log_um) = (MeanFiring::default(), vec![0.0; window / 2]);
    let starts = starts(samples.slots(), window);
    for start in &starts {
        let mut together = Vec::new();
        for (channel, (_, values)) in channels.iter_mut().zip(&samples.channels) {
            let (Some(conversion), Some(values)) =
                (channel.conversion, values.get(*start..start + window))
            else {
                continue;
            };
            let mut values = values.to_vec();
            let Some(amplitudes) = amplitude_spectrum(&mut values) else {
                continue;
            };
            let found = Firing::new(amplitudes, bin_hz, &conversion);
            channel.firing.push(&found);
            together.push(found);
            for (log_um, amplitude) in log_um.iter_mut().zip(amplitudes) {
                *log_um += f64::from(amplitude.log10() - conversion.log_per_um);
            }
        }
        firing.push(&Firing::mean(together.iter()));
    }
    let count = (starts.len() * used.len()) as f64;
    Ok(Felt {
        file: samples.file,
        rate_hz: samples.rate_hz,
        rows: samples.rows,
        rows_missing: samples.rows_missing,
        readings_missing: samples.readings_missing,
        window_s,
        reference: surface,
        channels,
        firing,
        log_sigma: used.iter().sum::<f32>() / used.len() as f32,
        spectrum_um: log_um
            .into_iter()
            .map(|sum| 10f64.powf(sum / count))
            .collect(),
        guessed: samples.guessed,
    })
}

/// Starts of windows that overlap by half or less, so that each counts as one of its own; two or
/// more use all rows.
fn starts(rows: usize, window: usize) -> Vec<usize> {
    let steps = (rows - window) / (window / 2);
    (0..=steps)
        .map(|step| (step * (rows - window)).checked_div(steps).unwrap_or(0))
        .collect()
}

/// D by the mean amplitude over the windows; none without one.
fn conversion(
    surface: &Reference,
    values: &[f32],
    window: usize,
    cycles: f32,
) -> Option<Conversion> {
    let line =
        |start| SpectralLine::measure(&mut values.get(start..start + window)?.to_vec(), cycles);
    let lines: Option<Vec<SpectralLine>> =
        starts(values.len(), window).into_iter().map(line).collect();
    let (amplitude, sigma) = SpectralLine::mean(lines?.into_iter())?;
    surface.conversion(amplitude, sigma).ok()
}

impl Loaded {
    fn read(
        samples: &Samples,
        selection: &Selection,
        progress: &mut dyn FnMut(u64),
    ) -> Result<Self> {
        let rows = &mut *samples.open()?;
        let columns = columns(rows, selection)?;
        let part = Part::read(rows, selection, ROWS_MAX, progress)?;
        let file = rows.file().to_owned();
        let grid = Grid::of(&part, &file, selection)?;
        ensure!(
            grid.uneven_s.is_empty(),
            "{file}: its rows are not evenly spaced in time, as spectra need: give their rate with --rate HZ if the stamps are wrong"
        );
        let mut readings_missing = 0;
        let mut channel = |column: &usize| {
            let column_values = part.column(*column);
            let readings = grid.places.iter().zip(column_values.iter());
            let readings = readings.map(|(place, value)| (*place, *value));
            let known: Vec<(usize, f64)> = readings.filter(|(_, value)| !value.is_nan()).collect();
            readings_missing += part.rows() - known.len();
            let values = bridged(&known, grid.slots());
            let name = rows.names()[*column].clone();
            let greatest = values
                .iter()
                .fold(0.0, |greatest: f32, value| greatest.max(value.abs()));
            ensure!(
                greatest == 0.0 || SQUARED.contains(&greatest),
                "{file}: column {name}: its values differ by {greatest:e}, which f32 cannot square: scale them"
            );
            Ok((name, values))
        };
        let channels = columns.iter().map(&mut channel).collect::<Result<_>>()?;
        let (rate_hz, rows_missing) = (grid.rate_hz, grid.missing());
        Ok(Self {
            file,
            rate_hz,
            rows: part.rows(),
            rows_missing,
            readings_missing,
            channels,
            guessed: rows.guessed(),
        })
    }

    /// Samples of a channel, missing rows included.
    fn slots(&self) -> usize {
        self.rows + self.rows_missing
    }
}

/// Readings at their places, less the first one; straight lines where readings are missing. Zeros
/// without any reading.
fn bridged(known: &[(usize, f64)], slots: usize) -> Vec<f32> {
    let mut values = vec![0.0; slots];
    let Some((_, first)) = known.first().copied() else {
        return values;
    };
    for pair in known.windows(2) {
        let [(from, a), (to, b)] = [pair[0], pair[1]];
        for (step, value) in values[from..to].iter_mut().enumerate() {
            *value = (a - first + (b - a) * step as f64 / (to - from) as f64) as f32;
        }
    }
    if let Some((last, value)) = known.last() {
        values[*last..].fill((value - first) as f32);
    }
    values
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn windows_overlap_by_half_or_less() {
        assert_eq!(starts(64, 64), [0]);
        assert_eq!(starts(95, 64), [0]);
        assert_eq!(starts(160, 64), [0, 32, 64, 96]);
        assert_eq!(starts(150, 64), [0, 43, 86]);
    }

    #[test]
    fn missing_readings_are_bridged() {
        assert_eq!(
            bridged(&[(1, 10.0), (2, 12.0), (4, 16.0)], 6),
            [0.0, 0.0, 2.0, 4.0, 6.0, 6.0]
        );
        assert_eq!(bridged(&[], 2), [0.0, 0.0]);
    }
}
