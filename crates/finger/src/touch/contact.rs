//! Phases of a touch: idle (A), contact spike and hold (B), slide (C), hold (D), release (E).
//!
//! The spike is found as in the paper's equations 2 and 3, over all taxels: the taxel whose
//! deviation from its idle level is the greatest gives the time. The slide comes either from the
//! protocol (equations 4 and 5) or from the signal: it starts when the held levels begin to change
//! and ends when they stop. Both times are searched for in the ring, as soon as a block of frames
//! shows that there is one to find.

use crate::ring::reached;
use crate::touch::averages::Averages;
use crate::touch::change::{Change, HoldMean};
use crate::touch::condition::Condition;
use crate::touch::held::{BACK_AT_IDLE, HELD_BACK, HeldLevel, IS_LOAD};
use crate::touch::idle::Idle;
use crate::touch::loaded::{Air, Judged, judge};
use crate::touch::motion::{BLOCK_FRAMES, Block, Motion};
use crate::touch::onset::Frames;
use crate::touch::past::FURTHEST;
use crate::touch::slide::{Moved, Moving, Phase, Sign, Sliding, planned, slide_end};
use crate::touch::spike::{BACK_FROM_SPIKE, SPIKE_FRAMES, SPIKE_STILL_BLOCKS, Spike, TAP};
use crate::touch::values::{difference, greater, length, lesser};
use ridgetone_proto::plan::Plan;
use ridgetone_proto::settings::{Slide, SlideRule, TAXELS};
use ridgetone_proto::telemetry::Hold;
use ridgetone_tone::Values;

/// Blocks from which the idle level and the noise are learned before anything is looked for: 133
/// ms.
const LEARN_BLOCKS: u32 = 8;
/// Blocks in a row without any change after which something is still: 66 ms.
const STILL_BLOCKS: u32 = 4;
/// Blocks after which the load of a hold, or its direction in a slide, is measured anew: 133 ms.
const LOAD_BLOCKS: u32 = 8;
/// Latest blocks excluded from the level before a motion: a slow motion may have begun in them. 133
/// ms.
const STILL_BACK: usize = 8;
/// Standard deviations by which the load falls in the latest frame of a finger that may be leaving.
const LIFTS: f32 = 3.0;
/// Frames from the contact to a slide that began before the spike was over: 50 ms, within which a
/// spike hides the slide.
const HIDDEN_FRAMES: u32 = 12;
/// Fraction of the touch's first load that falls at once in a release: a skin that has crept since
/// the contact stays behind.
const FALLEN: f32 = 0.55;

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

/// End of a block: its last frame, the ring up to there, and the receiver of changes.
struct Now<'a> {
    number: u32,
    ring: Averages<'a>,
    report: &'a mut dyn FnMut(Change),
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
            frame.values
        } else {
            cleaned = self.condition.cleaned(ring, number);
            let Some(values) = &cleaned else { return };
            values
        };
        let weights = self.motion.weights();
        match self.phase {
            Phase::Slide(_) => self.air.follow_slide(values, weights),
            Phase::Spike(_) => self.spike.follow(number, values, &self.idle.level, weights),
            _ => {}
        }
        self.motion.seeks_across = match &self.phase {
            Phase::Hold => true,
            Phase::Moving(moving) => moving.sign != Sign::Reported,
            _ => false,
        };
        let Some(block) = self.motion.push(values, frame.squares) else {
            return;
        };
        if core::mem::take(&mut self.skips_block) {
            if matches!(self.phase, Phase::Idle | Phase::Learning(_)) {
                self.enter(self.phase);
            }
        } else if self.step(
            block,
            &mut Now {
                number,
                ring,
                report,
            },
        ) {
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
            Phase::Slide(slide) => {
                self.phase = Phase::Hold;
                let is_planned = self.planned.is_some();
                let end = if is_planned { number } else { self.moved.until };
                report(Change::SlideEnd(slide.start, end));
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
                self.motion.ignore([0.0; TAXELS]);
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

    /// Processes a block. True if the finger was still, so that the noise can be learned from it.
    fn step(&mut self, block: Block, now: &mut Now) -> bool {
        let (mean, number) = (self.motion.past.back(0), now.number);
        let is_averaged = self.condition.is_averaged();
        match self.phase {
            Phase::Learning(blocks) => {
                self.follow_idle(self.off_idle(mean));
                self.phase = Phase::Learning(blocks + 1);
                if blocks + 1 == LEARN_BLOCKS {
                    self.enter(Phase::Idle);
                }
                return true;
            }
            Phase::Idle => {
                let off = self.off_idle(mean);
                if off <= self.idle.touched(self.motion.taxels) {
                    self.follow_idle(off);
                    return true;
                }
                let idle = &self.idle.level;
                let is_back = |before: &Values| {
                    self.motion.distance(mean, before) < self.motion.distance(idle, before)
                };
                if matches!(&self.air, Air::Known(Some(before)) if is_back(before)) {
                    self.enter(Phase::CreepingBack);
                } else {
                    self.spike = Spike::begin(number, idle, &self.frames(now.ring));
                    // The end of an earlier motion may be anywhere by now: numbers wrap.
                    self.moved = Moved::until(number);
                    self.enter(Phase::Spike(number));
                }
            }
            Phase::CreepingBack => {
                self.idle.restart(*mean, &self.condition);
                self.enter(Phase::Idle);
            }
            Phase::Spike(since) => {
                self.moved.follow(block, number, is_averaged);
                let is_due = number.wrapping_sub(since) >= SPIKE_FRAMES
                    || self.motion.still_quick >= SPIKE_STILL_BLOCKS;
                // With the protocol every touch begins with a contact.
                let is_sure = self.was_in_air || !self.finds_slides();
                if is_due && (is_sure || self.is_contact(since, now)) {
                    self.end_phase(now);
                }
            }
            Phase::Hold | Phase::Moving(_) => return self.hold(block, now),
            Phase::Slide(slide) if self.planned.is_none() => {
                let blocks = slide.blocks.wrapping_add(1);
                self.moved.follow(block, number, is_averaged);
                self.phase = Phase::Slide(Sliding { blocks, ..slide });
                if self.is_over(slide.is_slow, blocks) {
                    self.end_phase(now);
                }
            }
            Phase::Slide(_) | Phase::Starting(_) | Phase::Always(_) => {}
        }
        false
    }

    /// Processes a block of a hold or of a motion in it. True if nothing moves in a hold.
    fn hold(&mut self, block: Block, now: &mut Now) -> bool {
        let (number, knows_air) = (now.number, self.air.is_known());
        // The level of a hold changes slowly.
        if knows_air && self.motion.still.is_multiple_of(LOAD_BLOCKS) {
            self.load = self.off(&self.held.level);
        }
        let off = self.off(self.motion.past.back(0));
        let back = BACK_AT_IDLE * self.load;
        let was_back = |blocks| self.off(self.motion.past.back(blocks)) < back;
        // A change along the load alone is slow, so the oldest block counts too.
        let is_over = off < back && was_back(STILL_BLOCKS as usize - 1);
        let is_in_air = knows_air && !block.now && off < back && was_back(1);
        // A slow slide falls as far as a release does, but it rises again.
        let is_quiet = self.motion.still_quick >= STILL_BLOCKS;
        let has_fallen = is_quiet && self.has_fallen();
        if is_quiet && is_over || has_fallen && self.motion.still >= STILL_BLOCKS {
            self.end_hold(now.report);
            self.end_phase(now);
            return false;
        }
        let first = number.wrapping_sub(BLOCK_FRAMES - 1);
        let mut moving = match self.phase {
            Phase::Moving(moving) => moving,
            // As long as the level in the air is unknown, only a motion shows a release.
            _ if block.moves() && (self.finds_slides() || !knows_air) => Moving::since(first),
            _ if block.moves() => return false,
            _ => {
                if self.motion.still <= HELD_BACK as u32 {
                    self.held.restart();
                } else if off > IS_LOAD * self.load {
                    self.held.extend(number, &self.motion);
                }
                return true;
            }
        };
        let is_new = self.phase == Phase::Hold;
        if is_new || block.quick && moving.is_creep() {
            self.note_still_level();
            moving.since = first;
        }
        if is_in_air && !is_new {
            // In the air for two blocks: the motion so far was no slide, and a slide may begin now.
            moving = moving.anew(number.wrapping_add(1));
            self.contact = number;
        }
        let sign = self.sign(moving.sign, block, off);
        if sign != moving.sign && sign == Sign::Reported {
            let since = self.condition.latest().wrapping_sub(BLOCK_FRAMES - 1);
            (now.report)(Change::Moving(since));
        }
        moving.sign = sign;
        moving = moving.with(block);
        if self.finds_slides() && moving.is_slide() && !has_fallen {
            self.end_hold(now.report);
            self.phase = Phase::Starting(moving);
        } else if self.motion.still.min(self.motion.still_longest) >= STILL_BLOCKS {
            self.phase = Phase::Hold;
            self.motion.restart_lately();
        } else {
            self.phase = Phase::Moving(moving);
        }
        false
    }

    /// Sign of a motion with one more block, whose mean is `off` from idle: the first block that
    /// shows a motion across the direction of the load, unless its mean shows a finger that leaves.
    /// Channels are sampled one after the other, so that in the first frame of a lift only some have
    /// lost their load: if the load has fallen, the next block decides.
    fn sign(&self, sign: Sign, block: Block, off: f32) -> Sign {
        if !block.across || sign == Sign::Reported || !self.finds_slides() {
            return sign;
        }
        let motion = &self.motion;
        let may_lift = || {
            let fall = motion.along(motion.latest(), &self.held.level);
            fall > LIFTS && sign == Sign::None || off < IS_LOAD * self.load
        };
        if self.air.is_known() && may_lift() {
            Sign::Unsure
        } else {
            Sign::Reported
        }
    }

    /// Begins the slide that a motion has become.
    fn start_slide(&mut self, moving: Moving, ring: Averages, report: &mut dyn FnMut(Change)) {
        let contact = self.contact;
        let left = self.still_level.as_ref().map_or_else(
            || contact.wrapping_add(HIDDEN_FRAMES),
            |level| self.frames(ring).departure(level, moving.since, contact),
        );
        let is_later = reached(left, contact);
        let start = if is_later { left } else { contact };
        self.begin_slide(Sliding::new(start, moving.is_slow()), report);
    }

    /// True if a slide is over, which goes on for `blocks`: the finger is still, or in the air, even
    /// if something goes on shaking it there.
    fn is_over(&mut self, is_slow: bool, blocks: u32) -> bool {
        let motion = &self.motion;
        let is_still = motion.still >= STILL_BLOCKS
            && (motion.still_longest >= STILL_BLOCKS || !is_slow || !motion.is_weak());
        if !blocks.is_multiple_of(LOAD_BLOCKS) {
            return is_still;
        }
        let recent = motion.past.recent_mean();
        let off = self.off(&recent);
        if self.air.is_known() && off > IS_LOAD * self.load {
            self.aim(&recent);
        }
        is_still || off < BACK_AT_IDLE * self.load
    }

    /// Ends a phase with the latest block: the present level decides what the phase was and what
    /// comes next.
    fn end_phase(&mut self, now: &mut Now) {
        let level = self.motion.past.mean_of_four(0);
        let off = self.off(&level);
        let is_at_idle = off < BACK_AT_IDLE * self.load;
        let before = self.still_level.replace(level);
        self.skips_block = true;
        let is_spike = matches!(self.phase, Phase::Spike(_));
        let (mut arrived, mut has_slid) = (None, false);
        let is_released = match self.phase {
            Phase::Spike(_) => {
                let is_released = self.is_back_from_spike(off);
                if self.motion.still_quick < SPIKE_STILL_BLOCKS {
                    self.still_level = None;
                }
                let height = self.spike.height(self.motion.weights());
                if is_released && height < self.motion.taxels.limit(TAP) {
                    return self.enter(Phase::Idle);
                }
                self.report_contact(now.report);
                is_released
            }
            Phase::Slide(Sliding { start, .. }) => {
                // A finger that is shaken in the air shows nothing else.
                let frames = self.frames(now.ring);
                has_slid = true;
                let is_released = is_at_idle || self.has_left(&level);
                let end = if self.motion.still_quick < STILL_BLOCKS {
                    self.moved.until
                } else if is_released {
                    let lifted = frames.arrival(&level, now.number);
                    arrived = Some(lifted);
                    frames.hold_before(lifted, start)
                } else {
                    slide_end(&frames, &level, self.moved, now.number)
                };
                (now.report)(Change::SlideEnd(start, end));
                is_released
            }
            _ => {
                has_slid = self.held.hold == Hold::AfterSlide;
                true
            }
        };
        let knows_air = self.air.is_known();
        if is_released {
            let arrived = arrived.unwrap_or_else(|| match &before {
                Some(before) if knows_air && !is_at_idle => {
                    // The level just after the fall: the skin has crept on since.
                    let since = self.motion.still_quick.saturating_sub(STILL_BLOCKS) as usize;
                    let fallen = self.motion.past.mean_of_four(since.min(FURTHEST));
                    self.frames(now.ring).fall(before, &fallen, now.number)
                }
                _ => self.frames(now.ring).arrival(&level, now.number),
            });
            (now.report)(Change::Release(arrived));
            // Nothing slides in the air: the level after a slide is that in the air.
            self.was_in_air |= knows_air && has_slid;
            self.air = Air::Known(knows_air.then_some(self.idle.level));
            self.idle.restart(level, &self.condition);
            self.planned = None;
            self.motion.ignore([0.0; TAXELS]);
            self.enter(Phase::Idle);
            return;
        }
        if knows_air {
            if is_spike || off > IS_LOAD * self.load {
                (self.held.level, self.load) = (level, off);
            }
            if is_spike {
                self.first_load = length(&difference(&level, &self.idle.level));
            }
            self.aim(&level);
        }
        self.begin_hold(if is_spike && knows_air {
            Hold::BeforeSlide
        } else {
            Hold::AfterSlide
        });
    }

    /// Ignores changes along the line from idle to this level.
    fn aim(&mut self, level: &Values) {
        self.motion.ignore(difference(level, &self.idle.level));
    }

    /// Makes the idle level follow the latest block, which is `off` from that level.
    fn follow_idle(&mut self, off: f32) {
        let Self {
            idle,
            motion,
            condition,
            ..
        } = self;
        idle.follow(off, motion, condition);
    }

    /// Squared distance of a level from idle, in units of one frame's noise.
    fn off(&self, level: &Values) -> f32 {
        self.motion.distance(level, &self.idle.level)
    }

    /// Squared distance of a block's mean from idle, in units of the mean's noise.
    fn off_idle(&self, mean: &Values) -> f32 {
        self.off(mean) * BLOCK_FRAMES as f32
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
        Frames {
            ring,
            condition: &self.condition,
            motion: &self.motion,
        }
    }

    fn enter(&mut self, phase: Phase) {
        self.phase = phase;
        self.motion.restart();
    }

    /// True if a level, which is `off` from idle, is in the air after a spike. The spike may be
    /// many times as high as the hold, so only a level next to idle counts. For a finger that is
    /// shaken all the time a longer mean decides.
    fn is_back_from_spike(&self, off: f32) -> bool {
        let motion = &self.motion;
        let of_recent = self.off(&motion.past.recent_mean());
        let is_still = motion.still_quick >= SPIKE_STILL_BLOCKS;
        let off = if is_still {
            off
        } else {
            lesser(off, of_recent)
        };
        let at_idle = self.idle.touched(motion.taxels) * (1.0 / BLOCK_FRAMES as f32);
        off < greater(
            at_idle,
            BACK_FROM_SPIKE * self.spike.height(motion.weights()),
        )
    }

    /// True if the change since the block that ends with frame `since` is a contact. Otherwise a
    /// finger that was on something before slides, or it is unclear as yet.
    fn is_contact(&mut self, since: u32, now: &Now) -> bool {
        let (passed, first) = (
            now.number.wrapping_sub(since),
            since.wrapping_sub(BLOCK_FRAMES - 1),
        );
        let is_still = self.motion.still >= SPIKE_STILL_BLOCKS && passed > SPIKE_FRAMES;
        // A slide passes the level before it, but does not stay there; a tap is short.
        let off = |back| self.off(self.motion.past.back(back));
        let off = greater(off(0), off(STILL_BLOCKS as usize - 1));
        if passed < 2 * SPIKE_FRAMES && self.is_back_from_spike(off) {
            return true;
        }
        let (frames, idle) = (self.frames(now.ring), &self.idle.level);
        match judge(&frames, idle, first, now.number, is_still) {
            Judged::Contact { has_spike } => {
                self.was_in_air = has_spike;
                return true;
            }
            Judged::Slide(moments) => {
                self.air = Air::Unknown(moments);
                (self.load, self.contact) = (0.0, first.wrapping_sub(SPIKE_FRAMES));
                self.held.restart();
                self.still_level = Some(self.idle.level);
                // The next block begins the slide.
                self.phase = Phase::Moving(Moving::sliding_since(first));
            }
            Judged::Unclear => {}
        }
        false
    }

    /// True if a finger whose idle level is not known has left the levels of its slide.
    fn has_left(&self, level: &Values) -> bool {
        let Motion { taxels, .. } = &self.motion;
        self.air.is_left(level, self.motion.weights(), taxels.count)
    }

    /// True if the load fell in the latest motion, whatever the idle level is by now: the level may
    /// have drifted, and a skin creeps back to it.
    fn has_fallen(&self) -> bool {
        let (Phase::Moving(_), Some(before)) = (self.phase, &self.still_level) else {
            return false;
        };
        let (motion, past) = (&self.motion, &self.motion.past);
        let fall = FALLEN * motion.in_noise(self.first_load);
        let is_down = |level| self.has_left(level) || motion.along(level, before) > fall;
        // A change along the load alone is slow, so the oldest block counts too.
        is_down(past.back(STILL_BLOCKS as usize - 1)) && is_down(past.back(0))
    }

    /// Notes the level before a motion that the latest block shows.
    fn note_still_level(&mut self) {
        // Right after another motion the level at which that motion ended is kept.
        let past = &self.motion.past;
        if past.count > HELD_BACK {
            let skip = past.count.saturating_sub(4).clamp(HELD_BACK, STILL_BACK);
            self.still_level = Some(past.mean_of_four(skip));
        }
    }
}
