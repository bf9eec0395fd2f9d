//! Amplitude of a texture from its spatial period.

use super::error::{Error, between, within};
use serde::{Deserialize, Serialize};

/// Signal power of a sensor as a polynomial of the spatial period, and the power that corresponds
/// to the actuator's maximum.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct AmplitudeLaw {
    /// Coefficients for the period in millimetres, the constant first.
    pub coefficients: [f32; 5],
    /// Range of measured periods, millimetres. Others are clamped.
    pub period_mm: (f32, f32),
    /// Power that corresponds to the actuator's maximum amplitude.
    pub power_max: f32,
}

impl AmplitudeLaw {
    /// Okamoto et al., *Transmission of Tactile Roughness through Master-slave Systems*, equation 2
    /// (R^2 = 0.94, 0.8 to 2.0 mm), and P_max of equation 3.
    pub const OKAMOTO: Self = Self {
        coefficients: [72_298.0, -248_938.0, 309_743.0, -162_663.0, 30_770.0],
        period_mm: (0.8, 2.0),
        power_max: 6000.0,
    };

    pub fn check(&self) -> Result<(), Error> {
        for coefficient in self.coefficients {
            within("coefficient", coefficient, -1e12, 1e12)?;
        }
        within("period_mm.0", self.period_mm.0, 0.05, 100.0)?;
        within("period_mm.1", self.period_mm.1, self.period_mm.0, 100.0)?;
        within("power_max", self.power_max, 1e-12, 1e12)
    }

    /// Power at a period (equation 2), at least 0.
    pub fn power(&self, period_mm: f32) -> f32 {
        let (min, max) = self.period_mm;
        let x = between(period_mm, min, max);
        self.coefficients
            .iter()
            .rev()
            .fold(0.0, |sum, coefficient| sum * x + coefficient)
            .max(0.0)
    }

    /// Amplitude as a fraction of the actuator's maximum (equation 3), 0 to 1, for a power, or for
    /// the law's own power if `power` is 0.
    pub fn fraction(&self, period_mm: f32, power: f32) -> f32 {
        let power = if power > 0.0 {
            power
        } else {
            self.power(period_mm)
        };
        (power / self.power_max).clamp(0.0, 1.0)
    }
}
