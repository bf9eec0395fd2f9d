//! The noise of the taxels, learned while nothing moves.

use super::BLOCK_FRAMES;
use super::past::Past;
use super::share::{SHARE, greater, put, share};
use ridgetone_proto::settings::TAXELS;
use ridgetone_tone::Values;

/// Blocks over which the noise is averaged, once there are so many: 0.5 s.
const LEARN_BLOCKS: f32 = 32.0;

/// What is known of it.
#[derive(Clone, Debug)]
pub(super) struct Noise {
    /// One over the variance of each taxel's frames, which is the greater of the two below.
    pub weights: Values,
    /// By the differences from frame to frame: right for white noise.
    quick_variance: Values,
    /// By the differences from block to block: larger where neighbouring frames share their noise, as
    /// those of a recording that was interpolated do.
    slow_variance: Values,
    /// Blocks that have taught the noise, as far as they matter.
    learned: f32,
    /// Whether the latest block is to be learned.
    pub teaches: bool,
    /// What the one that is being learned weighs, else zero.
    lesson: f32,
}

impl Noise {
    /// That of an ideal chip, until there is better.
    pub const fn new() -> Self {
        Self {
            weights: [1.0; TAXELS],
            quick_variance: [1.0; TAXELS],
            slow_variance: [0.0; TAXELS],
            learned: 0.0,
            teaches: false,
            lesson: 0.0,
        }
    }

    /// Before a block's first share: what the block before it weighs in all that is learned; zero if it teaches nothing.
    #[inline(always)]
    pub fn begin(&mut self) -> f32 {
        self.lesson = 0.0;
        if core::mem::take(&mut self.teaches) {
            if self.learned < LEARN_BLOCKS {
                self.learned += 1.0;
            }
            self.lesson = 1.0 / self.learned;
        }
        self.lesson
    }

    /// Learns one share of the block that teaches, if there is one: the latest of `past`, whose squared changes from
    /// frame to frame are `squares`.
    #[inline(always)]
    pub fn learn_share(&mut self, turn: usize, past: &Past, squares: &Values) {
        if self.lesson == 0.0 {
            return;
        }
        let mean = past.back(0);
        let before = if past.count > 1 { past.back(1) } else { mean };
        let (mean, before, squares) = (share(mean, turn), share(before, turn), share(squares, turn));
        let (mut quick, mut slow) = (*share(&self.quick_variance, turn), *share(&self.slow_variance, turn));
        let mut weights = [0.0; SHARE];
        for c in 0..SHARE {
            // Two neighbours' difference has twice the variance of one; a mean of four frames has a
            // quarter of that of one.
            let quick_now = squares[c] * (1.0 / (2 * BLOCK_FRAMES) as f32);
            let off = mean[c] - before[c];
            let slow_now = off * off * (BLOCK_FRAMES as f32 / 2.0);
            // A code is an integer: less than 1/12 of its square is not noise but luck.
            quick[c] += self.lesson * (greater(quick_now, 1.0 / 12.0) - quick[c]);
            slow[c] += self.lesson * (slow_now - slow[c]);
            weights[c] = 1.0 / greater(quick[c], slow[c]);
        }
        put(&mut self.quick_variance, turn, quick);
        put(&mut self.slow_variance, turn, slow);
        put(&mut self.weights, turn, weights);
    }
}
