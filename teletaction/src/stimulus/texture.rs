//! A texture as a small message, instead of the vibration that it makes.

use super::error::{Error, within};
use serde::{Deserialize, Serialize};

/// Harmonics at most, the fundamental included.
pub const HARMONICS_MAX: usize = 4;

/// A harmonic of a texture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Harmonic {
    /// Amplitude relative to the fundamental's, 0 to 1.
    pub amplitude: f32,
    /// Phase against as many turns of the fundamental, cycles, -1 to 1.
    pub phase_cycles: f32,
}

/// A texture. Fields that nobody knows are 0, but for the period.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Texture {
    /// Spatial period, millimetres, 0.05 to 100.
    pub period_mm: f32,
    /// Standard deviation of the period, millimetres, 0 to 100.
    #[serde(default)]
    pub period_sigma_mm: f32,
    /// Signal power of the sensor at the period, in the unit of the
    /// [`AmplitudeLaw`](super::AmplitudeLaw), 0 to 1e12; 0: by the law.
    #[serde(default)]
    pub power: f32,
    /// The second harmonic and those above it.
    #[serde(default)]
    pub overtones: [Harmonic; HARMONICS_MAX - 1],
}

impl Texture {
    /// A plain one: a sine.
    pub const fn new(period_mm: f32) -> Self {
        let none = Harmonic {
            amplitude: 0.0,
            phase_cycles: 0.0,
        };
        Self {
            period_mm,
            period_sigma_mm: 0.0,
            power: 0.0,
            overtones: [none; HARMONICS_MAX - 1],
        }
    }

    /// Checks the ranges.
    pub fn check(&self) -> Result<(), Error> {
        within("period_mm", self.period_mm, 0.05, 100.0)?;
        within("period_sigma_mm", self.period_sigma_mm, 0.0, 100.0)?;
        within("power", self.power, 0.0, 1e12)?;
        for harmonic in self.overtones {
            within("amplitude", harmonic.amplitude, 0.0, 1.0)?;
            within("phase_cycles", harmonic.phase_cycles, -1.0, 1.0)?;
        }
        Ok(())
    }
}
