//! When did it happen: the frame at which the taxels left a level, or arrived at one.
//!
//! That something moves is known a few blocks late. The ring still holds the frames.

use crate::ring::{Ring, reached};
use crate::touch::chi_square::{distance, limit};
use ridgetone_proto::settings::TAXELS;
use ridgetone_tone::Values;

/// A frame this far from a level is not at that level: 42 for 16 taxels, a chi-square's mean of 16 and 4.5 times its
/// standard deviation of 5.7.
const DEPARTED: f32 = limit(1.0, 26.0);
/// Frames that are searched for the moment when a motion began or ended: 0.66 s.
pub const SEARCH_FRAMES: u32 = 160;
/// Parts of the taxels: a level that creeps is moved for one part with each frame, by the creep of so many frames.
const PARTS: usize = 4;

/// The frames in the ring, and what a distance is measured in.
#[derive(Clone, Copy, Debug)]
pub struct Frames<'a> {
    pub ring: &'a Ring,
    /// One over the variance of each taxel's frames.
    pub weights: &'a Values,
}

impl Frames<'_> {
    fn is_off(&self, level: &Values, frame: u32) -> bool {
        self.ring.frame(frame).is_some_and(|(values, _)| distance(self.weights, values, level) > DEPARTED)
    }

    /// The first frame off `level` of those that are off it around frame `from`: back from there as long as frames are off
    /// the level, as far as frame `earliest`; if that frame is not off, forward to the first that is, or `from` if none is.
    pub fn departure(&self, level: &Values, from: u32, earliest: u32) -> u32 {
        if self.is_off(level, from) {
            let back = SEARCH_FRAMES.min(from.wrapping_sub(earliest));
            let found = self.behind_pair(false, *level, &[0.0; TAXELS], from.wrapping_sub(1), back + 1);
            return found.unwrap_or(from.wrapping_sub(back));
        }
        let later = (1..SEARCH_FRAMES).map(|frames| from.wrapping_add(frames));
        later
            .take_while(|frame| !reached(*frame, self.ring.next()))
            .find(|frame| self.is_off(level, *frame))
            .unwrap_or(from)
    }

    /// The first of the frames up to `last` that are at `level` without a break.
    pub fn arrival(&self, level: &Values, last: u32) -> u32 {
        // One more than is searched: a border is known by the frame before it.
        self.behind_pair(true, *level, &[0.0; TAXELS], last, SEARCH_FRAMES + 1).unwrap_or(last)
    }

    /// The same for taxels that are at `level` in frame `last` and rise by `creep` in [`PARTS`] frames. They arrived no
    /// earlier than in frame `earliest`.
    pub fn arrival_creeping(&self, level: &Values, creep: &Values, last: u32, earliest: u32) -> u32 {
        // Two more than are searched: a border is known by two frames off the level.
        let frames = last.wrapping_sub(earliest).min(SEARCH_FRAMES) + 2;
        self.behind_pair(true, *level, creep, last, frames).unwrap_or(earliest)
    }

    /// Looks back from frame `last`, at so many frames, for two in a row that are off the level, or at it. Gives the frame
    /// behind them. One alone may be a wave that passes through the level, or noise.
    #[inline(never)]
    fn behind_pair(&self, off: bool, mut level: Values, creep: &Values, last: u32, frames: u32) -> Option<u32> {
        let mut found_before = false;
        for back in 0..frames {
            let frame = last.wrapping_sub(back);
            let found = self.is_off(&level, frame) == off;
            if found && found_before {
                return Some(frame.wrapping_add(2));
            }
            found_before = found;
            let left = frames - 1 - back;
            let first = left as usize % PARTS * (TAXELS / PARTS);
            for c in first..first + TAXELS / PARTS {
                level[c] -= creep[c];
            }
        }
        None
    }
}
