//! Least squares of all channels for lines and a baseline, from the sums over blocks.

use crate::blocks::Blocks;
use crate::covariance::form;
use crate::limits::{BLOCKS_MAX, CHANNELS_MAX, DEGREE_MAX, HARMONICS_MAX, UNKNOWNS_MAX};
use crate::lines::Lines;
use crate::matrix::{Factor, Square};
use crate::neighbours::Beside;
use crate::source::Values;
use crate::statistics::Products;

/// The two factors of a line in each channel, of unit variance beside all other unknowns.
pub type LineFactors = [Values; 2];

/// What is fitted: lines, and the degree of the baseline.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shape {
    /// Numbers of the lines.
    pub lines: Lines,
    /// Degree of the baseline.
    pub degree: usize,
}

impl Shape {
    /// Number of unknowns of a channel.
    pub fn unknowns(&self) -> usize {
        self.degree + 1 + 2 * self.lines.count()
    }

    /// Place of the first unknown of the lines.
    pub fn first_line(&self) -> usize {
        self.degree + 1
    }
}

/// A solution.
#[derive(Clone, Debug)]
pub struct Solution {
    /// What was fitted.
    pub shape: Shape,
    /// Factor of the normal equations.
    pub factor: Factor<UNKNOWNS_MAX>,
    /// Products of the orthonormal functions with the channels.
    pub projections: [Values; UNKNOWNS_MAX],
    /// Levels, then cosine and sine of each line.
    pub coefficients: [Values; UNKNOWNS_MAX],
}

impl Solution {
    /// A solution of nothing.
    pub const NONE: Self = Self {
        shape: Shape {
            lines: Lines::NONE,
            degree: 1,
        },
        factor: Factor::NONE,
        projections: [[0.0; CHANNELS_MAX]; UNKNOWNS_MAX],
        coefficients: [[0.0; CHANNELS_MAX]; UNKNOWNS_MAX],
    };

    /// Solves the normal equations.
    #[inline(never)]
    pub fn new(blocks: &Blocks, shape: Shape) -> Self {
        let (n, first) = (shape.unknowns(), shape.first_line());
        let mut gram = [[0.0; UNKNOWNS_MAX]; UNKNOWNS_MAX];
        let mut products = [[0.0; CHANNELS_MAX]; UNKNOWNS_MAX];
        let totals = blocks.totals(&shape, &[1.0; BLOCKS_MAX]);
        for (row, known) in gram.iter_mut().zip(blocks.of_baselines()).take(first) {
            row[..=DEGREE_MAX].copy_from_slice(known);
        }
        products[..first].copy_from_slice(&blocks.levels()[..first]);
        let lines = 2 * shape.lines.count();
        gram[first..n].copy_from_slice(&totals.of_shape(&shape)[..lines]);
        let of_lines = blocks.products(&shape, &[1.0; BLOCKS_MAX]);
        products[first..n].copy_from_slice(&of_lines[..lines]);
        let factor = Factor::new(&gram, n);
        let mut solution = Self {
            shape,
            factor,
            projections: [[0.0; CHANNELS_MAX]; UNKNOWNS_MAX],
            coefficients: [[0.0; CHANNELS_MAX]; UNKNOWNS_MAX],
        };
        solution.factor.forward_rows(&mut products);
        solution.projections = products;
        solution.factor.backward_rows(&mut products);
        solution.coefficients = products;
        solution
    }

    /// The model, for functions beside it.
    pub fn beside(&self) -> Beside<'_> {
        Beside {
            shape: &self.shape,
            factor: &self.factor,
            projections: Some(&self.projections),
        }
    }

    /// Products of the residuals, from those of the channels; what rounding leaves of a channel is
    /// not less than its share.
    pub fn residuals(&self, all: &Products, width: usize) -> Square<CHANNELS_MAX> {
        let mut residuals = all.matrix;
        for k in 0..width {
            let from = if all.may_share { 0 } else { k };
            for l in from..=k {
                let explained: f32 = (0..self.shape.unknowns())
                    .map(|i| self.projections[i][k] * self.projections[i][l])
                    .sum();
                residuals[k][l] -= explained;
                residuals[l][k] = residuals[k][l];
            }
            residuals[k][k] = residuals[k][k].max(all.least[k]);
        }
        residuals
    }

    /// Coefficients of the lines: cosine and sine of each.
    pub fn lines(&self) -> [Values; 2 * HARMONICS_MAX] {
        let first = self.shape.first_line();
        core::array::from_fn(|i| {
            let row = first + i;
            let is_one = i < 2 * self.shape.lines.count();
            if is_one {
                self.coefficients[row % UNKNOWNS_MAX]
            } else {
                [0.0; CHANNELS_MAX]
            }
        })
    }

    /// The factors of the lines, each orthonormal beside all other unknowns.
    #[inline(never)]
    pub fn line_factors(&self) -> [LineFactors; HARMONICS_MAX] {
        let inverse = self.factor.inverse();
        let mut factors = [[[0.0; CHANNELS_MAX]; 2]; HARMONICS_MAX];
        for (i, factors) in factors
            .iter_mut()
            .enumerate()
            .take(self.shape.lines.count())
        {
            let row = self.shape.first_line() + 2 * i;
            let (x, y, z) = (
                inverse[row][row],
                inverse[row + 1][row],
                inverse[row + 1][row + 1],
            );
            if x <= 0.0 || x * z - y * y <= 0.0 {
                continue;
            }
            let root = libm::sqrtf(x);
            let cross = y / root;
            let pivot = libm::sqrtf(z - cross * cross);
            let coefficients = [&self.coefficients[row], &self.coefficients[row + 1]];
            for k in 0..CHANNELS_MAX {
                factors[0][k] = coefficients[0][k] / root;
                factors[1][k] = (coefficients[1][k] - cross * factors[0][k]) / pivot;
            }
        }
        factors
    }
}

/// Power of a line's factors over noise: trace, smaller eigenvalue and sum of squared eigenvalues
/// of their products.
#[derive(Clone, Copy, Debug, Default)]
pub struct Power {
    /// Both factors together.
    pub all: f32,
    /// What the factors have beside a single shape in time.
    pub second: f32,
    /// Sum of the squared eigenvalues.
    pub squares: f32,
}

impl Power {
    /// By the inverse of the noise's covariance.
    pub fn new(factors: &LineFactors, weights: &Square<CHANNELS_MAX>) -> Self {
        let [a, b, c] = [
            form(&factors[0], weights, &factors[0]),
            form(&factors[0], weights, &factors[1]),
            form(&factors[1], weights, &factors[1]),
        ];
        let (half, apart) = (0.5 * (a + c), libm::sqrtf(0.25 * (a - c) * (a - c) + b * b));
        Self {
            all: a + c,
            second: half - apart,
            squares: a * a + 2.0 * b * b + c * c,
        }
    }
}
