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
/// Between the distances of frames at a level, whose mean is 16, and those of frames in motion, of noise and a tone as strong
/// as it, whose mean is 32: where both are as likely.
const BETWEEN: f32 = limit(1.0, 7.0);
/// One frame counts no more than this: a knock is no motion that goes on.
const MOST: f32 = limit(3.0, 24.0);
/// Frames that are searched for the moment of a release: 0.66 s.
pub const SEARCH_FRAMES: u32 = 160;
/// Frames that are searched for the start of a motion before the block that showed it, and behind.
const START_FRAMES: (u32, u32) = (64, 32);
/// Most frames that are searched for its end: 0.4 s.
const END_FRAMES: u32 = 96;
/// Frames of a hold between a slide and the release that show its level: 33 ms.
const PLATEAU_FRAMES: u32 = 8;
/// Frames before a release that may belong to it.
const LIFTING_FRAMES: u32 = 4;

/// The frames in the ring, and what a distance is measured in.
#[derive(Clone, Copy, Debug)]
pub struct Frames<'a> {
    pub ring: &'a Ring,
    /// One over the variance of each taxel's frames.
    pub weights: &'a Values,
    /// See [`Motion::pull`](crate::touch::motion::Motion::pull).
    pub pull: &'a Values,
}

impl Frames<'_> {
    fn is_off(&self, level: &Values, frame: u32) -> bool {
        self.ring.frame(frame).is_some_and(|(values, _)| distance(self.weights, values, level) > DEPARTED)
    }

    /// How much a frame speaks for motion away from `level`, which rises by `creep` in each frame that is passed: more than
    /// zero for it. What is along the direction of the load is none.
    #[inline(never)]
    fn moves(&self, level: &Values, creep: &Values, passed: f32, frame: u32) -> f32 {
        let Some((values, _)) = self.ring.frame(frame) else { return 0.0 };
        let (mut sum, mut along) = (0.0, 0.0);
        for c in 0..TAXELS {
            let off = values[c] - level[c] - creep[c] * passed;
            sum += off * off * self.weights[c];
            along += off * self.pull[c];
        }
        let apart = sum - along * along;
        (if apart > MOST { MOST } else { apart }) - BETWEEN
    }

    /// The first frame of a motion away from `level` that block `since` showed, `earliest` or later: the frames from there on
    /// speak most for motion, all together.
    pub fn departure(&self, level: &Values, since: u32, earliest: u32) -> u32 {
        let (before, behind) = START_FRAMES;
        let last = since.wrapping_add(behind);
        let last = if reached(last, self.ring.next()) { self.ring.next().wrapping_sub(1) } else { last };
        let frames = last.wrapping_sub(earliest).min(before + behind);
        let (mut sum, mut most, mut start) = (0.0, 0.0, since);
        for frame in (0..=frames).map(|back| last.wrapping_sub(back)) {
            sum += self.moves(level, &[0.0; TAXELS], 0.0, frame);
            if sum > most {
                (most, start) = (sum, frame);
            }
        }
        start
    }

    /// The first of the frames up to `last` that are at `level` without a break. One frame alone off it may be noise.
    #[inline(never)]
    pub fn arrival(&self, level: &Values, last: u32) -> u32 {
        let mut was_off = false;
        // One more than is searched: a border is known by the frame before it.
        for frame in (0..=SEARCH_FRAMES).map(|back| last.wrapping_sub(back)) {
            let is_off = self.is_off(level, frame);
            if is_off && was_off {
                return frame.wrapping_add(2);
            }
            was_off = is_off;
        }
        last
    }

    /// The first frame behind a motion that is over in frame `last`, in which the taxels are at `level` and rise by `creep`
    /// each frame: the frames from there on speak least for motion. No earlier than `earliest`.
    pub fn rest(&self, level: &Values, creep: &Values, last: u32, earliest: u32) -> u32 {
        let frames = last.wrapping_sub(earliest).min(END_FRAMES);
        let (mut sum, mut least, mut end) = (0.0, 0.0, last);
        for back in 0..=frames {
            let frame = last.wrapping_sub(back);
            sum += self.moves(level, creep, -(back as f32), frame);
            if sum < least {
                (least, end) = (sum, frame);
            }
        }
        end
    }

    /// The first frame of a hold that a release at frame `lifted` ended; that frame if there was none.
    pub fn hold_before(&self, lifted: u32, earliest: u32) -> u32 {
        let last = lifted.wrapping_sub(LIFTING_FRAMES);
        let mut level = [0.0; TAXELS];
        for back in 0..PLATEAU_FRAMES {
            if let Some((values, _)) = self.ring.frame(last.wrapping_sub(back)) {
                (0..TAXELS).for_each(|c| level[c] += values[c] * (1.0 / PLATEAU_FRAMES as f32));
            }
        }
        let held = self.rest(&level, &[0.0; TAXELS], last, earliest);
        if last.wrapping_sub(held) < PLATEAU_FRAMES { lifted } else { held }
    }
}
