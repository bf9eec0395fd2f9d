//! Four channels of a block at a time: as many sums as there are registers for.

use crate::frame_span::{BLOCK, Block};
use crate::limits::CHANNELS_MAX;
use crate::source::Values;

/// Columns of a group.
pub const GROUP: usize = 4;

/// The columns of a group over a block.
pub type Part = [[f32; GROUP]; BLOCK];

/// A sum for each of them.
pub type Sums = [f32; GROUP];

/// The channels of a group in a frame.
#[inline(always)]
pub fn group_of(values: &Values, group: usize) -> &Sums {
    &values.as_chunks().0[group % (CHANNELS_MAX / GROUP)]
}

/// All frames of a group of channels, less their offsets.
pub fn part(block: &Block, offset: &Values, group: usize) -> Part {
    let zero = group_of(offset, group);
    block.values.each_ref().map(|values| {
        let values = group_of(values, group);
        core::array::from_fn(|c| values[c] - zero[c])
    })
}

/// Sums of columns times a function.
// Called from several places and seldom: one copy is enough.
#[inline(never)]
pub fn products(part: &Part, function: &[f32; BLOCK]) -> Sums {
    let mut sums = [0.0; GROUP];
    for (row, factor) in part.iter().zip(function) {
        for c in 0..GROUP {
            sums[c] += row[c] * factor;
        }
    }
    sums
}
