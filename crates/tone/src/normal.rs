//! Normal equations of a handful of unknowns: the Cholesky factor, for one vector or for all
//! channels at once.

use crate::limits::{CHANNELS_MAX, UNKNOWNS_MAX};
use crate::source::Values;

/// A symmetric matrix, of which the lower triangle of the first `size` rows counts.
pub type Matrix = [[f32; UNKNOWNS_MAX]; UNKNOWNS_MAX];

/// A vector of which the first `size` elements count.
pub type Vector = [f32; UNKNOWNS_MAX];

/// A vector for every channel: one row for each unknown.
pub type Rows = [Values; UNKNOWNS_MAX];

/// A normal matrix, and its Cholesky factor in its place.
#[derive(Clone, Debug)]
pub struct Normal {
    /// How many unknowns there are.
    pub size: usize,
    /// Lower triangle; once factored the diagonal holds reciprocals.
    pub lower: Matrix,
}

impl Normal {
    /// An empty matrix of `size` unknowns, at most [`UNKNOWNS_MAX`].
    #[inline(always)]
    pub const fn new(size: usize) -> Self {
        Self {
            size: if size < UNKNOWNS_MAX {
                size
            } else {
                UNKNOWNS_MAX
            },
            lower: [[0.0; UNKNOWNS_MAX]; UNKNOWNS_MAX],
        }
    }

    /// Replaces the matrix by its factor, for as many unknowns, from the first on, as f32 can
    /// separate: `size` is then their number. A pivot must be more than a millionth of its diagonal
    /// element, and all of these shares' product more than `product_min`.
    pub fn factor(&mut self, product_min: f32) {
        let mut product = 1.0;
        for i in 0..self.size.min(UNKNOWNS_MAX) {
            let (above, below) = self.lower.split_at_mut(i);
            let Some(row) = below.first_mut() else { return };
            for (j, other) in (0..UNKNOWNS_MAX).zip(above.iter()) {
                row[j] = (row[j] - dot(&row[..j], &other[..j])) * other[j];
            }
            let pivot = row[i] - dot(&row[..i], &row[..i]);
            product *= pivot / row[i];
            if !(pivot > 1e-6 * row[i] && product > product_min) {
                self.size = i;
                return;
            }
            row[i] = 1.0 / libm::sqrtf(pivot);
        }
    }

    /// Forward substitution of one right-hand side, in place. The product of two such is that of
    /// the one's solution with the other's right-hand side.
    #[inline(never)]
    pub fn forward(&self, x: &mut Vector) {
        for (i, row) in self.lower.iter().enumerate().take(self.size) {
            x[i] = (x[i] - dot(&row[..i], &x[..i])) * row[i];
        }
    }

    /// The same for the first `width` channels; behind them there are zeros.
    pub fn forward_rows(&self, x: &mut Rows, width: usize) {
        for (i, row) in self.lower.iter().enumerate().take(self.size) {
            let (known, unknown) = x.split_at_mut(i);
            let Some(first) = unknown.first_mut() else {
                return;
            };
            subtract(first, known, row, row[i], width);
        }
    }

    /// Back substitution, for the first `width` channels: the solution.
    pub fn backward_rows(&self, x: &mut Rows, width: usize) {
        let size = self.size.min(UNKNOWNS_MAX);
        for i in (0..size).rev() {
            let (unknown, known) = x.split_at_mut(i + 1);
            let Some(last) = unknown.last_mut() else {
                return;
            };
            let mut factors = [0.0; UNKNOWNS_MAX];
            let below = self.lower.iter().take(size).skip(i + 1);
            factors
                .iter_mut()
                .zip(below)
                .for_each(|(factor, row)| *factor = row[i]);
            subtract(
                last,
                known.get(..size - i - 1).unwrap_or_default(),
                &factors,
                self.lower[i][i],
                width,
            );
        }
    }
}

/// Subtracts rows times factors from the first `width` channels of another, and multiplies these by
/// `scale`. By fours, which stay in registers: what is behind the channels should be zeros.
#[inline(never)]
pub fn subtract(from: &mut Values, rows: &[Values], factors: &[f32], scale: f32, width: usize) {
    for (i, four) in from
        .as_chunks_mut::<4>()
        .0
        .iter_mut()
        .enumerate()
        .take(width.div_ceil(4))
    {
        let mut left = *four;
        for (row, factor) in rows.iter().zip(factors) {
            let row = &row.as_chunks::<4>().0[i % (CHANNELS_MAX / 4)];
            left.iter_mut()
                .zip(row)
                .for_each(|(left, value)| *left -= factor * value);
        }
        *four = left.map(|left| left * scale);
    }
}

/// Sum of the products of two vectors, as far as both go.
#[inline(always)]
pub fn dot(a: &[f32], b: &[f32]) -> f32 {
    let mut sum = 0.0;
    for (a, b) in a.iter().zip(b) {
        sum += a * b;
    }
    sum
}

/// The same of all channels, for steps that are seldom taken.
// Not inlined: each copy is a loop of sixteen, unrolled.
#[inline(never)]
pub fn channels_dot(a: &Values, b: &Values) -> f32 {
    dot(a, b)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn solves_what_it_is_given() {
        let mut a = [[0.0; UNKNOWNS_MAX]; UNKNOWNS_MAX];
        let mut b = [[0.0; CHANNELS_MAX]; UNKNOWNS_MAX];
        let x = |i: usize, c: usize| [1.0, -2.0, 3.0][i] * (c as f32 + 1.0);
        let m = [[4.0, 1.0, 0.5], [1.0, 3.0, -1.0], [0.5, -1.0, 5.0]];
        for i in 0..3 {
            for j in 0..3 {
                a[i][j] = m[i][j];
                for c in 0..CHANNELS_MAX {
                    b[i][c] += m[i][j] * x(j, c);
                }
            }
        }
        let mut normal = Normal { size: 3, lower: a };
        normal.factor(1e-9);
        assert_eq!(normal.size, 3);
        let mut alone: Vector = core::array::from_fn(|i| b[i][7]);
        normal.forward(&mut alone);
        normal.forward_rows(&mut b, CHANNELS_MAX);
        for i in 0..3 {
            assert_eq!(alone[i], b[i][7]);
        }
        normal.backward_rows(&mut b, CHANNELS_MAX);
        for i in 0..3 {
            for c in 0..CHANNELS_MAX {
                assert!((b[i][c] - x(i, c)).abs() < 2e-6 * x(i, c).abs(), "{i} {c}");
            }
        }
    }

    #[test]
    fn refuses_a_singular_matrix() {
        let mut a = [[0.0; UNKNOWNS_MAX]; UNKNOWNS_MAX];
        a[0][0] = 1.0;
        a[1][0] = 1.0;
        a[0][1] = 1.0;
        a[1][1] = 1.0;
        let size = |size, lower| {
            let mut normal = Normal { size, lower };
            normal.factor(1e-9);
            normal.size
        };
        assert_eq!(size(2, a), 1);
        assert_eq!(size(1, [[0.0; UNKNOWNS_MAX]; UNKNOWNS_MAX]), 0);
        a[0][0] = f32::NAN;
        assert_eq!(size(2, a), 0);
    }
}
