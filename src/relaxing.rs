//! A baseline that relaxes as skin does after a contact: the rate that all channels share, along with the frequency.
//!
//! An exponential is a part of a slow wave to the eye, and a slow wave with its overtones is an exponential with a
//! faster tone to a fit. What tells them apart is that all channels relax at one rate.

use crate::descent::{Problem, Work};
use crate::levels::Levels;
use crate::model::Model;
use crate::nuisance::{Curve, Nuisances};
use crate::settings::TAXELS;
use crate::solve::Shape;
use crate::stretch::Stretch;
use core::ops::RangeInclusive;

/// Gauss-Newton steps of rate and frequency.
const STEPS: usize = 5;
/// Rates there can be, per half window: slower ones are a parabola, and time constants below a thirtieth of a window a
/// step.
const RATE: RangeInclusive<f32> = 0.2..=15.0;
/// Parts of itself by which a rate changes in a step at the most, down and up.
const STEP: RangeInclusive<f32> = -0.3..=0.5;

/// Moves a model with a baseline that relaxes to the likeliest rate and frequency next to its own. None if frames were
/// overwritten.
pub fn refine(stretch: &mut Stretch, levels: &Levels, work: &mut Work, model: &mut Model) -> Option<()> {
    let (mut nu, shape) = (model.nu, model.shape);
    let Curve::Relaxing(mut rate) = model.curve else { return Some(()) };
    for step_number in 0..STEPS {
        let nuisances = Nuisances::new(stretch, levels, Curve::Relaxing(rate))?;
        let mut problem = Problem::new(stretch, levels, &nuisances, work);
        problem.nu = nu;
        if nu > 0.0 {
            problem.pass(nu, shape.harmonics)?;
        }
        if problem.step(shape).is_none() {
            break;
        }
        let here = Model { nu, curve: nuisances.curve, rest: problem.solution().rest, shape };
        if step_number == 0 || here.is_likelier_than(model, levels) {
            *model = here;
        }
        let Some((faster, to)) = step(&mut problem, shape) else { break };
        // Not `clamp`: its assertion would bring all of float formatting into the image.
        rate += faster.min(STEP.end() * rate).max(STEP.start() * rate);
        if nu > 0.0 {
            nu = to;
        }
        if !RATE.contains(&rate) {
            break;
        }
    }
    Some(())
}

/// A Gauss-Newton step from the latest solution, of `shape`: by how much the rate is too slow, and the frequency. None if
/// the unknowns cannot be told apart.
fn step(problem: &mut Problem, shape: Shape) -> Option<(f32, f32)> {
    // Behind level, slope and an interferer's.
    let of = 1 + shape.nuisances;
    let (factors, rest) = (problem.solution().unknowns[of], problem.solution().rest);
    problem.step(Shape { nuisances: shape.nuisances + 1, ..shape })?;
    // The channels' own wishes, by what each knows.
    let changes = &problem.solution().unknowns[of + 1];
    let (mut common, mut squares) = (0.0, 0.0);
    let mut left = problem.levels.usable;
    while left != 0 {
        let c = left.trailing_zeros() as usize % TAXELS;
        left &= left - 1;
        common -= factors[c] * changes[c] / rest[c];
        squares += factors[c] * factors[c] / rest[c];
    }
    (squares > 0.0).then(|| (common / squares, problem.solution().nu))
}
