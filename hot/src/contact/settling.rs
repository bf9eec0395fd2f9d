//! After something: where the taxels are by then decides what it was and what comes next.

use super::{Change, ContactDetector, Phase, Sought, back_at_idle, is_load};
use crate::motion::SHARES;
use crate::window::Ring;

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
        self.enter(Phase::Settling(after, over));
    }

    /// Sums up one share of the level, which the blocks before `over` tell.
    #[inline(never)]
    pub(super) fn sum_up(&mut self, turn: usize, after: After, over: u32, ring: &Ring) {
        if after == After::Spike {
            self.sum_up_spike(turn, over, ring);
        }
        self.off += self.motion.settle(&mut self.level, &self.idle, turn, 0);
    }

    /// The level is summed up, one block after. True if the finger still touches, and holds.
    #[inline(never)]
    pub(super) fn settled(&mut self, after: After, over: u32, ring: &Ring, changed: &mut dyn FnMut(Change)) -> bool {
        let released = match after {
            After::Hold => true,
            After::Slide(..) => back_at_idle(self.off, self.load),
            After::Spike => {
                let off_again = back_at_idle(self.off, self.spike.height);
                if off_again && self.spike.is_faint() {
                    self.enter(Phase::Idle);
                    return false;
                }
                self.tell_contact(ring, changed);
                off_again
            }
        };
        match after {
            After::Slide(start, true) => self.date(Sought::End(start, released), over),
            _ if released => self.date(Sought::Release, over),
            _ => {}
        }
        if released {
            self.before = Some(self.idle);
            self.idle = self.level;
            self.planned = None;
            self.enter(Phase::Idle);
            return false;
        }
        if after == After::Spike || is_load(self.off, self.load) {
            (self.loaded, self.load) = (self.level, self.off);
        }
        self.phase = Phase::Hold;
        true
    }

    /// There will be no block after: settles at once.
    pub(super) fn settle_now(&mut self, ring: &Ring, changed: &mut dyn FnMut(Change)) {
        if let Phase::Settling(after, over) = self.phase {
            (0..SHARES).for_each(|turn| self.sum_up(turn, after, over, ring));
            self.settled(after, over, ring, changed);
        }
    }
}
