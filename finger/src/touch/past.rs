//! The recent past: means of the latest blocks of frames.

use ridgetone_proto::settings::TAXELS;
use ridgetone_tone::Values;

/// Frames of a block: 16.6 ms at 241 Hz.
pub const BLOCK_FRAMES: u32 = 4;
/// Blocks that are remembered: 0.53 s. A power of two, because their places wrap.
const HISTORY: usize = 32;
/// Most blocks that [`Past::mean_of_four`] can leave out.
pub const SKIP_MAX: usize = HISTORY - 5;

/// Means of the latest blocks.
#[derive(Clone, Debug)]
pub struct Past {
    blocks: [Values; HISTORY],
    /// Place of the latest.
    latest: usize,
    /// Blocks since the last restart, as far as they are remembered.
    pub count: usize,
}

impl Past {
    pub const fn new() -> Self {
        Self { blocks: [[0.0; TAXELS]; HISTORY], latest: 0, count: 0 }
    }

    pub fn push(&mut self, mean: Values) {
        self.latest = (self.latest + 1) % HISTORY;
        self.blocks[self.latest] = mean;
        self.count = (self.count + 1).min(HISTORY - 1);
    }

    /// The block `back` blocks before the latest, at most [`HISTORY`] - 1. It may be older than a restart.
    pub fn back(&self, back: usize) -> &Values {
        &self.blocks[self.latest.wrapping_sub(back) % HISTORY]
    }

    /// The mean of four blocks, the `skip` latest left out.
    pub fn mean_of_four(&self, skip: usize) -> Values {
        let [a, b, c, d] = [0, 1, 2, 3].map(|back| self.back(skip + back));
        core::array::from_fn(|taxel| (a[taxel] + b[taxel] + c[taxel] + d[taxel]) * 0.25)
    }
}
