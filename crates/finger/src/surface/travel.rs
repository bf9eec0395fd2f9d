//! Derives the spatial period from the lag between the columns and, with the frequency, speed and
//! direction.
//!
//! A wave of spatial period T along +x reaches the front column `pitch_mm` / T turns late, minus
//! the phase that the contact's ends cause ([`Array::edge_phase_rad`]). The phases give only the
//! fraction of a turn: whole turns more or less look the same, and so does a wave in the opposite
//! direction that is late by the rest of a turn. So the periods from [`Array::period_min_mm`] to
//! [`Array::period_max_mm`] are searched in every possible direction, and an answer is reported
//! only if it is the only one. A period between one and two pitches has a single answer, and so has
//! a longer one if the direction is known. A shorter one aliases to a longer one.
//!
//! Three other sources do not help. Overtones are late by multiples of the same turns. Friction
//! shifts the levels of facing piezoresistors according to its direction, but under gratings as
//! coarse as the paper's, the ridges shift them more, and under finer ones the number of turns
//! stays unknown. The order in which the units feel the touch shows the tilt of the surface, not
//! its motion.

use crate::surface::lag::Lag;
use core::f32::consts::PI;
use ridgetone_proto::settings::Array;
use ridgetone_proto::telemetry::{Direction, Travel, TravelStatus};

/// Deviation within which an answer is possible, standard deviations.
const POSSIBLE: f32 = 3.0;
/// Maximum difference (turns) between the phases and the period from the host's speed, beyond the
/// phases' uncertainty: the effect of a speed error of 5 % on a period of one pitch.
const AGREE: f32 = 0.05;

/// A value and its standard deviation.
pub type Measured = (f32, f32);

/// Turns by which a wave of this period along +x is late at the front column.
fn turns(array: &Array, period_mm: f32) -> f32 {
    array.pitch_mm / period_mm - array.edge_phase_rad / (2.0 * PI)
}

/// Adds the calibration's uncertainty to that of a lag.
fn calibrated(lag: Lag, array: &Array) -> Lag {
    let edge_sigma = array.edge_phase_sigma_rad / (2.0 * PI);
    Lag {
        sigma: ridgetone_tone::sqrt(lag.sigma * lag.sigma + edge_sigma * edge_sigma),
        ..lag
    }
}

/// Numbers of possible answers for a lag.
#[derive(Default)]
struct Answers {
    forward: u32,
    backward: u32,
    /// Lag of the last answer, turns.
    late: f32,
}

impl Answers {
    /// Finds the answers within the possible periods, extended by `margin` turns.
    fn new(array: &Array, lag_turns: f32, margin: f32) -> Self {
        let min = turns(array, array.period_max_mm) - margin;
        let max = turns(array, array.period_min_mm) + margin;
        let mut answers = Self::default();
        for (late, possible, count) in [
            (lag_turns, array.may_go_forward, &mut answers.forward),
            (-lag_turns, array.may_go_backward, &mut answers.backward),
        ] {
            // Add the lowest whole number of turns that leads into the range.
            let first = late + libm::roundf(min - late + 0.5);
            if possible && first <= max {
                *count = 1 + u32::from(first + 1.0 <= max);
                answers.late = first;
            }
        }
        answers
    }

    const fn count(&self) -> u32 {
        self.forward + self.backward
    }

    const fn direction(&self) -> Direction {
        match (self.forward, self.backward) {
            (_, 0) => Direction::Forward,
            (0, _) => Direction::Backward,
            _ => Direction::Unknown,
        }
    }
}

/// Derives travel from the phases alone, for a slide of unknown speed.
pub fn by_phases(lag: Option<Lag>, array: &Array, frequency_hz: Measured) -> Travel {
    let Some(lag) = lag else { return Travel::NONE };
    let sigma = calibrated(lag, array).sigma;
    // With the uncertainty of an uncalibrated array nearly every lag has several answers, so the
    // default constants choose one.
    let (status, margin) = if array.is_calibrated() {
        (TravelStatus::Unique, POSSIBLE * sigma)
    } else {
        (TravelStatus::Uncalibrated, POSSIBLE * lag.sigma)
    };
    let found = Answers::new(array, lag.turns, margin);
    let possible = Answers::new(array, lag.turns, POSSIBLE * sigma);
    let late = found.late;
    let is_within = late - margin >= turns(array, array.period_max_mm)
        && late + margin <= turns(array, array.period_min_mm);
    match found.count() {
        0 if possible.count() == 0 => Travel {
            status: TravelStatus::OutOfRange,
            ..Travel::NONE
        },
        1 if is_within => {
            let period_mm = array.pitch_mm / (late + array.edge_phase_rad / (2.0 * PI));
            let period_sigma_mm = period_mm * period_mm / array.pitch_mm * sigma;
            let (frequency_hz, sigma_hz) = frequency_hz;
            let speed_mm_s = frequency_hz * period_mm;
            // Frequency and phases at the window's centre are independent.
            let (of_frequency, of_period) = (sigma_hz * period_mm, period_sigma_mm * frequency_hz);
            Travel {
                status,
                direction: possible.direction(),
                spatial_period_mm: period_mm,
                spatial_period_sigma_mm: period_sigma_mm,
                speed_mm_s,
                speed_sigma_mm_s: ridgetone_tone::sqrt(
                    of_frequency * of_frequency + of_period * of_period,
                ),
            }
        }
        _ => Travel {
            status: TravelStatus::Ambiguous,
            ..Travel::NONE
        },
    }
}

/// Derives travel from the host's speed and the frequency. The phases verify it and give the
/// direction.
pub fn by_speed(lag: Option<Lag>, array: &Array, period_mm: Measured, speed_mm_s: f32) -> Travel {
    let travel = Travel {
        status: TravelStatus::Given,
        direction: Direction::Unknown,
        spatial_period_mm: period_mm.0,
        spatial_period_sigma_mm: period_mm.1,
        speed_mm_s,
        speed_sigma_mm_s: 0.0,
    };
    let Some(lag) = lag else { return travel };
    let lag = calibrated(lag, array);
    let expected = turns(array, period_mm.0);
    let agrees = |late: f32| {
        let off = late - expected;
        (off - libm::roundf(off)).abs() <= AGREE + POSSIBLE * lag.sigma
    };
    match (agrees(lag.turns), agrees(-lag.turns)) {
        (true, true) => travel,
        (true, false) => Travel {
            direction: Direction::Forward,
            ..travel
        },
        (false, true) => Travel {
            direction: Direction::Backward,
            ..travel
        },
        (false, false) => Travel {
            status: TravelStatus::Contradicted,
            ..travel
        },
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    extern crate std;

    const ARRAY: Array = Array {
        pitch_mm: 2.3,
        edge_phase_rad: 0.25,
        edge_phase_sigma_rad: 0.0,
        ..Array::DEFAULT
    };
    const TONE_HZ: Measured = (8.0, 0.008);

    /// Lag of a wave, from the definition.
    fn lag_of(period_mm: f64, direction: Direction) -> Lag {
        let way = if direction == Direction::Forward {
            1.0
        } else {
            -1.0
        };
        let turns = way * (2.3 / period_mm - 0.25 / std::f64::consts::TAU);
        Lag {
            turns: (turns - turns.round()) as f32,
            sigma: 1e-3,
        }
    }

    /// Asserts that a travel is unique and has this direction and period.
    #[track_caller]
    fn assert_unique(travel: &Travel, direction: Direction, period_mm: f64) {
        assert_eq!(
            (travel.status, travel.direction),
            (TravelStatus::Unique, direction)
        );
        assert_near(travel.spatial_period_mm, period_mm, 2e-6);
    }

    #[track_caller]
    fn assert_near(found: f32, expected: f64, fraction: f64) {
        assert!(
            (f64::from(found) / expected - 1.0).abs() < fraction,
            "{found} for {expected}"
        );
    }

    #[test]
    fn every_possible_period_comes_back_both_ways() {
        for direction in [Direction::Forward, Direction::Backward] {
            for period_mm in [2.35, 2.6, 3.1, 3.6, 4.1] {
                let travel = by_phases(Some(lag_of(period_mm, direction)), &ARRAY, TONE_HZ);
                assert_unique(&travel, direction, period_mm);
                assert_near(travel.speed_mm_s, 8.0 * period_mm, 3e-6);
                // d period = period^2 / pitch d turns. The speed also has the independent 0.1 % of
                // the frequency.
                let fraction = period_mm / 2.3 * 1e-3;
                assert_near(travel.spatial_period_sigma_mm, period_mm * fraction, 1e-3);
                assert_near(
                    travel.speed_sigma_mm_s,
                    fraction.hypot(1e-3) * 8.0 * period_mm,
                    1e-3,
                );
            }
        }
    }

    #[test]
    fn the_calibrations_uncertainty_counts() {
        let array = Array {
            edge_phase_sigma_rad: 0.01,
            ..ARRAY
        };
        let lag = Lag {
            sigma: 0.0,
            ..lag_of(3.1, Direction::Forward)
        };
        let travel = by_phases(Some(lag), &array, TONE_HZ);
        let sigma_mm = 3.1 * 3.1 / 2.3 * 0.01 / std::f64::consts::TAU;
        assert_near(travel.spatial_period_sigma_mm, sigma_mm, 1e-3);
    }

    /// Tests plane waves along units with a true pitch of 2.3 mm. With the default constants the
    /// results are 4 to 8 % off, which the uncertainty covers.
    #[test]
    fn an_array_that_was_never_calibrated_says_so() {
        let array = Array::DEFAULT;
        assert!(!array.is_calibrated() && ARRAY.is_calibrated());
        for period_mm in [2.6, 3.1, 3.6, 4.1] {
            let turns = 2.3 / period_mm;
            let lag = Lag {
                turns: (turns - f64::round(turns)) as f32,
                sigma: 1e-4,
            };
            let travel = by_phases(Some(lag), &array, TONE_HZ);
            assert_eq!(travel.status, TravelStatus::Uncalibrated, "{period_mm}");
            assert!(travel.direction != Direction::Backward, "{travel:?}");
            let off = (f64::from(travel.spatial_period_mm) - period_mm).abs();
            let sigma = f64::from(travel.spatial_period_sigma_mm);
            assert!(off > 0.03 * period_mm && off < 2.0 * sigma, "{travel:?}");
            assert!(travel.is_known());
        }
        // The constants do not decide between 3.6 mm one way and 4.2 mm the other.
        let lag = lag_of(3.9, Direction::Forward);
        let travel = by_phases(Some(lag), &array, TONE_HZ);
        assert_eq!(travel.direction, Direction::Unknown, "{travel:?}");
        let forward = Array {
            may_go_backward: false,
            ..array
        };
        let travel = by_phases(Some(lag), &forward, TONE_HZ);
        assert_eq!(travel.direction, Direction::Forward, "{travel:?}");
    }

    #[test]
    fn what_has_more_than_one_answer_is_ambiguous() {
        use Direction::{Backward, Forward};
        use TravelStatus::{Ambiguous, Unique};
        for (min, max, period_mm, direction, expected) in [
            // A period shorter than the pitch aliases: 1.3 mm has the same phase as 3.1 mm.
            (1.2, 4.2, 1.3, Forward, Ambiguous),
            (1.2, 4.2, 3.1, Forward, Ambiguous),
            // Beyond two pitches, a lag one way is a lead the other way.
            (2.3, 9.0, 3.1, Backward, Ambiguous),
            (2.3, 9.0, 6.0, Forward, Ambiguous),
            // Short periods are unique if no others are possible.
            (1.2, 1.4, 1.3, Backward, Unique),
            (4.5, 9.0, 6.0, Backward, Unique),
        ] {
            let array = Array {
                period_min_mm: min,
                period_max_mm: max,
                ..ARRAY
            };
            let found = by_phases(Some(lag_of(period_mm, direction)), &array, TONE_HZ);
            assert_eq!(
                found.status, expected,
                "{period_mm} mm of {min} to {max} mm"
            );
        }
        // The lag is too uncertain.
        let lag = Lag {
            turns: 0.3,
            sigma: 0.4,
        };
        assert_eq!(by_phases(Some(lag), &ARRAY, TONE_HZ).status, Ambiguous);
    }

    #[test]
    fn a_known_direction_leaves_one_answer_above_one_pitch() {
        let forward = Direction::Forward;
        let array = Array {
            period_max_mm: 20.0,
            may_go_backward: false,
            ..ARRAY
        };
        for period_mm in [2.4, 3.1, 4.6, 6.0, 9.0] {
            let travel = by_phases(Some(lag_of(period_mm, forward)), &array, TONE_HZ);
            assert_unique(&travel, forward, period_mm);
        }
        let none = Array {
            may_go_forward: false,
            ..array
        };
        let travel = by_phases(Some(lag_of(3.1, forward)), &none, TONE_HZ);
        assert_eq!(travel.status, TravelStatus::OutOfRange);
    }

    #[test]
    fn an_answer_at_the_edge_is_ambiguous_and_one_beyond_is_out_of_range() {
        let array = Array {
            period_min_mm: 2.6,
            period_max_mm: 3.6,
            ..ARRAY
        };
        let verdict = |period_mm| {
            by_phases(Some(lag_of(period_mm, Direction::Forward)), &array, TONE_HZ).status
        };
        // Three standard deviations are at least 0.35 % of the period.
        for (period_mm, expected) in [
            (2.57, TravelStatus::OutOfRange),
            (2.597, TravelStatus::Ambiguous),
            (2.603, TravelStatus::Ambiguous),
            (2.63, TravelStatus::Unique),
            (3.57, TravelStatus::Unique),
            (3.59, TravelStatus::Ambiguous),
            (3.61, TravelStatus::Ambiguous),
            (3.63, TravelStatus::OutOfRange),
        ] {
            assert_eq!(verdict(period_mm), expected, "{period_mm}");
        }
        assert_eq!(by_phases(None, &array, TONE_HZ), Travel::NONE);
    }

    #[test]
    fn the_hosts_speed_stands_and_the_phases_check_it() {
        use Direction::{Backward, Forward, Unknown};
        use TravelStatus::{Contradicted, Given};
        let vague = Lag {
            sigma: 0.2,
            ..lag_of(3.1, Forward)
        };
        for (lag, status, direction) in [
            (Some(lag_of(3.1, Forward)), Given, Forward),
            (Some(lag_of(3.1, Backward)), Given, Backward),
            // The phases for 3.6 mm are 0.10 turns off, and for 3.2 mm 0.02 turns.
            (Some(lag_of(3.6, Forward)), Contradicted, Unknown),
            (Some(lag_of(3.2, Forward)), Given, Forward),
            (None, Given, Unknown),
            (Some(vague), Given, Unknown),
        ] {
            let expected = Travel {
                status,
                direction,
                spatial_period_mm: 3.1,
                spatial_period_sigma_mm: 0.003,
                speed_mm_s: 24.8,
                speed_sigma_mm_s: 0.0,
            };
            assert_eq!(
                by_speed(lag, &ARRAY, (3.1, 0.003), 24.8),
                expected,
                "{lag:?}"
            );
        }
    }
}
