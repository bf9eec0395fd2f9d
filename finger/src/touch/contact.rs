//! Phases of a touch: idle (A), contact spike and hold (B), slide (C), hold (D), release (E).
//!
//! The spike is found as in the paper's equations 2 and 3, over all taxels and as the data come: the
//! taxel whose deviation from its idle level is the greatest tells the time. The slide comes either
//! from the protocol (equations 4 and 5) or from the signal itself: it starts when the held levels
//! begin to change and ends when they stop, both dated back to the frame where it happened: the end along the creep of
//! the skin, which goes on when nothing moves any more.
//!
//! A block of frames is dealt with while the next one comes, a share of the taxels with each frame; what a decision
//! needs is summed up in the same way, with the block after it. What is to be dated is told when it is: a slide's
//! end and a release up to a quarter of a second later.

mod aftermath;
mod hold;
mod pending_onset;
mod slide;
mod spike;

use crate::ring::Ring;
use crate::touch::motion::{BLOCK_FRAMES, Block, Motion};
use crate::touch::onset::Search;
use aftermath::After;
pub use hold::{Held, Imprint};
use pending_onset::PendingOnset;
use ridgetone_proto::settings::{SlideRule, TAXELS};
use ridgetone_tone::Values;
use spike::Spike;

/// Blocks that teach the idle level and the noise before anything is looked for: 133 ms.
const LEARN_BLOCKS: u32 = 8;
/// A block's mean this far from the idle level is contact: as [`crate::touch::motion`]'s own limit, with
/// room for the uncertainty of the level.
const TOUCHED: f32 = 100.0;
/// Time within which the spike's peak is looked for after the first touch, frames: 0.3 s. The paper
/// looks for it in the first 0.8 s of a record that contains it.
const SPIKE_FRAMES: u32 = 72;
/// Blocks in a row without any change after which something is still: 66 ms.
const STILL_BLOCKS: u32 = 4;
/// Latest blocks that are no part of the level that was held: that in which a motion is noticed, and the one before it,
/// which may hold the first of it already.
const HELD_BACK: usize = 2;
/// Levels are back at idle within this share of the way to the loaded ones, squared (about a third).
const BACK_AT_IDLE: f32 = 0.1;

/// What happened.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Change {
    /// The contact spike.
    Contact {
        /// Frame of its peak.
        frame: u32,
        /// Taxel with the greatest deviation.
        taxel: u8,
        /// That deviation from the idle level, codes.
        height: f32,
    },
    /// A slide began at this frame.
    SlideStart(u32),
    /// The slide has ended: first frame and the one behind its last.
    SlideEnd(u32, u32),
    /// The finger is off since this frame.
    Release(u32),
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Phase {
    Learning,
    Idle,
    /// Since this frame; the spike's peak is being looked for.
    Spike(u32),
    /// Something was over at this frame; where the taxels are by then is being summed up.
    Settling(After, u32),
    Hold,
    /// Something moves; a slide or only a step. Blocks with quick changes, and with any.
    Moving {
        quick: u32,
        any: u32,
    },
    /// Since this frame.
    Slide(u32),
}

/// The state machine.
#[derive(Clone, Debug)]
pub struct ContactDetector {
    rule: SlideRule,
    phase: Phase,
    motion: Motion,
    /// Number of the last frame of the latest block.
    block_end: u32,
    /// What is known and not told yet.
    news: Option<Change>,
    /// The latest block's end when something was told last, low byte: by a chance repeat an image waits for one block.
    told: u8,
    /// What is being dated, and how.
    pending_onset: Option<PendingOnset>,
    search: Search,
    /// What is to be dated next, from which frame on, and at which level.
    waiting: Option<(PendingOnset, u32)>,
    level: Values,
    /// Whether the level is that of the hold before a motion, and still being summed up.
    level_due: bool,
    /// Squared distance of that level from idle, as far as it is summed up.
    off: f32,
    idle: Values,
    /// How far the idle level is to follow the latest block.
    idle_follows: f32,
    idle_blocks: u32,
    /// Idle level before the last touch, if there was one: where the skin creeps back to.
    before: Option<Values>,
    /// By how much nearer to it the idle level is than the block of the first touch, as far as it is summed up.
    crept: f32,
    /// Mean over the latest hold, or where the taxels came to before there was one.
    loaded: Values,
    /// How far the loaded level is to follow the block that is [`HELD_BACK`] back.
    loaded_follows: f32,
    held: Held,
    /// Whether that hold is over and its image not told yet.
    image_due: bool,
    /// Squared distance of the loaded level from idle, in units of the latest noise.
    load: f32,
    spike: Spike,
    /// Frame of the touch's spike: no slide begins before it.
    touched: u32,
    /// Blocks in a row without a quick, and without any, change.
    still_quick: u32,
    still: u32,
    /// Slide by protocol: first frame and the one behind its last, until it is over.
    planned: Option<(u32, u32)>,
    /// Frame up to which the slide is known to have lasted.
    moving_until: u32,
}

impl ContactDetector {
    /// At rest, having seen nothing.
    pub const fn new(rule: SlideRule) -> Self {
        Self {
            rule,
            phase: Phase::Learning,
            motion: Motion::new(),
            block_end: 0,
            news: None,
            told: 0,
            pending_onset: None,
            search: Search::new(),
            waiting: None,
            level: [0.0; TAXELS],
            level_due: false,
            off: 0.0,
            idle: [0.0; TAXELS],
            idle_follows: 0.0,
            idle_blocks: 0,
            before: None,
            crept: 0.0,
            loaded: [0.0; TAXELS],
            loaded_follows: 0.0,
            held: Held::new(false),
            image_due: false,
            load: 0.0,
            spike: Spike::new(),
            touched: 0,
            still_quick: 0,
            still: 0,
            planned: None,
            moving_until: 0,
        }
    }

    /// From the next touch on, and for what of this one has not begun yet, slides come from here.
    pub const fn set_rule(&mut self, rule: SlideRule) {
        self.rule = rule;
    }

    /// Whether the finger is on something, or was until just now.
    pub const fn is_touched(&self) -> bool {
        !matches!(self.phase, Phase::Learning | Phase::Idle)
    }

    /// While a slide lasts, from when its start is told: its first frame, and the frame up to which it is known to have
    /// lasted.
    pub const fn sliding(&self) -> Option<(u32, u32)> {
        match self.phase {
            Phase::Slide(start) if self.news.is_none() => Some((start, self.moving_until)),
            _ => None,
        }
    }

    /// Takes frame `number`, the latest one in `ring`; tells what changed.
    pub fn push(&mut self, number: u32, values: &Values, ring: &Ring, changed: &mut dyn FnMut(Change)) {
        let turn = self.motion.turn() % BLOCK_FRAMES as usize;
        // First, so that what this frame finds out is told with the next.
        self.seek(turn, ring, changed);
        self.evaluate(turn, ring, changed);
        self.follow_plan(number, ring, changed);
        if self.motion.push(values) {
            self.block_end = number;
        }
    }

    /// The data has ended with the frame before `number`: a slide that still runs is over.
    pub fn finish(&mut self, number: u32, ring: &Ring, changed: &mut dyn FnMut(Change)) {
        for turn in self.motion.turn()..BLOCK_FRAMES as usize {
            self.evaluate(turn, ring, changed);
        }
        if matches!(self.phase, Phase::Hold | Phase::Moving { .. }) {
            self.end_hold();
        }
        if let Phase::Slide(start) = self.phase {
            let end = if self.planned.is_some() { number } else { self.moving_until };
            self.enter(Phase::Hold);
            self.tell(Change::SlideEnd(start, end), ring, changed);
        }
        self.settle_now(ring, changed);
        self.settle(ring, changed);
    }

    /// Deals with a share of the latest block.
    #[inline(never)]
    fn evaluate(&mut self, turn: usize, ring: &Ring, changed: &mut dyn FnMut(Change)) {
        if self.idle_follows > 0.0 {
            self.motion.approach(&mut self.idle, turn, self.idle_follows, 0);
        }
        match self.phase {
            Phase::Spike(since) => self.follow_spike(turn, since, ring),
            Phase::Settling(after, over) => self.sum_up(turn, after, over, ring),
            Phase::Moving { .. } if self.level_due => self.sum_up_held(turn),
            _ => {}
        }
        if self.loaded_follows > 0.0 {
            self.motion.approach(&mut self.loaded, turn, self.loaded_follows, HELD_BACK);
        }
        // While something slides the noise is not learned, and the load stays what it is.
        let holding = matches!(self.phase, Phase::Hold | Phase::Moving { .. });
        let (other, sliding) = (holding.then_some(&self.loaded), matches!(self.phase, Phase::Slide(_)));
        let Some(block) = self.motion.evaluate(turn, &self.idle, other, sliding) else { return };
        (self.idle_follows, self.loaded_follows) = (0.0, 0.0);
        if holding {
            self.load = block.other;
        }
        self.still_quick = if block.quick { 0 } else { self.still_quick.saturating_add(1) };
        self.still = if block.quick || block.slow { 0 } else { self.still.saturating_add(1) };
        // Not while something is searched for: that is work enough.
        if self.step(self.block_end, &block, ring, changed) && self.pending_onset.is_none() && self.waiting.is_none() {
            self.motion.learn();
        }
    }

    /// One block further. True if the finger was still, so that the noise can be learned from it.
    fn step(&mut self, number: u32, block: &Block, ring: &Ring, changed: &mut dyn FnMut(Change)) -> bool {
        match self.phase {
            Phase::Learning => {
                self.idle_blocks += 1;
                self.idle_follows = 1.0 / self.idle_blocks as f32;
                if self.idle_blocks == LEARN_BLOCKS {
                    self.enter(Phase::Idle);
                }
                true
            }
            Phase::Idle => {
                if block.off * BLOCK_FRAMES as f32 > TOUCHED {
                    self.begin_spike(number);
                    return false;
                }
                self.idle_follows = 1.0 / 16.0;
                true
            }
            Phase::Spike(since) => {
                if self.crept < 0.0 {
                    // The skin creeps back after a touch.
                    self.idle = *self.motion.mean();
                    self.enter(Phase::Idle);
                } else if number.wrapping_sub(since) >= SPIKE_FRAMES || self.still_quick >= 6 {
                    self.settle_after(After::Spike, number, ring, changed);
                }
                false
            }
            Phase::Settling(after, over) => {
                self.settled(after, over, ring, changed);
                false
            }
            Phase::Hold => self.hold(number, block, ring, changed),
            Phase::Moving { quick, any } => {
                self.moving((quick, any), number, block, ring, changed);
                false
            }
            Phase::Slide(start) => {
                self.slide(start, number, block, ring, changed);
                false
            }
        }
    }

    #[inline]
    fn enter(&mut self, phase: Phase) {
        self.phase = phase;
        self.motion.restart();
        self.still = 0;
        self.still_quick = 0;
    }
}

/// Whether a level so far from idle is back at it, the loaded one being so far from it; both squared.
fn back_at_idle(off: f32, loaded: f32) -> bool {
    off < BACK_AT_IDLE * loaded
}

/// Whether a level so far from idle is a load, the loaded one being so far from it; both squared. Less than half
/// of that is a skin on its way back.
fn is_load(off: f32, loaded: f32) -> bool {
    off > 0.25 * loaded
}
