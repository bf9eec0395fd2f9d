//! A texture as a short message that replaces its vibration.

use super::error::{Error, within};
use serde::{Deserialize, Serialize};

/// Maximum number of harmonics, including the fundamental.
pub const HARMONICS_MAX: usize = 4;

#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Harmonic {
    /// Amplitude relative to the fundamental's, 0 to 1.
    pub amplitude: f32,
    /// Phase relative to the fundamental's phase times the order, cycles, -1 to 1.
    pub phase_cycles: f32,
}

/// A texture. Unknown fields are 0, except for the period.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Texture {
    /// Spatial period, millimetres, 0.05 to 100.
    pub period_mm: f32,
    /// Standard deviation of the period, millimetres, 0 to 100.
    #[serde(default)]
    pub period_sigma_mm: f32,
    /// Signal power of the sensor at the period, in the unit of the
    /// [`AmplitudeLaw`](super::AmplitudeLaw), 0 to 1e12; 0 for the law's power.
    #[serde(default)]
    pub power: f32,
    /// Harmonics from the second on.
    #[serde(default)]
    pub overtones: [Harmonic; HARMONICS_MAX - 1],
}

impl Texture {
    /// Creates a plain texture, a sine.
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
