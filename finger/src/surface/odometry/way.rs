//! The place of every frame of a window, between the places that a robot has sent.
//!
//! From entry to entry it is a cubic: it runs through both places, and has at each the slope of the parabola through that entry
//! and its neighbours. For a hand that goes to and fro, a sin(2 pi f t), it is off by 0.023 a (2 pi f h)^4 at most, h from entry
//! to entry: by 0.06 mm at a = 29 mm, f = 1.07 Hz and h = 80 ms.

use super::track::{Entry, Track};
use super::{Mark, STALE_US};
use core::cell::Cell;
use ridgetone_proto::odometry::PLACE_PER_MM;

/// A cubic from one entry to the next.
#[derive(Clone, Copy, Debug)]
struct Segment {
    /// Number of the entry at its begin.
    number: u16,
    /// Time of its begin and of its end, microseconds from the window's begin.
    from_us: f32,
    until_us: f32,
    /// Coefficients of the powers of the time since its begin: units of place, from the first entry.
    powers: [f32; 4],
}

/// Places after a moment, relative to an entry near it.
#[derive(Debug)]
pub struct Way<'a> {
    track: &'a Track,
    mark: Mark,
    /// The robot's time at the window's begin.
    start_us: u32,
    /// Number of the latest entry that is not later than that.
    first: u16,
    /// Place of that entry.
    origin: i32,
    /// How much of the window's end has no place yet, microseconds.
    pub missing_us: u32,
    /// The segment that was used last: frames are visited one after the other.
    segment: Cell<Segment>,
}

impl<'a> Way<'a> {
    /// The way of so many microseconds of the board's, which ends `behind_us` after the mark's window. None if the messages do not
    /// cover its begin, or too little of its end: they may be missing for 0.1 s there and a quarter of the window.
    #[inline(never)]
    pub fn new(track: &'a Track, mark: &Mark, lasts_us: u32, behind_us: u32) -> Option<Self> {
        let end_us = mark.end_us.wrapping_add(behind_us);
        let start_us = end_us.wrapping_sub(libm::roundf(lasts_us as f32 * (1.0 + mark.faster())) as u32);
        let missing_us = (end_us.wrapping_sub(mark.newest.t_us) as i32).max(0) as u32;
        if !mark.is_some() || missing_us > STALE_US.min(lasts_us / 4) {
            return None;
        }
        let mut first = mark.until.wrapping_sub(1);
        let mut entry = mark.newest;
        while (entry.t_us.wrapping_sub(start_us) as i32) > 0 {
            if first == mark.oldest {
                return None;
            }
            first = first.wrapping_sub(1);
            entry = track.get(first);
        }
        let none = Segment { number: first, from_us: 0.0, until_us: f32::NEG_INFINITY, powers: [0.0; 4] };
        let way =
            Self { track, mark: *mark, start_us, first, origin: entry.place, missing_us, segment: Cell::new(none) };
        // The newest entry alone leads nowhere.
        (first != mark.until.wrapping_sub(1)).then_some(way)
    }

    /// Whether its entries are still what they were when the window fell due.
    pub fn is_intact(&self) -> bool {
        // The slope at the first entry may be by the one before it.
        self.track.has_kept(self.first.wrapping_sub(1))
    }

    /// Place after a time of the board's clock, millimetres from an entry near the window's begin.
    pub fn place_mm(&self, after_us: u32) -> f32 {
        let after_us = after_us as f32 + after_us as f32 * self.mark.faster();
        let mut segment = self.segment.get();
        if !(after_us >= segment.from_us && after_us <= segment.until_us) {
            segment = self.find(after_us, segment.number);
            self.segment.set(segment);
        }
        let [a, b, c, d] = segment.powers;
        let t_us = after_us - segment.from_us;
        (a + t_us * (b + t_us * (c + t_us * d))) * (1.0 / PLACE_PER_MM)
    }

    /// The segment of a time; outside all of them the first or the last one.
    #[inline(never)]
    fn find(&self, after_us: f32, near: u16) -> Segment {
        let last = self.mark.until.wrapping_sub(2);
        let mut number = near;
        while number != last && self.at(number.wrapping_add(1)).0 < after_us {
            number = number.wrapping_add(1);
        }
        while number != self.first && self.at(number).0 > after_us {
            number = number.wrapping_sub(1);
        }
        self.segment(number)
    }

    /// Time and place of an entry, relative to the window's begin and to the first entry.
    #[inline(never)]
    fn at(&self, number: u16) -> (f32, f32) {
        let is_newest = number == self.mark.until.wrapping_sub(1);
        let Entry { t_us, place } = if is_newest { self.mark.newest } else { self.track.get(number) };
        (t_us.wrapping_sub(self.start_us) as i32 as f32, place.wrapping_sub(self.origin) as f32)
    }

    fn segment(&self, number: u16) -> Segment {
        let [other, begin, end, next] = [u16::MAX, 0, 1, 2].map(|step| self.at(number.wrapping_add(step)));
        let [before, this, after] = [chord(other, begin), chord(begin, end), chord(end, next)];
        let (has_before, has_after) = (number != self.mark.oldest, number.wrapping_add(2) != self.mark.until);
        // Slopes by the parabola through three entries; at an end of the way by the one that the other side gives.
        let (mut from, mut to) = (curved(this, before), curved(this, after));
        if !has_before {
            from = if has_after { 2.0 * this.1 - to } else { this.1 };
        }
        if !has_after {
            to = 2.0 * this.1 - from;
        }
        let (per_us, mean) = (1.0 / this.0, this.1);
        let powers =
            [begin.1, from, (3.0 * mean - 2.0 * from - to) * per_us, (from + to - 2.0 * mean) * per_us * per_us];
        Segment { number, from_us: begin.0, until_us: end.0, powers }
    }
}

/// Slope between two chords that meet.
#[inline(never)]
fn curved(this: (f32, f32), other: (f32, f32)) -> f32 {
    (this.1 * other.0 + other.1 * this.0) / (this.0 + other.0)
}

/// Time from one entry to the next, and the mean speed on the way.
#[inline(never)]
fn chord(from: (f32, f32), to: (f32, f32)) -> (f32, f32) {
    let lasts_us = (to.0 - from.0).max(1.0);
    (lasts_us, (to.1 - from.1) / lasts_us)
}
