//! Phases of a touch: idle (A), contact spike and hold (B), slide (C), hold (D), release (E).
//!
//! The spike is found as in the paper's equations 2 and 3, over all taxels and as the data come: the
//! taxel whose deviation from its idle level is the greatest tells the time. The slide comes either
//! from the protocol (equations 4 and 5) or from the signal itself: it starts when the held levels
//! begin to change and ends when they stop, both dated back to the frame where it happened.

use crate::dating::{arrival_at, departure_from};
use crate::motion::{BLOCK_FRAMES, Block, LONG_BLOCKS, Motion, SHORT_BLOCKS};
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
    /// Something moves; a slide or only a step. Level that was held before, frame.
    Moving {
        held: Values,
        from: u32,
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
    idle: Values,
    /// Idle level before the last touch: where the skin creeps back to.
    before: Values,
    idle_blocks: u32,
    loaded: Values,
    peak: Values,
    peak_frame: [u32; TAXELS],
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
            idle: [0.0; TAXELS],
            before: [0.0; TAXELS],
            idle_blocks: 0,
            loaded: [0.0; TAXELS],
            peak: [0.0; TAXELS],
            peak_frame: [0; TAXELS],
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
        if let Phase::Spike(_) = self.phase {
            self.track_spike(number, values);
        }
        self.follow_plan(number, changed);
        let Some(block) = self.motion.push(values) else { return };
        self.still_quick = if block.quick { 0 } else { self.still_quick.saturating_add(1) };
        self.still = if block.quick || block.slow { 0 } else { self.still.saturating_add(1) };
        let learn = self.step(number, &block, ring, changed);
        self.motion.next_block(learn);
    }

    /// The data has ended: a slide that still runs is over.
    pub fn finish(&mut self, number: u32, changed: &mut impl FnMut(Change)) {
        if let Phase::Slide(start) = self.phase {
            let end = if self.planned.is_some() { number } else { self.moving_until };
            self.enter(Phase::Hold);
            changed(Change::SlideEnd(start, end));
        }
    }

    /// One block further. True if the finger was still, so that the noise can be learned from it.
    fn step(&mut self, number: u32, block: &Block, ring: &Ring, changed: &mut impl FnMut(Change)) -> bool {
        match self.phase {
            Phase::Learning => {
                self.idle_blocks += 1;
                let share = 1.0 / self.idle_blocks as f32;
                self.follow_idle(&block.mean, share);
                if self.idle_blocks == LEARN_BLOCKS {
                    self.before = self.idle;
                    self.enter(Phase::Idle);
                }
                true
            }
            Phase::Idle => {
                let off = self.motion.distance(&block.mean, &self.idle) * BLOCK_FRAMES as f32;
                if off > TOUCHED {
                    let to_before = |level| self.motion.distance(level, &self.before);
                    if to_before(&block.mean) < to_before(&self.idle) {
                        // The skin creeps back after a touch.
                        self.idle = block.mean;
                        return false;
                    }
                    self.begin_spike(number, ring);
                    return false;
                }
                self.follow_idle(&block.mean, 1.0 / 16.0);
                true
            }
            Phase::Spike(since) => {
                let over = number.wrapping_sub(since) >= SPIKE_FRAMES || self.still_quick >= 6;
                if over {
                    self.loaded = self.motion.recent_mean(0, STILL_BLOCKS as usize).unwrap_or(block.mean);
                    self.end_spike(number, ring, changed);
                }
                false
            }
            Phase::Hold => self.hold(number, block, ring, changed),
            Phase::Moving { held, from, quick, any } => {
                let quick = quick + block.quick as u32;
                let any = any + (block.quick || block.slow) as u32;
                if self.released(number, &block.mean, ring, changed) {
                    return false;
                }
                if quick >= SLIDE_BLOCKS || any >= SLOW_SLIDE_BLOCKS {
                    let left = departure_from(&self.motion, &held, from, ring);
                    let start = if reached(left, self.touched) { left } else { self.touched };
                    self.moving_until = start;
                    self.phase = Phase::Slide(start);
                    changed(Change::SlideStart(start));
                } else if self.still >= STILL_BLOCKS {
                    self.enter(Phase::Hold);
                } else {
                    self.phase = Phase::Moving { held, from, quick, any };
                }
                false
            }
            Phase::Slide(start) => {
                self.slide(start, number, block, ring, changed);
                false
            }
        }
    }

    fn enter(&mut self, phase: Phase) {
        self.phase = phase;
        self.motion.restart();
        self.still = 0;
        self.still_quick = 0;
    }

    fn follow_idle(&mut self, mean: &Values, share: f32) {
        for c in 0..TAXELS {
            self.idle[c] += share * (mean[c] - self.idle[c]);
        }
    }

    fn begin_spike(&mut self, number: u32, ring: &Ring) {
        self.enter(Phase::Spike(number));
        self.peak = [0.0; TAXELS];
        let first = number.wrapping_sub(BLOCK_FRAMES - 1 + LOOK_BACK);
        self.peak_frame = [first; TAXELS];
        for frame in 0..BLOCK_FRAMES + LOOK_BACK {
            let frame = first.wrapping_add(frame);
            if let Some((values, _)) = ring.frame(frame) {
                self.track_spike(frame, values);
            }
        }
    }

    /// Equation 3, for every taxel at once.
    fn track_spike(&mut self, number: u32, values: &Values) {
        for c in 0..TAXELS {
            let off = values[c] - self.idle[c];
            // A touch without a spike is a step, whose highest frame is any: long after a peak only
            // what stands clear of the noise is a higher one.
            let since = number.wrapping_sub(self.peak_frame[c]);
            let clear = if since > PEAK_FRAMES { CLEAR * self.motion.sigma(c) } else { 0.0 };
            if off.abs() > self.peak[c].abs() + clear {
                self.peak[c] = off;
                self.peak_frame[c] = number;
            }
        }
    }

    /// Equation 2: the taxel with the best defined spike tells the time.
    fn end_spike(&mut self, number: u32, ring: &Ring, changed: &mut impl FnMut(Change)) {
        let mut best = 0;
        for c in 1..TAXELS {
            if self.peak[c].abs() > self.peak[best].abs() {
                best = c;
            }
        }
        let (mean, peak_level) = (self.loaded, self.peak_level());
        let off_again = self.back_at_idle(&mean, &peak_level);
        if off_again && self.motion.distance(&peak_level, &self.idle) < TAP {
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
        changed(Change::Contact { frame, taxel: best as u8, height: self.peak[best] });
        self.enter(Phase::Hold);
        if off_again {
            self.release(number, &mean, ring, changed);
        }
    }

    /// The level of the spike's peaks.
    fn peak_level(&self) -> Values {
        let mut level = self.idle;
        for c in 0..TAXELS {
            level[c] += self.peak[c];
        }
        level
    }

    /// Notes the loaded level, unless it is less than half the load that is known: that is a skin
    /// on its way back.
    fn load(&mut self, level: &Values) {
        if self.motion.distance(level, &self.idle) > 0.25 * self.motion.distance(&self.loaded, &self.idle) {
            self.loaded = *level;
        }
    }

    fn back_at_idle(&self, mean: &Values, loaded: &Values) -> bool {
        self.motion.distance(mean, &self.idle) < BACK_AT_IDLE * self.motion.distance(loaded, &self.idle)
    }

    fn hold(&mut self, number: u32, block: &Block, ring: &Ring, changed: &mut impl FnMut(Change)) -> bool {
        if self.released(number, &block.mean, ring, changed) {
            return false;
        }
        if !(block.quick || block.slow) {
            self.load(&block.mean);
            return true;
        }
        if self.rule == SlideRule::Found {
            // The block before may hold the first of the motion already.
            let held = self.motion.recent_mean(2, 4).unwrap_or(self.loaded);
            let from = number.wrapping_sub(BLOCK_FRAMES - 1);
            self.phase = Phase::Moving { held, from, quick: block.quick as u32, any: 1 };
        }
        false
    }

    /// Ends the touch if the levels are still and back at idle.
    fn released(&mut self, number: u32, mean: &Values, ring: &Ring, changed: &mut impl FnMut(Change)) -> bool {
        if self.still_quick < STILL_BLOCKS || !self.back_at_idle(mean, &self.loaded) {
            return false;
        }
        let level = self.motion.recent_mean(0, STILL_BLOCKS as usize).unwrap_or(*mean);
        self.release(number, &level, ring, changed);
        true
    }

    /// The finger is off and the taxels at `level`.
    fn release(&mut self, number: u32, level: &Values, ring: &Ring, changed: &mut impl FnMut(Change)) {
        let frame = arrival_at(&self.motion, level, number, ring);
        self.before = self.idle;
        self.idle = *level;
        self.planned = None;
        self.enter(Phase::Idle);
        changed(Change::Release(frame));
    }

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
        let of_late = self.motion.recent_mean(0, LONG_BLOCKS as usize).unwrap_or(block.mean);
        let in_the_air = self.back_at_idle(&of_late, &self.loaded);
        if self.still < STILL_BLOCKS && !in_the_air {
            return;
        }
        let level = self.motion.recent_mean(0, STILL_BLOCKS as usize).unwrap_or(block.mean);
        let steady = self.still_quick >= STILL_BLOCKS;
        let end = if steady { arrival_at(&self.motion, &level, number, ring) } else { self.moving_until };
        let loaded = self.loaded;
        self.enter(Phase::Hold);
        changed(Change::SlideEnd(start, end));
        if self.back_at_idle(&level, &loaded) {
            self.release(number, &level, ring, changed);
        } else {
            self.load(&level);
        }
    }

    /// Starts and ends the slide by protocol.
    fn follow_plan(&mut self, number: u32, changed: &mut impl FnMut(Change)) {
        let Some((start, end)) = self.planned else { return };
        match self.phase {
            Phase::Hold if reached(number, start) => {
                self.phase = Phase::Slide(start);
                changed(Change::SlideStart(start));
            }
            Phase::Slide(_) if reached(number, end) => {
                self.planned = None;
                self.enter(Phase::Hold);
                changed(Change::SlideEnd(start, end));
            }
            Phase::Slide(_) => self.moving_until = number.wrapping_add(1),
            _ => {}
        }
    }
}
