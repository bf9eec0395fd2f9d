//! Least squares of all channels from the blocks, and Gauss-Newton steps of the common frequency.
//!
//! Each channel has a level, a slope, a cosine and a sine. The derivative by the frequency is a
//! combination of two more functions, the cosine and the sine times `u`, taken as constant in a
//! block: what they have beside the first four gives the step of all channels at once (variable
//! projection: G. H. Golub and V. Pereyra, SIAM J. Numer. Anal. 10 (1973) 413).

use super::blocks::{Block, Blocks, Rows, Wave};
use super::reference::Reference;
use crate::limits::CHANNELS_MAX;
use crate::phase::{cos_sin, from_turns};
use crate::source::Values;
use core::f32::consts::{FRAC_1_PI, PI};

/// Functions of a channel: level, slope, cosine, sine.
pub const FUNCTIONS: usize = 4;
/// The same with the two of the derivative.
const ALL: usize = FUNCTIONS + 2;
/// Least share of a function's square that the ones before it leave.
const LEFT: f32 = 1e-4;
/// Rounding of what a fit leaves of a channel's sum of squares, as a fraction of that sum.
const ROUNDING: f32 = 6e-7;
/// Largest step, radians at the window's end: half a cycle a window.
const STEP_MAX: f32 = 0.5 * PI;

/// Fit of all channels at one frequency.
#[derive(Clone, Copy, Debug, Default)]
pub struct Solution {
    /// Turn of the phase against that of the blocks, radians at `u` = 1.
    pub turn: f32,
    /// Standard deviation of the turn.
    pub turn_sigma: f32,
    /// Score of the turn, in units of the information.
    step: f32,
    /// Lower factor of the functions' products.
    lower: [[f32; ALL]; ALL],
    /// Projections of the channels on the functions, orthonormal.
    pub projections: [Values; FUNCTIONS],
    /// Coefficients of the functions.
    pub coefficients: [Values; FUNCTIONS],
    /// One over the variance of the noise.
    pub weights: Values,
    /// Variances of the residuals.
    pub variances: Values,
    /// Part of the variances that is rounding of sums.
    pub rounding: Values,
    /// Degrees of freedom of each channel's residuals.
    pub freedom: f32,
    /// Sum of the squares of all residuals.
    left: f32,
}

/// A block's sums at a turned phase.
pub struct Turned {
    pub turn: Wave,
    pub wave: Wave,
    pub double: Wave,
    pub moment: Wave,
}

impl Turned {
    /// Turns a block by `turn` radians at `u` = 1.
    pub fn new(block: &Block, turn: f32) -> Self {
        let (c, s) = cos_sin(from_turns(0.5 * FRAC_1_PI * turn * block.middle));
        let turn = [c, s];
        Self {
            turn,
            wave: times(block.wave, turn),
            double: times(block.double, times(turn, turn)),
            moment: times(block.moment, turn),
        }
    }
}

impl Solution {
    /// The best of some starts, cycles from the blocks' frequency, after a few steps each.
    pub fn best_of(blocks: &Blocks, reference: &Reference, starts: &[f32], steps: usize) -> Self {
        let mut best = Self {
            left: f32::INFINITY,
            ..Self::default()
        };
        for start in starts {
            let mut solution = Self::at(blocks, reference, PI * start);
            for _ in 0..steps {
                solution = Self::at(blocks, reference, solution.turn + solution.step());
            }
            if solution.left < best.left && blocks.cycles + solution.cycles() > 0.0 {
                best = solution;
            }
        }
        best
    }

    /// Solves for the channels with the blocks turned.
    #[inline(never)]
    pub fn at(blocks: &Blocks, reference: &Reference, turn: f32) -> Self {
        let mut solution = Self {
            turn,
            ..Self::default()
        };
        let mut rows = [[0.0; CHANNELS_MAX]; ALL];
        [rows[0], rows[1], _] = blocks.sums;
        let mut gram = [[0.0; ALL]; ALL];
        let [n, u, uu] = blocks.powers;
        (gram[0][0], gram[1][0], gram[1][1]) = (n, u, uu);
        for (block, sums) in blocks.iter() {
            let turned = Turned::new(block, turn);
            add_products(&mut gram, block, &turned);
            add_rows(&mut rows, sums, block.middle, turned.turn);
        }
        solution.lower = factor(gram);
        solution.solve(&mut rows, blocks, reference);
        solution
    }

    /// Projections, residuals, weights and the step.
    fn solve(&mut self, rows: &mut [Values; ALL], blocks: &Blocks, reference: &Reference) {
        let lower = &self.lower;
        for i in 0..ALL {
            for j in 0..i {
                let (done, rest) = rows.split_at_mut(i);
                let (from, factor) = (&done[j], lower[i][j]);
                rest[0]
                    .iter_mut()
                    .zip(from)
                    .for_each(|(to, x)| *to -= factor * x);
            }
            let inverse = if lower[i][i] > 0.0 {
                1.0 / lower[i][i]
            } else {
                0.0
            };
            rows[i].iter_mut().for_each(|to| *to *= inverse);
        }
        self.projections = [rows[0], rows[1], rows[2], rows[3]];
        let frames = blocks.frames();
        self.freedom = frames - FUNCTIONS as f32;
        let (mut score, mut information) = (0.0, 0.0);
        for c in 0..CHANNELS_MAX {
            if reference.inverse[c] <= 0.0 {
                continue;
            }
            let mut left = blocks.sums[2][c];
            for row in &self.projections {
                left -= row[c] * row[c];
            }
            let quantized = reference.rounding[c] * frames;
            let rounding = ROUNDING * blocks.sums[2][c];
            self.rounding[c] = rounding / self.freedom;
            let left = left.max(quantized) + rounding;
            let left = left.max(f32::MIN_POSITIVE);
            self.left += left;
            self.variances[c] = left / self.freedom;
            self.weights[c] = self.freedom / left;
            for i in (0..FUNCTIONS).rev() {
                let mut x = self.projections[i][c];
                for k in i + 1..FUNCTIONS {
                    x -= lower[k][i] * self.coefficients[k][c];
                }
                self.coefficients[i][c] = if lower[i][i] > 0.0 {
                    x / lower[i][i]
                } else {
                    0.0
                };
            }
            let (a, b) = (self.coefficients[2][c], self.coefficients[3][c]);
            // The derivative: b times the cosine times u, less a times the sine times u.
            let along = [b * lower[4][4] - a * lower[5][4], -a * lower[5][5]];
            score += self.weights[c] * (along[0] * rows[4][c] + along[1] * rows[5][c]);
            information += self.weights[c] * (along[0] * along[0] + along[1] * along[1]);
        }
        let information = information.max(f32::MIN_POSITIVE);
        self.step = score / information;
        self.turn_sigma = 1.0 / libm::sqrtf(information);
    }

    /// The next step, radians at `u` = 1.
    pub fn step(&self) -> f32 {
        self.step.clamp(-STEP_MAX, STEP_MAX)
    }

    /// Turn in cycles a window.
    pub fn cycles(&self) -> f32 {
        self.turn * FRAC_1_PI
    }

    /// Standard deviation of the frequency, cycles a window.
    pub fn sigma(&self) -> f32 {
        self.turn_sigma * FRAC_1_PI
    }

    /// Mean of the variances of a unit coefficient of cosine and sine.
    pub fn line_variance(&self) -> f32 {
        let (c, s) = (self.lower[2][2], self.lower[3][3]);
        if c > 0.0 && s > 0.0 {
            0.5 / (c * c) + 0.5 / (s * s)
        } else {
            f32::INFINITY
        }
    }
}

/// Adds a block's part of the functions' products, all but those of level and slope alone.
fn add_products(gram: &mut [[f32; ALL]; ALL], block: &Block, turned: &Turned) {
    let (n, u) = (block.frames, block.middle);
    let [c, s] = turned.wave;
    let along = [u * c + turned.moment[0], u * s + turned.moment[1]];
    let (cc, cs, ss) = (
        0.5 * (n + turned.double[0]),
        0.5 * turned.double[1],
        0.5 * (n - turned.double[0]),
    );
    let add = |row: &mut [f32; ALL], terms: &[f32]| {
        row.iter_mut().zip(terms).for_each(|(to, x)| *to += x);
    };
    add(&mut gram[2], &[c, along[0], cc]);
    add(&mut gram[3], &[s, along[1], cs, ss]);
    add(
        &mut gram[4],
        &[u * c, u * along[0], u * cc, u * cs, u * u * cc],
    );
    add(
        &mut gram[5],
        &[u * s, u * along[1], u * cs, u * ss, u * u * cs, u * u * ss],
    );
}

/// Adds a block's products of the channels with cosine and sine, turned, and the same times `u`.
#[inline(never)]
fn add_rows(rows: &mut [Values; ALL], sums: &Rows, u: f32, [x, y]: Wave) {
    let [_, cosines, sines] = sums;
    let [_, _, first, second, third, fourth] = rows;
    for c in 0..CHANNELS_MAX {
        let cos = cosines[c] * x - sines[c] * y;
        let sin = sines[c] * x + cosines[c] * y;
        first[c] += cos;
        second[c] += sin;
        third[c] += u * cos;
        fourth[c] += u * sin;
    }
}

/// Cholesky factor; a function that the ones before it explain gets a zero.
fn factor(mut gram: [[f32; ALL]; ALL]) -> [[f32; ALL]; ALL] {
    for i in 0..ALL {
        for j in 0..=i {
            let mut sum = gram[i][j];
            for k in 0..j {
                sum -= gram[i][k] * gram[j][k];
            }
            gram[i][j] = if i == j {
                if sum > LEFT * gram[i][i] {
                    libm::sqrtf(sum)
                } else {
                    0.0
                }
            } else if gram[j][j] > 0.0 {
                sum / gram[j][j]
            } else {
                0.0
            };
        }
    }
    gram
}

/// Product of two complex numbers.
fn times(a: Wave, b: Wave) -> Wave {
    [a[0] * b[0] - a[1] * b[1], a[0] * b[1] + a[1] * b[0]]
}
