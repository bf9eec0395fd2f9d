//! Weighted sums of rows of channels, four rows and four channels at a time.

use crate::source::Values;
use core::ops::Range;

/// Adds two pairs of rows, each times its factor, for some groups of four channels.
#[inline(always)]
pub fn add_rows(
    sums: &mut Values,
    groups: Range<usize>,
    rows: &[Values; 4],
    factors: &[[f32; 2]; 2],
) {
    let group = |row: &Values, g: usize| row.as_chunks::<4>().0.get(g).copied();
    let [[a, b], [c, d]] = *factors;
    for g in groups {
        let Some(sums) = sums.as_chunks_mut::<4>().0.get_mut(g) else {
            break;
        };
        let [one, two, three, four] = rows.each_ref().map(|row| group(row, g).unwrap_or_default());
        for k in 0..4 {
            sums[k] = sums[k] + a * one[k] + b * two[k] + c * three[k] + d * four[k];
        }
    }
}

/// Adds rows, each times its factor, for the first groups of four channels.
pub fn add_all(sums: &mut Values, groups: usize, rows: &[Values], factors: &[f32]) {
    let sums = sums.as_chunks_mut::<4>().0.iter_mut().enumerate();
    for (g, sums) in sums.take(groups) {
        // Keep a group's sums in registers.
        let [mut a, mut b, mut c, mut d] = *sums;
        for (row, factor) in rows.iter().zip(factors) {
            let Some(row) = row.as_chunks::<4>().0.get(g) else {
                break;
            };
            a += factor * row[0];
            b += factor * row[1];
            c += factor * row[2];
            d += factor * row[3];
        }
        *sums = [a, b, c, d];
    }
}
