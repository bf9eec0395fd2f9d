//! A recording to what is felt over it: windows, the reference, the receptors of each channel and
//! of all together.

use super::cut::Cut;
use super::known::Known;
use super::loaded::Loaded;
use crate::samples::Samples;
use crate::table_fit::Selection;
use anyhow::{Result, ensure};
use ridgetone_feel::{Conversion, Firing, Indices, MeanFiring, Reference};

/// Share by which the rates of a recording and of its reference may differ. At another rate the
/// filters in front of the converter may have another gain.
pub const RATES_DIFFER: f64 = 0.01;

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
    /// Longest window, seconds; `as_window_s` if none.
    pub window_s: Option<f64>,
    /// Window of the intensities that are wanted, and of the conversion, seconds.
    pub as_window_s: f64,
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
    /// The intensities are those of a window of this length, seconds.
    pub as_window_s: f64,
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
    /// The indices of a window of [`Self::as_window_s`].
    pub fn indices(&self, m: Option<(f32, f32)>) -> Indices {
        Indices::new(&self.firing, self.log_sigma, m)
    }

    pub fn bins(&self) -> usize {
        self.spectrum_um.len()
    }

    pub fn bin_hz(&self) -> f64 {
        self.window_s.recip()
    }
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
    let wanted_s = options.as_window_s;
    let cut = Cut::new(&samples, options.window_s.unwrap_or(wanted_s), wanted_s)?;
    let known = Known {
        surface: options.reference.surface,
        recording: reference,
        cut: Cut::new(reference, wanted_s, wanted_s)?,
    };
    let names = samples.channels.iter().map(|(name, _)| name.as_str());
    let mut channels = known.channels(names)?;

    let (mut firing, mut log_um) = (MeanFiring::default(), vec![0.0; cut.rows / 2]);
    for start in &cut.starts {
        let mut together = Vec::new();
        for (channel, (_, values)) in channels.iter_mut().zip(&samples.channels) {
            let (Some(conversion), Some(values)) =
                (channel.conversion, values.get(*start..start + cut.rows))
            else {
                continue;
            };
            let amplitudes = cut.spectrum.amplitudes(values);
            let found = Firing::new(&amplitudes, cut.windows, &conversion);
            channel.firing.push(&found);
            together.push(found);
            for (log_um, amplitude) in log_um.iter_mut().zip(&amplitudes) {
                *log_um += f64::from(amplitude.log10() - conversion.log_per_um);
            }
        }
        firing.push(&Firing::mean(together.iter()));
    }
    let conversions = channels.iter().filter_map(|channel| channel.conversion);
    let log_sigmas: Vec<f32> = conversions.map(|conversion| conversion.log_sigma).collect();
    let count = (cut.starts.len() * log_sigmas.len()) as f64;
    Ok(Felt {
        file: samples.file,
        rate_hz: samples.rate_hz,
        rows: samples.rows,
        rows_missing: samples.rows_missing,
        readings_missing: samples.readings_missing,
        window_s: cut.rows as f64 / samples.rate_hz,
        as_window_s: options.as_window_s,
        reference: options.reference.surface,
        channels,
        firing,
        log_sigma: log_sigmas.iter().sum::<f32>() / log_sigmas.len() as f32,
        spectrum_um: log_um
            .into_iter()
            .map(|sum| 10f64.powf(sum / count))
            .collect(),
        guessed: samples.guessed,
    })
}
