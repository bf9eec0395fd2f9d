//! Normal equations of a handful of unknowns: the Cholesky factor, for one vector or for all taxels at once.

use crate::nuisance::NUISANCES_MAX;
use crate::source::CHANNELS_MAX;
use crate::source::Values;

/// Most unknowns of a channel: offset, slope, nuisances, and cosine and sine of five harmonics.
pub const UNKNOWNS: usize = 12 + NUISANCES_MAX;

/// A symmetric matrix, of which the lower triangle of the first `size` rows counts.
pub type Matrix = [[f32; UNKNOWNS]; UNKNOWNS];

/// A vector of which the first `size` elements count.
pub type Vector = [f32; UNKNOWNS];

/// A vector for every taxel: one row for each unknown.
pub type Rows = [Values; UNKNOWNS];

/// A normal matrix, and its Cholesky factor in its place.
#[derive(Clone, Debug)]
pub struct Normal {
    /// How many unknowns there are.
    pub size: usize,
    /// Lower triangle; once factored the diagonal holds reciprocals.
    pub lower: Matrix,
}

impl Normal {
    /// An empty matrix of so many unknowns, at most [`UNKNOWNS`].
    #[inline(always)]
    pub const fn new(size: usize) -> Self {
        Self { size: if size < UNKNOWNS { size } else { UNKNOWNS }, lower: [[0.0; UNKNOWNS]; UNKNOWNS] }
    }

    /// Replaces the matrix by its factor. None if it is singular to working precision: a pivot fell below
    /// a millionth of its diagonal element, so that the unknowns cannot be told apart in f32.
    pub fn factor(&mut self) -> Option<()> {
        let size = self.size;
        self.factor_some();
        (self.size == size).then_some(())
    }

    /// The same of as many unknowns, from the first on, as can be told apart: `size` is then their number.
    pub fn factor_some(&mut self) {
        let mut product = 1.0;
        for i in 0..self.size {
            let (above, residual_sum_of_squares) = self.lower.split_at_mut(i);
            let Some(row) = residual_sum_of_squares.first_mut() else { return };
            for (j, other) in above.iter().enumerate() {
                row[j] = (row[j] - dot(&row[..j], &other[..j])) * other[j];
            }
            let pivot = row[i] - dot(&row[..i], &row[..i]);
            product *= pivot / row[i];
            if !(pivot > 1e-6 * row[i] && product > 1e-9) {
                self.size = i;
                return;
            }
            row[i] = 1.0 / libm::sqrtf(pivot);
        }
    }

    /// Solves the factor's own equations for one right-hand side, in place: half way to the solution. Its
    /// product with another such is that of the one's solution with the other.
    #[inline(never)]
    pub fn forward(&self, x: &mut Vector) {
        for (i, row) in self.lower.iter().enumerate().take(self.size) {
            x[i] = (x[i] - dot(&row[..i], &x[..i])) * row[i];
        }
    }

    /// The same for every taxel.
    pub fn forward_rows(&self, x: &mut Rows) {
        for (i, row) in self.lower.iter().enumerate().take(self.size) {
            let (known, residual_sum_of_squares) = x.split_at_mut(i);
            let Some(first) = residual_sum_of_squares.first_mut() else { return };
            let sum = less_products(first, row, known);
            for c in 0..CHANNELS_MAX {
                first[c] = sum[c] * row[i];
            }
        }
    }

    /// From half way to the solution, for every taxel.
    pub fn backward_rows(&self, x: &mut Rows) {
        for i in (0..self.size).rev() {
            let (residual_sum_of_squares, known) = x.split_at_mut(i + 1);
            let Some(last) = residual_sum_of_squares.last_mut() else { return };
            let mut sum = *last;
            for (known, row) in known.iter().zip(&self.lower[i + 1..self.size]) {
                for c in 0..CHANNELS_MAX {
                    sum[c] -= row[i] * known[c];
                }
            }
            for c in 0..CHANNELS_MAX {
                last[c] = sum[c] * self.lower[i][i];
            }
        }
    }
}

/// `from` less each of `rows` times its factor.
// Apart: elsewhere the compiler has no registers left for all the sums.
#[inline(never)]
pub fn less_products(from: &Values, factors: &[f32], rows: &[Values]) -> Values {
    let mut sum = *from;
    for (row, factor) in rows.iter().zip(factors) {
        for c in 0..CHANNELS_MAX {
            sum[c] -= factor * row[c];
        }
    }
    sum
}

/// Sum of the products of two vectors of one length, known to the compiler: no loop.
#[inline(never)]
pub fn dot_all<const N: usize>(a: &[f32; N], b: &[f32; N]) -> f32 {
    let mut sum = 0.0;
    for i in 0..N {
        sum += a[i] * b[i];
    }
    sum
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn solves_what_it_is_given() {
        let mut a = [[0.0; UNKNOWNS]; UNKNOWNS];
        let mut b = [[0.0; CHANNELS_MAX]; UNKNOWNS];
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
        normal.factor().unwrap();
        let mut alone: Vector = core::array::from_fn(|i| b[i][7]);
        normal.forward(&mut alone);
        normal.forward_rows(&mut b);
        for i in 0..3 {
            assert_eq!(alone[i], b[i][7]);
        }
        normal.backward_rows(&mut b);
        for i in 0..3 {
            for c in 0..CHANNELS_MAX {
                assert!((b[i][c] - x(i, c)).abs() < 2e-6 * x(i, c).abs(), "{i} {c}");
            }
        }
    }

    #[test]
    fn refuses_unknowns_that_cannot_be_told_apart() {
        let mut a = [[0.0; UNKNOWNS]; UNKNOWNS];
        a[0][0] = 1.0;
        a[1][0] = 1.0;
        a[0][1] = 1.0;
        a[1][1] = 1.0;
        assert!(Normal { size: 2, lower: a }.factor().is_none());
        assert!(Normal { size: 1, lower: [[0.0; UNKNOWNS]; UNKNOWNS] }.factor().is_none());
        a[0][0] = f32::NAN;
        assert!(Normal { size: 2, lower: a }.factor().is_none());
    }
}
