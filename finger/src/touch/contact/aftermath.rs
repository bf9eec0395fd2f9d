//! After something: where the taxels are by then decides what it was and what comes next.

use super::{Change, ContactDetector, Held, PendingOnset, Phase, back_at_idle, is_load};
use crate::ring::Ring;
use crate::touch::motion::{BLOCK_FRAMES, SHARES, SKIP_MAX};

/// Blocks after the one in which a slide is last known to have moved, until the mean of four that says where the taxels
/// were soon after it: a slow tone in noise may go on for one of them unnoticed.
const SOON_BLOCKS: u32 = 2;

/// What was over.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum After {
    Spike,
    /// The hold: the levels are still and back at idle.
    Hold,
    /// The slide that began at this frame, and whether its end is to be dated: else it was told.
    Slide(u32, bool),
}

impl ContactDetector {
    /// Something was over with the block that ends with frame `over`.
    #[inline(never)]
    pub(super) fn settle_after(&mut self, after: After, over: u32, ring: &Ring, changed: &mut dyn FnMut(Change)) {
        self.free_level(ring, changed);
        self.off = 0.0;
        // The loaded level is about to be another hold's.
        self.image_told();
        self.enter(Phase::Settling(after, over));
    }

    /// Sums up one share of the level, which the blocks before `over` tell.
    #[inline(never)]
    pub(super) fn sum_up(&mut self, turn: usize, after: After, over: u32, ring: &Ring) {
        if after == After::Spike {
            self.sum_up_spike(turn, over, ring);
        }
        self.off += self.motion.settle(&mut self.level, &self.idle, turn, 0);
        if let After::Slide(..) = after {
            let skip = self.blocks_since(over);
            // The slide's start is told: nothing is searched for.
            let (soon, creep) = self.search.line();
            self.motion.creep(soon, creep, &self.level, turn, skip);
        }
    }

    /// Blocks between the mean of four soon after the slide and that of the four up to frame `over`, by which it was
    /// known to be over.
    fn blocks_since(&self, over: u32) -> usize {
        let still = over.wrapping_sub(self.moving_until) / BLOCK_FRAMES;
        (still.saturating_sub(SOON_BLOCKS + 4) as usize).min(SKIP_MAX)
    }

    /// Begins to search for the end of a slide: back from the middle of the mean soon after it, along the creep.
    #[inline(never)]
    pub(super) fn search_end(&mut self, over: u32) {
        let middle = over.wrapping_sub(self.blocks_since(over) as u32 * BLOCK_FRAMES + 2 * BLOCK_FRAMES - 1);
        // That block differs from the one before it, where the change may have been.
        let earliest = self.moving_until.wrapping_sub(BLOCK_FRAMES);
        self.search.creeping_arrival(self.motion.weights(), middle, earliest);
    }

    /// The level is summed up, one block after.
    #[inline(never)]
    pub(super) fn settled(&mut self, after: After, over: u32, ring: &Ring, changed: &mut dyn FnMut(Change)) {
        let released = match after {
            After::Hold => true,
            After::Slide(..) => back_at_idle(self.off, self.load),
            After::Spike => {
                let off_again = back_at_idle(self.off, self.spike.height);
                if off_again && self.spike.is_faint() {
                    self.enter(Phase::Idle);
                    return;
                }
                self.tell_contact(ring, changed);
                off_again
            }
        };
        match after {
            After::Slide(start, true) => self.date(PendingOnset::End(start, released), over),
            _ if released => self.date(PendingOnset::Release, over),
            _ => {}
        }
        if released {
            self.before = Some(self.idle);
            self.idle = self.level;
            self.planned = None;
            self.enter(Phase::Idle);
            return;
        }
        if after == After::Spike || is_load(self.off, self.load) {
            (self.loaded, self.load) = (self.level, self.off);
        }
        self.held = Held::new(matches!(after, After::Slide(..)));
        self.phase = Phase::Hold;
    }

    /// There will be no block after: settles at once.
    pub(super) fn settle_now(&mut self, ring: &Ring, changed: &mut dyn FnMut(Change)) {
        if let Phase::Settling(after, over) = self.phase {
            (0..SHARES).for_each(|turn| self.sum_up(turn, after, over, ring));
            self.settled(after, over, ring, changed);
        }
    }
}
