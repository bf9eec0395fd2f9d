//! Least-squares fit of lines and a baseline in all channels, from the sums over blocks.

use crate::covariance::{add_product, form};
use crate::limits::{CHANNELS_MAX, DEGREE_MAX, HARMONICS_MAX, UNKNOWNS_MAX};
use crate::lines::Lines;
use crate::matrix::{Factor, Square, invert};
use crate::source::Values;
use crate::statistics::Products;

/// The two factors of a line in each channel, scaled to unit variance after projecting out all
/// other unknowns.
pub type LineFactors = [Values; 2];

/// Shape of the model: lines, and degree of the baseline.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shape {
    pub lines: Lines,
    pub degree: usize,
}

impl Shape {
    /// Number of unknowns per channel.
    pub fn unknowns(&self) -> usize {
        self.first_line() + 2 * self.lines.count().min(HARMONICS_MAX)
    }

    /// Index of the first unknown of the lines.
    pub fn first_line(&self) -> usize {
        self.degree.min(DEGREE_MAX) + 1
    }
}

/// Rows of the unknowns, in groups of four.
pub type Rows = [Values; UNKNOWNS_MAX.next_multiple_of(4)];

/// A model to project out of functions, as the factor of its normal equations.
#[derive(Clone, Copy, Debug)]
pub struct ProjectedModel<'b> {
    /// Lines and baseline.
    pub shape: &'b Shape,
    /// Factor of the normal equations.
    pub factor: Factor<'b, UNKNOWNS_MAX>,
    /// The part of the channels that the model explains; `None` if the blocks already hold
    /// residuals.
    pub projections: Option<&'b Rows>,
}

/// A solution of all channels.
#[derive(Clone, Debug)]
pub struct Solution {
    /// Lines and baseline.
    pub shape: Shape,
    /// Factor of the normal equations.
    pub lower: Square<UNKNOWNS_MAX>,
    /// Levels, then cosine and sine of each line: at first the projections of the channels onto
    /// orthonormal functions, and once solved the coefficients.
    pub rows: Rows,
}

impl Solution {
    pub const NONE: Self = Self {
        shape: Shape {
            lines: Lines::NONE,
            degree: 0,
        },
        lower: [[0.0; UNKNOWNS_MAX]; UNKNOWNS_MAX],
        rows: [[0.0; CHANNELS_MAX]; UNKNOWNS_MAX.next_multiple_of(4)],
    };

    /// Turns the projections into coefficients.
    pub fn solve(&mut self) {
        Factor::of(&self.lower, self.shape.unknowns()).backward_rows(&mut self.rows);
    }

    pub fn factor(&self) -> Factor<'_, UNKNOWNS_MAX> {
        Factor::of(&self.lower, self.shape.unknowns())
    }

    /// The model to project out of functions, with the projections.
    pub fn projected(&self) -> ProjectedModel<'_> {
        ProjectedModel {
            shape: &self.shape,
            factor: self.factor(),
            projections: Some(&self.rows),
        }
    }

    /// Products of the channels' residuals after the projections, on and below the diagonal.
    pub fn residuals(&self, all: &Products) -> Square<CHANNELS_MAX> {
        let mut residuals = all.matrix;
        if all.may_share {
            for row in self.rows.iter().take(self.shape.unknowns()) {
                add_product(&mut residuals, -1.0, row);
            }
        }
        for (k, square) in self.squares(all).into_iter().enumerate() {
            residuals[k][k] = square;
        }
        residuals
    }

    /// Sums of squared residuals after the projections, raised to at least those of rounding.
    pub fn squares(&self, all: &Products) -> Values {
        let mut squares: Values = core::array::from_fn(|k| all.matrix[k][k]);
        for row in self.rows.iter().take(self.shape.unknowns()) {
            let pairs = squares.iter_mut().zip(row);
            pairs.for_each(|(square, x)| *square -= x * x);
        }
        let pairs = squares.iter_mut().zip(&all.squares_min);
        pairs.for_each(|(square, min)| *square = square.max(*min));
        squares
    }

    /// Coefficients of the lines, once solved: cosine and sine of each.
    pub fn lines(&self) -> &[Values] {
        let (first, end) = (self.shape.first_line(), self.shape.unknowns());
        self.rows.get(first..end).unwrap_or_default()
    }

    pub fn inverse(&self) -> Square<UNKNOWNS_MAX> {
        let mut inverse = self.lower;
        invert(&mut inverse, self.shape.unknowns());
        inverse
    }

    /// The factors of the lines of a solved solution, orthonormal after projecting out all other
    /// unknowns.
    #[inline(never)]
    pub fn line_factors(&self) -> [LineFactors; HARMONICS_MAX] {
        let inverse = self.inverse();
        let mut factors = [[[0.0; CHANNELS_MAX]; 2]; HARMONICS_MAX];
        let count = self.shape.lines.count();
        for (i, factors) in factors.iter_mut().enumerate().take(count) {
            let row = self.shape.first_line() + 2 * i.min(HARMONICS_MAX - 1);
            let (x, y, z) = (
                inverse[row][row],
                inverse[row + 1][row],
                inverse[row + 1][row + 1],
            );
            if x <= 0.0 || x * z - y * y <= 0.0 {
                continue;
            }
            let root = crate::sqrt(x);
            let cross = y / root;
            let pivot = crate::sqrt(z - cross * cross);
            let coefficients = [&self.rows[row], &self.rows[row + 1]];
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
    /// Power beyond that of a single waveform common to all channels.
    pub second: f32,
    pub squares: f32,
}

impl Power {
    /// Computes the power, weighted by the inverse noise covariance `weights`.
    pub fn new(factors: &LineFactors, weights: &Square<CHANNELS_MAX>) -> Self {
        let [a, b, c] = [
            form(&factors[0], weights, &factors[0]),
            form(&factors[0], weights, &factors[1]),
            form(&factors[1], weights, &factors[1]),
        ];
        let (half, apart) = (0.5 * (a + c), crate::sqrt(0.25 * (a - c) * (a - c) + b * b));
        Self {
            all: a + c,
            second: half - apart,
            squares: a * a + 2.0 * b * b + c * c,
        }
    }
}
