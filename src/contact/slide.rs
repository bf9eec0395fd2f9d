//! The slide: from the held levels on, until they are still again or the protocol says so.

use super::{Change, ContactDetector, Phase, STILL_BLOCKS, Sought, back_at_idle};
use crate::motion::{BLOCK_FRAMES, Block, Distances, LONG_BLOCKS, SHORT_BLOCKS};
use crate::settings::SlideRule;
use crate::window::{Ring, reached};

/// Blocks with quick changes after which a motion is a slide and not a step: 150 ms.
const SLIDE_BLOCKS: u32 = 9;
/// Blocks with slow changes after which it is one: longer than a step stays in the comparison.
const SLOW_SLIDE_BLOCKS: u32 = 22;

impl ContactDetector {
    /// One block further while nothing moves. True if that still holds.
    #[inline(never)]
    pub(super) fn hold(&mut self, number: u32, block: &Block, ring: &Ring, changed: &mut impl FnMut(Change)) -> bool {
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

    /// One block further while something moves: it becomes a slide, or is still again. Before it so
    /// many had quick changes, and any.
    #[inline(always)]
    pub(super) fn moving(
        &mut self,
        (quick, any): (u32, u32),
        number: u32,
        block: &Block,
        ring: &Ring,
        changed: &mut impl FnMut(Change),
    ) {
        let quick = quick + block.quick as u32;
        let any = any + (block.quick || block.slow) as u32;
        if self.released(number, block, ring, changed) {
            return;
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
    }

    /// One block further in the slide that began at frame `start`.
    #[inline(never)]
    pub(super) fn slide(
        &mut self,
        start: u32,
        number: u32,
        block: &Block,
        ring: &Ring,
        changed: &mut impl FnMut(Change),
    ) {
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
    pub(super) fn follow_plan(&mut self, number: u32, ring: &Ring, changed: &mut impl FnMut(Change)) {
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

/// Whether a level so far from idle is a load, the loaded one being so far from it; both squared. Less than half
/// of that is a skin on its way back.
fn is_load(off: f32, loaded: f32) -> bool {
    off > 0.25 * loaded
}
