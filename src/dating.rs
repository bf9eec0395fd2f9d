//! When did it happen: the frame at which the taxels left a level, or came to one.
//!
//! That something moves is known a few blocks late; the ring still holds the frames.

use crate::motion::Motion;
use crate::window::{Ring, Values};

/// A frame this far from a level is not at that level: chi-square of 16, mean and 4.5 times 5.7.
const DEPARTED: f32 = 42.0;
/// Frames that are searched for the moment when a motion began or ended: 0.66 s.
const SEARCH_FRAMES: u32 = 160;

fn departed(motion: &Motion, frame: u32, level: &Values, ring: &Ring) -> bool {
    ring.frame(frame).is_some_and(|(values, _)| motion.distance(values, level) > DEPARTED)
}

/// The first frame off `level` of the stretch that is off it around frame `from`: back from
/// there as long as frames are off the level, else forward to the first that is.
pub fn departure_from(motion: &Motion, level: &Values, from: u32, ring: &Ring) -> u32 {
    let mut first = from;
    let mut ahead = 0;
    while ahead < SEARCH_FRAMES && !departed(motion, first, level, ring) {
        first = first.wrapping_add(1);
        ahead += 1;
    }
    if ahead > 0 {
        return if ahead < SEARCH_FRAMES { first } else { from };
    }
    for _ in 0..SEARCH_FRAMES {
        let before = first.wrapping_sub(1);
        // Two frames at the level: one alone may be a wave passing through it.
        if !departed(motion, before, level, ring) && !departed(motion, before.wrapping_sub(1), level, ring) {
            break;
        }
        first = before;
    }
    first
}

/// The first frame of the stretch up to `number` that is at `level` throughout.
pub fn arrival_at(motion: &Motion, level: &Values, number: u32, ring: &Ring) -> u32 {
    let mut frame = number;
    for _ in 0..SEARCH_FRAMES {
        // Two frames off the level: one alone may be noise.
        if departed(motion, frame, level, ring) && departed(motion, frame.wrapping_sub(1), level, ring) {
            return frame.wrapping_add(1);
        }
        frame = frame.wrapping_sub(1);
    }
    number
}
