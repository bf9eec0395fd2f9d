//! Cholesky factors of small symmetric matrices.

/// A square matrix, of which the first `n` rows and columns are used.
pub type Square<const N: usize> = [[f32; N]; N];

/// A pivot below this share of its diagonal is rounding: the unknown is left out.
const PIVOT_MIN: f32 = 2e-6;

/// A lower factor L with L L' = A. An unknown that the others explain has a row of zeros, and its
/// solution is zero.
#[derive(Clone, Copy, Debug)]
pub struct Factor<const N: usize> {
    lower: Square<N>,
    n: usize,
}

impl<const N: usize> Factor<N> {
    /// A factor of nothing.
    pub const NONE: Self = Self {
        lower: [[0.0; N]; N],
        n: 0,
    };

    /// Factors the first `n` rows and columns.
    pub fn new(a: &Square<N>, n: usize) -> Self {
        let mut lower = [[0.0; N]; N];
        for i in 0..n {
            for j in 0..i {
                let sum: f32 = (0..j).map(|k| lower[i][k] * lower[j][k]).sum();
                if lower[j][j] > 0.0 {
                    lower[i][j] = (a[i][j] - sum) / lower[j][j];
                }
            }
            let rest = a[i][i] - lower[i][..i].iter().map(|x| x * x).sum::<f32>();
            if rest > PIVOT_MIN * a[i][i] {
                lower[i][i] = libm::sqrtf(rest);
            } else {
                lower[i] = [0.0; N];
            }
        }
        Self { lower, n }
    }

    /// Solves L x = b in place.
    pub fn forward(&self, x: &mut [f32; N]) {
        for i in 0..self.n {
            let sum: f32 = (0..i).map(|k| self.lower[i][k] * x[k]).sum();
            let pivot = self.lower[i][i];
            x[i] = if pivot > 0.0 {
                (x[i] - sum) / pivot
            } else {
                0.0
            };
        }
    }

    /// Solves L' x = b in place.
    pub fn backward(&self, x: &mut [f32; N]) {
        for i in (0..self.n).rev() {
            let sum: f32 = (i + 1..self.n).map(|k| self.lower[k][i] * x[k]).sum();
            let pivot = self.lower[i][i];
            x[i] = if pivot > 0.0 {
                (x[i] - sum) / pivot
            } else {
                0.0
            };
        }
    }

    /// Solves L X = B in place for many right sides, which are columns.
    pub fn forward_rows<const M: usize>(&self, x: &mut [[f32; M]; N]) {
        for i in 0..self.n {
            let (before, rest) = x.split_at_mut(i);
            for (factor, row) in self.lower[i].iter().zip(before.iter()) {
                for (value, other) in rest[0].iter_mut().zip(row) {
                    *value -= factor * other;
                }
            }
            let pivot = self.lower[i][i];
            let inverse = if pivot > 0.0 { 1.0 / pivot } else { 0.0 };
            rest[0].iter_mut().for_each(|value| *value *= inverse);
        }
    }

    /// Solves L' X = B in place for many right sides, which are columns.
    pub fn backward_rows<const M: usize>(&self, x: &mut [[f32; M]; N]) {
        for i in (0..self.n).rev() {
            let (before, rest) = x.split_at_mut(i);
            let pivot = self.lower[i][i];
            let inverse = if pivot > 0.0 { 1.0 / pivot } else { 0.0 };
            rest[0].iter_mut().for_each(|value| *value *= inverse);
            for (factor, row) in self.lower[i].iter().zip(before) {
                for (value, other) in row.iter_mut().zip(&rest[0]) {
                    *value -= factor * other;
                }
            }
        }
    }

    /// Row `k` of the inverse of L: x is zeros but for a one in its place.
    pub fn backward_from(&self, k: usize, x: &mut [f32; N]) {
        for i in (0..=k).rev() {
            let sum: f32 = (i + 1..=k).map(|j| self.lower[j][i] * x[j]).sum();
            let pivot = self.lower[i][i];
            x[i] = if pivot > 0.0 {
                (x[i] - sum) / pivot
            } else {
                0.0
            };
        }
    }

    /// Solves A x = b in place.
    pub fn solve(&self, x: &mut [f32; N]) {
        self.forward(x);
        self.backward(x);
    }

    /// The inverse of A.
    pub fn inverse(&self) -> Square<N> {
        let mut inverse = [[0.0; N]; N];
        for i in 0..self.n {
            inverse[i][i] = 1.0;
            self.solve(&mut inverse[i]);
        }
        inverse
    }

    /// Logarithm of the determinant of A, without unknowns that are left out.
    pub fn log_det(&self) -> f32 {
        let pivots = (0..self.n)
            .map(|i| self.lower[i][i])
            .filter(|pivot| *pivot > 0.0);
        2.0 * pivots.map(libm::logf).sum::<f32>()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const A: Square<3> = [[4.0, 2.0, 0.6], [2.0, 5.0, 1.0], [0.6, 1.0, 3.0]];

    #[test]
    fn solves_inverts_and_has_the_determinant() {
        let factor = Factor::new(&A, 3);
        let mut x = [1.0, 2.0, 3.0];
        factor.solve(&mut x);
        for (row, b) in A.iter().zip([1.0, 2.0, 3.0]) {
            let got: f32 = row.iter().zip(x).map(|(a, x)| a * x).sum();
            assert!((got - b).abs() < 1e-5);
        }
        let inverse = factor.inverse();
        let one: f32 = (0..3).map(|k| A[1][k] * inverse[k][1]).sum();
        assert!((one - 1.0).abs() < 1e-5);
        let determinant = 4.0 * (15.0 - 1.0) - 2.0 * (6.0 - 0.6) + 0.6 * (2.0 - 3.0);
        assert!((factor.log_det() - libm::logf(determinant)).abs() < 1e-5);
    }

    #[test]
    fn an_unknown_that_the_others_explain_is_left_out() {
        let a = [[1.0, 1.0], [1.0, 1.0]];
        let mut x = [2.0, 2.0];
        Factor::new(&a, 2).solve(&mut x);
        assert_eq!(x, [2.0, 0.0]);
    }
}
