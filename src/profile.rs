//! A speed profile as the host gives it, and the place on the surface that it leads to.
//!
//! Speeds are given at a few times, and change evenly in between: the place is their integral, a parabola
//! from knot to knot, and is computed as that and not as a sum of steps. With places instead of times the
//! fit gives cycles per millimetre, whatever the speed does meanwhile ([`crate::stretch::Stretch::along`]).

use serde::{Deserialize, Serialize};

/// Most knots of a profile.
pub const KNOTS_MAX: usize = 32;

/// Fastest speed, millimetres per second: as fast as [`crate::settings::SlideRule::Protocol`] may be.
pub const SPEED_MAX_MM_S: f32 = 2000.0;

/// A speed at a time.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Knot {
    /// Device time, microseconds, up to 71 minutes; what comes later is [`After`].
    pub t_us: u32,
    /// Speed over the surface, millimetres per second; negative is back.
    pub speed_mm_s: f32,
}

/// What happens after the last knot.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum After {
    /// The last knot's speed goes on; before the first knot, the first one's does.
    Hold,
    /// It begins again, for ever: the last knot falls on the first one of the next round.
    Repeat,
}

/// What is wrong with a profile.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ProfileError {
    /// It has no knot, or only one to repeat.
    TooFew,
    /// It has more than [`KNOTS_MAX`] knots.
    TooMany {
        /// Knots it has.
        knots: usize,
    },
    /// A knot is not later than the one before it.
    NotLater {
        /// Number of the knot, from 0.
        knot: usize,
    },
    /// A speed is not a number, or beyond [`SPEED_MAX_MM_S`].
    Speed {
        /// Number of the knot, from 0.
        knot: usize,
        /// Its speed, millimetres per second.
        speed_mm_s: f32,
    },
}

impl core::fmt::Display for ProfileError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::TooFew => write!(f, "a speed profile needs a knot, and two to repeat"),
            Self::TooMany { knots } => write!(f, "{knots} knots: a speed profile has at most {KNOTS_MAX}"),
            Self::NotLater { knot } => write!(f, "knot {knot} is not later than the one before it"),
            Self::Speed { knot, speed_mm_s } => {
                write!(f, "knot {knot}: a speed of {speed_mm_s} mm/s: choose one up to {SPEED_MAX_MM_S} mm/s")
            }
        }
    }
}

impl core::error::Error for ProfileError {}

/// A speed profile: piecewise linear.
#[derive(Clone, Debug, PartialEq)]
pub struct Profile {
    knots: heapless::Vec<Knot, KNOTS_MAX>,
    /// Places of the knots, millimetres from the first.
    places_mm: [f64; KNOTS_MAX],
    after: After,
}

impl Profile {
    /// A profile of 1 to [`KNOTS_MAX`] knots, in the order of time.
    ///
    /// # Errors
    /// The first thing that is wrong with them.
    pub fn new(knots: &[Knot], after: After) -> Result<Self, ProfileError> {
        if knots.len() < if after == After::Repeat { 2 } else { 1 } {
            return Err(ProfileError::TooFew);
        }
        let vec = heapless::Vec::from_slice(knots).map_err(|_| ProfileError::TooMany { knots: knots.len() })?;
        let mut profile = Self { knots: vec, places_mm: [0.0; KNOTS_MAX], after };
        let mut before: Option<Knot> = None;
        let mut place_mm = 0.0;
        for ((knot, here), out) in knots.iter().enumerate().zip(&mut profile.places_mm) {
            // A NaN is not within any bounds.
            if !(here.speed_mm_s.abs() <= SPEED_MAX_MM_S) {
                return Err(ProfileError::Speed { knot, speed_mm_s: here.speed_mm_s });
            }
            if let Some(before) = before {
                if here.t_us <= before.t_us {
                    return Err(ProfileError::NotLater { knot });
                }
                let mean_mm_s = 0.5 * (f64::from(before.speed_mm_s) + f64::from(here.speed_mm_s));
                place_mm += mean_mm_s * f64::from(here.t_us - before.t_us) * 1e-6;
            }
            *out = place_mm;
            before = Some(*here);
        }
        Ok(profile)
    }

    /// Place at a device time, millimetres from the place of the first knot. In f64: after an hour of sliding a
    /// window's places must still be told to a hundredth of a ridge.
    pub fn place_mm(&self, t_us: u64) -> f64 {
        let t_us = t_us.min(i64::MAX as u64) as i64;
        let (Some(first), Some(last)) = (self.knots.first(), self.knots.last()) else { return 0.0 };
        let round_us = i64::from(last.t_us) - i64::from(first.t_us);
        if self.after == After::Hold || round_us == 0 {
            return self.within_mm(t_us);
        }
        let first_us = i64::from(first.t_us);
        // By way of f64, and put right by one where that rounds: a division of 64 bits is a kilobyte of code on the chip.
        let away_us = t_us - first_us;
        let mut rounds = (away_us as f64 / round_us as f64) as i64;
        let mut since_us = away_us.wrapping_sub(rounds.wrapping_mul(round_us));
        if since_us < 0 {
            (rounds, since_us) = (rounds - 1, since_us + round_us);
        }
        if since_us >= round_us {
            (rounds, since_us) = (rounds + 1, since_us - round_us);
        }
        let advance_mm = self.places_mm.get(self.knots.len() - 1).copied().unwrap_or(0.0);
        rounds as f64 * advance_mm + self.within_mm(first_us + since_us)
    }

    /// The same, in the first round.
    fn within_mm(&self, t_us: i64) -> f64 {
        let behind = self.knots.partition_point(|knot| i64::from(knot.t_us) <= t_us);
        let at = behind.saturating_sub(1);
        let (Some(knot), Some(place_mm)) = (self.knots.get(at), self.places_mm.get(at)) else { return 0.0 };
        let since_s = (t_us - i64::from(knot.t_us)) as f64 * 1e-6;
        let speed_mm_s = f64::from(knot.speed_mm_s);
        let mean_mm_s = match self.knots.get(at + 1) {
            Some(next) if behind > 0 => {
                let lasts_s = f64::from(next.t_us - knot.t_us) * 1e-6;
                speed_mm_s + 0.5 * (f64::from(next.speed_mm_s) - speed_mm_s) * (since_s / lasts_s)
            }
            _ => speed_mm_s,
        };
        place_mm + mean_mm_s * since_s
    }
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
                knot((turns * round_us).round() as u32, (197.0 * (TAU * turns).sin()) as f32)
            })
            .collect();
        Profile::new(&knots, After::Repeat).unwrap()
    }

    #[test]
    fn a_hands_place_is_the_closed_form_to_what_the_chords_leave() {
        let profile = hand();
        // The chords of a sine of n knots a turn lie below it by (2 pi / n)^2 / 12 on average.
        let chord = (TAU / (KNOTS_MAX - 1) as f64).powi(2) / 12.0;
        let reach_mm = 197.0 / (TAU * 1.07);
        let mut worst = 0f64;
        for i in 0..5000u64 {
            let t_us = i * 997;
            let closed_mm = reach_mm * (1.0 - (TAU * 1.07 * t_us as f64 * 1e-6).cos());
            worst = worst.max((profile.place_mm(t_us) - closed_mm).abs());
        }
        assert!(worst < 1.1 * 2.0 * reach_mm * chord, "{worst} mm");
        assert!(worst > 0.5 * 2.0 * reach_mm * chord, "{worst} mm");
    }

    #[test]
    fn between_the_knots_it_is_the_integral() {
        let profile =
            Profile::new(&[knot(1000, 10.0), knot(501_000, 30.0), knot(1_501_000, -5.0)], After::Hold).unwrap();
        // Midpoint sums of the speed, which are exact for straight lines: one microsecond a step.
        let speed = |t_us: f64| match t_us {
            t if t < 1000.0 => 10.0,
            t if t < 501_000.0 => 10.0 + 20.0 * (t - 1000.0) / 500_000.0,
            t if t < 1_501_000.0 => 30.0 - 35.0 * (t - 501_000.0) / 1e6,
            _ => -5.0,
        };
        let mut place_mm = -0.01;
        for t_us in 0..2_000_000u64 {
            assert!((profile.place_mm(t_us) - place_mm).abs() < 1e-9, "{t_us}");
            place_mm += speed(t_us as f64 + 0.5) * 1e-6;
        }
    }

    #[test]
    fn rounds_follow_each_other_without_a_seam() {
        let profile = Profile::new(&[knot(500, 20.0), knot(1_000_500, 40.0)], After::Repeat).unwrap();
        // 30 mm a round; before the first knot it is the end of the round before.
        assert_eq!(profile.place_mm(500), 0.0);
        assert!((profile.place_mm(0) + 40.0 * 500e-6).abs() < 1e-4);
        for rounds in [1u64, 2, 3600, 1_000_000] {
            assert!((profile.place_mm(500 + rounds * 1_000_000) - 30.0 * rounds as f64).abs() < 1e-6);
            let seam_us = 500 + rounds * 1_000_000;
            let steps = profile.place_mm(seam_us + 1) - profile.place_mm(seam_us - 1);
            assert!((steps - 60e-6).abs() < 1e-8, "{steps}");
        }
    }

    #[test]
    fn one_knot_is_a_constant_speed() {
        let profile = Profile::new(&[knot(0, 15.0)], After::Hold).unwrap();
        assert_eq!(profile.place_mm(3_600_000_000), 54_000.0);
    }

    #[test]
    fn what_is_wrong_is_named() {
        let flaw = |knots: &[Knot], after| Profile::new(knots, after).map_err(|error| std::format!("{error}"));
        for (knots, after, why) in [
            (&[][..], After::Hold, "needs a knot"),
            (&[knot(0, 1.0)][..], After::Repeat, "two to repeat"),
            (&[knot(0, 1.0); KNOTS_MAX + 1][..], After::Hold, "33 knots"),
            (&[knot(0, 1.0), knot(5, 1.0), knot(5, 1.0)][..], After::Hold, "knot 2 is not later"),
            (&[knot(0, 1.0), knot(1, f32::NAN)][..], After::Hold, "knot 1: a speed of NaN"),
            (&[knot(0, 2001.0)][..], After::Hold, "knot 0: a speed of 2001 mm/s"),
        ] {
            let error = flaw(knots, after).unwrap_err();
            assert!(error.contains(why), "{error}");
        }
    }

    #[test]
    fn any_time_has_a_place() {
        for profile in [hand(), Profile::new(&[knot(u32::MAX - 1, 1.0), knot(u32::MAX, 2.0)], After::Repeat).unwrap()] {
            for t_us in [0, 1, u64::MAX / 2, u64::MAX - 1, u64::MAX] {
                assert!(profile.place_mm(t_us).is_finite());
            }
        }
    }
}
