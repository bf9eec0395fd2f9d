//! Scores that people would give, by linear regression on what the receptors do and on the forces.

use crate::mean::MeanFiring;
use crate::receptor::RECEPTORS;

/// What scores depend on: the intensities of the receptors, and M.
pub const INDICES: usize = RECEPTORS + 1;

/// Window of the paper's intensities and of its conversion, seconds: its 30 mm at 10 mm/s (section
/// 2.3). The paper does not say what part of the run is transformed.
pub const PAPER_WINDOW_S: f32 = 3.0;

/// Soft, from 1 to 7 (equation 11). The paper gives no covariance, and no scatter of the scores
/// around the line.
pub const SOFT: Score = Score::exact([5.59, 0.0, 0.0, -0.002, 0.0, 0.0]);
/// Rough, from 1 to 7 (equation 12).
pub const ROUGH: Score = Score::exact([-16.075, 0.0, 0.011, 0.0, 0.0, 11.633]);

/// What scores are made of, in the order of [`Receptor::ALL`](crate::Receptor::ALL), then M.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Indices {
    /// Values; none of an absent one.
    pub values: [Option<f32>; INDICES],
    /// Their covariance.
    pub covariance: [[f32; INDICES]; INDICES],
}

/// A score as a straight line over the indices.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Score {
    /// The constant, then a coefficient for each index; 0 if the score does not depend on it.
    pub coefficients: [f32; INDICES + 1],
    /// Their covariance; zeros if unknown.
    pub covariance: [[f32; INDICES + 1]; INDICES + 1],
    /// Standard deviation of people's scores around the line; 0 if unknown.
    pub residual_sigma: f32,
}

impl Indices {
    /// Indices of the windows that the firing is wanted for. `log_sigma` is that of the conversion;
    /// `m` is M with its standard deviation.
    pub fn new(firing: &MeanFiring, log_sigma: f32, m: Option<(f32, f32)>) -> Self {
        let (mut values, mut covariance) = ([None; INDICES], [[0.0; INDICES]; INDICES]);
        let of_firing = firing.covariance(log_sigma);
        for a in 0..RECEPTORS {
            values[a] = firing.mean().intensity[a];
            covariance[a][..RECEPTORS].copy_from_slice(&of_firing[a]);
        }
        values[RECEPTORS] = m.map(|(value, _)| value);
        covariance[RECEPTORS][RECEPTORS] = m.map_or(0.0, |(_, sigma)| sigma * sigma);
        Self { values, covariance }
    }

    /// An index with its standard deviation.
    pub fn get(&self, index: usize) -> Option<(f32, f32)> {
        let value = self.values.get(index).copied().flatten()?;
        Some((
            value,
            libm::sqrtf(self.covariance.get(index)?.get(index)?.max(0.0)),
        ))
    }
}

impl Score {
    /// One whose uncertainty is unknown.
    pub const fn exact(coefficients: [f32; INDICES + 1]) -> Self {
        Self {
            coefficients,
            covariance: [[0.0; INDICES + 1]; INDICES + 1],
            residual_sigma: 0.0,
        }
    }

    /// The first index that the score depends on and that is absent.
    pub fn missing(&self, indices: &Indices) -> Option<usize> {
        (0..INDICES)
            .find(|index| self.coefficients[index + 1] != 0.0 && indices.values[*index].is_none())
    }

    /// The score with its standard deviation: that of the indices, of the coefficients, and of
    /// people around the line. None if an index that it depends on is absent.
    pub fn of(&self, indices: &Indices) -> Option<(f32, f32)> {
        if self.missing(indices).is_some() {
            return None;
        }
        let mut x = [1.0; INDICES + 1];
        for index in 0..INDICES {
            x[index + 1] = indices.values[index].unwrap_or(0.0);
        }
        let (mut value, mut variance) = (0.0, self.residual_sigma * self.residual_sigma);
        for a in 0..=INDICES {
            value += self.coefficients[a] * x[a];
            for b in 0..=INDICES {
                variance += x[a] * x[b] * self.covariance[a][b];
                if a > 0 && b > 0 {
                    let of_indices = indices.covariance[a - 1][b - 1];
                    variance += self.coefficients[a] * self.coefficients[b] * of_indices;
                }
            }
        }
        Some((value, libm::sqrtf(variance.max(0.0))))
    }
}
