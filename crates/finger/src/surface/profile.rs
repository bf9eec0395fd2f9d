//! A speed profile from the host, and the place on the surface that follows from it.
//!
//! Speeds are given at a few times and are linear in between. The place is their integral, a
//! parabola from knot to knot, in closed form. With places instead of times the fit gives cycles
//! per millimetre at any speed (`ridgetone_tone::FrameSpan::along`).

use core::num::NonZeroU32;
use ridgetone_proto::division::divide;
use ridgetone_proto::profile::{After, KNOTS_MAX, Knot};

/// Fastest speed, millimetres per second: as fast as
/// [`ridgetone_proto::settings::SlideRule::Protocol`] may be.
pub const SPEED_MAX_MM_S: f32 = 2000.0;

/// Why a profile is refused. Knots are numbered from 0.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum ProfileError {
    /// It has no knot; or only one, and repeats.
    #[error("a speed profile needs a knot, and two to repeat")]
    TooFew,
    /// It has this number of knots, which is more than [`KNOTS_MAX`].
    #[error("{0} knots: a speed profile has at most {KNOTS_MAX}")]
    TooMany(usize),
    /// This knot is not later than the one before it.
    #[error("knot {0} is not later than the one before it")]
    NotLater(usize),
    /// This knot's speed, millimetres per second, is not a number, or beyond [`SPEED_MAX_MM_S`].
    #[error("knot {0}: a speed of {1} mm/s: choose one up to {SPEED_MAX_MM_S} mm/s")]
    Speed(usize, f32),
}

/// The unit of the knots' places, millimetres: half of a nanometre per second times a microsecond.
/// In this unit the place of each knot is a whole number. Places wrap after 4.6 km, but a window is
/// shorter, and only differences count.
const MM_PER_COUNT: f32 = 0.5e-12;

/// Nanometres in a millimetre.
const NM_PER_MM: f32 = 1e6;

/// A speed profile: piecewise linear.
#[derive(Clone, Debug, PartialEq)]
pub struct Profile {
    knots: heapless::Vec<Knot, KNOTS_MAX>,
    /// Places of the knots from the first; see [`MM_PER_COUNT`].
    places: [i64; KNOTS_MAX],
    after: After,
}

impl Profile {
    /// A profile of 1 to [`KNOTS_MAX`] knots, in the order of time.
    pub fn new(knots: &[Knot], after: After) -> Result<Self, ProfileError> {
        if knots.len() < if after == After::Repeat { 2 } else { 1 } {
            return Err(ProfileError::TooFew);
        }
        let vec =
            heapless::Vec::from_slice(knots).map_err(|_| ProfileError::TooMany(knots.len()))?;
        let mut profile = Self {
            knots: vec,
            places: [0; KNOTS_MAX],
            after,
        };
        let mut before: Option<(Knot, i64)> = None;
        let mut place = 0i64;
        for ((knot, here), out) in knots.iter().enumerate().zip(&mut profile.places) {
            // A NaN is refused too.
            if !(here.speed_mm_s.abs() <= SPEED_MAX_MM_S) {
                return Err(ProfileError::Speed(knot, here.speed_mm_s));
            }
            // 31 bits hold the greatest speed.
            let speed_nm_s = (here.speed_mm_s * NM_PER_MM) as i32 as i64;
            if let Some((before, before_nm_s)) = before {
                if here.t_us <= before.t_us {
                    return Err(ProfileError::NotLater(knot));
                }
                place = place.wrapping_add(
                    (before_nm_s + speed_nm_s).wrapping_mul((here.t_us - before.t_us).into()),
                );
            }
            *out = place;
            before = Some((*here, speed_nm_s));
        }
        Ok(profile)
    }

    /// The way from where the finger is at a device time, microseconds.
    pub fn way_from(&self, start_us: u64) -> Way<'_> {
        let (first_us, last_us) = (
            self.time_us(0),
            self.time_us(self.knots.len().wrapping_sub(1)),
        );
        let repeats = self.after == After::Repeat;
        let round_us = NonZeroU32::new(last_us.wrapping_sub(first_us)).filter(|_| repeats);
        let from_us = match round_us {
            // Behind the last knot the speed stays the same.
            None => start_us.min(last_us.into()) as u32,
            Some(round_us) if start_us >= first_us.into() => {
                first_us + divide(start_us - u64::from(first_us), round_us.get()).1
            }
            Some(round_us) => last_us - (first_us - start_us as u32 - 1) % round_us - 1,
        };
        let knot = self.behind(from_us.into());
        let speed_mm_s = self.speed_mm_s(knot, from_us.into());
        let head_mm = mm(
            0.5 * (speed_mm_s + self.at(knot).speed_mm_s),
            self.time_us(knot).wrapping_sub(from_us),
        );
        Way {
            profile: self,
            from_us,
            round_us,
            knot,
            speed_mm_s,
            head_mm,
        }
    }

    /// The knot of that number, or the last one.
    fn at(&self, knot: usize) -> Knot {
        self.knots
            .get(knot)
            .or(self.knots.last())
            .copied()
            .unwrap_or_default()
    }

    fn time_us(&self, knot: usize) -> u32 {
        self.at(knot).t_us
    }

    fn place(&self, knot: usize) -> i64 {
        self.places.get(knot).copied().unwrap_or(0)
    }

    /// Number of the first knot that is later than this.
    fn behind(&self, t_us: u64) -> usize {
        self.knots
            .partition_point(|knot| u64::from(knot.t_us) <= t_us)
    }

    /// Speed at a time between the knot of this number and the one in front of it, mm/s. Before the
    /// first knot it is that of the first, behind the last knot that of the last.
    fn speed_mm_s(&self, behind: usize, t_us: u64) -> f32 {
        let (before, behind) = (self.at(behind.saturating_sub(1)), self.at(behind));
        let lasts_us = behind.t_us.wrapping_sub(before.t_us);
        if lasts_us == 0 {
            return before.speed_mm_s;
        }
        let since_us = t_us.wrapping_sub(before.t_us.into()) as u32;
        before.speed_mm_s
            + (behind.speed_mm_s - before.speed_mm_s) * (since_us as f32 / lasts_us as f32)
    }
}

/// The places after some moment, relative to the place at that moment: then f32 is exact to a
/// ten-millionth of the way in a window, however long the finger has slid before.
#[derive(Clone, Copy, Debug)]
pub struct Way<'a> {
    profile: &'a Profile,
    /// The moment, in the profile's time; in its first round if it repeats.
    from_us: u32,
    /// Length of a round if there are any.
    round_us: Option<NonZeroU32>,
    /// Number of the first knot later than that moment.
    knot: usize,
    /// Speed at that moment.
    speed_mm_s: f32,
    /// From there to that knot.
    head_mm: f32,
}

impl Way<'_> {
    /// Place after a time, millimetres from the first one.
    pub fn place_mm(&self, after_us: u32) -> f32 {
        let profile = self.profile;
        let (first_us, passed_us) = (
            profile.time_us(0),
            u64::from(self.from_us) + u64::from(after_us),
        );
        let (mut rounds, mut t_us) = (0, passed_us);
        if let Some(round_us) = self.round_us {
            // Since the first knot; longer than 32 bits hold is longer than any window.
            let since_us = (passed_us - u64::from(first_us)).min(u32::MAX.into()) as u32;
            (rounds, t_us) = (
                since_us / round_us,
                u64::from(first_us + since_us % round_us),
            );
        }
        let knot = profile.behind(t_us);
        let speed_mm_s = profile.speed_mm_s(knot, t_us);
        if rounds == 0 && knot == self.knot {
            return mm(0.5 * (self.speed_mm_s + speed_mm_s), after_us);
        }
        let before = profile.at(knot.saturating_sub(1));
        let tail_mm = mm(
            0.5 * (before.speed_mm_s + speed_mm_s),
            t_us.wrapping_sub(before.t_us.into()) as u32,
        );
        let round = profile.place(profile.knots.len().wrapping_sub(1));
        let knots = profile
            .place(knot.saturating_sub(1))
            .wrapping_sub(profile.place(self.knot));
        let between_mm =
            knots.wrapping_add(round.wrapping_mul(rounds.into())) as f32 * MM_PER_COUNT;
        self.head_mm + between_mm + tail_mm
    }
}

/// Millimetres in some microseconds.
fn mm(speed_mm_s: f32, time_us: u32) -> f32 {
    speed_mm_s * (time_us as f32 * 1e-6)
}

#[cfg(test)]
mod tests {
    use super::*;
    extern crate std;
    use std::f64::consts::TAU;
    use std::vec::Vec;

    fn knot(t_us: u32, speed_mm_s: f32) -> Knot {
        Knot { t_us, speed_mm_s }
    }

    /// One round of a hand that goes to and fro: 197 sin(2 pi 1.07 t) mm/s.
    fn hand() -> Profile {
        let round_us = 1e6 / 1.07;
        let knots: Vec<Knot> = (0..KNOTS_MAX)
            .map(|k| {
                let turns = k as f64 / (KNOTS_MAX - 1) as f64;
                knot(
                    (turns * round_us).round() as u32,
                    (197.0 * (TAU * turns).sin()) as f32,
                )
            })
            .collect();
        Profile::new(&knots, After::Repeat).unwrap()
    }

    /// Longest window, microseconds: what counts in it is a hundredth of a ridge, here of 0.5 mm.
    const WINDOW_US: u32 = 4_000_000;

    #[test]
    fn a_hands_place_is_the_closed_form_to_what_the_chords_leave() {
        let profile = hand();
        // The chords of a sine of n knots a turn lie below it by (2 pi / n)^2 / 12 on average.
        let chord = (TAU / (KNOTS_MAX - 1) as f64).powi(2) / 12.0;
        let reach_mm = 197.0 / (TAU * 1.07);
        let mut worst = 0f64;
        for i in 0..5000u32 {
            let t_us = i * 997;
            let closed_mm = reach_mm * (1.0 - (TAU * 1.07 * f64::from(t_us) * 1e-6).cos());
            worst = worst.max((f64::from(profile.way_from(0).place_mm(t_us)) - closed_mm).abs());
        }
        assert!(worst < 1.1 * 2.0 * reach_mm * chord, "{worst} mm");
        assert!(worst > 0.5 * 2.0 * reach_mm * chord, "{worst} mm");
    }

    #[test]
    fn between_the_knots_it_is_the_integral() {
        let profile = Profile::new(
            &[knot(1000, 10.0), knot(501_000, 30.0), knot(1_501_000, -5.0)],
            After::Hold,
        )
        .unwrap();
        // Midpoint sums of the speed, which are exact for straight lines: one microsecond a step.
        let speed = |t_us: f64| match t_us {
            t if t < 1000.0 => 10.0,
            t if t < 501_000.0 => 10.0 + 20.0 * (t - 1000.0) / 500_000.0,
            t if t < 1_501_000.0 => 30.0 - 35.0 * (t - 501_000.0) / 1e6,
            _ => -5.0,
        };
        for start_us in [
            0, 999, 1000, 250_000, 501_000, 1_400_000, 1_501_000, 1_600_000,
        ] {
            let (way, mut place_mm) = (profile.way_from(start_us), 0.0);
            for after_us in 0..2_000_000u32 {
                let off_mm = f64::from(way.place_mm(after_us)) - place_mm;
                assert!(off_mm.abs() < 1e-5, "{start_us} + {after_us}: {off_mm}");
                place_mm += speed(start_us as f64 + f64::from(after_us) + 0.5) * 1e-6;
            }
        }
    }

    /// However late a window begins, its places are as exact as the first one's, and so are those
    /// across the seam.
    #[test]
    fn rounds_follow_each_other_without_a_seam() {
        let profile =
            Profile::new(&[knot(500, 20.0), knot(1_000_500, 40.0)], After::Repeat).unwrap();
        // 30 mm a round, by the closed form from the place of the first knot.
        let place_mm = |since_us: f64| {
            let (rounds, s) = ((since_us / 1e6).floor(), (since_us / 1e6).rem_euclid(1.0));
            30.0 * rounds + 20.0 * s + 10.0 * s * s
        };
        for rounds in [0u64, 1, 2, 3600, 1_000_000, 10_000_000_000_000] {
            for since_us in [0u64, 1, 300_000, 999_999] {
                let way = profile.way_from(500 + rounds * 1_000_000 + since_us);
                for after_us in (0..WINDOW_US)
                    .step_by(997)
                    .chain([999_999, 1_000_000, 1_000_001])
                {
                    let expected_mm =
                        place_mm(since_us as f64 + f64::from(after_us)) - place_mm(since_us as f64);
                    let off_mm = f64::from(way.place_mm(after_us)) - expected_mm;
                    assert!(
                        off_mm.abs() < 5e-5,
                        "{rounds} rounds and {since_us} us, {after_us} us later: {off_mm}"
                    );
                }
            }
        }
        // Before the first knot it is the end of the round before.
        assert!((profile.way_from(0).place_mm(500) - 40.0 * 500e-6).abs() < 1e-5);
        assert!((profile.way_from(499).place_mm(1) - 40.0 * 1e-6).abs() < 1e-8);
    }

    /// A segment of an hour and more, and the greatest speeds, over which f32 would be millimetres
    /// off.
    #[test]
    fn a_window_late_in_a_long_segment_is_as_good_as_one_at_its_beginning() {
        let profile =
            Profile::new(&[knot(0, -2000.0), knot(u32::MAX, 2000.0)], After::Hold).unwrap();
        for start_us in [
            0u64,
            1,
            3_000_000_000,
            4_294_000_000,
            4_294_967_295,
            5_000_000_000,
        ] {
            let way = profile.way_from(start_us);
            let speed_mm_s =
                |t_us: f64| (-2000.0 + 4000.0 * t_us / f64::from(u32::MAX)).min(2000.0);
            for after_us in (0..WINDOW_US).step_by(9973) {
                let end_us = start_us as f64 + f64::from(after_us);
                let accelerates_us =
                    (f64::from(u32::MAX) - start_us as f64).clamp(0.0, f64::from(after_us));
                let mean_mm_s = 0.5
                    * (speed_mm_s(start_us as f64) + speed_mm_s(start_us as f64 + accelerates_us));
                let expected_mm = 1e-6
                    * (mean_mm_s * accelerates_us
                        + 2000.0 * (end_us - start_us as f64 - accelerates_us));
                let off_mm = f64::from(way.place_mm(after_us)) - expected_mm;
                assert!(off_mm.abs() < 5e-3, "{start_us} + {after_us}: {off_mm}");
            }
        }
    }

    #[test]
    fn one_knot_is_a_constant_speed() {
        let profile = Profile::new(&[knot(7, 15.0)], After::Hold).unwrap();
        for start_us in [0, 7, 8, 3_600_000_000, u64::MAX] {
            assert!((profile.way_from(start_us).place_mm(4_000_000) - 60.0).abs() < 1e-5);
        }
    }

    #[test]
    fn what_is_wrong_is_named() {
        let flaw = |knots: &[Knot], after| {
            Profile::new(knots, after).map_err(|error| std::format!("{error}"))
        };
        for (knots, after, why) in [
            (&[][..], After::Hold, "needs a knot"),
            (&[knot(0, 1.0)][..], After::Repeat, "two to repeat"),
            (&[knot(0, 1.0); KNOTS_MAX + 1][..], After::Hold, "33 knots"),
            (
                &[knot(0, 1.0), knot(5, 1.0), knot(5, 1.0)][..],
                After::Hold,
                "knot 2 is not later",
            ),
            (
                &[knot(0, 1.0), knot(1, f32::NAN)][..],
                After::Hold,
                "knot 1: a speed of NaN",
            ),
            (
                &[knot(0, 2001.0)][..],
                After::Hold,
                "knot 0: a speed of 2001 mm/s",
            ),
        ] {
            let error = flaw(knots, after).unwrap_err();
            assert!(error.contains(why), "{error}");
        }
    }

    #[test]
    fn any_time_has_a_place() {
        for profile in [
            hand(),
            Profile::new(
                &[knot(u32::MAX - 1, 1.0), knot(u32::MAX, 2.0)],
                After::Repeat,
            )
            .unwrap(),
        ] {
            for t_us in [0, 1, u64::MAX / 2, u64::MAX - 1, u64::MAX] {
                for after_us in [0, 1, WINDOW_US, u32::MAX] {
                    assert!(profile.way_from(t_us).place_mm(after_us).is_finite());
                }
            }
        }
    }
}
