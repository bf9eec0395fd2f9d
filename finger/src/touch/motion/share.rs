//! Shares of the taxels: a frame's work is one of them.

use super::BLOCK_FRAMES;
use ridgetone_proto::settings::TAXELS;
use ridgetone_tone::Values;

/// Taxels of a share.
pub const SHARE: usize = TAXELS / SHARES;
/// Shares of a block, as many as it has frames.
pub const SHARES: usize = BLOCK_FRAMES as usize;

/// The taxels of one share.
pub type Share = [f32; SHARE];

/// One share of what there is one of for every taxel.
pub fn share<T>(all: &[T; TAXELS], which: usize) -> &[T; SHARE] {
    &all.as_chunks().0[which % SHARES]
}

/// The same, to be changed.
pub fn share_mut<T>(all: &mut [T; TAXELS], which: usize) -> &mut [T; SHARE] {
    &mut all.as_chunks_mut().0[which % SHARES]
}

/// Puts one share of some values in its place.
pub fn put(values: &mut Values, which: usize, share: Share) {
    *share_mut(values, which) = share;
}

/// Squared distance of two levels, each taxel's times its weight.
pub fn distance<const N: usize>(weights: &[f32; N], a: &[f32; N], b: &[f32; N]) -> f32 {
    let part = |c: usize| {
        let off = a[c] - b[c];
        off * off * weights[c]
    };
    (1..N).fold(part(0), |sum, c| sum + part(c))
}

/// `f32::max` is a call here, with more regard for NaN than a sum of squares needs.
pub(super) fn greater(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}
