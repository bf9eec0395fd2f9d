//! Sums of rows of all channels, four rows and four channels at a time.

use crate::source::Values;
use core::ops::Range;

/// Adds two pairs of rows, each with its factor, in some groups of four channels.
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
