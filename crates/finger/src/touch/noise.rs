//! The noise of each taxel, learned from blocks in which nothing moves.

use crate::touch::block::BLOCK_FRAMES;
use crate::touch::past::Past;
use crate::touch::values::{greater, lesser};
use ridgetone_proto::settings::TAXELS;
use ridgetone_tone::Values;

/// Blocks after which the noise is known, more or less.
pub const KNOWN_BLOCKS: f32 = 8.0;
/// Blocks over which the noise is averaged: 0.5 s; once it is known, one of eight over 4 s.
pub const NOISE_BLOCKS: f32 = 32.0;
/// Minimum variance of a frame, squared codes: that of rounding to whole codes. Less is chance.
const ROUNDING_VARIANCE: f32 = 1.0 / 12.0;

/// Estimate of the noise.
#[derive(Clone, Debug)]
pub struct Noise {
    /// One over the variance of each taxel's frames, which is the greater of the two below.
    pub weights: Values,
    /// From the differences between frames: right for white noise.
    quick_variance: Values,
    /// From the differences between blocks: larger where neighbouring frames share their noise, as
    /// those of a recording that was interpolated do.
    slow_variance: Values,
    /// Blocks that the noise was learned from, at most [`NOISE_BLOCKS`].
    pub learned: f32,
}

impl Noise {
    /// The weights of an ideal chip, until there are better ones. The first block alone sets the
    /// variances.
    pub const fn new() -> Self {
        Self {
            weights: [1.0; TAXELS],
            quick_variance: [0.0; TAXELS],
            slow_variance: [0.0; TAXELS],
            learned: 0.0,
        }
    }

    /// Subtracts the contribution of a drift by `slope` in each block. The noise of a few blocks
    /// alone would be too small for some taxel. The weights follow with the next block that is
    /// learned from.
    pub fn forget(&mut self, slope: Option<&Values>) {
        self.learned = lesser(self.learned, KNOWN_BLOCKS);
        let Some(slope) = slope else { return };
        for c in 0..TAXELS {
            // In a block it adds four squares of a quarter of the slope, and one of all of it to
            // the difference of two means.
            let square = slope[c] * slope[c];
            let quick =
                self.quick_variance[c] - square * (1.0 / (2 * BLOCK_FRAMES * BLOCK_FRAMES) as f32);
            self.quick_variance[c] = greater(quick, ROUNDING_VARIANCE);
            self.slow_variance[c] = greater(
                self.slow_variance[c] - square * (BLOCK_FRAMES as f32 / 2.0),
                0.0,
            );
        }
    }

    /// Learns from the latest block of `past`, whose squared changes from frame to frame are
    /// `squares`.
    pub fn learn(&mut self, past: &Past, squares: &Values) {
        if self.learned < NOISE_BLOCKS {
            self.learned += 1.0;
        }
        let fraction = 1.0 / self.learned;
        let mean = past.back(0);
        let before = if past.count > 1 { past.back(1) } else { mean };
        for c in 0..TAXELS {
            // The difference of two neighbours has twice the variance of one frame; a mean of four
            // has a quarter of it.
            let quick_now = squares[c] * (1.0 / (2 * BLOCK_FRAMES) as f32);
            let off = mean[c] - before[c];
            let slow_now = off * off * (BLOCK_FRAMES as f32 / 2.0);
            let quick = &mut self.quick_variance[c];
            *quick += fraction * (greater(quick_now, ROUNDING_VARIANCE) - *quick);
            let slow = &mut self.slow_variance[c];
            *slow += fraction * (slow_now - *slow);
            self.weights[c] = 1.0 / greater(*quick, *slow);
        }
    }
}
