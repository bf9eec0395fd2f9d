//! Impulses: single values far off what is beside them. Squares weigh one of twenty standard
//! deviations as four hundred others, so where there are some they are replaced by the model and
//! the window is fitted anew.
//!
//! One step of a redescending estimator: P. J. Huber, E. M. Ronchetti, "Robust Statistics" (2nd
//! edition, 2009), section 4.8.

use crate::limits::CHANNELS_MAX;
use crate::phase_course::Course;
use crate::pieces::Data;
use crate::residual::{Model, padded};
use crate::solve::Solution;
use crate::source::Values;
use crate::tests::Sum;

/// Deviate of one value among some thousands.
const Z_IMPULSE: f32 = 4.8;
/// A step from a value to the one beside it has twice the noise: nearly the root of 2.
const STEP: f32 = 1.41;
/// Mean magnitude of white noise, in standard deviations: the root of 2 / pi.
const MEAN_MAGNITUDE: f32 = 0.797_884_6;
/// Most of a window's values that may be impulses.
const SHARE_MAX: f32 = 0.1;

/// The residuals of a window, piece after piece, each with those beside it.
fn residuals(
    data: &mut Data,
    model: &Model,
    visit: &mut dyn FnMut(&mut Data, usize, &[Values; 3]),
) {
    let mut last = [[0.0; CHANNELS_MAX]; 3];
    let (mut count, mut numbers) = (0u32, [0; 2]);
    for number in 0..data.pieces.count() {
        let Some(piece) = data.piece(number) else {
            continue;
        };
        last = [last[1], last[2], model.residual(&piece)];
        numbers = [numbers[1], number];
        count += 1;
        if count == 2 {
            // The first piece has one beside it, twice.
            visit(data, numbers[0], &[last[2], last[1], last[2]]);
        } else if count > 2 {
            visit(data, numbers[0], &last);
        }
    }
    if count > 1 {
        visit(data, numbers[1], &[last[1], last[2], last[1]]);
    }
}

/// Replaces what a solution leaves of single values; how many there are.
#[inline(never)]
pub fn replace(data: &mut Data, solution: &Solution, course: &Course) -> usize {
    let model = Model {
        shape: solution.shape,
        coefficients: padded(&solution.coefficients),
        motion: None,
        course: *course,
    };
    let width = data.width;
    // The first limit is by all magnitudes, which impulses raise; the second by those below it.
    let mut limits = [f32::INFINITY; CHANNELS_MAX];
    for round in 0..2 {
        let (mut magnitudes, mut most) = ([Sum::default(); CHANNELS_MAX], [0.0; CHANNELS_MAX]);
        residuals(data, &model, &mut |_, _, [_, values, _]| {
            for (k, value) in values.iter().enumerate().take(width) {
                most[k] = f32::max(most[k], value.abs());
                if value.abs() < limits[k] {
                    magnitudes[k].add(value.abs());
                }
            }
        });
        limits = magnitudes.map(|sum| Z_IMPULSE / MEAN_MAGNITUDE * sum.mean());
        if round == 0 && (0..width).all(|k| most[k] <= limits[k]) {
            return 0;
        }
    }
    let is_impulse = |k: usize, [before, values, after]: &[Values; 3]| {
        let sign = 1f32.copysign(values[k]);
        let least = ((values[k] - before[k]) * sign).min((values[k] - after[k]) * sign);
        values[k].abs() > limits[k] && least > STEP * limits[k] && limits[k] > 0.0
    };
    let (mut found, mut pieces) = (0, 0);
    residuals(data, &model, &mut |_, _, values| {
        pieces += 1;
        found += (0..width).filter(|k| is_impulse(*k, values)).count();
    });
    if found as f32 > SHARE_MAX * (pieces * width) as f32 {
        return 0;
    }
    if found > 0 {
        residuals(data, &model, &mut |data, number, values| {
            let mut replaced = data.pieces.get(number);
            for k in (0..width).filter(|k| is_impulse(*k, values)) {
                replaced[k] -= values[1][k];
            }
            data.pieces.set(number, &replaced);
        });
    }
    found
}
