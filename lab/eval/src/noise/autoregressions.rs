//! A sum of first-order autoregressions and white noise, whitened exactly by a Kalman filter.
//!
//! Source: Harvey, "Forecasting, structural time series models and the Kalman filter" (1989),
//! section 3.4.

use crate::bound::{Clue, orthonormal};

/// A process.
#[derive(Clone, Debug, PartialEq)]
pub struct Autoregressions {
    /// Factor and variance of each autoregression.
    pub parts: Vec<(f64, f64)>,
    /// Variance of the white noise.
    pub white: f64,
}

impl Autoregressions {
    /// The values of some columns, whitened in place.
    fn whiten(&self, columns: &mut [Vec<f64>]) {
        let parts = &self.parts;
        let count = parts.len();
        // Covariance of the parts' prediction, and the prediction of each column's.
        let mut covariance: Vec<Vec<f64>> = (0..count)
            .map(|i| {
                (0..count)
                    .map(|j| if i == j { parts[i].1 } else { 0.0 })
                    .collect()
            })
            .collect();
        let mut predicted = vec![vec![0.0; count]; columns.len()];
        for n in 0..columns.first().map_or(0, Vec::len) {
            let sums: Vec<f64> = covariance.iter().map(|row| row.iter().sum()).collect();
            let variance = sums.iter().sum::<f64>() + self.white;
            for (column, predicted) in columns.iter_mut().zip(&mut predicted) {
                let innovation = column[n] - predicted.iter().sum::<f64>();
                column[n] = innovation / variance.sqrt();
                for ((value, sum), (factor, _)) in predicted.iter_mut().zip(&sums).zip(parts) {
                    *value = factor * (*value + sum / variance * innovation);
                }
            }
            for i in 0..count {
                for j in 0..count {
                    let (a, b) = (parts[i].0, parts[j].0);
                    let kick = if i == j {
                        (1.0 - a * a) * parts[i].1
                    } else {
                        0.0
                    };
                    covariance[i][j] =
                        a * b * (covariance[i][j] - sums[i] * sums[j] / variance) + kick;
                }
            }
        }
    }

    /// What values say of the frequency, if `derivative` is theirs by it and `nuisance` is unknown.
    pub fn clues(&self, nuisance: &[Vec<f64>], channels: &[[&[f64]; 2]]) -> Vec<Clue> {
        let mut columns = nuisance.to_vec();
        columns.extend(channels.iter().flatten().map(|column| column.to_vec()));
        self.whiten(&mut columns);
        let whitened = columns.split_off(nuisance.len());
        let basis = orthonormal(columns);
        let clue = |pair: &[Vec<f64>]| Clue::of(pair[0].clone(), &pair[1], &basis);
        whitened.chunks_exact(2).map(clue).collect()
    }
}
