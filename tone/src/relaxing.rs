//! A baseline that relaxes as skin does after a contact: the rate that all channels share, along with the frequency.
//!
//! An exponential is a part of a slow wave to the eye, and a slow wave with its overtones is an exponential with a
//! faster tone to a fit. What tells them apart is that all channels relax at one rate.

use crate::descent::{Problem, Work};
use crate::frame_span::FrameSpan;
use crate::levels::Levels;
use crate::model::{Model, expected_gain};
use crate::nuisance::{Curve, Nuisances};
use crate::solve::{Shape, gain};
use crate::source::CHANNELS_MAX;
use core::ops::RangeInclusive;

/// Rates there can be, per half window: slower ones are a parabola, and time constants below a thirtieth of a window a
/// step.
const RATE: RangeInclusive<f32> = 0.2..=15.0;
/// Parts of itself by which a rate changes in a step at the most, down and up.
const STEP: RangeInclusive<f32> = -0.3..=0.5;

/// What a model with a baseline that relaxes leaves where it is, and where a step of rate and frequency leads, with the
/// log-likelihood that is promised there; the inner None if the unknowns cannot be told apart. None if frames were
/// overwritten.
pub fn relax(
    span: &mut FrameSpan,
    levels: &Levels,
    work: &mut Work,
    model: &mut Model,
) -> Option<Option<(Model, f32)>> {
    let (Curve::Relaxing(rate), shape) = (model.curve, model.shape) else { return Some(None) };
    if !RATE.contains(&rate) {
        return Some(None);
    }
    let nuisances = Nuisances::new(span, levels, model.curve)?;
    let mut problem = Problem::new(span, levels, &nuisances, work);
    problem.nu = model.nu;
    if model.nu > 0.0 {
        problem.pass(model.nu, shape.harmonics)?;
    }
    if problem.step(shape).is_none() {
        return Some(None);
    }
    model.residual_sum_of_squares = problem.solution().residual_sum_of_squares;
    let Some((faster, mut nu)) = step(&mut problem, shape) else { return Some(None) };
    // Not `clamp`: its assertion would bring all of float formatting into the image.
    let faster = faster.min(STEP.end() * rate).max(STEP.start() * rate);
    let solution = problem.solution();
    let mut expected =
        gain(levels, &model.residual_sum_of_squares, &solution.residual_sum_of_squares, shape.unknowns() + 1);
    if model.nu > 0.0 {
        expected += expected_gain(levels, solution);
    } else {
        nu = 0.0;
    }
    Some(Some((Model { nu, curve: Curve::Relaxing(rate + faster), ..*model }, expected)))
}

/// A Gauss-Newton step from the latest solution, of `shape`: by how much the rate is too slow, and the frequency. None if
/// the unknowns cannot be told apart.
fn step(problem: &mut Problem, shape: Shape) -> Option<(f32, f32)> {
    // Behind level, slope and an interferer's.
    let of = 1 + shape.nuisances;
    let (factors, residual_sum_of_squares) =
        (*problem.solution().unknowns.get(of)?, problem.solution().residual_sum_of_squares);
    problem.step(Shape { nuisances: shape.nuisances + 1, ..shape })?;
    // The channels' own wishes, by what each knows.
    let changes = problem.solution().unknowns.get(of + 1)?;
    let (mut common, mut squares) = (0.0, 0.0);
    let mut left = problem.levels.usable;
    while left != 0 {
        let c = left.trailing_zeros() as usize % CHANNELS_MAX;
        left &= left - 1;
        common -= factors[c] * changes[c] / residual_sum_of_squares[c];
        squares += factors[c] * factors[c] / residual_sum_of_squares[c];
    }
    (squares > 0.0).then(|| (common / squares, problem.solution().nu))
}
