//! The surface that is known: what the sensor's unit is in micrometres.

use super::cut::Cut;
use super::loaded::Loaded;
use super::measure::Channel;
use anyhow::{Context, Result, ensure};
use ridgetone_feel::{Conversion, MeanFiring, Reference, SpectralLine, amplitude_at};

/// A surface whose roughness is known, and its recording.
pub struct Known<'a> {
    pub surface: Reference,
    pub recording: &'a Loaded,
    pub cut: Cut,
}

impl Known<'_> {
    /// The channels of these names, each with its conversion. Fails if none has one.
    pub fn channels<'n>(&self, names: impl Iterator<Item = &'n str>) -> Result<Vec<Channel>> {
        let hz = self.surface.frequency_hz();
        let min_hz = self.cut.windows.bin_hz();
        let half = self.recording.rate_hz as f32 / 2.0;
        ensure!(
            (min_hz..half).contains(&hz),
            "--reference: {hz} Hz (speed_mm_s over rsm_mm) is not between {min_hz} Hz, a cycle a window, and {half} Hz, half the rate"
        );
        let file = &self.recording.file;
        let channel = |name: &str| {
            let mut channels = self.recording.channels.iter();
            let (_, values) = channels
                .find(|(known, _)| known == name)
                .with_context(|| format!("{file}: no column {name}"))?;
            Ok(Channel {
                name: name.to_owned(),
                conversion: self.conversion(values),
                firing: MeanFiring::default(),
            })
        };
        let channels: Vec<Channel> = names.map(channel).collect::<Result<_>>()?;
        ensure!(
            channels.iter().any(|channel| channel.conversion.is_some()),
            "{file}: the reference has no amplitude at {hz} Hz (speed_mm_s over rsm_mm) in any column: choose a recording in \
             which the finger slides over it"
        );
        Ok(channels)
    }

    /// D by the mean amplitude over the windows; none without one.
    fn conversion(&self, values: &[f32]) -> Option<Conversion> {
        let cycles = self.surface.frequency_hz() / self.cut.windows.bin_hz();
        let line = |start: &usize| {
            let values = values.get(*start..start + self.cut.rows)?;
            let spectrum = self.cut.spectrum.amplitudes(values);
            let amplitude = amplitude_at(values, cycles);
            Some(SpectralLine::new(amplitude, &spectrum, cycles))
        };
        let lines: Option<Vec<SpectralLine>> = self.cut.starts.iter().map(line).collect();
        let (amplitude, sigma) = SpectralLine::mean(lines?.into_iter(), self.cut.windows)?;
        self.surface.conversion(amplitude, sigma).ok()
    }
}
