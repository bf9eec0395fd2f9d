//! The bound of a window whose noise is neither white nor independent: that of its full covariance.
//!
//! All processes here are sums of autoregressions of the first order and of white noise, so a
//! Kalman filter whitens them exactly: its innovations, each over its standard deviation, are the
//! values times the inverse of the covariance's Cholesky factor. A disturbance that all channels
//! share with gains of their own lives in as many mixtures of channels as it has parts; all
//! mixtures at right angles to these hold white noise alone. Level, slope and amplitudes are
//! unknown in each channel, and so in each mixture: mixtures share nothing but the frequency, and
//! their information adds up.
//!
//! Source: S. M. Kay, "Fundamentals of Statistical Signal Processing: Estimation Theory" (1993),
//! section 3.9; Harvey, "Forecasting, structural time series models and the Kalman filter" (1989),
//! section 3.4.

use super::autoregressions::Autoregressions;
use super::process::Covariance;
use super::window::Window;
use crate::bound::Clue;
use ridgetone_proto::settings::TAXELS;
use std::f64::consts::TAU;

/// What a window says of its frequency, in cycles per frame; none where its noise or its tone has
/// no bound here.
pub fn clue(window: &Window) -> Option<Clue> {
    let truth = window.truth.as_ref()?;
    let frames = window.values.len();
    let centred = |n: usize| n as f64 - 0.5 * (frames as f64 - 1.0);
    let mut nuisance = vec![vec![1.0; frames], (0..frames).map(centred).collect()];
    nuisance.extend(truth.shapes.iter().cloned());
    for h in (1..=truth.harmonics).map(|h| h as f64) {
        let (sin, cos) = (0..frames)
            .map(|n| (TAU * h * window.mean.unwrap_or(0.0) * centred(n)).sin_cos())
            .unzip();
        nuisance.extend([cos, sin]);
    }
    let column = |of: &[[f64; TAXELS]], weights: &[f64; TAXELS]| -> Vec<f64> {
        of.iter()
            .map(|frame| {
                frame
                    .iter()
                    .zip(weights)
                    .map(|(value, weight)| value * weight)
                    .sum()
            })
            .collect()
    };
    let mixtures = |weights: &[[f64; TAXELS]]| -> Vec<[Vec<f64>; 2]> {
        weights
            .iter()
            .map(|weights| {
                [
                    column(&truth.derivative, weights),
                    column(&truth.values, weights),
                ]
            })
            .collect()
    };
    let clues = |process: &Autoregressions, columns: &[[Vec<f64>; 2]]| {
        let columns: Vec<[&[f64]; 2]> = columns
            .iter()
            .map(|[a, b]| [a.as_slice(), b.as_slice()])
            .collect();
        process.clues(&nuisance, &columns)
    };
    let single: [[f64; TAXELS]; TAXELS] =
        std::array::from_fn(|c| std::array::from_fn(|k| f64::from(u8::from(k == c))));
    let channels = mixtures(&single);
    match &truth.covariance {
        Covariance::Independent(process) => {
            let process = Autoregressions {
                white: process.white + truth.rounding,
                ..process.clone()
            };
            Some(Clue::sum(&clues(&process, &channels)))
        }
        Covariance::Shared {
            process,
            gains,
            white,
        } => {
            let white = Autoregressions {
                parts: Vec::new(),
                white: white + truth.rounding,
            };
            let mut all = Clue::sum(&clues(&white, &channels));
            for (direction, power) in directions(gains) {
                let columns = mixtures(&[direction]);
                // A mixture that the disturbance is in: with it instead of without.
                let without = Clue::sum(&clues(&white, &columns));
                let times = |(factor, variance): &(f64, f64)| (*factor, power * variance);
                let parts = process.parts.iter().map(times).collect();
                let with = Clue::sum(&clues(
                    &Autoregressions {
                        parts,
                        white: white.white,
                    },
                    &columns,
                ));
                all.information += with.information - without.information;
                all.score += with.score - without.score;
            }
            Some(all)
        }
    }
}

/// Mixtures of channels at right angles to each other in which disturbances of these gains and of
/// equal power are uncorrelated, and the power in each.
fn directions(gains: &[[f64; 2]; TAXELS]) -> Vec<([f64; TAXELS], f64)> {
    let product = |i: usize, j: usize| gains.iter().map(|gain| gain[i] * gain[j]).sum::<f64>();
    let angle = 0.5 * (2.0 * product(0, 1)).atan2(product(0, 0) - product(1, 1));
    let turned = |cos: f64, sin: f64| -> ([f64; TAXELS], f64) {
        let mixture = gains.map(|gain| cos * gain[0] + sin * gain[1]);
        let power: f64 = mixture.iter().map(|value| value * value).sum();
        (mixture.map(|value| value / power.sqrt()), power)
    };
    let both = [
        turned(angle.cos(), angle.sin()),
        turned(-angle.sin(), angle.cos()),
    ];
    both.into_iter()
        .filter(|(_, power)| *power > 1e-9)
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::draw::Draw;
    use crate::noise::parts::{Extra, Speed, Tone};
    use crate::noise::process::Noise;
    use crate::noise::window::Recipe;
    use nalgebra::{DMatrix, DVector};

    fn window(noise: Noise, frames: usize, seed: u64) -> Window {
        let harmonics = [1.0, 0.4, 0.0, 0.0, 0.0];
        let tone = Tone {
            cycles: (2.0, 6.0),
            harmonics,
            snr_db: 20.0,
            speed: Speed::Steady,
        };
        Recipe {
            noise,
            tone: Some(tone),
            extra: Extra::Nothing,
        }
        .make(frames, 241.14, &mut Draw::new(seed))
    }

    /// By the whole covariance of all channels and frames as a matrix, and the Fisher information
    /// of all unknowns.
    fn dense(window: &Window) -> f64 {
        let (truth, frames) = (window.truth.as_ref().expect("truth"), window.values.len());
        let lag = |process: &Autoregressions, apart: usize| -> f64 {
            process
                .parts
                .iter()
                .map(|(factor, variance)| variance * factor.powi(apart as i32))
                .sum()
        };
        let covariance = DMatrix::from_fn(TAXELS * frames, TAXELS * frames, |i, j| {
            let ((c, n), (d, m)) = ((i / frames, i % frames), (j / frames, j % frames));
            let same = f64::from(u8::from(i == j));
            let of_noise = match &truth.covariance {
                Covariance::Independent(process) if c == d => {
                    lag(process, n.abs_diff(m)) + same * process.white
                }
                Covariance::Independent(_) => 0.0,
                Covariance::Shared {
                    process,
                    gains,
                    white,
                } => {
                    (gains[c][0] * gains[d][0] + gains[c][1] * gains[d][1])
                        * lag(process, n.abs_diff(m))
                        + same * white
                }
            };
            of_noise + same * truth.rounding
        });
        let mean = window.mean.expect("a tone");
        let unknown = |n: usize, k: usize| match (k, TAU * (k / 2) as f64 * mean * n as f64) {
            (0, _) => 1.0,
            (1, _) => n as f64 / frames as f64,
            (k, angle) if k % 2 == 0 => angle.cos(),
            (_, angle) => angle.sin(),
        };
        let each = 2 + 2 * truth.harmonics;
        let columns = DMatrix::from_fn(TAXELS * frames, TAXELS * each + 1, |i, k| {
            let (c, n) = (i / frames, i % frames);
            match k.checked_sub(1) {
                None => truth.derivative[n][c],
                Some(k) if k / each == c => unknown(n, k % each),
                Some(_) => 0.0,
            }
        });
        let whitened = covariance
            .cholesky()
            .expect("a covariance")
            .l()
            .solve_lower_triangular(&columns)
            .expect("whole");
        let information = whitened.transpose() * whitened;
        let first = DVector::from_fn(information.nrows(), |i, _| f64::from(u8::from(i == 0)));
        1.0 / information.cholesky().expect("information").solve(&first)[0]
    }

    #[test]
    fn it_is_that_of_the_covariance_as_a_matrix() {
        for noise in [
            Noise::White,
            Noise::Pink,
            Noise::Ar(0.9),
            Noise::SharedPink,
            Noise::SharedPhases,
        ] {
            let window = window(noise, 40, 5);
            let (clue, dense) = (clue(&window).expect("a bound"), dense(&window));
            assert!(
                (clue.information / dense - 1.0).abs() < 1e-6,
                "{noise:?}: {} {dense}",
                clue.information
            );
        }
    }

    /// The error of an estimator on the bound has the bound's mean square.
    #[test]
    fn the_error_on_the_bound_has_the_mean_square_of_the_bound() {
        for noise in [
            Noise::White,
            Noise::Pink,
            Noise::Ar(0.6),
            Noise::SharedPink,
            Noise::SharedPhases,
        ] {
            let squares = (0..400).map(|seed| clue(&window(noise, 96, seed)).expect("a bound"));
            let mean = squares
                .map(|clue| clue.score.powi(2) / clue.information)
                .sum::<f64>()
                / 400.0;
            // Four standard deviations of a chi-square of 400 over its mean.
            assert!((0.72..1.28).contains(&mean), "{noise:?}: {mean}");
        }
    }
}
