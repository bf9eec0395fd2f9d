//! Normal equations of a handful of unknowns: Cholesky factor and solution.

/// Most unknowns of a channel: offset, slope, and cosine and sine of five harmonics.
pub const UNKNOWNS: usize = 12;

/// A symmetric matrix, of which the lower triangle of the first `size` rows counts.
pub type Matrix = [[f32; UNKNOWNS]; UNKNOWNS];

/// A vector of which the first `size` elements count.
pub type Vector = [f32; UNKNOWNS];

/// Cholesky factor of a normal matrix.
#[derive(Clone, Debug)]
pub struct Cholesky {
    size: usize,
    /// Lower triangle; the diagonal holds reciprocals.
    factor: Matrix,
}

impl Cholesky {
    /// Factors the first `size` rows and columns of `matrix`. None if it is singular to working
    /// precision: a pivot fell below a millionth of its diagonal element, so that the unknowns
    /// cannot be told apart in f32.
    pub fn new(matrix: &Matrix, size: usize) -> Option<Self> {
        let mut factor = *matrix;
        for j in 0..size {
            let mut pivot = factor[j][j];
            for k in 0..j {
                pivot -= factor[j][k] * factor[j][k];
            }
            if !(pivot > 1e-6 * matrix[j][j]) {
                return None;
            }
            let reciprocal = 1.0 / libm::sqrtf(pivot);
            factor[j][j] = reciprocal;
            for i in j + 1..size {
                let mut sum = factor[i][j];
                for k in 0..j {
                    sum -= factor[i][k] * factor[j][k];
                }
                factor[i][j] = sum * reciprocal;
            }
        }
        Some(Self { size, factor })
    }

    /// Solves for one right-hand side.
    pub fn solve(&self, right: &Vector) -> Vector {
        let mut x = *right;
        // Rows only, forwards by products and backwards by multiples: no stride, no bounds to check.
        for (i, row) in self.factor.iter().enumerate().take(self.size) {
            let (known, rest) = x.split_at_mut(i);
            if let (Some(first), Some(diagonal)) = (rest.first_mut(), row.get(i)) {
                *first = (*first - dot(row, known)) * diagonal;
            }
        }
        for (i, row) in self.factor.iter().enumerate().take(self.size).rev() {
            let (before, rest) = x.split_at_mut(i);
            if let (Some(first), Some(diagonal)) = (rest.first_mut(), row.get(i)) {
                *first *= diagonal;
                for (x, factor) in before.iter_mut().zip(row) {
                    *x -= factor * *first;
                }
            }
        }
        x
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn solves_what_it_is_given() {
        let mut a = [[0.0; UNKNOWNS]; UNKNOWNS];
        let mut b = [0.0; UNKNOWNS];
        let x = [1.0, -2.0, 3.0];
        let m = [[4.0, 1.0, 0.5], [1.0, 3.0, -1.0], [0.5, -1.0, 5.0]];
        for i in 0..3 {
            for j in 0..3 {
                a[i][j] = m[i][j];
                b[i] += m[i][j] * x[j];
            }
        }
        let found = Cholesky::new(&a, 3).unwrap().solve(&b);
        for i in 0..3 {
            assert!((found[i] - x[i]).abs() < 1e-6);
        }
    }

    #[test]
    fn refuses_unknowns_that_cannot_be_told_apart() {
        let mut a = [[0.0; UNKNOWNS]; UNKNOWNS];
        a[0][0] = 1.0;
        a[1][0] = 1.0;
        a[0][1] = 1.0;
        a[1][1] = 1.0;
        assert!(Cholesky::new(&a, 2).is_none());
        assert!(Cholesky::new(&[[0.0; UNKNOWNS]; UNKNOWNS], 1).is_none());
        a[0][0] = f32::NAN;
        assert!(Cholesky::new(&a, 2).is_none());
    }
}
