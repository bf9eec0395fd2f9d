//! What is being dated, and telling it in its order.

use super::{Change, ContactDetector};
use crate::motion::BLOCK_FRAMES;
use crate::window::Ring;

/// Frames that a search looks at with each frame of a block; the last one's work is dealing with the block before.
const LOOKS: [u32; BLOCK_FRAMES as usize] = [2, 2, 2, 1];

/// What a search is for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Sought {
    /// The first frame of what may become a slide.
    Start,
    /// The end of the slide that began at this frame, and whether the finger is off since.
    End(u32, bool),
    /// The frame since which the finger is off.
    Release,
}

impl ContactDetector {
    /// Goes on with dating: looks further, or tells what was found, or begins with what waits.
    pub(super) fn seek(&mut self, turn: usize, ring: &Ring, changed: &mut dyn FnMut(Change)) {
        match self.sought {
            None if self.waiting.is_some() => self.begin_search(),
            None | Some(Sought::Start) if self.search.is_over() => {}
            Some(sought) if self.search.is_over() => self.tell_found(sought, changed),
            _ => self.search.look(LOOKS[turn % LOOKS.len()], ring),
        }
    }

    /// Begins with what waits, if its level is there.
    fn begin_search(&mut self) {
        let Some((sought, frame)) = self.waiting else { return };
        if self.held > 0 {
            return;
        }
        let (weights, level) = (self.motion.weights(), &self.level);
        match sought {
            Sought::Start => self.search.departure(weights, level, frame),
            Sought::End(..) | Sought::Release => self.search.arrival(weights, level, frame),
        }
        (self.sought, self.waiting) = (Some(sought), None);
    }

    /// Tells the next of what was searched for. A start is told when it is known to be a slide's.
    fn tell_found(&mut self, sought: Sought, changed: &mut dyn FnMut(Change)) {
        let frame = self.search.result();
        self.sought = None;
        match sought {
            Sought::Start => {}
            Sought::End(start, released) => {
                self.sought = released.then_some(Sought::Release);
                changed(Change::SlideEnd(start, frame));
            }
            Sought::Release => changed(Change::Release(frame)),
        }
    }

    /// Tells all that is being dated and that waits for it.
    #[inline(never)]
    pub(super) fn settle(&mut self, ring: &Ring, changed: &mut dyn FnMut(Change)) {
        loop {
            match self.sought {
                Some(sought) => {
                    self.search.finish(ring);
                    self.tell_found(sought, changed);
                }
                None if self.waiting.is_some() && self.held == 0 => self.begin_search(),
                None => break,
            }
        }
        self.waiting = None;
    }

    /// Tells of a change, after what is still being searched for.
    #[inline(never)]
    pub(super) fn tell(&mut self, change: Change, ring: &Ring, changed: &mut dyn FnMut(Change)) {
        self.settle(ring, changed);
        changed(change);
    }

    /// The level is about to be that of something else: nothing may wait for it any more.
    pub(super) fn free_level(&mut self, ring: &Ring, changed: &mut dyn FnMut(Change)) {
        if self.waiting.is_some() {
            self.settle(ring, changed);
        }
    }

    /// Has something dated as soon as nothing else is, by the frame at which the taxels came to the level or left it:
    /// around `frame`.
    pub(super) fn date(&mut self, sought: Sought, frame: u32) {
        self.waiting = Some((sought, frame));
    }
}
