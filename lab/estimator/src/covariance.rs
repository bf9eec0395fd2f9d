//! The covariance of the channels' noise from a few samples: shrunk towards what few samples can
//! tell.
//!
//! O. Ledoit, M. Wolf, "A well-conditioned estimator for large-dimensional covariance matrices",
//! Journal of Multivariate Analysis 88 (2004), 365-411; here correlations are shrunk towards none,
//! and variances towards the shape of those of all frames.

use crate::limits::CHANNELS_MAX;
use crate::matrix::{Factor, Square};
use crate::source::Values;

/// Added to variances: rounding, in units of a channel's own variance.
pub const ROUNDING: f32 = 1e-7;

/// Samples of the noise: sums of their products, and how many there are.
#[derive(Clone, Copy, Debug)]
pub struct Samples<'s> {
    /// Products of the channels.
    pub products: &'s Square<CHANNELS_MAX>,
    /// Number of channels.
    pub width: usize,
    /// Number of samples.
    pub count: f32,
    /// Number of samples of equal weight that tell as much.
    pub effective: f32,
    /// Whether channels may be correlated.
    pub may_share: bool,
}

/// A shrunk covariance.
#[derive(Clone, Debug)]
pub struct Covariance {
    /// The covariance.
    pub matrix: Square<CHANNELS_MAX>,
    /// Its inverse.
    pub inverse: Square<CHANNELS_MAX>,
    /// Share of the correlations that was taken away.
    pub shrinkage: f32,
    /// Channels that tell as much and are not correlated.
    pub channels: f32,
}

impl Covariance {
    /// Zeros.
    pub const NONE: Self = Self {
        matrix: [[0.0; CHANNELS_MAX]; CHANNELS_MAX],
        inverse: [[0.0; CHANNELS_MAX]; CHANNELS_MAX],
        shrinkage: 1.0,
        channels: 1.0,
    };
}

impl Samples<'_> {
    /// The covariance; `all` are variances over all frames.
    #[inline(never)]
    pub fn covariance(&self, all: Option<&Values>) -> Covariance {
        let (c, products) = (self.width, self.products);
        let mut own = [0.0; CHANNELS_MAX];
        for k in 0..c {
            own[k] = products[k][k] / self.count + ROUNDING;
        }
        let mut variances = own;
        if let Some(all) = all {
            let ratio = |k: usize| own[k] / all[k];
            let mean = (0..c).map(ratio).sum::<f32>() / c as f32;
            let spread = (0..c)
                .map(|k| (ratio(k) - mean) * (ratio(k) - mean))
                .sum::<f32>()
                / c as f32;
            let share =
                (2.0 / self.effective * mean * mean / spread.max(f32::MIN_POSITIVE)).min(1.0);
            for k in 0..c {
                variances[k] = share * mean * all[k] + (1.0 - share) * own[k];
            }
        }
        let mut matrix = [[0.0; CHANNELS_MAX]; CHANNELS_MAX];
        let mut squares = 0.0;
        if self.may_share {
            let inverse = own.map(|own| 1.0 / libm::sqrtf(self.count * own.max(f32::MIN_POSITIVE)));
            for k in 0..c {
                for l in 0..k {
                    let value = products[k][l] * inverse[k] * inverse[l];
                    matrix[k][l] = value;
                    squares += 2.0 * value * value;
                }
            }
        }
        let shrinkage = if self.may_share && c > 1 {
            ((c * (c - 1)) as f32 / self.effective / squares.max(f32::MIN_POSITIVE)).min(1.0)
        } else {
            1.0
        };
        if shrinkage < 1.0 {
            let deviations = variances.map(libm::sqrtf);
            for k in 0..c {
                for l in 0..k {
                    matrix[k][l] *= (1.0 - shrinkage) * deviations[k] * deviations[l];
                    matrix[l][k] = matrix[k][l];
                }
            }
        } else {
            matrix = [[0.0; CHANNELS_MAX]; CHANNELS_MAX];
        }
        for k in 0..c {
            matrix[k][k] = variances[k];
        }
        let kept = (1.0 - shrinkage) * (1.0 - shrinkage) * squares;
        let inverse = if shrinkage < 1.0 {
            Factor::new(&matrix, c).inverse()
        } else {
            let mut inverse = [[0.0; CHANNELS_MAX]; CHANNELS_MAX];
            for k in 0..c {
                inverse[k][k] = 1.0 / matrix[k][k];
            }
            inverse
        };
        Covariance {
            matrix,
            inverse,
            shrinkage,
            channels: (c * c) as f32 / (c as f32 + kept),
        }
    }
}

/// The product x' W y.
pub fn form(x: &Values, weights: &Square<CHANNELS_MAX>, y: &Values) -> f32 {
    let rows = x.iter().zip(weights);
    rows.map(|(x, row)| x * row.iter().zip(y).map(|(w, y)| w * y).sum::<f32>())
        .sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn samples(products: &Square<CHANNELS_MAX>) -> Samples<'_> {
        Samples {
            products,
            width: 2,
            count: 50.0,
            effective: 50.0,
            may_share: true,
        }
    }

    #[test]
    fn a_correlation_that_few_samples_may_have_by_chance_is_taken_away() {
        let mut products = [[0.0; CHANNELS_MAX]; CHANNELS_MAX];
        (products[0][0], products[1][1]) = (50.0, 200.0);
        (products[0][1], products[1][0]) = (10.0, 10.0);
        let covariance = samples(&products).covariance(None);
        assert_eq!(covariance.shrinkage, 1.0);
        assert_eq!(covariance.channels, 2.0);
        assert!((covariance.inverse[1][1] - 0.25).abs() < 1e-6);
    }

    #[test]
    fn a_strong_correlation_stays() {
        let mut products = [[0.0; CHANNELS_MAX]; CHANNELS_MAX];
        (products[0][0], products[1][1]) = (50.0, 50.0);
        (products[0][1], products[1][0]) = (45.0, 45.0);
        let covariance = samples(&products).covariance(None);
        assert!(covariance.shrinkage < 0.03 && covariance.matrix[0][1] > 0.87);
        assert!(covariance.channels < 1.2);
        let one: f32 = (0..2)
            .map(|k| covariance.matrix[0][k] * covariance.inverse[k][0])
            .sum();
        assert!((one - 1.0).abs() < 1e-4);
    }
}
