//! Level of a hold, for the pressure map: the mean of the latest part of the hold in which nothing
//! moved.

use crate::touch::block::BLOCK_FRAMES;
use crate::touch::motion::Motion;
use ridgetone_proto::settings::TAXELS;
use ridgetone_proto::telemetry::Hold;
use ridgetone_tone::Values;

/// Latest blocks excluded from the level: the one in which a motion is noticed, and the one before,
/// in which the motion may have begun.
pub const HELD_BACK: usize = 2;
/// Minimum number of blocks for a pressure map: 0.1 s.
const BLOCKS_MIN: u32 = 6;
/// Squared fraction of the way from idle to the held level below which a level is at idle: about a
/// third.
pub const BACK_AT_IDLE: f32 = 0.1;
/// Squared fraction of the way beyond which a level is a load: a half. Less is a skin on its way
/// back.
pub const IS_LOAD: f32 = 0.25;

/// Level of the hold.
#[derive(Clone, Debug, PartialEq)]
pub struct HeldLevel {
    /// Mean of the blocks, codes; before the first block, the level at which the taxels are still.
    pub level: Values,
    /// First frame of the mean.
    pub from: u32,
    /// Frame after the last one of the mean.
    pub until: u32,
    blocks: u32,
    /// Bit k: taxel k was good all the time.
    pub good: u16,
    /// True if a slide preceded the hold.
    pub hold: Hold,
}

impl HeldLevel {
    pub const fn new() -> Self {
        Self {
            level: [0.0; TAXELS],
            from: 0,
            until: 0,
            blocks: 0,
            good: u16::MAX,
            hold: Hold::BeforeSlide,
        }
    }

    /// Starts again with an empty mean.
    pub fn restart(&mut self) {
        (self.blocks, self.good) = (0, u16::MAX);
    }

    /// Extends the mean by a still block, which ends with frame `number`.
    pub fn extend(&mut self, number: u32, motion: &Motion) {
        self.until = number
            .wrapping_sub(HELD_BACK as u32 * BLOCK_FRAMES)
            .wrapping_add(1);
        if self.blocks == 0 {
            self.from = self.until.wrapping_sub(BLOCK_FRAMES);
        }
        self.blocks = self.blocks.saturating_add(1);
        let (latest, fraction) = (motion.past.back(HELD_BACK), 1.0 / self.blocks as f32);
        for (level, latest) in self.level.iter_mut().zip(latest) {
            *level += fraction * (latest - *level);
        }
    }

    pub const fn frames(&self) -> u32 {
        self.blocks * BLOCK_FRAMES
    }

    /// True if the hold is long enough for a pressure map.
    pub const fn is_long_enough(&self) -> bool {
        self.blocks >= BLOCKS_MIN
    }
}
