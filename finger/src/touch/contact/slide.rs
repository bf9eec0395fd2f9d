//! The slide: from the held levels on, until they are still again or the protocol says so.

use super::{After, Change, ContactDetector, HELD_BACK, Held, PendingOnset, Phase, STILL_BLOCKS, back_at_idle};
use crate::ring::{Ring, reached};
use crate::touch::motion::{BLOCK_FRAMES, Block, LONG_BLOCKS, SHORT_BLOCKS};
use ridgetone_proto::settings::SlideRule;

/// Blocks that something has to move for to be a slide, not a knock: 183 ms.
const LASTING_BLOCKS: u32 = 11;
/// Blocks with quick changes after which a motion is a slide: it stays in the comparison for some when it is over.
const SLIDE_BLOCKS: u32 = LASTING_BLOCKS + SHORT_BLOCKS;
/// Blocks with slow changes after which it is one.
const SLOW_SLIDE_BLOCKS: u32 = LASTING_BLOCKS + LONG_BLOCKS;

impl ContactDetector {
    /// One block further while nothing moves. True if that still holds.
    #[inline(never)]
    pub(super) fn hold(&mut self, number: u32, block: &Block, ring: &Ring, changed: &mut dyn FnMut(Change)) -> bool {
        if self.released(number, block, ring, changed) {
            return false;
        }
        if !(block.quick || block.slow) {
            self.hold_on(number, block);
            return true;
        }
        if self.rule == SlideRule::Found {
            self.free_level(ring, changed);
            self.phase = Phase::Moving { quick: block.quick as u32, any: 1 };
            // Right after something else the level that it left is the one.
            self.level_due = self.motion.known() > HELD_BACK;
            self.date(PendingOnset::Start, number.wrapping_sub(BLOCK_FRAMES - 1));
        }
        false
    }

    /// Sums up one share of the level that was held before something moved.
    #[inline(never)]
    pub(super) fn sum_up_held(&mut self, turn: usize) {
        self.motion.settle(&mut self.level, &self.idle, turn, HELD_BACK);
    }

    /// Ends the touch if the levels are still and back at idle.
    fn released(&mut self, number: u32, block: &Block, ring: &Ring, changed: &mut dyn FnMut(Change)) -> bool {
        let released = self.still_quick >= STILL_BLOCKS && back_at_idle(block.off, self.load);
        if released {
            self.forget_start();
            self.settle_after(After::Hold, number, ring, changed);
            self.end_hold();
        }
        released
    }

    /// What moved was no slide.
    fn forget_start(&mut self) {
        self.waiting = self.waiting.filter(|(pending_onset, _)| *pending_onset != PendingOnset::Start);
        self.pending_onset = self.pending_onset.filter(|pending_onset| *pending_onset != PendingOnset::Start);
    }

    /// One block further while something moves: it becomes a slide, or is still again. Before it so
    /// many had quick changes, and any.
    #[inline(never)]
    pub(super) fn moving(
        &mut self,
        (quick, any): (u32, u32),
        number: u32,
        block: &Block,
        ring: &Ring,
        changed: &mut dyn FnMut(Change),
    ) {
        let quick = quick + block.quick as u32;
        let any = any + (block.quick || block.slow) as u32;
        self.level_due = false;
        if self.released(number, block, ring, changed) {
            return;
        }
        let found = self.pending_onset == Some(PendingOnset::Start) && self.search.has_seen_all(ring);
        let still = self.still >= STILL_BLOCKS;
        self.phase = Phase::Moving { quick, any };
        if (quick >= SLIDE_BLOCKS || any >= SLOW_SLIDE_BLOCKS) && (found || still) {
            if !found {
                self.settle(ring, changed);
            }
            self.pending_onset = None;
            let left = self.search.result();
            let start = if reached(left, self.touched) { left } else { self.touched };
            self.moving_until = start;
            self.phase = Phase::Slide(start);
            self.end_hold();
            self.tell(Change::SlideStart(start), ring, changed);
        } else if still {
            self.forget_start();
            self.enter(Phase::Hold);
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
        changed: &mut dyn FnMut(Change),
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
        if self.still < STILL_BLOCKS && !back_at_idle(block.off, self.load) {
            return;
        }
        let steady = self.still_quick >= STILL_BLOCKS;
        self.settle_after(After::Slide(start, steady), number, ring, changed);
        if !steady {
            self.tell(Change::SlideEnd(start, self.moving_until), ring, changed);
        }
    }

    /// Starts and ends the slide by protocol.
    pub(super) fn follow_plan(&mut self, number: u32, ring: &Ring, changed: &mut dyn FnMut(Change)) {
        let Some((start, end)) = self.planned else { return };
        match self.phase {
            Phase::Hold if reached(number, start) => {
                self.phase = Phase::Slide(start);
                self.end_hold();
                self.tell(Change::SlideStart(start), ring, changed);
            }
            Phase::Slide(_) if reached(number, end) => {
                self.planned = None;
                self.held = Held::new(true);
                self.enter(Phase::Hold);
                self.tell(Change::SlideEnd(start, end), ring, changed);
            }
            Phase::Slide(_) => self.moving_until = number.wrapping_add(1),
            _ => {}
        }
    }
}
