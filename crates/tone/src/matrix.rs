//! In-place Cholesky factors of small symmetric matrices.

/// A square matrix, of which the first `n` rows and columns are used.
pub type Square<const N: usize> = [[f32; N]; N];

/// A pivot below this fraction of its diagonal is rounding error, and its unknown is left out.
pub const PIVOT_MIN: f32 = 2e-6;

/// Lower factor L of A = L L', in the lower triangle of a matrix. A linearly dependent unknown has
/// a row and a column of zeros, and its solution is zero.
#[derive(Clone, Copy, Debug)]
pub struct Factor<'a, const N: usize> {
    lower: &'a Square<N>,
    n: usize,
}

impl<'a, const N: usize> Factor<'a, N> {
    /// Factors the first `n` rows and columns in place.
    pub fn new(a: &'a mut Square<N>, n: usize) -> Self {
        Self::with_pivots(a, n, PIVOT_MIN)
    }

    /// Factors in place, leaving out unknowns whose pivot is below a fraction `min` of the
    /// diagonal.
    pub fn with_pivots(a: &'a mut Square<N>, n: usize, min: f32) -> Self {
        let n = n.min(N);
        for i in 0..n {
            let diagonal = a[i][i];
            for j in 0..i {
                let sum: f32 = (0..j).map(|k| a[i][k] * a[j][k]).sum();
                let pivot = a[j][j];
                a[i][j] = if pivot > 0.0 {
                    (a[i][j] - sum) / pivot
                } else {
                    0.0
                };
            }
            let beside = diagonal - a[i][..i].iter().map(|x| x * x).sum::<f32>();
            if beside > min * diagonal {
                a[i][i] = crate::sqrt(beside);
            } else {
                a[i][..=i].fill(0.0);
            }
        }
        Self { lower: a, n }
    }

    /// Wraps the first `n` rows and columns of a matrix that is already factored.
    pub fn of(lower: &'a Square<N>, n: usize) -> Self {
        Self { lower, n }
    }

    /// Solves L x = b in place.
    pub fn forward(&self, x: &mut [f32; N]) {
        for i in 0..self.n.min(N) {
            let (row, before) = (&self.lower[i], &x[..i]);
            let sum: f32 = row.iter().zip(before).map(|(l, x)| l * x).sum();
            let pivot = row[i];
            x[i] = if pivot > 0.0 {
                (x[i] - sum) / pivot
            } else {
                0.0
            };
        }
    }

    /// Solves L' x = b in place.
    pub fn backward(&self, x: &mut [f32; N]) {
        for i in (0..self.n.min(N)).rev() {
            let row = &self.lower[i];
            x[i] = if row[i] > 0.0 { x[i] / row[i] } else { 0.0 };
            let own = x[i];
            for (x, factor) in x[..i].iter_mut().zip(row) {
                *x -= factor * own;
            }
        }
    }

    /// Solves L X = B in place for many right-hand sides, the columns of `x`.
    pub fn forward_rows<const M: usize>(&self, x: &mut [[f32; M]]) {
        for (i, factors) in self.lower.iter().enumerate().take(self.n) {
            let Some((before, [own, ..])) = x.split_at_mut_checked(i) else {
                return;
            };
            let pivot = factors[i];
            let inverse = if pivot > 0.0 { 1.0 / pivot } else { 0.0 };
            for (g, own) in own.as_chunks_mut::<4>().0.iter_mut().enumerate() {
                let [mut a, mut b, mut c, mut d] = *own;
                for (factor, row) in factors.iter().zip(before.iter()) {
                    let row = &row.as_chunks::<4>().0[g];
                    a -= factor * row[0];
                    b -= factor * row[1];
                    c -= factor * row[2];
                    d -= factor * row[3];
                }
                *own = [inverse * a, inverse * b, inverse * c, inverse * d];
            }
        }
    }

    /// Solves L' X = B in place for many right-hand sides, the columns of `x`.
    pub fn backward_rows<const M: usize>(&self, x: &mut [[f32; M]]) {
        for (i, factors) in self.lower.iter().enumerate().take(self.n).rev() {
            let Some((before, [own, ..])) = x.split_at_mut_checked(i) else {
                continue;
            };
            let pivot = factors.get(i).copied().unwrap_or_default();
            let inverse = if pivot > 0.0 { 1.0 / pivot } else { 0.0 };
            own.iter_mut().for_each(|value| *value *= inverse);
            for (factor, row) in factors.iter().zip(before) {
                for (value, other) in row.iter_mut().zip(&*own) {
                    *value -= factor * other;
                }
            }
        }
    }

    /// Solves A x = b in place.
    pub fn solve(&self, x: &mut [f32; N]) {
        self.forward(x);
        self.backward(x);
    }

    /// Log determinant of A, without the unknowns that are left out.
    pub fn log_det(&self) -> f32 {
        let pivots = (0..self.n.min(N))
            .map(|i| self.lower[i][i])
            .filter(|pivot| *pivot > 0.0);
        2.0 * pivots.map(libm::logf).sum::<f32>()
    }

    /// Log determinant of A, with squared pivots raised to at least `min`, including those of
    /// unknowns left out.
    pub fn log_det_above(&self, min: &[f32; N]) -> f32 {
        let pivots = self.lower.iter().enumerate().take(self.n);
        let squares = pivots.map(|(i, row)| row[i] * row[i]);
        let squares = squares.zip(min).map(|(square, min)| square.max(*min));
        squares.map(libm::logf).sum()
    }
}

/// Inverts a factor of `n` rows and columns in place.
pub fn invert_lower<const N: usize>(lower: &mut Square<N>, n: usize) {
    let n = n.min(N);
    for j in (0..n).rev() {
        let pivot = lower[j][j];
        let inverse = if pivot > 0.0 { 1.0 / pivot } else { 0.0 };
        lower[j][j] = inverse;
        for i in (j + 1..n).rev() {
            let Some(own) = lower.get(i) else {
                continue;
            };
            let columns = own.iter().zip(&*lower).take(i + 1).skip(j + 1);
            let sum: f32 = columns.map(|(factor, row)| factor * row[j]).sum();
            lower[i][j] = -inverse * sum;
        }
    }
}

/// Replaces the factor of a matrix of `n` rows and columns by the matrix's inverse.
pub fn invert<const N: usize>(lower: &mut Square<N>, n: usize) {
    let n = n.min(N);
    invert_lower(lower, n);
    for i in 0..n {
        for j in 0..=i {
            let sum = (i..n).map(|k| lower[k][i] * lower[k][j]).sum();
            lower[i][j] = sum;
            lower[j][i] = sum;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const A: Square<3> = [[4.0, 2.0, 0.6], [2.0, 5.0, 1.0], [0.6, 1.0, 3.0]];

    #[test]
    fn solves_inverts_and_has_the_determinant() {
        let mut a = A;
        let factor = Factor::new(&mut a, 3);
        let mut x = [1.0, 2.0, 3.0];
        factor.solve(&mut x);
        for (row, b) in A.iter().zip([1.0, 2.0, 3.0]) {
            let got: f32 = row.iter().zip(x).map(|(a, x)| a * x).sum();
            assert!((got - b).abs() < 1e-5);
        }
        let determinant = 4.0 * (15.0 - 1.0) - 2.0 * (6.0 - 0.6) + 0.6 * (2.0 - 3.0);
        assert!((factor.log_det() - libm::logf(determinant)).abs() < 1e-5);
        invert(&mut a, 3);
        for i in 0..3 {
            for j in 0..3 {
                let product: f32 = (0..3).map(|k| A[i][k] * a[k][j]).sum();
                let unit = if i == j { 1.0 } else { 0.0 };
                assert!((product - unit).abs() < 1e-5, "{i} {j}: {product}");
            }
        }
    }

    #[test]
    fn an_unknown_that_the_others_explain_is_left_out() {
        let mut a = [[1.0, 1.0, 0.5], [1.0, 1.0, 0.5], [0.5, 0.5, 1.0]];
        let mut x = [2.0, 2.0, 1.0];
        Factor::new(&mut a, 3).solve(&mut x);
        assert_eq!(x, [2.0, 0.0, 0.0]);
        invert(&mut a, 3);
        assert_eq!(a[1], [0.0; 3]);
        assert!((a[0][0] - 4.0 / 3.0).abs() < 1e-6 && (a[0][2] + 2.0 / 3.0).abs() < 1e-6);
    }
}
