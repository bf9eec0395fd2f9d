//! Least squares of all channels from the blocks, and Gauss-Newton steps of the common frequency.
//!
//! Each channel has a level, a slope, and a cosine and a sine of each line. The derivative by the
//! frequency is a combination of further functions: cosines and sines times `u`, taken as constant
//! in a block. Their components orthogonal to the first functions give the step of all channels at
//! once (variable projection: G. H. Golub and V. Pereyra, SIAM J. Numer. Anal. 10 (1973) 413).

use super::blocks::{BLOCKS, Block, Blocks, LINES, WAVES};
use super::reference::Reference;
use crate::limits::CHANNELS_MAX;
use crate::phase::{Wave, cos_sin, from_turns, line_products, times};
use crate::significance::square_root;
use crate::source::Values;
use core::f32::consts::{FRAC_1_PI, PI};

/// Maximum number of functions of a channel: level, slope, cosine and sine of each line.
const FUNCTIONS: usize = 2 + 2 * LINES;
/// Maximum number of functions, including those of the derivative.
const ALL: usize = FUNCTIONS + 2 * LINES;
/// Minimum fraction of a function's square left by the earlier functions.
const LEFT: f32 = 1e-4;
/// Rounding of a channel's sum of squared residuals, as a fraction of its sum of squares.
const ROUNDING: f32 = 6e-7;
/// Maximum step, radians at the window's end: half a cycle per window.
const STEP_MAX: f32 = 0.5 * PI;

/// Fit of all channels at one frequency.
#[derive(Clone, Copy, Debug)]
pub struct Solution {
    /// Rotation of the phase relative to the blocks, radians at `u` = 1.
    pub turn: f32,
    /// Standard deviation of the turn.
    pub turn_sigma: f32,
    /// Next step: score of the turn over its information.
    step: f32,
    /// Decrease of the residuals' squares by the step, in units of the noise.
    gain: f32,
    /// Numbers of the lines.
    orders: [usize; LINES],
    lines: usize,
    /// Lower Cholesky factor of the functions' products.
    lower: [[f32; ALL]; ALL],
    /// Inverse of the diagonal of `lower`; 0 for a linearly dependent function.
    inverse: [f32; ALL],
    /// Coefficients of the functions.
    pub coefficients: [Values; FUNCTIONS],
    /// Inverse variance of each channel's noise.
    pub weights: Values,
    /// Variances of the residuals.
    pub variances: Values,
    /// Part of the variances that is rounding of sums.
    pub rounding: Values,
    /// Degrees of freedom of each channel's residuals.
    pub freedom: f32,
    /// Sum of the squares of all residuals, over the reference's scales.
    pub left: f32,
    totals: Totals,
}

/// Sums of a block at a rotated phase: of the multiples from 0 on, and of the lines times `u`.
#[derive(Clone, Copy, Debug, Default)]
pub struct Turned {
    /// Rotation of each line, cosine and sine, from 1 on.
    pub turns: [Wave; LINES],
    pub waves: Waves,
    pub with_u: [Wave; LINES],
}

impl Turned {
    /// Rotates the first lines of a block by `turn` radians at `u` = 1; other lines are unchanged.
    #[inline(always)]
    pub fn set(&mut self, block: &Block, turn: f32, lines: usize) {
        let lines = lines.min(LINES);
        let (c, s) = cos_sin(from_turns(0.5 * FRAC_1_PI * turn * block.middle));
        self.waves[0] = [block.frames, 0.0];
        let mut power = [c, s];
        for m in 0..2 * lines {
            let wave = times(block.waves[m], power);
            self.waves[m + 1] = wave;
            if m < lines {
                let moment = times(block.moments[m], power);
                self.turns[m] = power;
                self.with_u[m] = [
                    block.middle * wave[0] + moment[0],
                    block.middle * wave[1] + moment[1],
                ];
            }
            power = times(power, [c, s]);
        }
    }
}

/// Sums of cosine and sine of each multiple of the phase, from 0 on.
pub type Waves = [Wave; WAVES + 1];

/// Sums over the blocks, from which the products of the functions are computed.
#[derive(Clone, Copy, Debug)]
struct Totals {
    /// Waves, waves times the block's `u`, and waves times the square of `u`.
    waves: [Waves; 3],
    /// Lines times `u`, and lines times `u` and the block's `u`.
    with_u: [[Wave; LINES]; 2],
    /// Rotation of each line in each block.
    turns: [[Wave; BLOCKS]; LINES],
}

impl Totals {
    const NONE: Self = Self {
        waves: [[[0.0; 2]; WAVES + 1]; 3],
        with_u: [[[0.0; 2]; LINES]; 2],
        turns: [[[0.0; 2]; BLOCKS]; LINES],
    };

    /// Sums up the first lines of rotated blocks. Leaves other lines unchanged.
    #[inline(always)]
    fn set(&mut self, blocks: &Blocks, turn: f32, lines: usize) {
        let (lines, max) = (lines.min(LINES), (2 * lines).min(WAVES));
        for sums in &mut self.waves {
            sums[..=max].fill([0.0; 2]);
        }
        for sums in &mut self.with_u {
            sums[..lines].fill([0.0; 2]);
        }
        let add = |to: &mut Wave, [x, y]: Wave| *to = [to[0] + x, to[1] + y];
        let mut turned = Turned::default();
        for (b, (block, _)) in blocks.iter().enumerate().take(BLOCKS) {
            turned.set(block, turn, lines);
            let u = block.middle;
            let [plain, once, twice] = &mut self.waves;
            plain[0][0] += block.frames;
            once[0][0] += u * block.frames;
            twice[0][0] += u * (u * block.frames);
            for m in 1..=max {
                let wave = turned.waves[m];
                let with_u = wave.map(|x| u * x);
                add(&mut plain[m], wave);
                add(&mut once[m], with_u);
                add(&mut twice[m], with_u.map(|x| u * x));
            }
            for m in 0..lines {
                self.turns[m][b] = turned.turns[m];
                add(&mut self.with_u[0][m], turned.with_u[m]);
                add(&mut self.with_u[1][m], turned.with_u[m].map(|x| u * x));
            }
        }
    }
}

impl Solution {
    /// A solution without lines.
    pub const NONE: Self = Self {
        turn: 0.0,
        turn_sigma: 0.0,
        step: 0.0,
        gain: 0.0,
        orders: [0; LINES],
        lines: 0,
        lower: [[0.0; ALL]; ALL],
        inverse: [0.0; ALL],
        coefficients: [[0.0; CHANNELS_MAX]; FUNCTIONS],
        weights: [0.0; CHANNELS_MAX],
        variances: [0.0; CHANNELS_MAX],
        rounding: [0.0; CHANNELS_MAX],
        freedom: 0.0,
        left: 0.0,
        totals: Totals::NONE,
    };

    /// Chooses the lines of a mask, in which bit k is line k.
    pub fn choose(&mut self, lines: u16) {
        self.lines = 0;
        for order in (1..=LINES).filter(|order| lines >> order & 1 == 1) {
            self.orders[self.lines % LINES] = order;
            self.lines += 1;
        }
    }

    /// Numbers of the lines, ascending.
    pub fn orders(&self) -> &[usize] {
        self.orders.get(..self.lines).unwrap_or_default()
    }

    /// Mask of the lines.
    pub fn mask(&self) -> u16 {
        self.orders()
            .iter()
            .fold(0, |mask, order| mask | 1 << order)
    }

    /// Number of a channel's functions.
    pub fn functions(&self) -> usize {
        (2 + 2 * self.lines).min(FUNCTIONS)
    }

    /// Solves for the channels with the blocks rotated by `turn`.
    pub fn solve(&mut self, blocks: &Blocks, reference: &Reference, turn: f32) {
        match self.orders() {
            [1] => self.solve_lines::<1>(blocks, reference, turn),
            _ => self.solve_lines::<LINES>(blocks, reference, turn),
        }
    }

    /// Solves for up to `L` lines; with one line the loops over lines vanish.
    #[inline(never)]
    fn solve_lines<const L: usize>(&mut self, blocks: &Blocks, reference: &Reference, turn: f32) {
        self.turn = turn;
        let highest = self.orders().last().copied().unwrap_or(1);
        self.totals
            .set(blocks, turn, if L == 1 { 1 } else { highest });
        self.fill(blocks.powers);
        self.factor();
        self.freedom = blocks.frames() - self.functions() as f32;
        self.left = 0.0;
        let (mut score, mut information) = (0.0, 0.0);
        for group in 0..CHANNELS_MAX / 4 {
            let [of_group, and] = self.solve_group::<L>(blocks, reference, group);
            score += of_group;
            information += and;
        }
        if information < f32::MIN_POSITIVE {
            information = f32::MIN_POSITIVE;
        }
        self.step = score / information;
        self.turn_sigma = 1.0 / square_root(information);
        self.gain = score * self.step;
    }

    /// Solves at the best of some starts, cycles from the blocks' frequency: the one with the
    /// smallest residuals after a step.
    #[inline(never)]
    pub fn start(&mut self, blocks: &Blocks, reference: &Reference, starts: &[f32]) {
        let mut best = (f32::INFINITY, 0.0);
        for start in starts {
            self.solve(blocks, reference, PI * start);
            let turn = self.turn + self.step();
            let all = self.freedom * reference.width as f32;
            let left = self.left * (1.0 - self.gain / all);
            if left < best.0 && PI * blocks.cycles + turn > 0.0 {
                best = (left, turn);
            }
        }
        self.solve(blocks, reference, best.1);
    }

    /// Log likelihood after the next step, less the penalty of the unknowns (G. Schwarz, Ann. Stat.
    /// 6 (1978) 461).
    pub fn score(&self, reference: &Reference) -> f32 {
        let functions = self.functions() as f32;
        let frames = self.freedom + functions;
        let pairs = self.variances.iter().zip(&reference.inverse);
        let used = pairs.filter(|(_, inverse)| **inverse > 0.0);
        let terms = used.map(|(variance, inverse)| {
            libm::logf(variance * inverse * inverse * self.freedom / frames)
        });
        let unknowns = functions * reference.width as f32;
        let likelihood = 0.5 * (self.gain - frames * terms.sum::<f32>());
        likelihood - 0.5 * unknowns * libm::logf(frames)
    }

    /// Fills in the products of the functions.
    fn fill(&mut self, [n, u, uu]: [f32; 3]) {
        let (lower, totals) = (&mut self.lower, &self.totals);
        let derivatives = (2 + 2 * self.lines).min(FUNCTIONS);
        (lower[0][0], lower[1][0], lower[1][1]) = (n, u, uu);
        let [plain, once, twice] = &totals.waves;
        for i in 0..self.lines.min(LINES) {
            let order = self.orders[i].clamp(1, LINES);
            let (own, along) = (2 + 2 * i, derivatives + 2 * i);
            for part in 0..2 {
                lower[own + part][0] = plain[order][part];
                lower[own + part][1] = totals.with_u[0][order - 1][part];
                lower[along + part][0] = once[order][part];
                lower[along + part][1] = totals.with_u[1][order - 1][part];
            }
            for j in 0..self.lines.min(LINES) {
                let other = self.orders[j].clamp(1, LINES);
                let (to, to_along) = (2 + 2 * j, derivatives + 2 * j);
                let functions = line_products(plain, order, other);
                let mixed = line_products(once, order, other);
                let all = line_products(twice, order, other);
                for (a, b) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
                    lower[along + a][to + b] = mixed[a][b];
                    if j <= i {
                        lower[own + a][to + b] = functions[a][b];
                        lower[along + a][to_along + b] = all[a][b];
                    }
                }
            }
        }
    }

    /// Factors in place; a linearly dependent function gets a pivot of zero.
    fn factor(&mut self) {
        for i in 0..(2 + 4 * self.lines).min(ALL) {
            let (done, row) = self.lower.split_at_mut(i);
            let row = &mut row[0];
            let own = row[i];
            let mut left = own;
            for (j, (other, inverse)) in done.iter().zip(&self.inverse).enumerate() {
                let (before, rest) = row.split_at_mut(j.min(ALL - 1));
                let mut sum = rest[0];
                for (x, y) in before.iter().zip(other) {
                    sum -= x * y;
                }
                rest[0] = sum * inverse;
                left -= rest[0] * rest[0];
            }
            if left > LEFT * own {
                row[i] = square_root(left);
                self.inverse[i] = 1.0 / row[i];
            } else {
                (row[i], self.inverse[i]) = (0.0, 0.0);
            }
        }
    }

    /// Solves for four channels: residuals, weights, coefficients; returns their part of the step's
    /// score and information.
    #[inline(never)]
    fn solve_group<const L: usize>(
        &mut self,
        blocks: &Blocks,
        reference: &Reference,
        group: usize,
    ) -> [f32; 2] {
        let lines = if L == 1 { 1 } else { self.lines.min(LINES) };
        let functions = 2 + 2 * lines;
        let all = functions + 2 * lines;
        let part = |values: &Values| values.as_chunks::<4>().0[group % 4];
        let mut rows = [[0.0; 4]; ALL];
        rows[0] = part(&blocks.sums[0]);
        rows[1] = part(&blocks.sums[1]);
        for i in 0..lines {
            let line = self.orders[i].clamp(1, LINES) - 1;
            let (own, along) = (2 + 2 * i, functions + 2 * i);
            let sums = products_of(&self.totals.turns[line], blocks, line, group);
            if along + 1 < ALL {
                [rows[own], rows[own + 1], rows[along], rows[along + 1]] = sums;
            }
        }
        // Projections on the orthonormal functions.
        for i in 0..all {
            let mut row = rows[i];
            for j in 0..i {
                let factor = self.lower[i][j];
                for k in 0..4 {
                    row[k] -= factor * rows[j][k];
                }
            }
            rows[i] = row.map(|x| x * self.inverse[i]);
        }
        let squares = part(&blocks.sums[2]);
        let mut left = squares;
        for row in &rows[..functions] {
            for k in 0..4 {
                left[k] -= row[k] * row[k];
            }
        }
        let (inverse, quantized) = (part(&reference.inverse), part(&reference.rounding));
        let [mut weights, mut variances, mut rounding] = [[0.0; 4]; 3];
        for k in 0..4 {
            if inverse[k] > 0.0 {
                let of_sums = ROUNDING * squares[k];
                let min = quantized[k] * blocks.frames();
                let own = if left[k] > min { left[k] } else { min } + of_sums;
                let own = if own > 0.0 { own } else { f32::MIN_POSITIVE };
                self.left += own * inverse[k] * inverse[k];
                rounding[k] = of_sums / self.freedom;
                variances[k] = own / self.freedom;
                weights[k] = self.freedom / own;
            }
        }
        let mut coefficients = [[0.0; 4]; FUNCTIONS];
        for i in (0..functions).rev() {
            let mut row = rows[i];
            for j in i + 1..functions {
                let factor = self.lower[j][i];
                for k in 0..4 {
                    row[k] -= factor * coefficients[j][k];
                }
            }
            coefficients[i] = row.map(|x| x * self.inverse[i]);
            self.coefficients[i].as_chunks_mut::<4>().0[group % 4] = coefficients[i];
        }
        // The derivative: b times the cosine times u, less a times the sine times u.
        let [mut score, mut information] = [[0.0; 4]; 2];
        for i in 0..2 * lines {
            let mut along = [0.0; 4];
            for j in i..2 * lines {
                let order = self.orders[j / 2] as f32;
                let factor = self.lower[functions + j][functions + i];
                let factor = if j % 2 == 0 {
                    order * factor
                } else {
                    -order * factor
                };
                let other = coefficients[(2 + (j ^ 1)) % FUNCTIONS];
                for k in 0..4 {
                    along[k] += factor * other[k];
                }
            }
            let row = rows[functions + i];
            for k in 0..4 {
                score[k] += along[k] * row[k];
                information[k] += along[k] * along[k];
            }
        }
        let sum = |values: [f32; 4]| {
            let [a, b, c, d] = values;
            let [e, f, g, h] = weights;
            a * e + b * f + c * g + d * h
        };
        self.weights.as_chunks_mut::<4>().0[group % 4] = weights;
        self.variances.as_chunks_mut::<4>().0[group % 4] = variances;
        self.rounding.as_chunks_mut::<4>().0[group % 4] = rounding;
        [sum(score), sum(information)]
    }

    /// The next step, radians at `u` = 1.
    pub fn step(&self) -> f32 {
        self.step.clamp(-STEP_MAX, STEP_MAX)
    }

    /// Takes the last step, without solving again.
    pub fn finish(&mut self) {
        self.turn += self.step();
    }

    /// Turn in cycles per window.
    pub fn cycles(&self) -> f32 {
        self.turn * FRAC_1_PI
    }

    /// Standard deviation of the frequency, cycles per window.
    pub fn sigma(&self) -> f32 {
        self.turn_sigma * FRAC_1_PI
    }

    /// Information on the turn that a line appears to have in a channel if it is only noise;
    /// `variance` is the noise variance of its cosine and sine.
    pub fn noise_information(&self, place: usize, variance: f32) -> f32 {
        let functions = self.functions();
        let order = self.orders().get(place).map_or(0.0, |order| *order as f32);
        let rows = self.lower.iter().skip(functions + 2 * place).take(2);
        let squares = rows.map(|row| {
            let own = row.iter().skip(functions).take(2 * place + 2);
            own.map(|x| x * x).sum::<f32>()
        });
        order * order * variance * squares.sum::<f32>()
    }

    /// Covariance of a line's cosine and sine for unit noise; `place` is the line's index.
    pub fn covariance(&self, place: usize) -> [[f32; 2]; 2] {
        let (functions, own) = (self.functions(), (2 + 2 * place).min(FUNCTIONS - 2));
        // Columns of the factor's inverse.
        let mut columns = [[0.0; FUNCTIONS]; 2];
        for (column, at) in columns.iter_mut().zip([own, own + 1]) {
            for i in at..functions {
                let mut x = if i == at { 1.0 } else { 0.0 };
                for k in at..i {
                    x -= self.lower[i][k] * column[k];
                }
                column[i] = x * self.inverse[i];
            }
        }
        let [x, y] = &columns;
        let dot = |a: &[f32; FUNCTIONS], b: &[f32; FUNCTIONS]| -> f32 {
            a.iter().zip(b).map(|(a, b)| a * b).sum()
        };
        [[dot(x, x), dot(x, y)], [dot(x, y), dot(y, y)]]
    }
}

/// Products of four channels with a line's cosine and sine, and with its cosine and sine times `u`.
#[inline(never)]
fn products_of(
    turns: &[Wave; BLOCKS],
    blocks: &Blocks,
    line: usize,
    group: usize,
) -> [[f32; 4]; 4] {
    let mut sums = [[0.0; 4]; 4];
    for ((block, rows), [x, y]) in blocks.iter().zip(turns) {
        let u = block.middle;
        let Some([cosines, sines]) = rows.as_chunks::<2>().0.get(line) else {
            continue;
        };
        let cosines = &cosines.as_chunks::<4>().0[group % 4];
        let sines = &sines.as_chunks::<4>().0[group % 4];
        for k in 0..4 {
            let cos = cosines[k] * x - sines[k] * y;
            let sin = sines[k] * x + cosines[k] * y;
            sums[0][k] += cos;
            sums[1][k] += sin;
            sums[2][k] += u * cos;
            sums[3][k] += u * sin;
        }
    }
    sums
}
