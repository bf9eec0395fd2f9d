//! Symmetric matrices, of which the lower triangle is kept row by row: half of the memory of the
//! whole.

/// Elements of the lower triangle of `n` rows.
pub(crate) const fn triangle(n: usize) -> usize {
    n * (n + 1) / 2
}

/// Element of row `i` and column `j` of a symmetric matrix.
pub(crate) fn at(matrix: &[f32], i: usize, j: usize) -> f32 {
    let (i, j) = if i < j { (j, i) } else { (i, j) };
    matrix[triangle(i) + j]
}

/// The greatest absolute value; what is no number does not count.
pub(crate) fn largest(values: &[f32]) -> f32 {
    values
        .iter()
        .fold(0.0, |most: f32, value| most.max(value.abs()))
}

pub(crate) fn dot(a: &[f32], b: &[f32]) -> f32 {
    // Four sums: the next product needs not wait for the last.
    let mut sums = [0.0; 4];
    let (a4, b4) = (a.chunks_exact(4), b.chunks_exact(4));
    let rest: f32 = a4
        .remainder()
        .iter()
        .zip(b4.remainder())
        .map(|(a, b)| a * b)
        .sum();
    for (a, b) in a4.zip(b4) {
        for (sum, (a, b)) in sums.iter_mut().zip(a.iter().zip(b)) {
            *sum += a * b;
        }
    }
    (sums[0] + sums[1]) + (sums[2] + sums[3]) + rest
}

/// The Cholesky factor in place of the first `n` rows; its diagonal holds reciprocals. A pivot that
/// is not more than `least` times its diagonal element is an error: its row.
pub(crate) fn factor(matrix: &mut [f32], n: usize, least: f32) -> Result<(), usize> {
    for i in 0..n {
        let (above, row) = matrix.split_at_mut(triangle(i));
        for j in 0..i {
            let other = &above[triangle(j)..][..=j];
            row[j] = (row[j] - dot(&row[..j], &other[..j])) * other[j];
        }
        let pivot = row[i] - dot(&row[..i], &row[..i]);
        if !(pivot > least * row[i]) {
            return Err(i);
        }
        row[i] = pivot.sqrt().recip();
    }
    Ok(())
}

/// Solves for one right-hand side, in place, with the factor of [`factor`].
pub(crate) fn solve(lower: &[f32], x: &mut [f32]) {
    let n = x.len();
    for i in 0..n {
        let row = &lower[triangle(i)..][..=i];
        x[i] = (x[i] - dot(&row[..i], &x[..i])) * row[i];
    }
    for i in (0..n).rev() {
        let row = &lower[triangle(i)..][..=i];
        let value = x[i] * row[i];
        x[i] = value;
        for (x, element) in x[..i].iter_mut().zip(row) {
            *x -= element * value;
        }
    }
}

/// The inverse of the matrix in place of its factor.
pub(crate) fn invert(lower: &mut [f32], n: usize) {
    // First the inverse of the factor, row by row: row i of it is -1/l_ii of the rows above,
    // weighted by row i.
    for i in 0..n {
        let (above, row) = lower.split_at_mut(triangle(i));
        let diagonal = row[i];
        for j in 0..i {
            // Column j of the inverse so far, from its diagonal on.
            let sum: f32 = (j..i).map(|k| row[k] * above[triangle(k) + j]).sum();
            row[j] = -diagonal * sum;
        }
    }
    // Then the product of its transpose with itself: an element needs only rows from its own on.
    for i in 0..n {
        for j in 0..=i {
            lower[triangle(i) + j] = (i..n)
                .map(|k| lower[triangle(k) + i] * lower[triangle(k) + j])
                .sum();
        }
    }
}
