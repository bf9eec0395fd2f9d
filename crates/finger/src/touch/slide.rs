//! Phases of a touch, and its slides: when a motion is a slide, until when it moved for sure, and
//! when it ended.

use crate::ring::reached;
use crate::touch::block::{BLOCK_FRAMES, Block};
use crate::touch::chi_square::{Limit, limit};
use crate::touch::condition::Condition;
use crate::touch::motion::{FAINT_BLOCKS, LONG_BLOCKS, LONGEST_BLOCKS, SHORT_BLOCKS};
use crate::touch::onset::{END_FRAMES, Frames, StillLevel};
use crate::touch::values::{difference, scale};
use ridgetone_proto::settings::{Slide, SlideRule};
use ridgetone_tone::Values;

/// Blocks for which a motion has to last to be a slide, not a knock: 183 ms.
const LASTING_BLOCKS: u32 = 11;
/// [`LASTING_BLOCKS`] for a slow motion, whose first blocks do not show: 116 ms.
const SLOW_LASTING_BLOCKS: u32 = 7;
/// Number of blocks with quick changes that make a motion a slide. A motion still shows in the
/// comparison for [`SHORT_BLOCKS`] after it has ended.
const SLIDE_BLOCKS: u32 = LASTING_BLOCKS + SHORT_BLOCKS;
/// Blocks with quick or faint changes after which a motion is a slide.
const FAINT_SLIDE_BLOCKS: u32 = LASTING_BLOCKS + FAINT_BLOCKS;
/// Blocks with any changes after which a motion is a slide.
const SLOW_SLIDE_BLOCKS: u32 = SLOW_LASTING_BLOCKS + LONG_BLOCKS;
/// Blocks with any changes, also in the longest comparison, after which a motion is a slide.
const LONGEST_SLIDE_BLOCKS: u32 = SLOW_LASTING_BLOCKS + LONGEST_BLOCKS;
/// Blocks after which an average with a fraction of 0.2 per block has fallen from four times the
/// typical value to less than 1.3 times: 1 + 3 x 0.8^n.
const FADED_BLOCKS: u32 = 11;
/// Blocks from the last one in which a slide is known to have moved to the mean of four that shows
/// the level soon after it: a slow tone in noise may go on for one of them unnoticed.
const SOON_BLOCKS: u32 = 2;
/// Frames by which a slide may end before the last motion taken for sure: the remainder in an
/// average shows too.
const UNSURE_FRAMES: u32 = 40;
/// Minimum distance of two means of four blocks that shows a creep, blocks: nearer means share
/// some.
const CREEP_BLOCKS: u32 = 4;
/// Squared distance of two means, in units of its noise, that is a creep: 61 for 16 taxels, as in
/// [`crate::touch::motion`].
const CREEPS: Limit = limit(1.0, 45.0);

/// Phase of a touch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Phase {
    /// The idle level is learned: number of blocks so far.
    Learning(u32),
    Idle,
    /// The skin creeps back to where it was before the latest touch: the next block's mean is the
    /// idle level.
    CreepingBack,
    /// Touched since the block that ends with this frame; the spike's peak is looked for.
    Spike(u32),
    Hold,
    /// Something moves, a slide or only a step.
    Moving(Moving),
    /// The motion is a slide. Its start is looked for with the next frame: in this one the hold's
    /// pressure map is reported.
    Starting(Moving),
    Slide(Sliding),
    /// A slide by [`SlideRule::Always`]: nothing is looked for.
    Always(Sliding),
}

/// The first sign of a motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Sign {
    None,
    /// The load falls in the motion: the finger may be leaving.
    Unsure,
    Reported,
}

/// A motion that may become a slide.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moving {
    /// First frame of the motion's first block.
    pub since: u32,
    /// Number of blocks with quick changes, with quick or faint ones, and with any recent ones.
    quick: u32,
    faint: u32,
    any: u32,
    /// Blocks with a change in any comparison, the longest one included.
    longest: u32,
    /// First frame with a change across the direction of the load.
    pub sign: Sign,
}

impl Moving {
    /// A motion before its first block, which begins with frame `since`.
    pub const fn since(since: u32) -> Self {
        Self {
            since,
            quick: 0,
            faint: 0,
            any: 0,
            longest: 0,
            sign: Sign::None,
        }
    }

    /// The motion so far was none: it may begin with frame `since`.
    pub const fn anew(self, since: u32) -> Self {
        Self {
            sign: self.sign,
            ..Self::since(since)
        }
    }

    /// A motion that has lasted long enough, since a block that begins with frame `since`.
    pub const fn sliding_since(since: u32) -> Self {
        Self {
            quick: SLIDE_BLOCKS,
            any: 1,
            ..Self::since(since)
        }
    }

    /// Counts one more block.
    pub const fn with(self, block: Block) -> Self {
        Self {
            quick: self.quick + block.quick as u32,
            faint: self.faint + (block.quick || block.faint) as u32,
            any: self.any + block.moves_lately() as u32,
            longest: self.longest + block.moves() as u32,
            ..self
        }
    }

    /// True if the motion may be a creeping skin: only the longest comparison shows it.
    pub const fn is_creep(&self) -> bool {
        self.any == 0
    }

    /// True if only slow comparisons show that the motion lasts.
    pub const fn is_slow(&self) -> bool {
        self.quick < SLIDE_BLOCKS && self.faint < FAINT_SLIDE_BLOCKS
    }

    /// True if the motion has lasted long enough.
    pub const fn is_slide(&self) -> bool {
        !self.is_slow() || self.any >= SLOW_SLIDE_BLOCKS || self.longest >= LONGEST_SLIDE_BLOCKS
    }
}

/// A slide under way.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sliding {
    /// First frame of the slide.
    pub start: u32,
    /// True if only slow comparisons show that the slide lasts.
    pub is_slow: bool,
    /// Blocks since the slide was noticed.
    pub blocks: u32,
}

impl Sliding {
    pub const fn new(start: u32, is_slow: bool) -> Self {
        Self {
            start,
            is_slow,
            blocks: 0,
        }
    }
}

/// End of a motion so far.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moved {
    /// The slide lasted at least until this frame.
    pub until: u32,
    /// True if only the longest comparison shows the motion, which dates it poorly.
    pub is_loose: bool,
}

impl Moved {
    pub const fn until(until: u32) -> Self {
        Self {
            until,
            is_loose: false,
        }
    }

    /// One block further, which ends with frame `number`. Its comparisons show a change somewhere in
    /// their reach, and only that within the block is a change right now.
    ///
    /// Averaged frames have short windows: there an average counts only when a block as strong as can
    /// be has left it.
    pub const fn follow(&mut self, block: Block, number: u32, is_averaged: bool) {
        let reach = match block {
            Block { now: true, .. } => 0,
            Block { quick: true, .. } => SHORT_BLOCKS,
            Block { faint: true, .. } if is_averaged => FADED_BLOCKS,
            Block { faint: true, .. } => FAINT_BLOCKS,
            Block { slow: true, .. } => LONG_BLOCKS,
            Block { longest: true, .. } => LONGEST_BLOCKS,
            _ => return,
        };
        let until = number.wrapping_sub(BLOCK_FRAMES * (reach + 1) - 1);
        if reached(until, self.until) {
            let is_loose = !block.moves_lately();
            *self = Self { until, is_loose };
        }
    }
}

/// First frame of the slide that the protocol plans for a touch at frame `contact`, and the one
/// after the last. `None` if the slide is found by motion.
pub fn planned(slide: &Slide, contact: u32, condition: &Condition) -> Option<(u32, u32)> {
    if slide.rule == SlideRule::Found {
        return None;
    }
    let start = contact.wrapping_add(condition.frames_in(slide.delay_s));
    let frames = condition.frames_in(slide.length_mm / slide.speed_mm_s);
    Some((start, start.wrapping_add(frames)))
}

/// The first frame after a slide: the taxels have arrived at the trend along which the skin creeps
/// when nothing moves any more. The latest block, which ends with frame `over`, shows that the
/// slide has ended. `level` is the mean of the last four blocks.
pub fn slide_end(frames: &Frames, level: &Values, moved: Moved, over: u32) -> u32 {
    let earliest = moved.until.wrapping_sub(UNSURE_FRAMES);
    if moved.is_loose {
        let last = over.wrapping_sub(2 * BLOCK_FRAMES);
        let stride = last.wrapping_sub(earliest) / END_FRAMES + 1;
        return frames.motion_end(StillLevel::new(level), last, earliest, stride);
    }
    // Blocks between the mean soon after the slide and that of the last four.
    let still = over.wrapping_sub(moved.until) / BLOCK_FRAMES;
    let skip = still.saturating_sub(SOON_BLOCKS + 4);
    let soon = &frames.mean(over.wrapping_sub(skip * BLOCK_FRAMES), 4 * BLOCK_FRAMES);
    // Two means of sixteen frames each: only a difference beyond their noise, which may wander, is a
    // creep.
    let apart = frames.motion.distance(level, soon) * (2 * BLOCK_FRAMES) as f32;
    let noise = frames.motion.wander() * frames.motion.taxels.limit(CREEPS);
    let is_creep = skip >= CREEP_BLOCKS && apart > noise;
    let mut creep = difference(level, soon);
    scale(&mut creep, 1.0 / (skip.max(1) * BLOCK_FRAMES) as f32);
    let creep = is_creep.then_some(&creep);
    let middle = over.wrapping_sub(skip * BLOCK_FRAMES + 2 * BLOCK_FRAMES - 1);
    frames.motion_end(StillLevel { level: soon, creep }, middle, earliest, 1)
}
