//! The mean over several windows, with its covariance.

use crate::firing::{Firing, Matrix};
use crate::receptor::RECEPTORS;
use crate::reference::SCATTER_FROM;

/// Variance of a sum of logarithms of amplitudes of a random surface by the number of bins, squared
/// decades a bin.
///
/// The amplitude in a bin is Rayleigh's: its natural logarithm has the variance pi^2 / 24, the
/// 0.0776 squared decades. Under Hamming's window neighbours are correlated by -0.625, the next
/// ones by 0.133; the covariance of the logarithms goes with the dilogarithm of the square: 0.266
/// and 0.011 of the variance, on both sides.
const VARIANCE_PER_BIN: f32 = 0.0776 * (1.0 + 2.0 * (0.266 + 0.011));

/// How the receptors fire on the average of several windows.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MeanFiring {
    windows: f32,
    mean: Firing,
    /// Sums of products of deviations from the mean.
    scatter: Matrix,
}

impl MeanFiring {
    /// Adds a window. All windows have to be of one length and one rate.
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

    /// Windows so far.
    pub fn windows(&self) -> u32 {
        self.windows as u32
    }

    /// The mean of all windows.
    pub fn mean(&self) -> &Firing {
        &self.mean
    }

    /// Covariance of the mean: how other stretches of the same surface would scatter, how an error
    /// of the conversion of `log_sigma` decades moves all bins that are above their thresholds, and
    /// what the intensities would change by if lines were noise.
    ///
    /// From eight windows on the first part is the windows' scatter. Of fewer it is that of a
    /// surface without a period, which is more than that of a steady vibration.
    pub fn covariance(&self, log_sigma: f32) -> Matrix {
        let mut covariance = [[0.0; RECEPTORS]; RECEPTORS];
        let by_scatter = self.windows >= SCATTER_FROM;
        for a in 0..RECEPTORS {
            for b in 0..RECEPTORS {
                let of_window = match by_scatter {
                    true => self.scatter[a][b] / (self.windows - 1.0),
                    false => VARIANCE_PER_BIN * self.mean.products[a][b],
                };
                let by_conversion = log_sigma * log_sigma * self.mean.above[a] * self.mean.above[b];
                let by_law = self.mean.lines_as_noise[a] * self.mean.lines_as_noise[b];
                covariance[a][b] = of_window / f32::max(self.windows, 1.0) + by_conversion + by_law;
            }
        }
        covariance
    }
}
