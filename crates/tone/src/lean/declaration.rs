//! Tests of the scene's declaration: are the residuals of the blocks white and independent?
//!
//! Three F ratios. The levels of the blocks tell drift and noise that is stronger at low
//! frequencies; cosine and sine in each block tell a tone that changes, and another one next to it;
//! correlations of the levels between channels tell noise that channels share.

use super::blocks::{Block, Blocks, Rows};
use super::reference::Reference;
use super::solve::{FUNCTIONS, Solution, Turned};
use crate::limits::CHANNELS_MAX;
use crate::significance::deviate;
use crate::source::Values;

/// Deviate of each of them: one of 100,000 is above.
const Z: f32 = 4.3;

/// Deviates of the tests.
#[derive(Clone, Copy, Debug, Default)]
pub struct Declared {
    /// Of the levels.
    pub levels: f32,
    /// Of cosine and sine.
    pub lines: f32,
    /// Of the correlations between channels.
    pub shared: f32,
}

impl Declared {
    /// The largest of the three.
    pub fn worst(&self) -> f32 {
        self.levels.max(self.lines).max(self.shared)
    }

    /// True if the window is what the scene declares.
    pub fn is_met(&self) -> bool {
        self.worst() <= Z
    }
}

/// Tests what a solution leaves of the blocks.
#[inline(never)]
pub fn test(blocks: &Blocks, reference: &Reference, solution: &Solution) -> Declared {
    let (mut levels, mut lines, mut explained, mut count) = (0.0, 0.0, 0.0, 0.0f32);
    let mut products = [[0.0; CHANNELS_MAX]; CHANNELS_MAX];
    for (block, sums) in blocks.iter() {
        let turned = Turned::new(block, solution.turn);
        let [level, cos, sin] = residuals(block, sums, &turned, solution);
        let inverse = 1.0 / block.frames;
        levels += inverse * power(&level, &solution.weights);
        lines += inverse * (power(&cos, &solution.weights) + power(&sin, &solution.weights));
        let [c, s] = turned.wave;
        explained += 2.0 * inverse * (c * c + s * s);
        count += 1.0;
        let root = libm::sqrtf(inverse);
        let level = level.map(|x| root * x);
        for i in 0..CHANNELS_MAX {
            for j in 0..=i {
                products[i][j] += level[i] * level[j];
            }
        }
    }
    let width = reference.width as f32;
    // A line of many cycles a block has no part in the levels.
    let of_levels = (count - 2.0 - explained / blocks.frames()).max(1.0);
    let of_lines = (count - 0.5 * FUNCTIONS as f32).max(1.0);
    let freedom = width * solution.freedom;
    Declared {
        levels: deviate(levels / (width * of_levels), width * of_levels, freedom),
        lines: deviate(lines / (width * of_lines), width * of_levels, freedom),
        shared: correlation(&products, solution, of_levels),
    }
}

/// What the fit leaves of a block's sums: of the values, and of their products with cosine and sine.
fn residuals(block: &Block, sums: &Rows, turned: &Turned, solution: &Solution) -> Rows {
    let (n, u) = (block.frames, block.middle);
    let [c, s] = turned.wave;
    let [x, y] = turned.turn;
    let [cc, ss] = [0.5 * (n + turned.double[0]), 0.5 * (n - turned.double[0])];
    let cs = 0.5 * turned.double[1];
    let along = [u * c + turned.moment[0], u * s + turned.moment[1]];
    let [level, slope, a, b] = &solution.coefficients;
    let [levels, cosines, sines] = sums;
    let mut left = [[0.0; CHANNELS_MAX]; 3];
    for k in 0..CHANNELS_MAX {
        let (l, t, a, b) = (level[k], slope[k], a[k], b[k]);
        let cos = cosines[k] * x - sines[k] * y;
        let sin = sines[k] * x + cosines[k] * y;
        left[0][k] = levels[k] - (l * n + t * (u * n + block.d) + a * c + b * s);
        left[1][k] = cos - (l * c + t * along[0] + a * cc + b * cs);
        left[2][k] = sin - (l * s + t * along[1] + a * cs + b * ss);
    }
    left
}

/// Sum of the squares of the channels, weighted.
fn power(values: &Values, weights: &Values) -> f32 {
    let squares = values.iter().zip(weights);
    squares.map(|(value, weight)| weight * value * value).sum()
}

/// Deviate of the mean square of the correlations between channels.
fn correlation(
    products: &[[f32; CHANNELS_MAX]; CHANNELS_MAX],
    solution: &Solution,
    freedom: f32,
) -> f32 {
    let weights = &solution.weights;
    // Rounding is no noise of its own.
    let own = |k: usize| products[k][k] + freedom * solution.rounding[k];
    let (mut sum, mut pairs) = (0.0, 0.0f32);
    for i in 0..CHANNELS_MAX {
        for j in 0..i {
            if weights[i] > 0.0 && weights[j] > 0.0 {
                sum += products[i][j] * products[i][j] / (own(i) * own(j));
                pairs += 1.0;
            }
        }
    }
    if pairs < 1.0 {
        return 0.0;
    }
    deviate(freedom * sum / pairs, pairs, 1e6)
}
