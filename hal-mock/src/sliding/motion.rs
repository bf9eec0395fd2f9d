//! Motion of the grating: the stimulator's steady slide with its imperfections, or a hand that
//! moves to and fro.

use core::f64::consts::{PI, TAU};

/// Deviations of a real stimulator from its nominal speed; [`IDEAL`](Self::IDEAL) has none.
#[derive(Clone, Copy, Debug, PartialEq, serde::Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Stimulator {
    /// Duration of the acceleration, and of the deceleration at the end, in seconds, >= 0. Default
    /// 0.02: plausible, not in the paper.
    pub ramp_s: f64,
    /// Error of the mean speed, in percent, -99 to 1000. Default 0.
    pub speed_error_percent: f64,
    /// Amplitude of the speed's ripple in percent of the speed, 0 to 99. Default 0. The seed sets
    /// the phase.
    pub ripple_percent: f64,
    /// Frequency of the ripple in hertz, > 0. Default 5.
    pub ripple_hz: f64,
    /// Maximum time by which the slide begins early or late, in seconds, 0 to `hold_before_s`.
    /// Default 0.
    pub onset_jitter_s: f64,
}

impl Stimulator {
    /// Moves at the exact speed from the start.
    pub const IDEAL: Self = Self {
        ramp_s: 0.0,
        speed_error_percent: 0.0,
        ripple_percent: 0.0,
        ripple_hz: 5.0,
        onset_jitter_s: 0.0,
    };
}

impl Default for Stimulator {
    fn default() -> Self {
        Self {
            ramp_s: 0.02,
            ..Self::IDEAL
        }
    }
}

/// A hand that moves to and fro, v(t) = `peak_mm_s` sin(2 pi `swing_hz` t). The defaults are from
/// Okamoto et al., *Transmission of Tactile Roughness through Master-slave Systems*, section IV.
#[derive(Clone, Copy, Debug, PartialEq, serde::Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Hand {
    /// Maximum speed in mm/s, > 0. Default 197.
    pub peak_mm_s: f64,
    /// Swings to and fro per second, in hertz, > 0. Default 1.07.
    pub swing_hz: f64,
    /// Number of swings, > 0. Default 5.
    pub swings: f64,
}

impl Default for Hand {
    fn default() -> Self {
        Self {
            peak_mm_s: 197.0,
            swing_hz: 1.07,
            swings: 5.0,
        }
    }
}

/// A motion, as functions of the time since it began.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Motion {
    /// Speed after the ramp in mm/s; duration of a ramp and of the whole motion, seconds; relative
    /// amplitude, angular frequency in 1/s and phase in radians of the ripple.
    Steady {
        speed_mm_s: f64,
        ramp_s: f64,
        planned_s: f64,
        ripple: f64,
        omega: f64,
        phase_rad: f64,
    },
    Hand(Hand),
}

impl Motion {
    /// Creates a slide of `slide_mm` at `speed_mm_s` with the stimulator's deviations. `random` is
    /// uniform in 0 to 1.
    pub(crate) fn steady(
        speed_mm_s: f64,
        slide_mm: f64,
        stimulator: Stimulator,
        random: f64,
    ) -> Self {
        let Stimulator {
            ramp_s,
            speed_error_percent,
            ripple_percent,
            ripple_hz,
            ..
        } = stimulator;
        let speed_mm_s = speed_mm_s * (1.0 + 0.01 * speed_error_percent);
        Self::Steady {
            speed_mm_s,
            ramp_s,
            planned_s: slide_mm / speed_mm_s + ramp_s,
            ripple: 0.01 * ripple_percent,
            omega: TAU * ripple_hz,
            phase_rad: TAU * random,
        }
    }

    /// Speed that determines the tone's frequency, in mm/s: without ramps and ripple; for a hand,
    /// the peak speed.
    pub(crate) fn tone_speed_mm_s(&self) -> f64 {
        match self {
            Self::Steady { speed_mm_s, .. } => *speed_mm_s,
            Self::Hand(hand) => hand.peak_mm_s,
        }
    }

    pub(crate) fn duration_s(&self) -> f64 {
        match *self {
            Self::Steady {
                planned_s,
                ripple: 0.0,
                ..
            } => planned_s,
            Self::Steady {
                planned_s,
                ripple,
                omega,
                ..
            } => {
                // The time with ripple increases monotonically and differs from the planned time by
                // no more than this.
                let max_s = 2.0 * ripple / omega;
                let (mut low_s, mut high_s) = ((planned_s - max_s).max(0.0), planned_s + max_s);
                for _ in 0..60 {
                    let middle_s = 0.5 * (low_s + high_s);
                    if self.rippled_s(middle_s) < planned_s {
                        low_s = middle_s
                    } else {
                        high_s = middle_s
                    }
                }
                high_s
            }
            Self::Hand(Hand {
                swing_hz, swings, ..
            }) => swings / swing_hz,
        }
    }

    /// Distance from the start in millimetres.
    pub(crate) fn place_mm(&self, since_s: f64) -> f64 {
        match *self {
            Self::Steady {
                speed_mm_s,
                ramp_s,
                planned_s,
                ..
            } => {
                let s = self.rippled_s(since_s).clamp(0.0, planned_s);
                // A half-cosine ramp lags behind full speed by half its length; both ramps are
                // equal.
                let ramped = |s: f64| {
                    if s >= ramp_s {
                        s - 0.5 * ramp_s
                    } else {
                        0.5 * (s - ramp_s / PI * libm::sin(PI * s / ramp_s))
                    }
                };
                let to_go_s = planned_s - s;
                let s = if to_go_s < ramp_s {
                    planned_s - ramp_s - ramped(to_go_s)
                } else {
                    ramped(s)
                };
                speed_mm_s * s
            }
            Self::Hand(Hand {
                peak_mm_s,
                swing_hz,
                ..
            }) => {
                let turns = swing_hz * since_s.clamp(0.0, self.duration_s());
                peak_mm_s / (TAU * swing_hz) * (1.0 - libm::cos(TAU * turns))
            }
        }
    }

    pub(crate) fn speed_mm_s(&self, since_s: f64) -> f64 {
        if since_s <= 0.0 || since_s >= self.duration_s() {
            return 0.0;
        }
        match *self {
            Self::Steady {
                speed_mm_s,
                ramp_s,
                planned_s,
                ripple,
                omega,
                phase_rad,
            } => {
                let s = self.rippled_s(since_s);
                let edge_s = s.min(planned_s - s);
                let ramp = if edge_s < ramp_s {
                    0.5 - 0.5 * libm::cos(PI * edge_s / ramp_s)
                } else {
                    1.0
                };
                speed_mm_s * ramp * (1.0 + ripple * libm::sin(omega * since_s + phase_rad))
            }
            Self::Hand(Hand {
                peak_mm_s,
                swing_hz,
                ..
            }) => peak_mm_s * libm::sin(TAU * swing_hz * since_s),
        }
    }

    /// Time of the planned motion, in seconds, that corresponds to `since_s` with ripple.
    fn rippled_s(&self, since_s: f64) -> f64 {
        match *self {
            Self::Steady {
                ripple,
                omega,
                phase_rad,
                ..
            } if ripple > 0.0 => {
                since_s
                    + ripple / omega
                        * (libm::cos(phase_rad) - libm::cos(omega * since_s + phase_rad))
            }
            _ => since_s,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn uneven() -> Motion {
        let stimulator = Stimulator {
            ramp_s: 0.05,
            speed_error_percent: 1.0,
            ripple_percent: 20.0,
            ..Stimulator::IDEAL
        };
        Motion::steady(30.0, 60.0, stimulator, 0.3)
    }

    #[test]
    fn the_speed_is_the_places_derivative() {
        for motion in [
            uneven(),
            Motion::Hand(Hand::default()),
            Motion::steady(15.0, 60.0, Stimulator::IDEAL, 0.0),
        ] {
            let duration_s = motion.duration_s();
            for k in 1..1000 {
                let (s, h) = (duration_s * f64::from(k) / 1000.0, 1e-6);
                let slope = (motion.place_mm(s + h) - motion.place_mm(s - h)) / (2.0 * h);
                assert!(
                    (slope - motion.speed_mm_s(s)).abs() < 1e-3,
                    "{motion:?} at {s} s: {slope}"
                );
            }
            assert_eq!((motion.place_mm(-1.0), motion.speed_mm_s(-1.0)), (0.0, 0.0));
            assert_eq!(
                motion.place_mm(duration_s),
                motion.place_mm(duration_s + 1.0)
            );
        }
    }

    #[test]
    fn a_slide_is_as_long_as_it_should_be() {
        assert!((uneven().place_mm(10.0) - 60.0).abs() < 1e-9);
        let ideal = Motion::steady(30.0, 60.0, Stimulator::IDEAL, 0.5);
        assert_eq!((ideal.duration_s(), ideal.place_mm(1.0)), (2.0, 30.0));
        // 2 s / 1.01 and a ramp; the ripple moves the end by up to 13 ms.
        assert!((uneven().duration_s() - 2.0 / 1.01 - 0.05).abs() < 0.0128);
    }

    #[test]
    fn a_hand_comes_back() {
        let hand = Motion::Hand(Hand::default());
        assert!(hand.place_mm(hand.duration_s()).abs() < 1e-9);
        // The farthest point is after half a swing: 2 * 197 / (2 pi 1.07) mm.
        assert!((hand.place_mm(0.5 / 1.07) - 58.604).abs() < 1e-3);
        assert!((hand.speed_mm_s(0.25 / 1.07) - 197.0).abs() < 1e-9);
        assert!((hand.duration_s() - 4.673).abs() < 1e-3);
    }
}
