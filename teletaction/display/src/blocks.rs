//! Symmetric matrices of 16 rows, in blocks of 4 x 4: in the firmware's frame loops of fixed
//! lengths take a third of the instructions of those of [`packed`](crate::packed).

use crate::packed::{inverse_root, triangle};

/// Rows of a block, and blocks in a row.
pub(crate) const FOUR: usize = 4;

/// 4 x 4 elements, or 16 values in fours.
pub(crate) type Block = [[f32; FOUR]; FOUR];

/// The blocks on and below the diagonal, row by row. Those on it are whole.
pub(crate) type Blocks = [Block; triangle(FOUR)];

/// Makes a matrix that has the same number in its whole diagonal, and nothing else.
pub(crate) fn set_diagonal(matrix: &mut Blocks, value: f32) {
    matrix.fill([[0.0; FOUR]; FOUR]);
    for s in 0..FOUR {
        if let Some(block) = matrix.get_mut(triangle(s) + s) {
            block
                .iter_mut()
                .enumerate()
                .for_each(|(i, row)| row[i % FOUR] = value);
        }
    }
}

/// Adds the products of each of some values with themselves, the block of s and t times their
/// weight s ^ t. Gives the number of multiplications.
pub(crate) fn add(matrix: &mut Blocks, values: &[Block], weights: &[[f32; FOUR]]) -> u32 {
    let mut multiply_adds = 0;
    for s in 0..FOUR {
        for t in 0..=s {
            let Some(place) = matrix.get_mut(triangle(s) + t) else {
                continue;
            };
            // In registers until the last of the values: most of the time is spent here.
            let mut block = *place;
            for (values, weights) in values.iter().zip(weights) {
                let weight = weights[(s ^ t) % FOUR];
                if weight == 0.0 {
                    continue;
                }
                let (right, [a, b, c, d], [i, j, k, l]) = (&values[t], &values[s], &mut block);
                add_row(i, weight * a, right);
                add_row(j, weight * b, right);
                add_row(k, weight * c, right);
                add_row(l, weight * d, right);
                multiply_adds += (FOUR * FOUR) as u32;
            }
            *place = block;
        }
    }
    multiply_adds
}

/// Without a loop, which a build for size leaves rolled.
#[inline(always)]
fn add_row([a, b, c, d]: &mut [f32; FOUR], times: f32, [e, f, g, h]: &[f32; FOUR]) {
    *a += times * e;
    *b += times * f;
    *c += times * g;
    *d += times * h;
}

/// The Cholesky factor in its place; its diagonal holds reciprocals. None if the matrix is not
/// positive definite.
pub(crate) fn factor(matrix: &mut Blocks) -> Option<()> {
    for s in 0..FOUR {
        for t in 0..=s {
            // Of the block's row, and of that of the diagonal block above it.
            let (before, block) = matrix.split_at_mut_checked(triangle(s) + t)?;
            let block = block.first_mut()?;
            for (left, above) in before
                .get(triangle(s)..)?
                .iter()
                .zip(before.get(triangle(t)..)?)
            {
                for (row, left) in block.iter_mut().zip(left) {
                    row.iter_mut()
                        .zip(above)
                        .for_each(|(element, above)| *element -= dot(left, above));
                }
            }
            if let Some(diagonal) = before.get(triangle(t) + t) {
                block.iter_mut().for_each(|row| forward(row, diagonal));
            } else {
                for i in 0..FOUR {
                    let (above, row) = block.split_at_mut(i);
                    let row = row.first_mut()?;
                    forward(row, above);
                    let pivot = row[..i]
                        .iter()
                        .fold(row[i], |pivot, element| pivot - element * element);
                    if !(pivot > 0.0) {
                        return None;
                    }
                    row[i] = inverse_root(pivot);
                }
            }
        }
    }
    Some(())
}

/// Solves for one right-hand side, in place, with the factor of [`factor`].
pub(crate) fn solve(lower: &Blocks, x: &mut Block) {
    for s in 0..FOUR {
        let (before, x) = x.split_at_mut(s);
        for (block, before) in lower[triangle(s)..].iter().zip(before) {
            x[0].iter_mut()
                .zip(block)
                .for_each(|(x, row)| *x -= dot(row, before));
        }
        forward(&mut x[0], &lower[triangle(s) + s]);
    }
    for s in (0..FOUR).rev() {
        let (before, x) = x.split_at_mut(s);
        for (i, row) in lower[triangle(s) + s].iter().enumerate().rev() {
            let value = x[0][i] * row[i];
            x[0][i] = value;
            x[0][..i]
                .iter_mut()
                .zip(row)
                .for_each(|(x, element)| *x -= element * value);
        }
        for (block, before) in lower[triangle(s)..].iter().zip(before) {
            for (row, value) in block.iter().zip(&x[0]) {
                before
                    .iter_mut()
                    .zip(row)
                    .for_each(|(before, element)| *before -= element * value);
            }
        }
    }
}

/// Solves with the first rows of a block on the factor's diagonal, as many as there are.
fn forward(x: &mut [f32; FOUR], rows: &[[f32; FOUR]]) {
    for (i, row) in rows.iter().enumerate().take(FOUR) {
        let rest = x[..i]
            .iter()
            .zip(row)
            .fold(x[i], |rest, (x, element)| rest - x * element);
        x[i] = rest * row[i];
    }
}

/// The product of two fours.
pub(crate) fn dot([a, b, c, d]: &[f32; FOUR], [e, f, g, h]: &[f32; FOUR]) -> f32 {
    a * e + b * f + c * g + d * h
}

#[cfg(test)]
mod tests {
    use super::*;

    fn diagonal(value: f32) -> Blocks {
        let mut matrix = [[[7.0; FOUR]; FOUR]; triangle(FOUR)];
        set_diagonal(&mut matrix, value);
        matrix
    }

    /// A matrix of products and a diagonal, and its solution by elimination in f64.
    #[test]
    fn a_system_is_solved_as_in_f64() {
        let mut state = 1u32;
        let mut draw = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 8) as f32 / 8_388_608.0 - 1.0
        };
        for _ in 0..50 {
            let mut matrix = diagonal(0.3);
            let mut full = [[0.0f64; 17]; 16];
            (0..16).for_each(|i| full[i][i] = f64::from(0.3f32));
            for _ in 0..20 {
                let values: Block = core::array::from_fn(|_| core::array::from_fn(|_| draw()));
                assert_eq!(add(&mut matrix, &[values], &[[1.0; 4]]), 160);
                let values = values.as_flattened();
                for i in 0..16 {
                    (0..16).for_each(|j| full[i][j] += f64::from(values[i]) * f64::from(values[j]));
                }
            }
            let mut x: Block = core::array::from_fn(|_| core::array::from_fn(|_| draw()));
            (0..16).for_each(|i| full[i][16] = x[i / 4][i % 4].into());
            assert_eq!(factor(&mut matrix), Some(()));
            solve(&matrix, &mut x);
            // Gauss and Jordan; the matrix is positive definite, so no row needs to be exchanged.
            for pivot in 0..16 {
                let row = full[pivot].map(|element| element / full[pivot][pivot]);
                for other in (0..16).filter(|other| *other != pivot) {
                    let times = full[other][pivot];
                    (0..17).for_each(|j| full[other][j] -= times * row[j]);
                }
                full[pivot] = row;
            }
            let most = full
                .iter()
                .fold(0.0, |most: f64, row| most.max(row[16].abs()));
            for (x, row) in x.as_flattened().iter().zip(full) {
                assert!(
                    (f64::from(*x) - row[16]).abs() < 1e-4 * most,
                    "{x} {}",
                    row[16]
                );
            }
        }
    }

    /// Each weight counts for its blocks alone.
    #[test]
    fn a_weight_of_zero_leaves_its_blocks() {
        let mut matrix = diagonal(0.0);
        assert_eq!(
            add(&mut matrix, &[[[1.0; 4]; 4]], &[[2.0, 0.0, -1.0, 0.0]]),
            16 * 6
        );
        for s in 0..4 {
            for t in 0..=s {
                let expected = [2.0, 0.0, -1.0, 0.0][s ^ t];
                assert_eq!(matrix[triangle(s) + t], [[expected; 4]; 4], "{s} {t}");
            }
        }
        for value in [0.0, -1.0, f32::NAN] {
            assert_eq!(factor(&mut diagonal(value)), None);
        }
    }
}
