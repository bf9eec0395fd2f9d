//! Phases of a touch: idle (A), contact spike and hold (B), slide (C), hold (D), release (E).
//!
//! The spike is found as in the paper's equations 2 and 3, over all taxels and as the data come: the
//! taxel whose deviation from its idle level is the greatest tells the time. The slide comes either
//! from the protocol (equations 4 and 5) or from the signal itself: it starts when the held levels
//! begin to change and ends when they stop, both dated back to the frame where it happened.
//!
//! A block of frames is dealt with when the next one has come, and what is to be dated is told when it is: a
//! slide's end and a release up to a fifth of a second later.

use crate::dating::Search;
use crate::motion::{BLOCK_FRAMES, Block, Distances, LONG_BLOCKS, Motion, SHORT_BLOCKS};
use crate::settings::{FRAME_RATE_HZ, SlideRule, TAXELS};
use crate::window::{Ring, Values, reached};

/// Blocks that teach the idle level and the noise before anything is looked for: 133 ms.
const LEARN_BLOCKS: u32 = 8;
/// A block's mean this far from the idle level is contact: as [`crate::motion`]'s own limit, with
/// room for the uncertainty of the level.
const TOUCHED: f32 = 100.0;
/// Time within which the spike's peak is looked for after the first touch, frames: 0.3 s. The paper
/// looks for it in the first 0.8 s of a record that contains it.
const SPIKE_FRAMES: u32 = 72;
/// Frames after a peak in which any higher frame is a better one: 20 ms.
const PEAK_FRAMES: u32 = 5;
/// Standard deviations by which a later one must be higher.
const CLEAR: f32 = 4.0;
/// Squared height of a spike, in units of the noise, from which a tap that leaves no load is told: 30
/// standard deviations in every taxel. Less is a vibration.
const TAP: f32 = 16.0 * 900.0;
/// Frames before the block of the first touch where the spike may have begun.
const LOOK_BACK: u32 = 4;
/// Blocks in a row without any change after which something is still: 66 ms.
const STILL_BLOCKS: u32 = 4;
/// Blocks with quick changes after which a motion is a slide and not a step: 150 ms.
const SLIDE_BLOCKS: u32 = 9;
/// Blocks with slow changes after which it is one: longer than a step stays in the comparison.
const SLOW_SLIDE_BLOCKS: u32 = 22;
/// Frames that a search looks at with each frame of a block; the last one's work is dealing with the block before.
const LOOKS: [u32; BLOCK_FRAMES as usize] = [2, 2, 2, 0];
/// Frames of a spike that are looked at with each frame of a block: one more than come, for it is noticed late.
const SPIKE_LOOKS: [u32; BLOCK_FRAMES as usize] = [2, 1, 1, 1];
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
    Hold,
    /// Something moves; a slide or only a step. Blocks with quick changes, and with any.
    Moving {
        quick: u32,
        any: u32,
    },
    /// Since this frame.
    Slide(u32),
}

/// What a search is for.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Sought {
    /// The first frame of what may become a slide.
    Start,
    /// The end of the slide that began at this frame, and whether the finger is off since.
    End(u32, bool),
    /// The frame since which the finger is off.
    Release,
}

/// The state machine.
#[derive(Clone, Debug)]
pub struct ContactDetector {
    rule: SlideRule,
    phase: Phase,
    motion: Motion,
    /// Number of the last frame of the latest block.
    block_end: u32,
    /// What is being dated, and how.
    sought: Option<Sought>,
    search: Search,
    idle: Values,
    /// Idle level before the last touch: where the skin creeps back to.
    before: Values,
    /// How far the idle level is to follow the latest block.
    idle_follows: f32,
    /// Whether the loaded level is to become that of the latest block.
    loaded_follows: bool,
    idle_blocks: u32,
    loaded: Values,
    peak: Values,
    peak_frame: [u32; TAXELS],
    /// Frame in which the spike is looked for next.
    spike_frame: u32,
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
            sought: None,
            search: Search::new(),
            idle: [0.0; TAXELS],
            before: [0.0; TAXELS],
            idle_follows: 0.0,
            loaded_follows: false,
            idle_blocks: 0,
            loaded: [0.0; TAXELS],
            peak: [0.0; TAXELS],
            peak_frame: [0; TAXELS],
            spike_frame: 0,
            touched: 0,
            still_quick: 0,
            still: 0,
            planned: None,
            moving_until: 0,
        }
    }

    /// While a slide lasts: its first frame, and the frame up to which it is known to have lasted.
    pub const fn sliding(&self) -> Option<(u32, u32)> {
        match self.phase {
            Phase::Slide(start) => Some((start, self.moving_until)),
            _ => None,
        }
    }

    /// Takes frame `number`, the latest one in `ring`; tells what changed.
    pub fn push(&mut self, number: u32, values: &Values, ring: &Ring, changed: &mut impl FnMut(Change)) {
        let turn = self.motion.turn() % BLOCK_FRAMES as usize;
        self.evaluate(turn, ring, changed);
        if let Phase::Spike(_) = self.phase {
            self.track_spike(SPIKE_LOOKS[turn], ring);
        }
        self.follow_plan(number, ring, changed);
        if self.sought.is_some() {
            self.look(LOOKS[turn], ring, changed);
        }
        if self.motion.push(values) {
            self.block_end = number;
        }
    }

    /// The data has ended with the frame before `number`: a slide that still runs is over.
    pub fn finish(&mut self, number: u32, ring: &Ring, changed: &mut impl FnMut(Change)) {
        for turn in self.motion.turn()..BLOCK_FRAMES as usize {
            self.evaluate(turn, ring, changed);
        }
        if let Phase::Slide(start) = self.phase {
            let end = if self.planned.is_some() { number } else { self.moving_until };
            self.enter(Phase::Hold);
            self.tell(Change::SlideEnd(start, end), ring, changed);
        }
        self.settle(ring, changed);
    }

    /// Deals with a share of the latest block.
    #[inline(never)]
    fn evaluate(&mut self, turn: usize, ring: &Ring, changed: &mut impl FnMut(Change)) {
        // Share by share, as the block is evaluated.
        if self.idle_follows > 0.0 {
            self.motion.approach(&mut self.idle, turn, self.idle_follows);
        }
        if self.loaded_follows {
            self.motion.approach(&mut self.loaded, turn, 1.0);
        }
        let touching = matches!(self.phase, Phase::Hold | Phase::Moving { .. } | Phase::Slide(_));
        let loaded = touching.then_some(&self.loaded);
        let sliding = matches!(self.phase, Phase::Slide(_));
        let Some(block) = self.motion.evaluate(turn, &self.idle, loaded, sliding) else { return };
        (self.idle_follows, self.loaded_follows) = (0.0, false);
        self.still_quick = if block.quick { 0 } else { self.still_quick.saturating_add(1) };
        self.still = if block.quick || block.slow { 0 } else { self.still.saturating_add(1) };
        // Not while something is searched for: that is work enough.
        if self.step(self.block_end, &block, ring, changed) && self.sought.is_none() {
            self.motion.learn();
        }
    }

    /// Goes on with the search, and tells what it was for when it is over.
    fn look(&mut self, frames: u32, ring: &Ring, changed: &mut impl FnMut(Change)) {
        let Some(sought) = self.sought else { return };
        let Some(frame) = self.search.look(frames, ring) else { return };
        match sought {
            // Told when it is known to be a slide.
            Sought::Start => return,
            Sought::End(start, released) => {
                changed(Change::SlideEnd(start, frame));
                if released {
                    changed(Change::Release(frame));
                }
            }
            Sought::Release => changed(Change::Release(frame)),
        }
        self.sought = None;
    }

    /// Ends a search, so that another may begin and all is told in its order.
    #[inline(never)]
    fn settle(&mut self, ring: &Ring, changed: &mut impl FnMut(Change)) {
        self.look(u32::MAX, ring, changed);
        self.sought = None;
    }

    #[inline(never)]
    fn tell(&mut self, change: Change, ring: &Ring, changed: &mut impl FnMut(Change)) {
        self.settle(ring, changed);
        changed(change);
    }

    /// One block further. True if the finger was still, so that the noise can be learned from it.
    fn step(&mut self, number: u32, block: &Block, ring: &Ring, changed: &mut impl FnMut(Change)) -> bool {
        match self.phase {
            Phase::Learning => {
                self.idle_blocks += 1;
                let share = 1.0 / self.idle_blocks as f32;
                for turn in 0..BLOCK_FRAMES as usize {
                    self.motion.approach(&mut self.idle, turn, share);
                }
                if self.idle_blocks == LEARN_BLOCKS {
                    self.before = self.idle;
                    self.enter(Phase::Idle);
                }
                true
            }
            Phase::Idle => {
                let mean = self.motion.mean();
                if block.distances.block * BLOCK_FRAMES as f32 > TOUCHED {
                    let to_before = |level| self.motion.distance(level, &self.before);
                    if to_before(mean) < to_before(&self.idle) {
                        // The skin creeps back after a touch.
                        self.idle = *mean;
                        return false;
                    }
                    self.begin_spike(number);
                    return false;
                }
                self.idle_follows = 1.0 / 16.0;
                true
            }
            Phase::Spike(since) => {
                let over = number.wrapping_sub(since) >= SPIKE_FRAMES || self.still_quick >= 6;
                if over {
                    self.loaded = self.still_level();
                    self.end_spike(number, ring, changed);
                }
                false
            }
            Phase::Hold => self.hold(number, block, ring, changed),
            Phase::Moving { quick, any } => {
                let quick = quick + block.quick as u32;
                let any = any + (block.quick || block.slow) as u32;
                if self.released(number, block, ring, changed) {
                    return false;
                }
                if quick >= SLIDE_BLOCKS || any >= SLOW_SLIDE_BLOCKS {
                    let left = self.search.finish(ring);
                    self.sought = None;
                    let start = if reached(left, self.touched) { left } else { self.touched };
                    self.moving_until = start;
                    self.phase = Phase::Slide(start);
                    self.tell(Change::SlideStart(start), ring, changed);
                } else if self.still >= STILL_BLOCKS {
                    self.sought = None;
                    self.enter(Phase::Hold);
                } else {
                    self.phase = Phase::Moving { quick, any };
                }
                false
            }
            Phase::Slide(start) => {
                self.slide(start, number, block, ring, changed);
                false
            }
        }
    }

    #[inline(never)]
    fn enter(&mut self, phase: Phase) {
        self.phase = phase;
        self.motion.restart();
        self.still = 0;
        self.still_quick = 0;
    }

    /// Mean of the blocks after which something is still.
    #[inline(never)]
    fn still_level(&self) -> Values {
        self.motion.recent_mean(0, STILL_BLOCKS as usize).unwrap_or(*self.motion.mean())
    }

    #[inline(never)]
    fn begin_spike(&mut self, number: u32) {
        self.enter(Phase::Spike(number));
        self.peak = [0.0; TAXELS];
        self.spike_frame = number.wrapping_sub(BLOCK_FRAMES - 1 + LOOK_BACK);
        self.peak_frame = [self.spike_frame; TAXELS];
    }

    /// Equation 3, for every taxel at once, in the next `frames` frames up to the latest block's end.
    #[inline(never)]
    fn track_spike(&mut self, frames: u32, ring: &Ring) {
        for _ in 0..frames {
            let number = self.spike_frame;
            if !reached(self.block_end, number) {
                return;
            }
            self.spike_frame = number.wrapping_add(1);
            let Some((values, _)) = ring.frame(number) else { continue };
            for c in 0..TAXELS {
                let off = values[c] - self.idle[c];
                let higher = off.abs() - self.peak[c].abs();
                if higher > 0.0 {
                    // A touch without a spike is a step, whose highest frame is any: long after a peak only
                    // what stands clear of the noise is a higher one.
                    let late = number.wrapping_sub(self.peak_frame[c]) > PEAK_FRAMES;
                    if !late || higher * higher > CLEAR * CLEAR * self.motion.variance(c) {
                        self.peak[c] = off;
                        self.peak_frame[c] = number;
                    }
                }
            }
        }
    }

    /// Equation 2: the taxel with the best defined spike tells the time.
    #[inline(never)]
    fn end_spike(&mut self, number: u32, ring: &Ring, changed: &mut impl FnMut(Change)) {
        self.track_spike(u32::MAX, ring);
        let mut best = 0;
        for c in 1..TAXELS {
            if self.peak[c].abs() > self.peak[best].abs() {
                best = c;
            }
        }
        let peak_height = self.motion.distance(&self.peak, &[0.0; TAXELS]);
        let off_again = back_at_idle(self.motion.distance(&self.loaded, &self.idle), peak_height);
        if off_again && peak_height < TAP {
            self.enter(Phase::Idle);
            return;
        }
        let frame = self.peak_frame[best];
        self.touched = frame;
        self.planned = match self.rule {
            SlideRule::Found => None,
            SlideRule::Protocol { delay_s, speed_mm_s, length_mm } => {
                let start = frame.wrapping_add((delay_s * FRAME_RATE_HZ + 0.5) as u32);
                Some((start, start.wrapping_add((length_mm / speed_mm_s * FRAME_RATE_HZ + 0.5) as u32)))
            }
        };
        self.tell(Change::Contact { frame, taxel: best as u8, height: self.peak[best] }, ring, changed);
        self.enter(Phase::Hold);
        if off_again {
            self.release(self.loaded);
            self.date(Sought::Release, self.idle, number, ring, changed);
        }
    }

    #[inline(never)]
    fn hold(&mut self, number: u32, block: &Block, ring: &Ring, changed: &mut impl FnMut(Change)) -> bool {
        if self.released(number, block, ring, changed) {
            return false;
        }
        if !(block.quick || block.slow) {
            let Distances { block, loaded, .. } = block.distances;
            self.loaded_follows = is_load(block, loaded);
            return true;
        }
        if self.rule == SlideRule::Found {
            // The block before may hold the first of the motion already.
            let held = self.motion.recent_mean(2, 4).unwrap_or(self.loaded);
            let from = number.wrapping_sub(BLOCK_FRAMES - 1);
            self.phase = Phase::Moving { quick: block.quick as u32, any: 1 };
            self.settle(ring, changed);
            self.search.departure(self.motion.weights(), &held, from);
            self.sought = Some(Sought::Start);
        }
        false
    }

    /// Ends the touch if the levels are still and back at idle.
    #[inline(never)]
    fn released(&mut self, number: u32, block: &Block, ring: &Ring, changed: &mut impl FnMut(Change)) -> bool {
        let Distances { block: off, loaded, .. } = block.distances;
        if self.still_quick < STILL_BLOCKS || !back_at_idle(off, loaded) {
            return false;
        }
        let level = self.still_level();
        self.release(level);
        self.date(Sought::Release, self.idle, number, ring, changed);
        true
    }

    /// The finger is off and the taxels at `level`.
    #[inline(never)]
    fn release(&mut self, level: Values) {
        self.before = self.idle;
        self.idle = level;
        self.planned = None;
        self.enter(Phase::Idle);
    }

    /// Begins to look for the frame at which the taxels came to `level`, where they are at frame `number`.
    #[inline(never)]
    fn date(&mut self, sought: Sought, level: Values, number: u32, ring: &Ring, changed: &mut impl FnMut(Change)) {
        self.settle(ring, changed);
        self.search.arrival(self.motion.weights(), &level, number);
        self.sought = Some(sought);
    }

    #[inline(never)]
    fn slide(&mut self, start: u32, number: u32, block: &Block, ring: &Ring, changed: &mut impl FnMut(Change)) {
        if self.planned.is_some() {
            return;
        }
        // A comparison tells of a change somewhere in its reach: of what moved since only a change
        // right now tells for sure.
        let reach = match block {
            Block { now: true, .. } => Some(0),
            Block { quick: true, .. } => Some(SHORT_BLOCKS),
            Block { slow: true, .. } => Some(LONG_BLOCKS),
            _ => None,
        };
        if let Some(reach) = reach {
            let sure = number.wrapping_sub(BLOCK_FRAMES * (reach + 1) - 1);
            if reached(sure, self.moving_until) {
                self.moving_until = sure;
            }
        }
        // Still, or in the air: there a slide is over even if something goes on shaking the finger.
        let Distances { of_late, loaded, .. } = block.distances;
        if self.still < STILL_BLOCKS && !back_at_idle(of_late, loaded) {
            return;
        }
        let level = self.still_level();
        let off = self.motion.distance(&level, &self.idle);
        let released = back_at_idle(off, loaded);
        let steady = self.still_quick >= STILL_BLOCKS;
        if !steady {
            self.tell(Change::SlideEnd(start, self.moving_until), ring, changed);
        }
        if released {
            self.release(level);
        } else {
            self.enter(Phase::Hold);
            if is_load(off, loaded) {
                self.loaded = level;
            }
        }
        if steady {
            self.date(Sought::End(start, released), level, number, ring, changed);
        } else if released {
            self.date(Sought::Release, level, number, ring, changed);
        }
    }

    /// Starts and ends the slide by protocol.
    fn follow_plan(&mut self, number: u32, ring: &Ring, changed: &mut impl FnMut(Change)) {
        let Some((start, end)) = self.planned else { return };
        match self.phase {
            Phase::Hold if reached(number, start) => {
                self.phase = Phase::Slide(start);
                self.tell(Change::SlideStart(start), ring, changed);
            }
            Phase::Slide(_) if reached(number, end) => {
                self.planned = None;
                self.enter(Phase::Hold);
                self.tell(Change::SlideEnd(start, end), ring, changed);
            }
            Phase::Slide(_) => self.moving_until = number.wrapping_add(1),
            _ => {}
        }
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
