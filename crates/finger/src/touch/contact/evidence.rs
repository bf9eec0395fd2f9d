//! Evidence in the levels: contact, fallen load, moments without motion.

use super::{ContactDetector, STILL_BACK, STILL_BLOCKS};
use crate::touch::averages::Averages;
use crate::touch::block::BLOCK_FRAMES;
use crate::touch::held::HELD_BACK;
use crate::touch::loaded::{Air, Judged, judge};
use crate::touch::phase::Phase;
use crate::touch::slide::Moving;
use crate::touch::spike::{BACK_FROM_SPIKE, SPIKE_FRAMES, SPIKE_STILL_BLOCKS};
use crate::touch::values::greater;
use ridgetone_tone::Values;

/// Fraction of the touch's first load that falls at once in a release: a skin that has crept since
/// the contact stays behind.
const FALLEN: f32 = 0.55;

impl ContactDetector {
    /// True if a level, which is `off` from idle, is in the air after a spike. The spike may be
    /// many times as high as the hold, so only a level next to idle counts. For a finger that is
    /// shaken all the time a longer mean decides.
    pub(super) fn is_back_from_spike(&self, off: f32) -> bool {
        let is_still = self.motion.still_quick >= SPIKE_STILL_BLOCKS;
        let of_recent = self
            .motion
            .distance(&self.motion.past().recent_mean(), &self.idle.level);
        let off = if is_still || off < of_recent {
            off
        } else {
            of_recent
        };
        let at_idle = self.idle.touched(self.motion.taxels) * (1.0 / BLOCK_FRAMES as f32);
        off < greater(
            at_idle,
            BACK_FROM_SPIKE * self.spike.height(self.motion.weights()),
        )
    }

    /// True if the change since the block that ends with frame `since` is a contact. Otherwise a
    /// finger that was on something before slides, or it is unclear as yet.
    pub(super) fn is_contact(&mut self, since: u32, number: u32, ring: Averages) -> bool {
        let is_still =
            self.motion.still >= SPIKE_STILL_BLOCKS && number.wrapping_sub(since) > SPIKE_FRAMES;
        let first = since.wrapping_sub(BLOCK_FRAMES - 1);
        // A slide passes the level before it, but does not stay there; a tap is short.
        let is_short = number.wrapping_sub(since) < 2 * SPIKE_FRAMES;
        let off = |back| {
            self.motion
                .distance(self.motion.past().back(back), &self.idle.level)
        };
        if is_short && self.is_back_from_spike(greater(off(0), off(STILL_BLOCKS as usize - 1))) {
            return true;
        }
        match judge(
            &self.frames(ring),
            &self.idle.level,
            first,
            number,
            is_still,
        ) {
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
    pub(super) fn has_left(&self, level: &Values) -> bool {
        self.air
            .is_left(level, self.motion.weights(), self.motion.taxels.count)
    }

    /// True if the load fell in the latest motion, whatever the idle level is by now: the level may
    /// have drifted, and a skin creeps back to it.
    pub(super) fn has_fallen(&self) -> bool {
        let (Phase::Moving(_), Some(before)) = (self.phase, &self.still_level) else {
            return false;
        };
        let fall = FALLEN * self.motion.in_noise(self.first_load);
        let is_down =
            |level: &Values| self.has_left(level) || self.motion.along(level, before) > fall;
        // A change along the load alone is slow, so the oldest block counts too.
        let past = self.motion.past();
        is_down(past.back(STILL_BLOCKS as usize - 1)) && is_down(past.back(0))
    }

    /// Notes the level before a motion that the latest block shows.
    pub(super) fn note_still_level(&mut self) {
        // Right after another motion the level at which that motion ended is kept.
        let count = self.motion.past().count;
        if count > HELD_BACK {
            let skip = count.saturating_sub(4).clamp(HELD_BACK, STILL_BACK);
            self.still_level = Some(self.motion.past().mean_of_four(skip));
        }
    }
}
