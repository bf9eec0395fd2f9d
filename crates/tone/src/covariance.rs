//! Covariance of the channels' noise from few samples, by shrinkage.
//!
//! O. Ledoit, M. Wolf, "A well-conditioned estimator for large-dimensional covariance matrices",
//! Journal of Multivariate Analysis 88 (2004), 365-411; here correlations are shrunk towards zero,
//! and variances towards a common multiple of those over all frames.

use crate::limits::CHANNELS_MAX;
use crate::matrix::{Factor, Square, invert};
use crate::source::Values;

/// Rounding variance that is added, as a fraction of a channel's own variance.
pub const ROUNDING: f32 = 5e-7;

/// Number and kind of the noise samples.
#[derive(Clone, Copy, Debug)]
pub struct Samples {
    /// Number of channels.
    pub width: usize,
    pub count: f32,
    /// Effective number: equally weighted samples with the same information.
    pub effective: f32,
    /// True if channels may be correlated.
    pub may_share: bool,
}

/// A shrunk covariance and its inverse.
#[derive(Clone, Copy, Debug)]
pub struct Covariance {
    pub variances: Values,
    /// Shrinkage towards the diagonal.
    pub shrinkage: f32,
    /// Effective number of uncorrelated channels.
    pub channels: f32,
}

impl Covariance {
    pub const NONE: Self = Self {
        variances: [0.0; CHANNELS_MAX],
        shrinkage: 1.0,
        channels: 1.0,
    };
}

impl Samples {
    /// Shrinks the covariance, and replaces the samples' products (on and below the diagonal) by
    /// the inverse covariance; `all` holds variances over all frames.
    #[inline(never)]
    pub fn invert(&self, products: &mut Square<CHANNELS_MAX>, all: Option<&Values>) -> Covariance {
        let c = self.width.min(CHANNELS_MAX);
        let own: Values = core::array::from_fn(|k| products[k][k] / self.count + ROUNDING);
        let variances = all.map_or(own, |all| self.shrunk(&own, all));
        let mut squares = 0.0;
        if self.may_share {
            let inverse = own.map(|own| 1.0 / crate::sqrt(self.count * own.max(f32::MIN_POSITIVE)));
            for k in 0..c {
                for l in 0..k {
                    products[k][l] *= inverse[k] * inverse[l];
                    squares += 2.0 * products[k][l] * products[k][l];
                }
            }
        }
        let shrinkage = if self.may_share && c > 1 {
            ((c * (c - 1)) as f32 / self.effective / squares.max(f32::MIN_POSITIVE)).min(1.0)
        } else {
            1.0
        };
        if shrinkage < 1.0 {
            let deviations = variances.map(crate::sqrt);
            for k in 0..c {
                for l in 0..k {
                    products[k][l] *= (1.0 - shrinkage) * deviations[k] * deviations[l];
                }
                products[k][k] = variances[k];
            }
            Factor::new(products, c);
            invert(products, c);
        } else {
            *products = [[0.0; CHANNELS_MAX]; CHANNELS_MAX];
            for k in 0..c {
                products[k][k] = 1.0 / variances[k];
            }
        }
        let kept = (1.0 - shrinkage) * (1.0 - shrinkage) * squares;
        Covariance {
            variances,
            shrinkage,
            channels: (c * c) as f32 / (c as f32 + kept),
        }
    }

    /// Shrinks the samples' variances `own` towards a common multiple of `all`.
    fn shrunk(&self, own: &Values, all: &Values) -> Values {
        let mut variances = *own;
        let count = self.width.min(CHANNELS_MAX);
        let width = count as f32;
        let ratio = |k: usize| own[k] / all[k];
        let mean = (0..count).map(ratio).sum::<f32>() / width;
        let spread = (0..count)
            .map(|k| (ratio(k) - mean) * (ratio(k) - mean))
            .sum::<f32>()
            / width;
        let fraction =
            (2.0 / self.effective * mean * mean / spread.max(f32::MIN_POSITIVE)).min(1.0);
        for k in 0..count {
            variances[k] = fraction * mean * all[k] + (1.0 - fraction) * own[k];
        }
        variances
    }
}

/// Returns x' W y; unused channels must be zero.
pub fn form(x: &Values, weights: &Square<CHANNELS_MAX>, y: &Values) -> f32 {
    let rows = x.iter().zip(weights).filter(|(x, _)| **x != 0.0);
    rows.map(|(x, row)| x * row.iter().zip(y).map(|(w, y)| w * y).sum::<f32>())
        .sum()
}

/// Returns x' W x for symmetric weights, in groups of four up to the diagonal; unused channels must
/// be zero.
pub fn power(x: &Values, weights: &Square<CHANNELS_MAX>) -> f32 {
    let groups = x.as_chunks::<4>().0;
    let mut power = 0.0;
    for (k, (own, row)) in x.iter().zip(weights).enumerate() {
        if *own == 0.0 {
            continue;
        }
        let mut products = row
            .as_chunks::<4>()
            .0
            .iter()
            .zip(groups)
            .map(|(w, x)| w[0] * x[0] + w[1] * x[1] + w[2] * x[2] + w[3] * x[3]);
        let below: f32 = products.by_ref().take(k / 4).sum();
        power += own * (2.0 * below + products.next().unwrap_or_default());
    }
    power
}

/// Adds the products of the channels of two samples, on and below the diagonal, in groups of four.
pub fn add_products(products: &mut [Values], [one, other]: [&Values; 2]) {
    for (k, row) in products.iter_mut().enumerate().take(CHANNELS_MAX) {
        let own = [one[k], other[k]];
        let groups = one.as_chunks::<4>().0.iter().zip(other.as_chunks::<4>().0);
        let rows = row.as_chunks_mut::<4>().0.iter_mut();
        for (sums, (one, other)) in rows.zip(groups).take(k / 4 + 1) {
            for i in 0..4 {
                sums[i] += own[0] * one[i] + own[1] * other[i];
            }
        }
    }
}

/// Adds `weight` times the products of the channels of a sample, on and below the diagonal; unused
/// channels must be zero.
pub fn add_product(products: &mut Square<CHANNELS_MAX>, weight: f32, values: &Values) {
    for (k, row) in products.iter_mut().enumerate() {
        let own = weight * values[k];
        if own == 0.0 {
            continue;
        }
        let groups = values.as_chunks::<4>().0;
        let rows = row.as_chunks_mut::<4>().0.iter_mut();
        for (sums, values) in rows.zip(groups).take(k / 4 + 1) {
            for i in 0..4 {
                sums[i] += own * values[i];
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SAMPLES: Samples = Samples {
        width: 2,
        count: 50.0,
        effective: 50.0,
        may_share: true,
    };

    #[test]
    fn a_correlation_that_few_samples_may_have_by_chance_is_taken_away() {
        let mut products = [[0.0; CHANNELS_MAX]; CHANNELS_MAX];
        (products[0][0], products[1][1]) = (50.0, 200.0);
        (products[0][1], products[1][0]) = (10.0, 10.0);
        let covariance = SAMPLES.invert(&mut products, None);
        assert_eq!(covariance.shrinkage, 1.0);
        assert_eq!(covariance.channels, 2.0);
        assert!((products[1][1] - 0.25).abs() < 1e-6 && products[0][1] == 0.0);
    }

    #[test]
    fn a_strong_correlation_stays() {
        let mut products = [[0.0; CHANNELS_MAX]; CHANNELS_MAX];
        (products[0][0], products[1][1]) = (50.0, 50.0);
        (products[0][1], products[1][0]) = (45.0, 45.0);
        let covariance = SAMPLES.invert(&mut products, None);
        assert!(covariance.shrinkage < 0.03 && covariance.channels < 1.2);
        // The inverse of [[1, r], [r, 1]] is [[1, -r], [-r, 1]] / (1 - r^2).
        let r = -products[0][1] / products[0][0];
        assert!(r > 0.87, "{r}");
        assert!((products[0][0] * (1.0 - r * r) - 1.0).abs() < 1e-4);
        assert_eq!(products[0][1], products[1][0]);
    }
}
