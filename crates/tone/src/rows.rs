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
    let [one, two, three, four] = rows.each_ref().map(|row| row.as_chunks::<4>().0);
    let [[a, b], [c, d]] = *factors;
    let rows = one.iter().zip(two).zip(three.iter().zip(four));
    let sums = sums.as_chunks_mut::<4>().0.iter_mut();
    for (sums, ((one, two), (three, four))) in sums.zip(rows).take(groups.end).skip(groups.start) {
        for k in 0..4 {
            sums[k] = sums[k] + a * one[k] + b * two[k] + c * three[k] + d * four[k];
        }
    }
}
