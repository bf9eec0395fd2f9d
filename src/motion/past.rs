//! The recent past: means of the latest blocks, from which comparisons start.

use super::LONG;
use super::share::{SHARE, SHARES, Share, put, share};
use crate::settings::TAXELS;
use crate::window::Values;

/// Blocks that are remembered, and one in the making.
pub(super) const HISTORY: usize = (2 * LONG + 1).next_power_of_two();

/// Means of the latest blocks.
#[derive(Clone, Debug)]
pub(super) struct Past {
    pub blocks: [Values; HISTORY],
    /// Place of the latest.
    pub latest: usize,
    /// Blocks that are remembered.
    pub count: usize,
    /// Sum of the latest ones, as many as the long comparison reaches back.
    pub sum: Values,
}

impl Past {
    /// Nothing yet.
    pub const fn new() -> Self {
        Self { blocks: [[0.0; TAXELS]; HISTORY], latest: 0, count: 0, sum: [0.0; TAXELS] }
    }

    /// The block `back` blocks before the latest; further back than [`HISTORY`] it is a later one.
    pub fn back(&self, back: usize) -> &Values {
        &self.blocks[self.latest.wrapping_sub(back) % HISTORY]
    }

    /// Place of the next one.
    pub fn next(&self) -> usize {
        (self.latest + 1) % HISTORY
    }

    /// Mean of the `count` latest blocks but the `skip` very latest, as far as they are remembered.
    /// None if there is not one.
    pub fn recent_mean(&self, skip: usize, count: usize) -> Option<Values> {
        let until = (skip + count).min(self.count);
        if until <= skip {
            return None;
        }
        let mut mean = [0.0; TAXELS];
        for turn in 0..SHARES {
            put(&mut mean, turn, self.share_mean(turn, skip..until));
        }
        Some(mean)
    }

    /// One share of the mean of some blocks. Apart, for all in one would be unrolled to over a kilobyte.
    #[inline(never)]
    fn share_mean(&self, turn: usize, blocks: core::ops::Range<usize>) -> Share {
        let mut sum = [0.0; SHARE];
        let count = blocks.len() as f32;
        for back in blocks {
            let block = share(self.back(back), turn);
            for c in 0..SHARE {
                sum[c] += block[c];
            }
        }
        sum.map(|sum| sum / count)
    }
}
