//! Scores that people would give, by linear regression on the receptors' firing and the forces.

use crate::Measured;
use crate::mean::MeanFiring;
use crate::receptor::RECEPTORS;

/// Number of values that scores depend on: the intensities of the receptors, and M, the ratio of
/// tangential to normal force.
pub const INDICES: usize = RECEPTORS + 1;

/// Soft, from 1 to 7 (equation 11). The paper states neither a covariance nor a scatter of the
/// scores around the line.
pub const SOFT: Score = Score {
    constant: 5.59,
    coefficients: [0.0, 0.0, -0.002, 0.0, 0.0],
};
/// Rough, from 1 to 7 (equation 12).
pub const ROUGH: Score = Score {
    constant: -16.075,
    coefficients: [0.0, 0.011, 0.0, 0.0, 11.633],
};

/// Intensities in the order of [`Receptor::ALL`](crate::Receptor::ALL), then M.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Indices {
    /// Values; `None` if absent.
    pub values: [Option<f32>; INDICES],
    /// Covariance of the values.
    pub covariance: [[f32; INDICES]; INDICES],
}

/// A score as a linear function of the indices.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Score {
    /// Score with all indices at zero.
    pub constant: f32,
    /// Coefficient of each index; 0 if the score does not depend on it.
    pub coefficients: [f32; INDICES],
}

impl Indices {
    /// Creates indices with their covariance. `conversion_sigma` is the relative standard deviation
    /// of the conversion.
    pub fn new(firing: &MeanFiring, conversion_sigma: f32, m: Option<Measured>) -> Self {
        let (mut values, mut covariance) = ([None; INDICES], [[0.0; INDICES]; INDICES]);
        let of_firing = firing.covariance(conversion_sigma);
        for a in 0..RECEPTORS {
            values[a] = firing.mean().intensity[a];
            covariance[a][..RECEPTORS].copy_from_slice(&of_firing[a]);
        }
        values[RECEPTORS] = m.map(|m| m.value);
        covariance[RECEPTORS][RECEPTORS] = m.map_or(0.0, |m| m.sigma * m.sigma);
        Self { values, covariance }
    }

    /// An index with its standard deviation.
    pub fn get(&self, index: usize) -> Option<Measured> {
        let variance = *self.covariance.get(index)?.get(index)?;
        Some(Measured {
            value: self.values.get(index).copied().flatten()?,
            sigma: libm::sqrtf(variance.max(0.0)),
        })
    }
}

impl Score {
    /// Returns the first absent index on which the score depends.
    pub fn missing(&self, indices: &Indices) -> Option<usize> {
        (0..INDICES).find(|&i| self.coefficients[i] != 0.0 && indices.values[i].is_none())
    }

    /// Returns the score with the standard deviation due to the indices. `None` if an index that it
    /// depends on is absent.
    pub fn of(&self, indices: &Indices) -> Option<Measured> {
        if self.missing(indices).is_some() {
            return None;
        }
        let (mut value, mut variance) = (self.constant, 0.0);
        for a in 0..INDICES {
            value += self.coefficients[a] * indices.values[a].unwrap_or(0.0);
            for b in 0..INDICES {
                variance += self.coefficients[a] * self.coefficients[b] * indices.covariance[a][b];
            }
        }
        Some(Measured {
            value,
            sigma: libm::sqrtf(variance.max(0.0)),
        })
    }
}
