//! What is being dated, and telling it in its order.

use super::{Change, ContactDetector, Phase};
use crate::ring::Ring;
use crate::touch::motion::BLOCK_FRAMES;
use crate::touch::onset::LOOK;

/// A search's work with each frame of a block: a look, or two if half of the taxels do; the last has enough else to do.
const WORK: [u32; BLOCK_FRAMES as usize] = [LOOK + LOOK / 2, LOOK + LOOK / 2, LOOK + LOOK / 2, 0];
/// Frame of a block with which what was found is told, because others have more to do; other news with that or the one before it.
const TELLING: usize = 1;

/// What a search is for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum PendingOnset {
    /// The first frame of what may become a slide.
    Start,
    /// The end of the slide that began at this frame, and whether the finger is off since.
    End(u32, bool),
    /// The frame since which the finger is off.
    Release,
}

impl ContactDetector {
    /// Goes on with dating, one thing a frame: looks further, tells what was found or known, begins with what waits.
    pub(super) fn seek(&mut self, turn: usize, ring: &Ring, changed: &mut dyn FnMut(Change)) {
        match self.pending_onset {
            Some(pending_onset) if self.search.is_over() => {
                // A start is told when it is known to be a slide's.
                if pending_onset != PendingOnset::Start && turn == TELLING {
                    self.tell_found(pending_onset, changed);
                }
            }
            // A spike is work enough.
            Some(_) if matches!(self.phase, Phase::Spike(_)) => {}
            Some(_) => self.search.look(WORK[turn % WORK.len()], ring),
            None => match self.news {
                Some(change) if turn <= TELLING => {
                    self.news = None;
                    self.told = self.block_end as u8;
                    changed(change);
                }
                Some(_) => {}
                // Not with the first two: they have more to do with what the block before decided.
                None if turn > TELLING => self.begin_search(),
                None => {}
            },
        }
    }

    /// Whether the latest frame had more to do than others: it ended a block, or something is looked for.
    pub fn is_busy(&self) -> bool {
        let searching = self.waiting.is_some() || self.pending_onset.is_some() && !self.search.is_over();
        self.motion.turn() == 0 || searching || matches!(self.phase, Phase::Spike(_) | Phase::Settling(..))
    }

    /// Begins with what waits, if its level is there.
    fn begin_search(&mut self) {
        let Some((pending_onset, frame)) = self.waiting else { return };
        if self.level_due {
            return;
        }
        let (weights, level) = (self.motion.weights(), &self.level);
        match pending_onset {
            PendingOnset::Start => self.search.departure(weights, level, frame, self.touched),
            PendingOnset::End(..) => self.search_end(frame),
            PendingOnset::Release => self.search.arrival(weights, level, frame),
        }
        (self.pending_onset, self.waiting) = (Some(pending_onset), None);
    }

    /// Tells the next of what was searched for.
    fn tell_found(&mut self, pending_onset: PendingOnset, changed: &mut dyn FnMut(Change)) {
        let frame = self.search.result();
        self.told = self.block_end as u8;
        self.pending_onset = None;
        match pending_onset {
            PendingOnset::Start => {}
            PendingOnset::End(start, released) => {
                self.pending_onset = released.then_some(PendingOnset::Release);
                changed(Change::SlideEnd(start, frame));
            }
            PendingOnset::Release => changed(Change::Release(frame)),
        }
    }

    /// Tells all that is known, being dated, or waits for it.
    #[inline(never)]
    pub(super) fn settle(&mut self, ring: &Ring, changed: &mut dyn FnMut(Change)) {
        loop {
            if let Some(pending_onset) = self.pending_onset {
                self.search.finish(ring);
                self.tell_found(pending_onset, changed);
            } else if let Some(change) = self.news.take() {
                changed(change);
            } else if self.waiting.is_some() && !self.level_due {
                self.begin_search();
            } else {
                break;
            }
        }
        self.waiting = None;
    }

    /// Has a change told after what is still being searched for: with the next frame, if that is nothing.
    pub(super) fn tell(&mut self, change: Change, ring: &Ring, changed: &mut dyn FnMut(Change)) {
        if self.waiting.is_some() || self.news.is_some() {
            self.settle(ring, changed);
        }
        self.news = Some(change);
    }

    /// The level is about to be that of something else: nothing may wait for it any more.
    pub(super) fn free_level(&mut self, ring: &Ring, changed: &mut dyn FnMut(Change)) {
        if self.waiting.is_some() {
            self.settle(ring, changed);
        }
    }

    /// Has something dated as soon as nothing else is, by the frame at which the taxels came to the level or left it:
    /// around `frame`.
    pub(super) fn date(&mut self, pending_onset: PendingOnset, frame: u32) {
        self.waiting = Some((pending_onset, frame));
    }
}
