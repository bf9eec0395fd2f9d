//! Level in the air and its drift, with which a touch is compared.

use crate::touch::block::BLOCK_FRAMES;
use crate::touch::chi_square::{Limit, Taxels, limit};
use crate::touch::condition::Condition;
use crate::touch::motion::Motion;
use crate::touch::values::{add_times, greater, lesser};
use ridgetone_proto::settings::TAXELS;
use ridgetone_tone::Values;

/// Squared distance of a block's mean from the idle level that is contact: 100 for 16 taxels. The
/// limit of [`crate::touch::motion`], with a margin for the uncertainty of the level.
const TOUCHED: Limit = limit(1.0, 84.0);
/// Contact in noise that is not white and whose level wanders: a multiple of the typical distance.
const OVER_TYPICAL: f32 = 8.0;
/// Squared distance of a block that shows that the level does not go straight on: 61, as in
/// [`crate::touch::motion`].
const BENT: Limit = limit(1.0, 45.0);
/// Minimum and maximum number of blocks to which a line is fitted: 0.27 to 1.06 s. Fewer would
/// follow a gentle touch.
const BLOCKS: (f32, f32) = (16.0, 64.0);
/// Squared slope over its variance that is a drift rather than chance: 100 for 16 taxels.
const DRIFTS: Limit = limit(1.0, 84.0);
/// Blocks of a straight trend that show a drift: a skin that creeps back bends before.
const DRIFT_BLOCKS: f32 = 24.0;

/// Blocks from the middle of a block, for which a level holds, to the end, at which a slope is
/// known: 1.5 of 4 frames.
const AHEAD: f32 = 0.5 - 0.5 / BLOCK_FRAMES as f32;

/// A line through the latest blocks: a first-order polynomial filter with a growing memory
/// (Brookner, "Tracking and Kalman Filtering Made Easy" (1998), chapter 7).
#[derive(Clone, Debug)]
pub struct Idle {
    /// Level of the latest block, codes, without the known drift.
    pub level: Values,
    /// Rise per block, including the known drift.
    pub slope: Values,
    blocks: f32,
    /// Recent squared distance of a block from the line.
    typical: f32,
}

impl Idle {
    pub const fn new() -> Self {
        Self {
            level: [0.0; TAXELS],
            slope: [0.0; TAXELS],
            blocks: 0.0,
            typical: 0.0,
        }
    }

    /// Starts again at a level that four blocks have shown. A drift goes on.
    pub fn restart(&mut self, level: Values, condition: &Condition) {
        self.level = level;
        if condition.drifts() {
            self.blocks = BLOCKS.0;
        } else {
            (self.slope, self.blocks) = ([0.0; TAXELS], 4.0);
        }
    }

    /// Number of frames whose mean has the variance of the level.
    pub fn frames(&self) -> f32 {
        let blocks = self.blocks;
        BLOCK_FRAMES as f32 * blocks * (blocks + 1.0) / (4.0 * blocks - 2.0)
    }

    /// The squared distance of a block's mean that is contact.
    pub fn touched(&self, taxels: Taxels) -> f32 {
        greater(taxels.limit(TOUCHED), OVER_TYPICAL * self.typical)
    }

    /// Follows the latest block, which is in the air and `off` from the level, and measures the
    /// drift. The noise is learned anew if the drift was taken for noise.
    pub fn follow(&mut self, off: f32, motion: &mut Motion, condition: &mut Condition) {
        let (taxels, is_known) = (motion.taxels, condition.drifts());
        if self.blocks >= 4.0 {
            self.typical += (off - self.typical) * (1.0 / lesser(self.blocks, 32.0));
        }
        let (min, max) = BLOCKS;
        if off > taxels.limit(BENT) && self.blocks > min {
            self.blocks = greater(min, 0.5 * self.blocks);
        } else if self.blocks < max {
            self.blocks += 1.0;
        }
        let blocks = self.blocks;
        let fraction = 1.0 / (blocks * (blocks + 1.0));
        let to_level = (4.0 * blocks - 2.0) * fraction;
        let to_slope = if blocks > 1.0 { 6.0 * fraction } else { 0.0 };
        let (mean, weights) = (motion.past.back(0), motion.weights());
        let mut square = 0.0;
        for c in 0..TAXELS {
            let rise = if is_known { 0.0 } else { self.slope[c] };
            let expected = self.level[c] + rise;
            let off = mean[c] - expected;
            self.level[c] = expected + to_level * off;
            self.slope[c] += to_slope * off;
            if is_known {
                self.level[c] += AHEAD * to_slope * off;
            }
            square += self.slope[c] * self.slope[c] * weights[c];
        }
        // The slope's variance is 12 / n^3 of that of a block's mean. Noise that wanders has
        // steeper slopes than its blocks show.
        let wander = greater(1.0, self.typical / taxels.count);
        let times = square * (BLOCK_FRAMES as f32 / 12.0) * blocks * blocks * blocks;
        let drifts = times > taxels.limit(DRIFTS) * wander * wander;
        if blocks < DRIFT_BLOCKS && !is_known {
            return;
        }
        let slope = drifts.then_some(&self.slope);
        condition.set_drift(slope);
        if drifts != is_known {
            let ahead = if drifts { AHEAD } else { -AHEAD };
            add_times(&mut self.level, ahead, &self.slope);
            motion.forget(slope);
        }
    }
}
