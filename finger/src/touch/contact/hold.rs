//! What a hold does to the taxels: their mean over it, for the static image.

use super::{ContactDetector, HELD_BACK, Phase, is_load};
use crate::touch::motion::{BLOCK_FRAMES, Block};
use ridgetone_tone::Values;

/// Fewest blocks of a hold that are worth an image: 0.1 s.
const BLOCKS_MIN: u32 = 6;

/// The latest stretch of a hold in which nothing moved.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Held {
    /// Its first frame.
    pub from: u32,
    /// The frame behind its last.
    pub until: u32,
    /// Blocks in the mean over it.
    blocks: u32,
    /// Bit k: taxel k was good in all of it.
    pub good: u16,
    /// Whether a slide went before the hold.
    pub after_slide: bool,
}

impl Held {
    /// Nothing yet of a hold, with or without a slide before it.
    pub(super) const fn new(after_slide: bool) -> Self {
        Self { from: 0, until: 0, blocks: 0, good: 0, after_slide }
    }

    /// Frames in the mean over it.
    pub const fn frames(&self) -> u32 {
        self.blocks * BLOCK_FRAMES
    }
}

/// A hold and its levels, codes.
#[derive(Clone, Copy, Debug)]
pub struct Imprint<'a> {
    /// The hold.
    pub held: Held,
    /// Mean over it.
    pub level: &'a Values,
    /// Level before the touch.
    pub idle: &'a Values,
    /// One over the variance of each taxel's frames.
    pub weights: &'a Values,
}

impl ContactDetector {
    /// One still block of a hold further: the loaded level goes on to be the mean of those that hold back enough from
    /// whatever may begin to move.
    pub(super) fn hold_on(&mut self, number: u32, block: &Block) {
        if self.still <= HELD_BACK as u32 || !is_load(block.off, self.load) {
            (self.held.blocks, self.held.good) = (0, u16::MAX);
            return;
        }
        let held = &mut self.held;
        held.until = number.wrapping_sub(HELD_BACK as u32 * BLOCK_FRAMES).wrapping_add(1);
        if held.blocks == 0 {
            held.from = held.until.wrapping_sub(BLOCK_FRAMES);
        }
        held.blocks = held.blocks.saturating_add(1);
        self.loaded_follows = 1.0 / held.blocks as f32;
    }

    /// A hold is over; its image is due if it was long enough.
    pub(super) fn end_hold(&mut self) {
        self.image_due = self.held.blocks >= BLOCKS_MIN;
    }

    /// Whether an image is due.
    pub const fn has_image(&self) -> bool {
        self.image_due
    }

    /// Whether an image is due and the latest frame has time for some of it: the two in the middle of a block, unless
    /// something was told while it came.
    pub fn has_time_for_image(&self) -> bool {
        let middle = matches!(self.motion.turn(), 2 | 3);
        self.image_due && middle && self.told != self.block_end as u8 && self.pending_onset.is_none() && !self.is_busy()
    }

    /// Only these taxels of the next frame are to be trusted.
    #[inline(never)]
    pub fn doubt_all_but(&mut self, good: u16) {
        if self.phase == Phase::Hold {
            self.held.good &= good;
        }
    }

    /// What is due, until [`Self::image_told`]; none while the levels are being moved.
    pub fn imprint(&self) -> Option<Imprint<'_>> {
        let idle = match self.phase {
            Phase::Settling(..) => return None,
            Phase::Slide(_) | Phase::Hold | Phase::Moving { .. } => &self.idle,
            // The touch is over, and the idle level that of the next.
            Phase::Learning | Phase::Idle | Phase::Spike(_) => self.before.as_ref()?,
        };
        let (held, level, weights) = (self.held, &self.loaded, self.motion.weights());
        Some(Imprint { held, level, idle, weights })
    }

    /// The image is told.
    pub fn image_told(&mut self) {
        self.image_due = false;
    }
}
