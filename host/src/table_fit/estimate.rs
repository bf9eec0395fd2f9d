//! Calls the estimator, with the number of frames and the scene. No other module calls it.

use super::bridge;
use super::scaled::Scaled;
use crate::digits::significant;
use crate::part::{Band, Selection};
use anyhow::{Result, bail};
use ridgetone_tone::{
    Delays, Fit, Fitter, FrameSpan, HARMONICS_MAX, OtherTone, Scene, Status, Table,
};

/// Blank cells are bridged if the fraction of complete rows is below this.
const WHOLE_FRACTION_MIN: f64 = 0.95;

/// Alternatives to an ambiguous tone are searched below its frequency times this fraction, and
/// above its frequency divided by this fraction.
const BELOW: f64 = 0.9;

/// Result of the estimator.
pub struct Estimated {
    pub found: Fit,
    /// Number of grid intervals per fitted frame.
    pub slots_per_frame: usize,
    /// Frequency that was subtracted from all frequencies before the fit, cycles per frame.
    pub shift: f64,
    /// Remark on how the rows were processed, and on tones outside the band.
    pub note: Option<String>,
}

impl Estimated {
    /// Creates the result of fitting unprocessed rows.
    pub fn of(found: Fit, note: Option<String>) -> Self {
        Self {
            found,
            slots_per_frame: 1,
            shift: 0.0,
            note,
        }
    }
}

/// Positions of the finger while the frames are read.
pub struct Motion {
    /// Position of each frame; empty for a fit in time.
    pub positions: Vec<f32>,
    /// Delays of the readings, if known.
    pub delays: Option<Delays>,
}

impl Motion {
    /// Returns no positions, for a fit in time.
    pub fn still() -> Self {
        Self {
            positions: Vec::new(),
            delays: None,
        }
    }
}

pub struct Frames<'a> {
    pub file: &'a str,
    pub scaled: &'a Scaled,
    pub motion: &'a Motion,
    pub rate_hz: f64,
    pub selection: &'a Selection,
    pub band: Band,
}

impl Frames<'_> {
    /// Returns the unit of frequencies: the rate for a fit in time, whose result is in cycles per
    /// frame.
    fn unit_hz(&self) -> f64 {
        if self.motion.positions.is_empty() {
            self.rate_hz
        } else {
            1.0
        }
    }

    /// Adds an alternative to an ambiguous fit that has none: the strongest tone below or above the
    /// fitted one.
    pub fn named(&self, mut found: Fit) -> Result<Fit> {
        let is_open = found.status == Status::Ambiguous && found.other_tone.is_none();
        if !is_open {
            return Ok(found);
        }
        let unit_hz = self.unit_hz();
        let hz = f64::from(found.frequency) * unit_hz;
        let power = |found: &Fit| -> f32 {
            found
                .channels
                .iter()
                .map(|channel| channel.amplitude.powi(2))
                .sum()
        };
        let below = Band {
            max_hz: Some(BELOW * hz),
            ..self.band
        };
        let above = Band {
            min_hz: Some(hz / BELOW),
            ..self.band
        };
        let mut others = Vec::new();
        for band in [below, above] {
            let is_band = match (band.min_hz, band.max_hz) {
                (Some(min_hz), Some(max_hz)) => min_hz < max_hz,
                _ => true,
            };
            if is_band {
                let other = Self { band, ..*self }.fit()?;
                others.extend(other.status.has_tone().then_some(other));
            }
        }
        let other = others.iter().max_by(|a, b| power(a).total_cmp(&power(b)));
        found.other_tone = other.map(|other| OtherTone {
            frequency: other.frequency,
            fraction: power(other) / power(&found).max(f32::MIN_POSITIVE),
        });
        Ok(found)
    }

    /// If there is no tone in the band, describes a tone outside the band.
    pub fn outside(&self, found: &Fit) -> Result<Option<String>> {
        if self.band.is_open() || found.status.has_tone() {
            return Ok(None);
        }
        let open = Self {
            band: Band::default(),
            ..*self
        };
        let other = open.fit()?;
        Ok(other.status.has_tone().then(|| {
            let hz = significant(f64::from(other.frequency) * self.unit_hz(), 4);
            format!("a tone of {hz} Hz is outside of --min-hz and --max-hz")
        }))
    }

    fn scene(&self) -> Scene {
        let Band { min_hz, max_hz } = self.band;
        let unit_hz = self.unit_hz();
        let bound = |hz: Option<f64>| hz.map_or(0.0, |hz| (hz / unit_hz) as f32);
        let harmonics = self.selection.harmonics.unwrap_or(HARMONICS_MAX as u8);
        Scene {
            band: ridgetone_tone::Band {
                min: bound(min_hz),
                max: bound(max_hz),
            },
            ..ridgetone_finger::scene(&self.selection.declared, harmonics)
        }
    }

    /// Fits the frames, with single blank cells bridged if that helps.
    pub fn fit(&self) -> Result<Fit> {
        // A few rows with blank cells are better left out than bridged. A fast tone cannot be
        // bridged.
        if self.motion.positions.is_empty() && self.scaled.whole_fraction() < WHOLE_FRACTION_MIN {
            let bridged = self.scaled.bridged();
            let found = self.run(&bridged)?;
            if found.status.has_tone() && f64::from(found.frequency) <= bridge::TONE_MAX {
                return Ok(found);
            }
        }
        self.run(self.scaled)
    }

    fn run(&self, scaled: &Scaled) -> Result<Fit> {
        let (file, selection) = (self.file, self.selection);
        let mut source = Table {
            values: &scaled.values,
            valid: &scaled.valid,
        };
        let frames = scaled.values.len() as u32;
        let mut span = FrameSpan::new(&mut source, 0, frames).with_quantization(1.0);
        if let Some(interferer_hz) = selection.interferer_hz {
            span = span.with_interferer((interferer_hz / self.rate_hz) as f32);
        }
        let positions = &self.motion.positions;
        let position = |frame: u32| positions.get(frame as usize).copied().unwrap_or(f32::NAN);
        if !self.motion.positions.is_empty() {
            let Some(along) = span.along(&position) else {
                match &selection.position {
                    Some(column) => bail!(
                        "{file}: by column {} the finger does not move in this part",
                        column.name()
                    ),
                    None => bail!("{file}: the time stands still in this part"),
                }
            };
            span = along;
        }
        let (mut fitter, scene) = (Box::new(Fitter::new()), self.scene());
        let delays = self.motion.delays.as_ref();
        let found = match delays.filter(|_| !positions.is_empty()) {
            Some(delays) => fitter.fit_delayed(&mut span, &scene, delays),
            None => fitter.fit(&mut span, &scene),
        };
        let Ok(found) = found else {
            bail!("{file}: the fit did not reach all rows");
        };
        Ok(found)
    }
}
