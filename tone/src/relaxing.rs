//! A baseline that relaxes exponentially: its rate, which all channels share, along with the frequency.
//!
//! An exponential resembles a part of a slow wave, and to a fit a slow wave with overtones resembles an exponential with a
//! faster tone. The common rate of all channels separates them.

use crate::descent::Problem;
use crate::equations::Shape;
use crate::likelihood::{expected_gain, gain};
use crate::limits::CHANNELS_MAX;
use crate::model::Model;
use crate::nuisance::Curve;
use crate::source::Overwritten;
use crate::window::Window;
use core::ops::RangeInclusive;

/// Rates that are fitted, per half window: a slower one is a parabola, and a time constant below a thirtieth of a window a
/// step.
const RATES: RangeInclusive<f32> = 0.2..=15.0;
/// Largest change of a rate in a step, as a share of it, down and up.
const STEP_SHARES: RangeInclusive<f32> = -0.3..=0.5;

/// Finds the residuals of a model with a baseline that relaxes, and where a step of rate and frequency leads, with the
/// log-likelihood that is expected there; None if the equations are singular.
pub fn relax(window: &mut Window, model: &mut Model) -> Result<Option<(Model, f32)>, Overwritten> {
    let (Curve::Relaxing(rate), shape) = (model.curve, model.shape) else { return Ok(None) };
    if !RATES.contains(&rate) {
        return Ok(None);
    }
    let nuisances = window.nuisances(model.curve)?;
    let mut problem = Problem::new(window, &nuisances);
    problem.nu = model.nu;
    if model.nu > 0.0 {
        problem.pass(model.nu, shape.harmonics)?;
    }
    if problem.step(shape).is_none() {
        return Ok(None);
    }
    model.residual_sum_of_squares = problem.solution().residual_sum_of_squares;
    let Some((faster, mut nu)) = step(&mut problem, shape) else { return Ok(None) };
    // Not `clamp`: its assertion would bring all of float formatting into the image.
    let faster = faster.min(STEP_SHARES.end() * rate).max(STEP_SHARES.start() * rate);
    let (solution, levels) = (problem.solution(), problem.window.levels);
    let (before, after) = (&model.residual_sum_of_squares, &solution.residual_sum_of_squares);
    let mut expected = gain(levels, before, after, shape.unknowns() + 1);
    if model.nu > 0.0 {
        expected += expected_gain(levels, solution);
    } else {
        nu = 0.0;
    }
    Ok(Some((Model { nu, curve: Curve::Relaxing(rate + faster), ..*model }, expected)))
}

/// A Gauss-Newton step from the latest solution, of `shape`: the change of the rate, and the new frequency. None if the
/// equations are singular.
fn step(problem: &mut Problem, shape: Shape) -> Option<(f32, f32)> {
    // Behind level, slope and an interferer's.
    let of = 1 + shape.nuisances;
    let (factors, residual_sum_of_squares) =
        (*problem.solution().unknowns.get(of)?, problem.solution().residual_sum_of_squares);
    problem.step(Shape { nuisances: shape.nuisances + 1, ..shape })?;
    // The channels' own changes, weighted by their information.
    let changes = problem.solution().unknowns.get(of + 1)?;
    let (mut common, mut squares) = (0.0, 0.0);
    let mut remaining = problem.window.levels.usable;
    while remaining != 0 {
        let c = remaining.trailing_zeros() as usize % CHANNELS_MAX;
        remaining &= remaining - 1;
        common -= factors[c] * changes[c] / residual_sum_of_squares[c];
        squares += factors[c] * factors[c] / residual_sum_of_squares[c];
    }
    (squares > 0.0).then(|| (common / squares, problem.solution().nu))
}
