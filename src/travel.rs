//! From the lag between the columns to the spatial period, and with the frequency to speed and direction.
//!
//! A wave of spatial period T that travels along +x comes to the column in front `pitch_mm` / T turns late, less the
//! turns by which the contact's ends pull the columns together ([`Array::pull_rad`]). Of that the phases tell the
//! fraction of a turn: n turns more or less look the same, and so does a wave the other way that is late by what is
//! left of a turn. So an answer is sought among the periods of [`Array::period_least_mm`] to
//! [`Array::period_most_mm`] in both directions, and told only if there is but one. Periods between one pitch and two
//! have a single answer each; a shorter one, which aliases, has another among the longer ones.

use crate::lag::Lag;
use crate::settings::Array;
use crate::telemetry::{Direction, Travel, Verdict};
use core::f32::consts::PI;

/// Standard deviations on either side within which an answer is possible.
const POSSIBLE: f32 = 3.0;
/// How far the phases may be from a period told by the host and still agree with it, turns, besides their own
/// uncertainty: what a speed that is off by 5 % does to a period of one pitch.
const AGREE: f32 = 0.05;

/// A value and its standard deviation.
pub type Measured = (f32, f32);

/// Turns by which the column in front is late behind a wave of one period along +x.
fn turns(array: &Array, period_mm: f32) -> f32 {
    array.pitch_mm / period_mm - array.pull_rad / (2.0 * PI)
}

/// The lag with the uncertainty of the calibration in it.
fn calibrated(lag: Lag, array: &Array) -> Lag {
    let pull_sigma = array.pull_sigma_rad / (2.0 * PI);
    Lag { sigma: libm::sqrtf(lag.sigma * lag.sigma + pull_sigma * pull_sigma), ..lag }
}

/// What the phases alone tell. `frequency_hz` of a slide whose speed nobody told.
#[inline(never)]
pub fn found(lag: Option<Lag>, array: &Array, frequency_hz: Measured) -> Travel {
    let Some(lag) = lag else { return Travel::NONE };
    let lag = calibrated(lag, array);
    let margin = POSSIBLE * lag.sigma;
    let (least, most) = (turns(array, array.period_most_mm), turns(array, array.period_least_mm));
    let (mut answers, mut answer) = (0, (0.0, Direction::Unknown));
    for (sign, direction) in [(1.0, Direction::Forward), (-1.0, Direction::Backward)] {
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
        0 => Travel { verdict: Verdict::OutOfRange, ..Travel::NONE },
        1 if late - margin >= least && late + margin <= most => {
            let period_mm = array.pitch_mm / (late + array.pull_rad / (2.0 * PI));
            let period_sigma_mm = period_mm * period_mm / array.pitch_mm * lag.sigma;
            let (frequency_hz, sigma_hz) = frequency_hz;
            let speed_mm_s = frequency_hz * period_mm;
            // Frequency and phases at the window's centre do not depend on each other.
            let (of_frequency, of_period) = (sigma_hz * period_mm, period_sigma_mm * frequency_hz);
            Travel {
                verdict: Verdict::Unique,
                direction,
                spatial_period_mm: period_mm,
                spatial_period_sigma_mm: period_sigma_mm,
                speed_mm_s,
                speed_sigma_mm_s: libm::sqrtf(of_frequency * of_frequency + of_period * of_period),
            }
        }
        _ => Travel { verdict: Verdict::Ambiguous, ..Travel::NONE },
    }
}

/// What the host's speed and the frequency tell; the phases give the direction and are a check. `way` is that of a
/// wave that travels along +x with increasing abscissa.
#[inline(never)]
pub fn told(lag: Option<Lag>, array: &Array, period_mm: Measured, speed_mm_s: f32, way: Direction) -> Travel {
    let travel = Travel {
        verdict: Verdict::Told,
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
        (true, false) => Travel { direction: way, ..travel },
        (false, true) => Travel { direction: way.reversed(), ..travel },
        (false, false) => Travel { verdict: Verdict::Contradicted, ..travel },
    }
}
