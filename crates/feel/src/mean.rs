//! The mean firing over several windows, with its covariance.

use crate::firing::{Firing, Matrix};
use crate::receptor::RECEPTORS;
use crate::reference::SCATTER_FROM;
use core::f32::consts::LN_10;

/// Variance per bin of a sum of log amplitudes of a random surface, squared decades.
///
/// The amplitude in a bin is Rayleigh distributed: its natural logarithm has the variance pi^2 /
/// 24, which is 0.0776 squared decades. Under a Hamming window adjacent bins are correlated by
/// -0.625, the next ones by 0.133. The covariance of the logarithms is the dilogarithm of the
/// squared correlation: 0.266 and 0.011 of the variance, on both sides.
const VARIANCE_PER_BIN: f32 = 0.0776 * (1.0 + 2.0 * (0.266 + 0.011));

/// Mean firing over several windows.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MeanFiring {
    windows: f32,
    mean: Firing,
    /// Sums of products of deviations from the mean.
    scatter: Matrix,
}

impl MeanFiring {
    /// Adds a window. All windows must have the same length and rate.
    pub fn push(&mut self, firing: &Firing) {
        let before = self.mean.intensity.map(|value| value.unwrap_or(0.0));
        self.mean.average(firing, self.windows as usize);
        self.windows += 1.0;
        let off = |m: usize, from: f32| firing.intensity[m].map_or(0.0, |value| value - from);
        for a in 0..RECEPTORS {
            for b in 0..RECEPTORS {
                let after = self.mean.intensity[b].unwrap_or(0.0);
                self.scatter[a][b] += off(a, before[a]) * off(b, after);
            }
        }
    }

    /// Mean of all windows.
    pub fn mean(&self) -> &Firing {
        &self.mean
    }

    /// Covariance of the mean intensities, the sum of three parts: scatter between stretches of the
    /// same surface; the relative error of the conversion, which moves all bins above their
    /// thresholds; and the change of the intensities if lines were noise.
    ///
    /// With eight or more windows the first part is the windows' scatter. With fewer it is the
    /// scatter of a surface without a period, which is more than that of a steady vibration.
    pub fn covariance(&self, conversion_sigma: f32) -> [[f32; RECEPTORS]; RECEPTORS] {
        let mut covariance = [[0.0; RECEPTORS]; RECEPTORS];
        let decades = conversion_sigma / LN_10;
        for a in 0..RECEPTORS {
            for b in 0..RECEPTORS {
                let of_window = if self.windows >= SCATTER_FROM {
                    self.scatter[a][b] / (self.windows - 1.0)
                } else {
                    VARIANCE_PER_BIN * self.mean.products[a][b]
                };
                let by_conversion = decades * decades * self.mean.above[a] * self.mean.above[b];
                let by_law = self.mean.lines_as_noise[a] * self.mean.lines_as_noise[b];
                covariance[a][b] = of_window / f32::max(self.windows, 1.0) + by_conversion + by_law;
            }
        }
        covariance
    }
}
