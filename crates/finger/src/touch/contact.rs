//! Phases of a touch: idle (A), contact spike and hold (B), slide (C), hold (D), release (E).
//!
//! The spike is found as in the paper's equations 2 and 3, over all taxels: the taxel whose
//! deviation from its idle level is the greatest gives the time. The slide comes either from the
//! protocol (equations 4 and 5) or from the signal: it starts when the held levels begin to change
//! and ends when they stop. Both times are searched for in the ring, as soon as a block of frames
//! shows that there is one to find.

mod evidence;

use crate::ring::reached;
use crate::touch::averages::Averages;
use crate::touch::change::{Change, HoldMean};
use crate::touch::condition::Condition;
use crate::touch::held::{BACK_AT_IDLE, HELD_BACK, HeldLevel, IS_LOAD};
use crate::touch::idle::{Idle, Noise};
use crate::touch::loaded::Air;
use crate::touch::motion::{BLOCK_FRAMES, Block, Motion};
use crate::touch::onset::Frames;
use crate::touch::past::FURTHEST;
use crate::touch::phase::{Ended, Phase};
use crate::touch::slide::{Moved, Moving, Sign, Sliding, planned, slide_end};
use crate::touch::spike::{SPIKE_FRAMES, SPIKE_STILL_BLOCKS, Spike, TAP};
use crate::touch::values::{difference, length};
use ridgetone_proto::plan::Plan;
use ridgetone_proto::settings::{Slide, SlideRule};
use ridgetone_proto::telemetry::Hold;
use ridgetone_tone::Values;

/// Blocks from which the idle level and the noise are learned before anything is looked for: 133
/// ms.
const LEARN_BLOCKS: u32 = 8;
/// Blocks in a row without any change after which something is still: 66 ms.
const STILL_BLOCKS: u32 = 4;
/// Blocks after which the load of a hold is measured anew: 133 ms.
const LOAD_BLOCKS: u32 = 8;
/// Latest blocks excluded from the level before a motion: a slow motion may have begun in them. 133
/// ms.
const STILL_BACK: usize = 8;
/// Blocks after which the direction of the load is measured anew in a slide: 133 ms.
const AIM_BLOCKS: u32 = 8;
/// Standard deviations by which the load falls in the latest frame of a finger that may be leaving.
const LIFTS: f32 = 3.0;
/// Frames from the contact to a slide that began before the spike was over: 50 ms, within which a
/// spike hides the slide.
const HIDDEN_FRAMES: u32 = 12;

/// The state machine.
#[derive(Clone, Debug)]
pub struct ContactDetector {
    /// Source of slides, for the next touch and for the part of this touch that has not begun.
    pub slide: Slide,
    phase: Phase,
    /// True if the next block is not judged, because it may contain the end of the previous phase.
    skips_block: bool,
    condition: Condition,
    motion: Motion,
    idle: Idle,
    air: Air,
    spike: Spike,
    /// True if a contact spike, or a release after a slide, has shown that the idle level is that
    /// in the air.
    was_in_air: bool,
    /// Frame of the touch's spike: no slide begins before it.
    contact: u32,
    held: HeldLevel,
    /// Squared distance of the held level from idle, in units of the noise.
    load: f32,
    /// Length of the touch's first load, codes: later changes of the noise do not affect it.
    first_load: f32,
    /// Level at which the taxels were still before the latest motion; `None` for a motion that
    /// began before the spike was over.
    still_level: Option<Values>,
    /// End so far of the touch's latest motion, or of its slide.
    moved: Moved,
    /// Slide by protocol: first frame and the one after the last, until it is over.
    planned: Option<(u32, u32)>,
}

/// A frame, or a mean of frames with the squares of the frames about it.
pub struct Observed<'a> {
    /// Values of the taxels.
    pub values: &'a Values,
    /// Squares of the frames about the mean; `None` for a single frame.
    pub squares: Option<&'a Values>,
}

impl ContactDetector {
    /// The idle state, before the first frame.
    pub const fn new(slide: Slide, plan: &Plan) -> Self {
        Self {
            slide,
            phase: Phase::Learning(0),
            skips_block: false,
            condition: Condition::new(plan),
            motion: Motion::new(plan),
            idle: Idle::new(),
            air: Air::Known(None),
            spike: Spike::new(),
            was_in_air: false,
            contact: 0,
            held: HeldLevel::new(),
            load: 0.0,
            first_load: 0.0,
            still_level: None,
            moved: Moved::until(0),
            planned: None,
        }
    }

    /// Subtracts mains hum of this frequency before detection; zero: none.
    pub const fn set_mains(&mut self, interferer_hz: f32) {
        self.condition.set_mains(interferer_hz);
    }

    const fn finds_slides(&self) -> bool {
        matches!(self.slide.rule, SlideRule::Found)
    }

    /// True if the finger is on something.
    pub const fn is_touched(&self) -> bool {
        !matches!(self.phase, Phase::Learning(_) | Phase::Idle)
    }

    /// While a slide lasts: its first frame, and the frame up to which it is known to have lasted.
    pub const fn sliding(&self) -> Option<(u32, u32)> {
        match self.phase {
            Phase::Slide(slide) | Phase::Always(slide) => Some((slide.start, self.moved.until)),
            _ => None,
        }
    }

    /// Notes that only these taxels of the next frame are good.
    pub fn note_good(&mut self, good: u16) {
        if self.phase == Phase::Hold {
            self.held.good &= good;
        }
    }

    /// Takes frame `number`, the latest one in `ring`; for an average, with the squares of the
    /// frames about it. Reports what changed.
    pub fn push(
        &mut self,
        number: u32,
        frame: Observed<'_>,
        ring: Averages,
        report: &mut dyn FnMut(Change),
    ) {
        let Observed { values, squares } = frame;
        if self.slides_always(number, report) {
            return;
        }
        self.follow_plan(number, report);
        let number = self.condition.reach(number);
        if let Phase::Starting(moving) = self.phase {
            self.start_slide(moving, ring, report);
        }
        let cleaned;
        let values = if self.condition.is_plain() {
            values
        } else {
            let Some(frame) = self.condition.cleaned(ring, number) else {
                return;
            };
            cleaned = frame;
            &cleaned
        };
        match self.phase {
            Phase::Slide(_) => self.air.follow_slide(values, self.motion.weights()),
            Phase::Spike(_) => {
                self.spike
                    .follow(number, values, &self.idle.level, self.motion.weights())
            }
            _ => {}
        }
        self.motion.seeks_across = match &self.phase {
            Phase::Hold => true,
            Phase::Moving(moving) => moving.sign != Sign::Reported,
            _ => false,
        };
        let Some(block) = self.motion.push(values, squares) else {
            return;
        };
        if core::mem::take(&mut self.skips_block) {
            if matches!(self.phase, Phase::Idle | Phase::Learning(_)) {
                self.enter(self.phase);
            }
        } else if self.step(number, block, ring, report) {
            self.motion.learn();
        }
    }

    /// Ends the data with the frame before `number`, and a slide under way.
    pub fn finish(&mut self, number: u32, report: &mut dyn FnMut(Change)) {
        match self.phase {
            Phase::Hold | Phase::Moving(_) => self.end_hold(report),
            Phase::Always(slide) => {
                self.idle = Idle::new();
                self.skips_block = true;
                self.enter(Phase::Learning(0));
                report(Change::SlideEnd(slide.start, number));
            }
            Phase::Slide(Sliding { start, .. }) => {
                self.phase = Phase::Hold;
                let end = if self.planned.is_some() {
                    number
                } else {
                    self.moved.until
                };
                report(Change::SlideEnd(start, end));
            }
            _ => {}
        }
    }

    /// Takes frame `number` as part of a slide if [`SlideRule::Always`] applies; otherwise false.
    /// When another rule applies, the slide ends, and the level in the air is learned anew.
    fn slides_always(&mut self, number: u32, report: &mut dyn FnMut(Change)) -> bool {
        let is_always = self.slide.rule == SlideRule::Always;
        if is_always != matches!(self.phase, Phase::Always(_)) {
            self.finish(number, report);
            if is_always {
                self.motion.ignore(None);
                self.planned = None;
                (self.air, self.was_in_air) = (Air::Known(None), false);
                self.phase = Phase::Always(Sliding::new(number, false));
                report(Change::SlideStart(number));
            }
        }
        if is_always {
            self.moved.until = number.wrapping_add(1);
        }
        is_always
    }

    /// Processes a block that ends with frame `number`. True if the finger was still, so that the
    /// noise can be learned from the block.
    fn step(
        &mut self,
        number: u32,
        block: Block,
        ring: Averages,
        report: &mut dyn FnMut(Change),
    ) -> bool {
        let mean = self.motion.past().back(0);
        match self.phase {
            Phase::Learning(blocks) => {
                self.follow_idle(self.off_idle(mean));
                self.phase = Phase::Learning(blocks + 1);
                if blocks + 1 == LEARN_BLOCKS {
                    self.enter(Phase::Idle);
                }
                true
            }
            Phase::Idle => {
                let off = self.off_idle(mean);
                if off <= self.idle.touched(self.motion.taxels) {
                    self.follow_idle(off);
                    return true;
                }
                let idle = &self.idle.level;
                let is_nearer = |before: &Values| {
                    self.motion.distance(mean, before) < self.motion.distance(idle, before)
                };
                if matches!(&self.air, Air::Known(Some(before)) if is_nearer(before)) {
                    self.enter(Phase::CreepingBack);
                } else {
                    self.spike = Spike::begin(number, idle, &self.frames(ring));
                    // The end of an earlier motion may be anywhere by now: numbers wrap.
                    self.moved = Moved::until(number);
                    self.enter(Phase::Spike(number));
                }
                false
            }
            Phase::CreepingBack => {
                self.idle.restart(*mean, &self.condition);
                self.enter(Phase::Idle);
                false
            }
            Phase::Spike(since) => {
                self.moved
                    .follow(block, number, self.condition.is_averaged());
                let passed = number.wrapping_sub(since);
                let is_due =
                    passed >= SPIKE_FRAMES || self.motion.still_quick >= SPIKE_STILL_BLOCKS;
                // With the protocol every touch begins with a contact.
                if is_due
                    && (self.was_in_air
                        || !self.finds_slides()
                        || self.is_contact(since, number, ring))
                {
                    self.end_phase(Ended::Spike, number, ring, report);
                }
                false
            }
            Phase::Hold | Phase::Moving(_) => {
                // The level of a hold changes slowly.
                if self.air.is_known() && self.motion.still.is_multiple_of(LOAD_BLOCKS) {
                    self.load = self.motion.distance(&self.held.level, &self.idle.level);
                }
                let off = self.motion.distance(mean, &self.idle.level);
                // A change along the load alone is slow, so the oldest block counts too.
                let back = BACK_AT_IDLE * self.load;
                let is_back = |blocks: usize| {
                    self.motion
                        .distance(self.motion.past().back(blocks), &self.idle.level)
                        < back
                };
                let is_over = off < back && is_back(STILL_BLOCKS as usize - 1);
                let is_in_air = self.air.is_known() && !block.now && off < back && is_back(1);
                // A slow slide falls as far as a release does, but it rises again.
                let is_quiet = self.motion.still_quick >= STILL_BLOCKS;
                let has_fallen = is_quiet && self.has_fallen();
                if is_quiet && is_over || has_fallen && self.motion.still >= STILL_BLOCKS {
                    self.end_hold(report);
                    self.end_phase(Ended::Hold, number, ring, report);
                    return false;
                }
                if let Phase::Moving(mut moving) = self.phase {
                    if block.quick && moving.is_creep() {
                        self.note_still_level();
                        moving.since = number.wrapping_sub(BLOCK_FRAMES - 1);
                    }
                    if is_in_air {
                        // In the air for two blocks: the motion so far was no slide, and a slide
                        // may begin now.
                        moving = moving.anew(number.wrapping_add(1));
                        self.contact = number;
                    }
                    self.sign_of_motion(&mut moving, block, off, report);
                    self.moving(moving.with(block), has_fallen, report);
                    return false;
                }
                self.hold(number, off, block, report)
            }
            Phase::Slide(mut slide) => {
                if self.planned.is_none() {
                    slide.blocks = slide.blocks.wrapping_add(1);
                    self.moved
                        .follow(block, number, self.condition.is_averaged());
                    self.slide(slide, number, ring, report);
                }
                false
            }
            Phase::Starting(_) | Phase::Always(_) => false,
        }
    }

    /// Processes a block of a hold, whose mean is `off` from idle. True if nothing moves.
    fn hold(
        &mut self,
        number: u32,
        off: f32,
        block: Block,
        report: &mut dyn FnMut(Change),
    ) -> bool {
        let moves = block.moves();
        // As long as the level in the air is unknown, only a motion shows a release.
        if moves && (self.finds_slides() || !self.air.is_known()) {
            self.note_still_level();
            let mut moving = Moving::since(number.wrapping_sub(BLOCK_FRAMES - 1));
            self.sign_of_motion(&mut moving, block, off, report);
            self.phase = Phase::Moving(moving.with(block));
        } else if !moves && self.motion.still <= HELD_BACK as u32 {
            self.held.restart();
        } else if !moves && off > IS_LOAD * self.load {
            self.held.extend(number, &self.motion);
        }
        !moves
    }

    /// Reports the first block that shows a motion across the direction of the load, unless its
    /// mean, which is `off` from idle, shows a finger that leaves. Channels are sampled one after
    /// the other, so that in the first frame of a lift only some have lost their load: if the load
    /// has fallen, the next block decides.
    fn sign_of_motion(
        &self,
        moving: &mut Moving,
        block: Block,
        off: f32,
        report: &mut dyn FnMut(Change),
    ) {
        if !block.across || moving.sign == Sign::Reported || !self.finds_slides() {
            return;
        }
        if self.air.is_known() {
            let fall = self.motion.along(self.motion.latest(), &self.held.level);
            let may_lift = fall > LIFTS && moving.sign == Sign::None;
            if may_lift || off < IS_LOAD * self.load {
                moving.sign = Sign::Unsure;
                return;
            }
        }
        moving.sign = Sign::Reported;
        let since = self.condition.latest().wrapping_sub(BLOCK_FRAMES - 1);
        report(Change::Moving(since));
    }

    /// Processes a block while something moves: the motion becomes a slide, or is over.
    fn moving(&mut self, moving: Moving, has_fallen: bool, report: &mut dyn FnMut(Change)) {
        if self.finds_slides() && moving.is_slide() && !has_fallen {
            self.end_hold(report);
            self.phase = Phase::Starting(moving);
        } else if self.motion.still >= STILL_BLOCKS && self.motion.still_longest >= STILL_BLOCKS {
            self.phase = Phase::Hold;
            self.motion.restart_lately();
        } else {
            self.phase = Phase::Moving(moving);
        }
    }

    /// Begins the slide that a motion has become.
    fn start_slide(&mut self, moving: Moving, ring: Averages, report: &mut dyn FnMut(Change)) {
        let left = match &self.still_level {
            Some(level) => self
                .frames(ring)
                .departure(level, moving.since, self.contact),
            None => self.contact.wrapping_add(HIDDEN_FRAMES),
        };
        let start = if reached(left, self.contact) {
            left
        } else {
            self.contact
        };
        self.begin_slide(Sliding::new(start, moving.is_slow()), report);
    }

    /// Processes a block of a slide.
    fn slide(
        &mut self,
        slide: Sliding,
        number: u32,
        ring: Averages,
        report: &mut dyn FnMut(Change),
    ) {
        self.phase = Phase::Slide(slide);
        // Still, or in the air: there a slide is over even if something goes on shaking the finger.
        let mut is_over = self.motion.still >= STILL_BLOCKS
            && (self.motion.still_longest >= STILL_BLOCKS
                || !slide.is_slow
                || !self.motion.is_weak());
        if slide.blocks.is_multiple_of(AIM_BLOCKS) {
            let recent = self.motion.past().recent_mean();
            let off = self.motion.distance(&recent, &self.idle.level);
            is_over |= off < BACK_AT_IDLE * self.load;
            if self.air.is_known() && off > IS_LOAD * self.load {
                self.aim(&recent);
            }
        }
        if is_over {
            self.end_phase(Ended::Slide(slide), number, ring, report);
        }
    }

    /// Ends a phase with the latest block, which ends with frame `over`: the present level decides
    /// what the phase was and what comes next.
    fn end_phase(
        &mut self,
        ended: Ended,
        over: u32,
        ring: Averages,
        report: &mut dyn FnMut(Change),
    ) {
        let level = self.motion.past().mean_of_four(0);
        let off = self.motion.distance(&level, &self.idle.level);
        let before = self.still_level.replace(level);
        self.skips_block = true;
        let mut arrived = None;
        let is_released = match ended {
            Ended::Spike => {
                let is_released = self.is_back_from_spike(off);
                if self.motion.still_quick < SPIKE_STILL_BLOCKS {
                    self.still_level = None;
                }
                if is_released
                    && self.spike.height(self.motion.weights()) < self.motion.taxels.limit(TAP)
                {
                    self.enter(Phase::Idle);
                    return;
                }
                self.report_contact(report);
                is_released
            }
            Ended::Hold => true,
            Ended::Slide(Sliding { start, .. }) => {
                // A finger that is shaken in the air shows nothing else.
                let frames = self.frames(ring);
                let is_released = off < BACK_AT_IDLE * self.load || self.has_left(&level);
                let end = if self.motion.still_quick < STILL_BLOCKS {
                    self.moved.until
                } else if is_released {
                    let lifted = frames.arrival(&level, over);
                    arrived = Some(lifted);
                    frames.hold_before(lifted, start)
                } else {
                    slide_end(&frames, &self.motion, &level, self.moved, over)
                };
                report(Change::SlideEnd(start, end));
                is_released
            }
        };
        if is_released {
            let arrived = arrived.unwrap_or_else(|| match &before {
                Some(before) if self.air.is_known() && off >= BACK_AT_IDLE * self.load => {
                    // The level just after the fall: the skin has crept on since.
                    let since = self.motion.still_quick.saturating_sub(STILL_BLOCKS) as usize;
                    let fallen = self.motion.past().mean_of_four(since.min(FURTHEST));
                    self.frames(ring).fall(before, &fallen, over)
                }
                _ => self.frames(ring).arrival(&level, over),
            });
            report(Change::Release(arrived));
            // Nothing slides in the air: the level after a slide is that in the air.
            let has_slid = ended != Ended::Spike
                && (ended != Ended::Hold || self.held.hold == Hold::AfterSlide);
            self.was_in_air |= self.air.is_known() && has_slid;
            self.air = Air::Known(self.air.is_known().then_some(self.idle.level));
            self.idle.restart(level, &self.condition);
            self.planned = None;
            self.motion.ignore(None);
            self.enter(Phase::Idle);
            return;
        }
        if !self.air.is_known() {
            self.begin_hold(Hold::AfterSlide);
            return;
        }
        if ended == Ended::Spike || off > IS_LOAD * self.load {
            (self.held.level, self.load) = (level, off);
        }
        if ended == Ended::Spike {
            self.first_load = length(&difference(&level, &self.idle.level));
        }
        self.aim(&level);
        self.begin_hold(if ended == Ended::Spike {
            Hold::BeforeSlide
        } else {
            Hold::AfterSlide
        });
    }

    /// Ignores changes along the line from idle to this level.
    fn aim(&mut self, level: &Values) {
        self.motion
            .ignore(Some(difference(level, &self.idle.level)));
    }

    /// Makes the idle level follow the latest block, which is `off` from that level.
    fn follow_idle(&mut self, off: f32) {
        let Self {
            idle,
            motion,
            condition,
            ..
        } = self;
        if idle.follow(
            motion.past().back(0),
            off,
            Noise {
                weights: motion.weights(),
                taxels: motion.taxels,
            },
            condition,
        ) {
            motion.forget(condition.drifts().then_some(&idle.slope));
        }
    }

    /// Squared distance of a block's mean from idle, in units of the mean's noise.
    fn off_idle(&self, mean: &Values) -> f32 {
        self.motion.distance(mean, &self.idle.level) * BLOCK_FRAMES as f32
    }

    /// Reports the contact: the taxel with the highest spike gives the time.
    fn report_contact(&mut self, report: &mut dyn FnMut(Change)) {
        let (frame, taxel, height) = self.spike.highest(self.motion.weights());
        let onset = self.spike.onset;
        let onset = if reached(onset, frame) { frame } else { onset };
        self.contact = frame;
        self.planned = planned(&self.slide, frame, &self.condition);
        report(Change::Contact {
            frame,
            onset,
            taxel,
            height,
        });
    }

    /// Starts and ends the slide by protocol.
    fn follow_plan(&mut self, number: u32, report: &mut dyn FnMut(Change)) {
        let Some((start, end)) = self.planned else {
            return;
        };
        match &mut self.phase {
            Phase::Hold if reached(number, start) => {
                self.end_hold(report);
                self.begin_slide(Sliding::new(start, false), report);
            }
            Phase::Slide(_) if reached(number, end) => {
                self.planned = None;
                self.begin_hold(Hold::AfterSlide);
                report(Change::SlideEnd(start, end));
            }
            Phase::Slide(_) => self.moved.until = number.wrapping_add(1),
            _ => {}
        }
    }

    fn begin_slide(&mut self, slide: Sliding, report: &mut dyn FnMut(Change)) {
        if !reached(self.moved.until, slide.start) {
            self.moved = Moved::until(slide.start);
        }
        self.phase = Phase::Slide(slide);
        report(Change::SlideStart(slide.start));
    }

    fn begin_hold(&mut self, hold: Hold) {
        self.held.restart();
        self.held.hold = hold;
        self.enter(Phase::Hold);
    }

    fn end_hold(&mut self, report: &mut dyn FnMut(Change)) {
        if self.air.is_known() && self.held.is_long_enough() {
            report(Change::HoldEnd(HoldMean {
                held: &self.held,
                span: (self.held.from, self.held.until),
                frames: self.held.frames(),
                idle: &self.idle.level,
                idle_frames: self.idle.frames(),
                weights: self.motion.weights(),
            }));
        }
    }

    fn frames<'a>(&'a self, ring: Averages<'a>) -> Frames<'a> {
        let motion = &self.motion;
        Frames {
            ring,
            taxels: motion.taxels,
            condition: &self.condition,
            weights: motion.weights(),
            wander: motion.wander(),
            pull: motion.pull(),
        }
    }

    fn enter(&mut self, phase: Phase) {
        self.phase = phase;
        self.motion.restart();
    }
}
