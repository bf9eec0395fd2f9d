//! Shares of the taxels: a frame's work is one of them.

use super::BLOCK_FRAMES;
use crate::settings::TAXELS;
use crate::window::Values;

/// Taxels of a share.
pub(super) const SHARE: usize = TAXELS / SHARES;
/// Shares of a block, as many as it has frames.
pub(super) const SHARES: usize = BLOCK_FRAMES as usize;

/// The taxels of one share.
pub(super) type Share = [f32; SHARE];

pub(super) fn share(values: &Values, which: usize) -> &Share {
    &values.as_chunks().0[which % SHARES]
}

pub(super) fn put(values: &mut Values, which: usize, share: Share) {
    values.as_chunks_mut().0[which % SHARES] = share;
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
