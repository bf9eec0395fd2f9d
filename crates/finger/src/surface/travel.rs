//! From the lag between the columns to the spatial period, and with the frequency to speed and
//! direction.
//!
//! A wave of spatial period T along +x reaches the column in front `pitch_mm` / T turns late, less
//! the phase that the contact's ends cause ([`Array::edge_phase_rad`]). The phases give only the
//! fraction of a turn: n turns more or less look the same, and so does a wave in the other
//! direction that is late by the rest of a turn. So the periods from [`Array::period_least_mm`] to
//! [`Array::period_most_mm`] are searched in every possible direction, and an answer is reported
//! only if it is the only one. Each period between one pitch and two has a single answer, and so
//! has a longer one if the direction is known. A shorter one aliases: it has another answer among
//! the longer ones.
//!
//! Three other sources do not help. The overtones are late by whole multiples of the same turns.
//! Friction shifts the levels of facing piezoresistors by its direction. Under gratings as coarse
//! as the paper's, the ridges shift them more. Under finer ones the number of turns stays open. The
//! order in which the units feel the touch shows the stimulus's tilt, not its motion.

use crate::surface::lag::Lag;
use core::f32::consts::PI;
use ridgetone_proto::settings::Array;
use ridgetone_proto::telemetry::{Direction, Travel, TravelStatus};

/// Standard deviations on either side within which an answer is possible.
const POSSIBLE: f32 = 3.0;
/// The phases agree with the period by the host's speed if they differ by less than this and their
/// own uncertainty, turns: a speed that is off by 5 % changes a period of one pitch by so much.
const AGREE: f32 = 0.05;

/// A value and its standard deviation.
pub type Measured = (f32, f32);

/// Turns by which a wave of this period along +x is late at the column in front.
fn turns(array: &Array, period_mm: f32) -> f32 {
    array.pitch_mm / period_mm - array.edge_phase_rad / (2.0 * PI)
}

/// The lag, with the calibration's uncertainty added to its own.
fn calibrated(lag: Lag, array: &Array) -> Lag {
    let edge_sigma = array.edge_phase_sigma_rad / (2.0 * PI);
    Lag {
        sigma: libm::sqrtf(lag.sigma * lag.sigma + edge_sigma * edge_sigma),
        ..lag
    }
}

/// Travel by the phases alone, for a slide of unknown speed.
pub fn by_phases(lag: Option<Lag>, array: &Array, frequency_hz: Measured) -> Travel {
    let Some(lag) = lag else { return Travel::NONE };
    let lag = calibrated(lag, array);
    let margin = POSSIBLE * lag.sigma;
    let (least, most) = (
        turns(array, array.period_most_mm),
        turns(array, array.period_least_mm),
    );
    let (mut answers, mut answer) = (0, (0.0, Direction::Unknown));
    for (sign, direction, possible) in [
        (1.0, Direction::Forward, array.may_go_forward),
        (-1.0, Direction::Backward, array.may_go_backward),
    ] {
        if !possible {
            continue;
        }
        let late = sign * lag.turns;
        // The first whole number of turns that leads into the range.
        let first = late + libm::roundf(least - margin - late + 0.5);
        if first <= most + margin {
            answers += 1;
            answer = (first, direction);
        }
        answers += (first + 1.0 <= most + margin) as u32;
    }
    let (late, direction) = answer;
    match answers {
        0 => Travel {
            status: TravelStatus::OutOfRange,
            ..Travel::NONE
        },
        1 if late - margin >= least && late + margin <= most => {
            let period_mm = array.pitch_mm / (late + array.edge_phase_rad / (2.0 * PI));
            let period_sigma_mm = period_mm * period_mm / array.pitch_mm * lag.sigma;
            let (frequency_hz, sigma_hz) = frequency_hz;
            let speed_mm_s = frequency_hz * period_mm;
            // Frequency and phases at the window's centre do not depend on each other.
            let (of_frequency, of_period) = (sigma_hz * period_mm, period_sigma_mm * frequency_hz);
            Travel {
                status: TravelStatus::Unique,
                direction,
                spatial_period_mm: period_mm,
                spatial_period_sigma_mm: period_sigma_mm,
                speed_mm_s,
                speed_sigma_mm_s: libm::sqrtf(of_frequency * of_frequency + of_period * of_period),
            }
        }
        _ => Travel {
            status: TravelStatus::Ambiguous,
            ..Travel::NONE
        },
    }
}

/// Travel by the host's speed and the frequency. The phases check it and give the direction. `way`
/// is the direction of a wave along +x with increasing abscissa.
pub fn by_speed(
    lag: Option<Lag>,
    array: &Array,
    period_mm: Measured,
    speed_mm_s: f32,
    way: Direction,
) -> Travel {
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
            direction: way,
            ..travel
        },
        (false, true) => Travel {
            direction: way.reversed(),
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

    /// The lag of a wave, by the definition.
    fn lag_of(period_mm: f64, direction: Direction) -> Lag {
        let turns = 2.3 / period_mm - 0.25 / std::f64::consts::TAU;
        let turns = if direction == Direction::Forward {
            turns
        } else {
            -turns
        };
        Lag {
            turns: (turns - turns.round()) as f32,
            sigma: 1e-3,
        }
    }

    #[test]
    fn every_possible_period_comes_back_both_ways() {
        for direction in [Direction::Forward, Direction::Backward] {
            for period_mm in [2.35, 2.6, 3.1, 3.6, 4.1] {
                let travel = by_phases(Some(lag_of(period_mm, direction)), &ARRAY, TONE_HZ);
                assert_eq!(
                    (travel.status, travel.direction),
                    (TravelStatus::Unique, direction),
                    "{period_mm}"
                );
                assert!(
                    (f64::from(travel.spatial_period_mm) - period_mm).abs() < 1e-5,
                    "{travel:?}"
                );
                assert!(
                    (f64::from(travel.speed_mm_s) - 8.0 * period_mm).abs() < 1e-4,
                    "{travel:?}"
                );
                // d period = period^2 / pitch d turns; and in the speed the frequency's 0.1 %,
                // independently.
                let share = period_mm / 2.3 * 1e-3;
                assert!(
                    (f64::from(travel.spatial_period_sigma_mm) / period_mm / share - 1.0).abs()
                        < 1e-3,
                    "{travel:?}"
                );
                let both = share.hypot(1e-3) * 8.0 * period_mm;
                assert!(
                    (f64::from(travel.speed_sigma_mm_s) / both - 1.0).abs() < 1e-3,
                    "{travel:?}"
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
        let sigma_mm = 3.1 * 3.1 / 2.3 * 0.01 / core::f32::consts::TAU;
        assert!(
            (travel.spatial_period_sigma_mm / sigma_mm - 1.0).abs() < 1e-3,
            "{travel:?}"
        );
    }

    #[test]
    fn what_has_more_than_one_answer_is_ambiguous() {
        let verdict = |least: f32, most: f32, period_mm, direction| {
            let array = Array {
                period_least_mm: least,
                period_most_mm: most,
                ..ARRAY
            };
            by_phases(Some(lag_of(period_mm, direction)), &array, TONE_HZ).status
        };
        // A period shorter than the pitch aliases: one of 1.3 mm to the phase of one of 3.1 mm.
        assert_eq!(
            verdict(1.2, 4.2, 1.3, Direction::Forward),
            TravelStatus::Ambiguous
        );
        assert_eq!(
            verdict(1.2, 4.2, 3.1, Direction::Forward),
            TravelStatus::Ambiguous
        );
        // Two pitches and more: what is late one way is as much ahead the other.
        assert_eq!(
            verdict(2.3, 9.0, 3.1, Direction::Backward),
            TravelStatus::Ambiguous
        );
        assert_eq!(
            verdict(2.3, 9.0, 6.0, Direction::Forward),
            TravelStatus::Ambiguous
        );
        // Short ones are unique if no others are possible.
        assert_eq!(
            verdict(1.2, 1.4, 1.3, Direction::Backward),
            TravelStatus::Unique
        );
        assert_eq!(
            verdict(4.5, 9.0, 6.0, Direction::Backward),
            TravelStatus::Unique
        );
    }

    #[test]
    fn a_known_direction_leaves_one_answer_above_one_pitch() {
        let array = Array {
            period_most_mm: 20.0,
            may_go_backward: false,
            ..ARRAY
        };
        for period_mm in [2.4, 3.1, 4.6, 6.0, 9.0] {
            let travel = by_phases(Some(lag_of(period_mm, Direction::Forward)), &array, TONE_HZ);
            assert_eq!(
                (travel.status, travel.direction),
                (TravelStatus::Unique, Direction::Forward),
                "{period_mm}"
            );
            assert!(
                (f64::from(travel.spatial_period_mm) / period_mm - 1.0).abs() < 1e-5,
                "{travel:?}"
            );
        }
        let none = Array {
            may_go_forward: false,
            ..array
        };
        assert_eq!(
            by_phases(Some(lag_of(3.1, Direction::Forward)), &none, TONE_HZ).status,
            TravelStatus::OutOfRange
        );
    }

    #[test]
    fn an_answer_at_the_edge_is_ambiguous_and_one_beyond_is_out_of_range() {
        let array = Array {
            period_least_mm: 2.6,
            period_most_mm: 3.6,
            ..ARRAY
        };
        let verdict = |period_mm| {
            by_phases(Some(lag_of(period_mm, Direction::Forward)), &array, TONE_HZ).status
        };
        // Three standard deviations are 0.35 % of the period and more.
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
    fn a_lag_that_is_not_known_at_all_is_ambiguous() {
        let lag = Lag {
            turns: 0.3,
            sigma: 0.4,
        };
        assert_eq!(
            by_phases(Some(lag), &ARRAY, TONE_HZ).status,
            TravelStatus::Ambiguous
        );
    }

    #[test]
    fn the_hosts_speed_stands_and_the_phases_check_it() {
        let check = |lag, way| {
            let travel = by_speed(lag, &ARRAY, (3.1, 0.003), 24.8, way);
            let Travel {
                spatial_period_mm,
                spatial_period_sigma_mm,
                speed_mm_s,
                speed_sigma_mm_s,
                ..
            } = travel;
            let values = (
                spatial_period_mm,
                spatial_period_sigma_mm,
                speed_mm_s,
                speed_sigma_mm_s,
            );
            assert_eq!(values, (3.1, 0.003, 24.8, 0.0));
            (travel.status, travel.direction)
        };
        let (forward, backward) = (Direction::Forward, Direction::Backward);
        assert_eq!(
            check(Some(lag_of(3.1, forward)), forward),
            (TravelStatus::Given, forward)
        );
        assert_eq!(
            check(Some(lag_of(3.1, backward)), forward),
            (TravelStatus::Given, backward)
        );
        // By place on a surface that goes back, a wave along +x is one with decreasing place.
        assert_eq!(
            check(Some(lag_of(3.1, forward)), backward),
            (TravelStatus::Given, backward)
        );
        // The phases of 3.6 mm are 0.10 turns away; those of 3.2 mm are 0.02.
        assert_eq!(
            check(Some(lag_of(3.6, forward)), forward),
            (TravelStatus::Contradicted, Direction::Unknown)
        );
        assert_eq!(
            check(Some(lag_of(3.2, forward)), forward),
            (TravelStatus::Given, forward)
        );
        assert_eq!(
            check(None, forward),
            (TravelStatus::Given, Direction::Unknown)
        );
        let vague = Lag {
            sigma: 0.2,
            ..lag_of(3.1, forward)
        };
        assert_eq!(
            check(Some(vague), forward),
            (TravelStatus::Given, Direction::Unknown)
        );
    }
}
