//! When did it happen: the frame at which the taxels left a level, or came to one.
//!
//! That something moves is known a few blocks late; the ring still holds the frames. They are looked
//! at a few at a time, so that no frame's work is much more than another's.

use crate::ring::{Ring, reached};
use crate::touch::motion::{SHARES, share, share_mut};
use ridgetone_proto::settings::TAXELS;
use ridgetone_tone::Values;

/// A frame this far from a level is not at that level: chi-square of 16, mean and 4.5 times 5.7.
const DEPARTED: f32 = 42.0;
/// Frames that are searched for the moment when a motion began or ended: 0.66 s.
const SEARCH_FRAMES: u32 = 160;
/// Work of looking at one frame at most: both halves of the taxels.
pub const LOOK: u32 = 2;

/// A search under way, or over.
#[derive(Clone, Debug)]
pub struct Search {
    level: Values,
    /// How much the level rises in [`SHARES`] frames.
    creep: Values,
    /// As the noise was when the search began.
    weights: Values,
    aim: Aim,
    /// Frame that is looked at next.
    frame: u32,
    /// Frames that may still be looked at.
    left: u32,
    /// Frames that a departure is searched for back from where it began.
    back: u32,
    /// Whether the frame looked at before was off the level.
    was_off: bool,
    /// What is found, or what it is taken for if nothing is.
    result: u32,
    over: bool,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Aim {
    /// Forward: the first frame off the level.
    Ahead,
    /// Back from a frame off the level, as long as frames are off it.
    Departure,
    /// Back from a frame at the level, as long as frames are at it.
    Arrival,
}

impl Search {
    /// None under way.
    pub const fn new() -> Self {
        Self {
            level: [0.0; TAXELS],
            creep: [0.0; TAXELS],
            weights: [0.0; TAXELS],
            aim: Aim::Ahead,
            frame: 0,
            left: 0,
            back: 0,
            was_off: false,
            result: 0,
            over: true,
        }
    }

    /// Begins to search for the first frame off `level` of the stretch that is off it around frame `from`:
    /// back from there as long as frames are off the level, as far as frame `earliest`; else forward to the first
    /// that is.
    pub fn departure(&mut self, weights: &Values, level: &Values, from: u32, earliest: u32) {
        self.begin(Aim::Ahead, weights, level, from, SEARCH_FRAMES);
        self.was_off = true;
        self.back = SEARCH_FRAMES.min(from.wrapping_sub(earliest));
    }

    /// Begins to search for the first frame of the stretch up to `number` that is at `level` throughout.
    pub fn arrival(&mut self, weights: &Values, level: &Values, number: u32) {
        // One more than is searched: a border is known by the frame before it.
        self.begin(Aim::Arrival, weights, level, number, SEARCH_FRAMES + 1);
        self.creep = [0.0; TAXELS];
        self.was_off = false;
    }

    /// Level and creep for the next [`Self::creeping_arrival`], to be filled in while nothing is searched for: the latter
    /// is how much the level rises in [`SHARES`] frames.
    pub fn line(&mut self) -> (&mut Values, &mut Values) {
        (&mut self.level, &mut self.creep)
    }

    /// As [`Self::arrival`], at the level of [`Self::line`] in frame `number` and creeping before it; the taxels came
    /// there no earlier than in frame `earliest`.
    pub fn creeping_arrival(&mut self, weights: &Values, number: u32, earliest: u32) {
        self.weights = *weights;
        (self.aim, self.frame, self.result, self.over, self.was_off) = (Aim::Arrival, number, earliest, false, false);
        // Two more than are searched: two frames off the level tell a border.
        self.left = number.wrapping_sub(earliest).min(SEARCH_FRAMES) + 2;
    }

    #[inline(never)]
    fn begin(&mut self, aim: Aim, weights: &Values, level: &Values, frame: u32, left: u32) {
        (self.level, self.weights) = (*level, *weights);
        (self.aim, self.frame, self.left, self.result, self.over) = (aim, frame, left, frame, false);
    }

    /// Looks at frames as far as they have come and as long as that is no more than so much `work`.
    #[inline(never)]
    pub fn look(&mut self, mut work: u32, ring: &Ring) {
        while work >= LOOK && !self.has_seen_all(ring) {
            let (off, done) = self.is_off(ring);
            work -= done;
            self.step(off);
        }
    }

    /// Whether the next frame is off the level, and the work it was to tell: half the taxels may do.
    fn is_off(&self, ring: &Ring) -> (bool, u32) {
        let Some((values, _)) = ring.frame(self.frame) else { return (false, LOOK / 2) };
        let mut sum = 0.0;
        for (half, work) in [(0..TAXELS / 2, LOOK / 2), (TAXELS / 2..TAXELS, LOOK)] {
            for c in half {
                let off = values[c] - self.level[c];
                sum += off * off * self.weights[c];
            }
            if sum > DEPARTED {
                return (true, work);
            }
        }
        (false, LOOK)
    }

    /// Whether there is nothing left to look at, or not yet.
    pub fn has_seen_all(&self, ring: &Ring) -> bool {
        self.over || (self.aim == Aim::Ahead && reached(self.frame, ring.next()))
    }

    /// Whether there is nothing left to look at.
    pub const fn is_over(&self) -> bool {
        self.over
    }

    /// The frame that was found, or what it is taken for.
    pub const fn result(&self) -> u32 {
        self.result
    }

    /// Looks at all that is left.
    pub fn finish(&mut self, ring: &Ring) {
        self.look(2 * SEARCH_FRAMES * LOOK, ring);
    }

    /// One frame further: that one was off the level, or at it.
    fn step(&mut self, off: bool) {
        self.left -= 1;
        match self.aim {
            Aim::Ahead if !off => {
                self.frame = self.frame.wrapping_add(1);
                self.over = self.left == 0;
            }
            Aim::Ahead if self.left + 1 < SEARCH_FRAMES => self.end(self.frame),
            Aim::Ahead => {
                // It is off already where the search began.
                self.aim = Aim::Departure;
                self.left = self.back + 1;
                self.result = self.frame.wrapping_sub(self.back);
                self.frame = self.frame.wrapping_sub(1);
            }
            Aim::Departure | Aim::Arrival => {
                // Two frames in a row: of waves one alone may pass through the level, and one alone off
                // it may be noise.
                if off == self.was_off && off == (self.aim == Aim::Arrival) {
                    self.end(self.frame.wrapping_add(2));
                } else {
                    self.was_off = off;
                    self.frame = self.frame.wrapping_sub(1);
                    if self.aim == Aim::Arrival {
                        self.creep_back();
                    }
                    self.over = self.left == 0;
                }
            }
        }
    }

    /// The level one frame earlier: of a share of the taxels, the others' turn comes with the next frames.
    fn creep_back(&mut self) {
        let turn = self.left as usize % SHARES;
        let creep = share(&self.creep, turn);
        for (level, creep) in share_mut(&mut self.level, turn).iter_mut().zip(creep) {
            *level -= creep;
        }
    }

    fn end(&mut self, result: u32) {
        self.result = result;
        self.over = true;
    }
}

impl Default for Search {
    fn default() -> Self {
        Self::new()
    }
}
