//! What is being dated, and telling it in its order.

use super::{Change, ContactDetector};
use crate::window::{Ring, Values};

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
    /// Goes on with the search, and tells what it was for when it is over.
    pub(super) fn look(&mut self, frames: u32, ring: &Ring, changed: &mut impl FnMut(Change)) {
        let Some(sought) = self.sought else { return };
        let Some(frame) = self.search.look(frames, ring) else { return };
        match sought {
            // Told when it is known to be a slide.
            Sought::Start => return,
            Sought::End(start, released) => {
                changed(Change::SlideEnd(start, frame));
                if released {
                    changed(Change::Release(frame));
                }
            }
            Sought::Release => changed(Change::Release(frame)),
        }
        self.sought = None;
    }

    /// Ends a search, so that another may begin and all is told in its order.
    #[inline(never)]
    pub(super) fn settle(&mut self, ring: &Ring, changed: &mut impl FnMut(Change)) {
        self.look(u32::MAX, ring, changed);
        self.sought = None;
    }

    /// Tells of a change, after what is still being searched for.
    #[inline(never)]
    pub(super) fn tell(&mut self, change: Change, ring: &Ring, changed: &mut impl FnMut(Change)) {
        self.settle(ring, changed);
        changed(change);
    }

    /// Begins to look for the frame at which the taxels came to `level`, where they are at frame `number`.
    #[inline(never)]
    pub(super) fn date(
        &mut self,
        sought: Sought,
        level: Values,
        number: u32,
        ring: &Ring,
        changed: &mut impl FnMut(Change),
    ) {
        self.settle(ring, changed);
        self.search.arrival(self.motion.weights(), &level, number);
        self.sought = Some(sought);
    }
}
