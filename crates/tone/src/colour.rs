//! The colour of the noise at a line: its spectral density there, by an autoregression of the
//! second order of the residuals.
//!
//! Residuals are not the noise. What the solution has taken of it is missing, at every line and at
//! the baseline: of white noise that leaves holes next to the main line, and an autoregression
//! takes them for colour. So what white noise would lack is added again.

use crate::phase::{cos_sin, from_turns};
use crate::solve::Solution;
use core::f32::consts::PI;

/// Lags of the residuals' correlation.
pub const LAGS: usize = 3;
/// Least share of the noise that the autoregression leaves unexplained.
const INNOVATION_MIN: f32 = 1e-3;

/// The noise at a line, over white noise.
#[derive(Clone, Copy, Debug)]
pub struct Colour {
    /// Its spectral density.
    pub density: f32,
    /// Its power in the blocks' band about the line.
    pub band: f32,
    /// Power of the residuals in that band: what the baseline and other lines have taken is not in
    /// it.
    pub residual: f32,
}

impl Colour {
    /// Of the residuals' correlation over the blocks at `u`, about harmonic `main`, 0 the
    /// fundamental: sums over the blocks and both quadratures, in units of the channels' noise.
    pub fn new(lags: &[f32; LAGS], main: usize, solution: &Solution, u: &[f32]) -> Self {
        let blocks = u.len() as f32;
        // Of cosine and sine together, for each channel; the main line has taken one block's worth.
        let white = solution.width as f32;
        let correlation =
            |lag: usize| lags[lag % LAGS] / ((blocks - lag as f32).max(1.0) * white) + 1.0 / blocks;
        let residual = correlation(0).max(f32::MIN_POSITIVE);
        let taken = taken(main, solution, u);
        let correlation = |lag: usize| correlation(lag) + taken[lag % LAGS];
        let band = correlation(0).max(f32::MIN_POSITIVE);
        let (one, two) = (correlation(1) / band, correlation(2) / band);
        let spread = (1.0 - one * one).max(INNOVATION_MIN);
        let (first, second) = (one * (1.0 - two) / spread, (two - one * one) / spread);
        let unexplained = (1.0 - first * one - second * two).max(INNOVATION_MIN);
        let gain = (1.0 - first - second).max(0.1);
        Self {
            density: band * unexplained / (gain * gain),
            band,
            residual,
        }
    }
}

/// What the baseline and the other lines have taken of white noise's correlation about the main
/// line, lag by lag.
///
/// A line takes the noise at its frequency and at minus that. Seen from the main line both are
/// waves, which a block's sum weakens to sin(pi t) / (pi t), t turns a block. Level, slope and
/// curves are as lines without a frequency.
fn taken(main: usize, solution: &Solution, u: &[f32]) -> [f32; LAGS] {
    let [first, second, ..] = u else {
        return [0.0; LAGS];
    };
    let (of_one, mut taken) = (solution.nu * (second - first), [0.0; LAGS]);
    let lines = solution.shape.harmonics;
    for wave in 0..=2 * lines {
        let (harmonic, is_mirrored) = (wave / 2, wave % 2 == 1);
        // How many there are, and how many fundamentals away.
        let (count, apart) = match () {
            () if harmonic == lines => (2 + solution.shape.curves, main + 1),
            () if is_mirrored => (1, harmonic + main + 2),
            () => (1, harmonic.abs_diff(main)),
        };
        if apart == 0 {
            continue;
        }
        let turns = of_one * apart as f32;
        let (_, sin) = cos_sin(from_turns(0.5 * turns));
        let weak = sin / (PI * turns);
        let share = count as f32 * weak * weak / u.len() as f32;
        let cos = 1.0 - 2.0 * sin * sin;
        for (taken, cos) in taken.iter_mut().zip([1.0, cos, 2.0 * cos * cos - 1.0]) {
            *taken += share * cos;
        }
    }
    taken
}

#[cfg(test)]
mod tests {
    extern crate std;

    use super::*;
    use crate::solve::Shape;
    use std::f64::consts::TAU;
    use std::vec::Vec;

    const BLOCKS: usize = 12;
    const FRAMES: usize = 96;

    /// The correlation of what least squares leave of white noise, exactly: their projection, in
    /// f64.
    fn exact(cycles: f64, harmonics: usize, main: usize) -> [f64; LAGS] {
        let u = |i: usize| (2 * i + 1) as f64 / FRAMES as f64 - 1.0;
        let mut basis: Vec<Vec<f64>> = std::vec![
            (0..FRAMES).map(|_| 1.0).collect(),
            (0..FRAMES).map(u).collect()
        ];
        for h in 1..=harmonics {
            let angle = |i: usize| 0.5 * TAU * cycles * h as f64 * u(i);
            basis.push((0..FRAMES).map(|i| angle(i).cos()).collect());
            basis.push((0..FRAMES).map(|i| angle(i).sin()).collect());
        }
        // Gram and Schmidt.
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        for k in 0..basis.len() {
            let (known, rest) = basis.split_at_mut(k);
            for other in known {
                let along = dot(&rest[0], other);
                rest[0]
                    .iter_mut()
                    .zip(other.iter())
                    .for_each(|(value, other)| *value -= along * other);
            }
            let length = dot(&rest[0], &rest[0]).sqrt();
            rest[0].iter_mut().for_each(|value| *value /= length);
        }
        // A block's sums with cosine and sine of the main line, turned to the window's centre: of
        // unit power in white noise.
        let in_block = FRAMES / BLOCKS;
        let wave = |b: usize, quadrature: usize| -> Vec<f64> {
            let of = |i: usize| {
                let angle =
                    0.5 * TAU * cycles * (main + 1) as f64 * u(i) - 0.25 * TAU * quadrature as f64;
                if i / in_block == b {
                    angle.cos() / (in_block as f64).sqrt()
                } else {
                    0.0
                }
            };
            (0..FRAMES).map(of).collect()
        };
        let left = |a: &[f64], b: &[f64]| {
            dot(a, b) - basis.iter().map(|e| dot(a, e) * dot(b, e)).sum::<f64>()
        };
        core::array::from_fn(|lag| {
            let pairs =
                (lag..BLOCKS).flat_map(|b| [0, 1].map(|q| left(&wave(b, q), &wave(b - lag, q))));
            pairs.sum::<f64>()
        })
    }

    /// White noise has no colour, whatever its solution has taken of it.
    #[test]
    fn white_noise_is_white_behind_its_solution() {
        let u: [f32; BLOCKS] = core::array::from_fn(|b| (2 * b + 1) as f32 / BLOCKS as f32 - 1.0);
        for (cycles, harmonics, main) in [
            (2.2, 4, 0),
            (3.0, 4, 0),
            (3.7, 4, 0),
            (3.3, 3, 1),
            (5.1, 2, 0),
            (7.4, 1, 0),
        ] {
            let shape = Shape {
                harmonics,
                ..Shape::default()
            };
            let solution = Solution {
                nu: 0.5 * cycles as f32,
                shape,
                width: 1,
                ..Solution::NONE
            };
            let exact = exact(cycles, harmonics, main);
            let Colour {
                density,
                band,
                residual,
            } = Colour::new(&exact.map(|lag| lag as f32), main, &solution, &u);
            assert!(
                (0.88..1.1).contains(&density) && (0.95..1.05).contains(&band),
                "{cycles}: {density} {band}"
            );
            // The residuals' own correlation, with the main line's part added, is what says that
            // there is colour.
            let own = exact[0] / BLOCKS as f64 + 1.0 / BLOCKS as f64;
            assert!(
                (f64::from(residual) - own).abs() < 1e-5 && residual < band,
                "{cycles}: {residual}"
            );
        }
    }

    /// An autoregression of the first order, r, has the density (1 + r) / (1 - r) at the line.
    #[test]
    fn an_autoregression_has_its_own_density() {
        let u: [f32; 1000] = core::array::from_fn(|b| (2 * b + 1) as f32 / 1000.0 - 1.0);
        let solution = Solution {
            nu: 100.3,
            width: 4,
            ..Solution::NONE
        };
        for r in [-0.5, 0.0, 0.3, 0.8f32] {
            let lags = [1.0, r, r * r];
            let sums = core::array::from_fn(|lag| lags[lag] * 4.0 * (1000 - lag) as f32);
            let of = Colour::new(&sums, 0, &solution, &u);
            let expected = (1.0 + r) / (1.0 - r);
            assert!(
                (of.density / expected - 1.0).abs() < 0.02 && (of.band - 1.0).abs() < 0.01,
                "{r}: {of:?}"
            );
        }
    }
}
