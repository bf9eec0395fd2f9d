//! The place of every frame of a window, between the places that a robot has sent.
//!
//! From entry to entry it is a cubic: it runs through both places, and has at each the slope of the
//! polynomial through the entry and its nearest neighbours, `NODES` in all. Three of them, a
//! parabola, are not enough: its slopes are too low by a sixth of (2 pi f h)^2 for a hand that goes
//! to and fro f times a second, h from entry to entry, and ways by 0.05 % too short at f = 0.8 Hz
//! and h = 77 ms.

use super::track::{Entry, Track};
use super::{Mark, STALE_US};
use core::cell::Cell;
use ridgetone_proto::odometry::PLACE_PER_MM;

/// Entries that give a slope.
const NODES: u16 = 5;

/// A cubic from one entry to the next.
#[derive(Clone, Copy, Debug)]
struct Segment {
    /// Number of the entry at its begin.
    number: u16,
    /// Time of its begin and of its end, microseconds from the window's begin.
    from_us: f32,
    until_us: f32,
    /// Coefficients of the powers of the time since its begin: millimetres from the first entry.
    powers: [f32; 4],
    /// Slope at its end; NaN of none.
    to: f32,
}

/// Places after a moment, relative to an entry near it.
#[derive(Debug)]
pub struct Trajectory<'a> {
    track: &'a Track,
    mark: Mark,
    /// Microseconds of the robot's clock in one of the board's, less 1.
    faster: f32,
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

impl<'a> Trajectory<'a> {
    /// The trajectory during `lasts_us` microseconds of the board's clock, which ends `behind_us` after
    /// the mark's window. None if the messages do not cover its begin, or too little of its end:
    /// they may be missing for 0.1 s there and a quarter of the window.
    pub fn new(track: &'a Track, mark: &Mark, lasts_us: u32, behind_us: u32) -> Option<Self> {
        let end_us = mark.end_us.wrapping_add(behind_us);
        let start_us =
            end_us.wrapping_sub(libm::roundf(lasts_us as f32 * (1.0 + mark.faster())) as u32);
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
        let none = Segment {
            number: first,
            from_us: 0.0,
            until_us: f32::NEG_INFINITY,
            powers: [0.0; 4],
            to: f32::NAN,
        };
        let trajectory = Self {
            track,
            mark: *mark,
            faster: mark.faster(),
            start_us,
            first,
            origin: entry.place,
            missing_us,
            segment: Cell::new(none),
        };
        // The newest entry alone leads nowhere.
        (first != mark.until.wrapping_sub(1)).then_some(trajectory)
    }

    /// Whether its entries are still what they were when the window fell due.
    pub fn is_intact(&self) -> bool {
        // The slope at the first entry may be by the two before it.
        let before = self.first.wrapping_sub(self.mark.oldest).min(2);
        self.track.has_kept(self.first.wrapping_sub(before))
    }

    /// Place after a time of the board's clock, millimetres from an entry near the window's begin.
    pub fn place_mm(&self, after_us: f32) -> f32 {
        let after_us = after_us + after_us * self.faster;
        let mut segment = self.segment.get();
        if !(after_us >= segment.from_us && after_us <= segment.until_us) {
            segment = self.find(after_us, segment.number);
            self.segment.set(segment);
        }
        let [a, b, c, d] = segment.powers;
        let t_us = after_us - segment.from_us;
        a + t_us * (b + t_us * (c + t_us * d))
    }

    /// The segment of a time; outside all of them the first or the last one.
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
    fn at(&self, number: u16) -> (f32, f32) {
        let is_newest = number == self.mark.until.wrapping_sub(1);
        let Entry { t_us, place } = if is_newest {
            self.mark.newest
        } else {
            self.track.get(number)
        };
        (
            t_us.wrapping_sub(self.start_us) as i32 as f32,
            place.wrapping_sub(self.origin) as f32,
        )
    }

    fn segment(&self, number: u16) -> Segment {
        let [begin, end] = [0, 1].map(|step| self.at(number.wrapping_add(step)));
        // Frames are visited one after the other.
        let last = self.segment.get();
        let from = if last.number.wrapping_add(1) == number && !last.to.is_nan() {
            last.to
        } else {
            self.slope(number)
        };
        let to = self.slope(number.wrapping_add(1));
        let per_us = 1.0 / (end.0 - begin.0).max(1.0);
        let mean = (end.1 - begin.1) * per_us;
        let powers = [
            begin.1,
            from,
            (3.0 * mean - 2.0 * from - to) * per_us,
            (from + to - 2.0 * mean) * per_us * per_us,
        ];
        let powers = powers.map(|power| power * (1.0 / PLACE_PER_MM));
        Segment {
            number,
            from_us: begin.0,
            until_us: end.0,
            powers,
            to,
        }
    }

    /// Slope at an entry, units of place in a microsecond.
    fn slope(&self, number: u16) -> f32 {
        let Mark { oldest, until, .. } = self.mark;
        let (before, after) = (
            number.wrapping_sub(oldest),
            until.wrapping_sub(1).wrapping_sub(number),
        );
        // Two before it and one behind it, at an end of the trajectory more on the other side.
        let back = before.min((NODES - 1 - after.min(NODES - 1)).max(2));
        let ahead = after.min(NODES - 1 - back);
        let first = number.wrapping_sub(back);
        let mut nodes = [(0.0, 0.0); NODES as usize];
        let nodes = nodes
            .get_mut(..=(back + ahead) as usize)
            .unwrap_or_default();
        nodes
            .iter_mut()
            .zip(0..)
            .for_each(|(node, at)| *node = self.at(first.wrapping_add(at)));
        let Some(&(this_us, this)) = nodes.get(back as usize) else {
            return 0.0;
        };
        // The derivative of Lagrange's polynomial: a mean of the chords to the other entries.
        let mut slope = 0.0;
        for (t_us, place) in nodes.iter().filter(|node| node.0 != this_us) {
            let (mut over, mut under) = (place - this, t_us - this_us);
            for (other_us, _) in nodes
                .iter()
                .filter(|node| node.0 != this_us && node.0 != *t_us)
            {
                (over, under) = (over * (other_us - this_us), under * (other_us - t_us));
            }
            slope += over / under;
        }
        slope
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::f64::consts::TAU;
    extern crate std;

    /// A hand to and fro, millimetres, from its closed form.
    fn hand_mm(t_s: f64) -> f64 {
        let turns = 0.8 * t_s.max(0.0);
        60.0 / (TAU * 0.8) * (1.0 - (TAU * turns).cos())
    }

    /// Slope of the trajectory over the true one less 1, by least squares: the deviation of a period that
    /// is fitted to it.
    fn stretch(trajectory: &Trajectory, from_s: f64) -> (f64, f64) {
        let points: std::vec::Vec<_> = (0..600u32)
            .map(|ms| {
                (
                    hand_mm(from_s + f64::from(ms) * 1e-3),
                    f64::from(trajectory.place_mm(1000.0 * ms as f32)),
                )
            })
            .collect();
        let mean = |of: &dyn Fn(&(f64, f64)) -> f64| {
            points.iter().map(of).sum::<f64>() / points.len() as f64
        };
        let (x, y) = (mean(&|point| point.0), mean(&|point| point.1));
        let slope =
            mean(&|point| (point.0 - x) * (point.1 - y)) / mean(&|point| (point.1 - y).powi(2));
        let worst = points.iter().fold(0f64, |worst, point| {
            worst.max((point.1 - y - point.0 + x).abs())
        });
        (1.0 / slope - 1.0, worst)
    }

    /// Windows of 0.6 s, with messages as they come and entries as far apart as the default plan
    /// has them.
    #[test]
    fn a_hands_trajectory_is_as_long_as_it_is() {
        for (step_us, most) in [(4_000u32, 4e-4), (20_000, 4e-4), (50_000, 1.5e-3)] {
            let (track, mut sum, mut windows, mut most_off, mut most_mm) =
                (Track::new(), 0.0, 0u32, 0f64, 0f64);
            for n in 0..5_000_000 / step_us {
                let t_us = n * step_us;
                let place = (hand_mm(f64::from(t_us) * 1e-6 - 0.5) * f64::from(PLACE_PER_MM))
                    .round() as i32;
                track.put(Entry { t_us, place }, 77_400);
                if t_us < 1_200_000 || t_us / 100_000 == t_us.saturating_sub(step_us) / 100_000 {
                    continue;
                }
                let (until, newest) = track.newest().expect("entries");
                let mark = Mark {
                    until,
                    oldest: track.oldest(),
                    newest,
                    end_us: t_us,
                    ..Mark::NONE
                };
                let trajectory = Trajectory::new(&track, &mark, 600_000, 0).expect("a trajectory");
                let (off, mm) = stretch(&trajectory, f64::from(t_us) * 1e-6 - 0.6 - 0.5);
                (sum, windows, most_off, most_mm) = (
                    sum + off,
                    windows + 1,
                    most_off.max(off.abs()),
                    most_mm.max(mm),
                );
            }
            let mean = sum / f64::from(windows);
            std::println!(
                "{step_us} us: {mean:.1e} in the mean, {most_off:.1e} and {most_mm:.4} mm at most"
            );
            assert!(
                windows > 30 && mean.abs() < 1e-4 && most_off < most,
                "{step_us} us: {mean}, {most_off}"
            );
        }
    }

    /// Where there are only a few entries the polynomial goes through all of them: a line, a
    /// parabola, a cubic are themselves.
    #[test]
    fn a_few_entries_give_their_polynomial() {
        for entries in 2..=6u16 {
            let place = |t_s: f64| match entries {
                2 => 30.0 * t_s,
                3 => 30.0 * t_s * t_s,
                _ => 30.0 * t_s * t_s * t_s - 5.0 * t_s,
            };
            let track = Track::new();
            for n in 0..entries {
                // Not evenly spaced.
                let t_us = u32::from(n) * 80_000 + u32::from(n % 2) * 15_000;
                let at = place(f64::from(t_us) * 1e-6) * f64::from(PLACE_PER_MM);
                track.put(
                    Entry {
                        t_us,
                        place: at.round() as i32,
                    },
                    0,
                );
            }
            let (until, newest) = track.newest().expect("entries");
            let mark = Mark {
                until,
                oldest: track.oldest(),
                newest,
                end_us: newest.t_us,
                ..Mark::NONE
            };
            let trajectory = Trajectory::new(&track, &mark, newest.t_us, 0).expect("a trajectory");
            for t_us in (0..newest.t_us).step_by(5000) {
                let off_mm =
                    f64::from(trajectory.place_mm(t_us as f32)) - place(f64::from(t_us) * 1e-6);
                assert!(
                    off_mm.abs() < 3e-4,
                    "{entries} entries, {t_us} us: {off_mm} mm"
                );
            }
        }
    }
}
