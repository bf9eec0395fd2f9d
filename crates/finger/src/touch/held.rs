//! The level that is held, for the static image: the mean of the latest part of a hold in which
//! nothing moved.

use crate::touch::block::BLOCK_FRAMES;
use crate::touch::motion::Motion;
use crate::touch::values::approach;
use ridgetone_proto::settings::TAXELS;
use ridgetone_proto::telemetry::Hold;
use ridgetone_tone::Values;

/// Latest blocks that are no part of the level: that in which a motion is noticed, and the one
/// before it, which may hold the first of it.
pub const HELD_BACK: usize = 2;
/// Minimum number of blocks that are worth an image: 0.1 s.
const BLOCKS_MIN: u32 = 6;
/// A level is back at idle within this fraction of the way to the held one, squared: about a third.
pub const BACK_AT_IDLE: f32 = 0.1;
/// A level is a load beyond this fraction of the way, squared: a half. Less is a skin on its way
/// back.
pub const IS_LOAD: f32 = 0.25;

/// Level of the hold.
#[derive(Clone, Debug, PartialEq)]
pub struct HeldLevel {
    /// Mean of the blocks, codes. Before the first block, where the taxels are still.
    pub level: Values,
    /// First frame of the mean.
    pub from: u32,
    /// The frame behind its last.
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

    /// Begins anew: nothing is in the mean yet.
    pub fn restart(&mut self) {
        (self.blocks, self.good) = (0, u16::MAX);
    }

    /// One still block further, which ends with frame `number`.
    pub fn extend(&mut self, number: u32, motion: &Motion) {
        self.until = number
            .wrapping_sub(HELD_BACK as u32 * BLOCK_FRAMES)
            .wrapping_add(1);
        if self.blocks == 0 {
            self.from = self.until.wrapping_sub(BLOCK_FRAMES);
        }
        self.blocks = self.blocks.saturating_add(1);
        approach(
            &mut self.level,
            motion.past().back(HELD_BACK),
            1.0 / self.blocks as f32,
        );
    }

    /// Frames in the mean.
    pub const fn frames(&self) -> u32 {
        self.blocks * BLOCK_FRAMES
    }

    /// True if it is long enough for an image.
    pub const fn is_long_enough(&self) -> bool {
        self.blocks >= BLOCKS_MIN
    }
}
