//! The recent past: means of the latest blocks, from which comparisons start.

use super::LONG;
use super::share::{SHARE, Share, share};
use ridgetone_proto::settings::TAXELS;
use ridgetone_tone::Values;

/// Blocks that are remembered, and one in the making.
pub(super) const HISTORY: usize = (2 * LONG + 1).next_power_of_two();

/// Means of the latest blocks.
#[derive(Clone, Debug)]
pub(super) struct Past {
    /// In one row: an array of arrays is emptied one by one, by ten bytes of code each.
    blocks: [f32; HISTORY * TAXELS],
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
        Self { blocks: [0.0; HISTORY * TAXELS], latest: 0, count: 0, sum: [0.0; TAXELS] }
    }

    /// The block `back` blocks before the latest; further back than [`HISTORY`] it is a later one.
    pub fn back(&self, back: usize) -> &Values {
        &self.blocks.as_chunks().0[self.latest.wrapping_sub(back) % HISTORY]
    }

    /// The one in the making.
    pub fn next_mut(&mut self) -> &mut Values {
        &mut self.blocks.as_chunks_mut().0[(self.latest + 1) % HISTORY]
    }

    /// Place of the next one.
    pub fn next(&self) -> usize {
        (self.latest + 1) % HISTORY
    }

    /// One share of the mean of four blocks, the `skip` latest left out. A restart does not matter: they may be older.
    #[inline(never)]
    pub fn mean_of_four(&self, turn: usize, skip: usize) -> Share {
        let mut sum = *share(self.back(skip), turn);
        for back in 1..4 {
            let block = share(self.back(skip + back), turn);
            for c in 0..SHARE {
                sum[c] += block[c];
            }
        }
        sum.map(|sum| sum * 0.25)
    }
}
