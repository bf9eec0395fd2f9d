//! A baseline that relaxes as skin does after a contact, with a tone on it: the likeliest rate and frequency.
//!
//! An exponential is a part of a slow wave to the eye, and a slow wave with its overtones is an exponential with a
//! faster tone to a fit. What tells them apart is that all channels relax at one rate: so the rate is fitted
//! along with the frequency, and each model is judged by its likelihood less what its unknowns are worth.

use crate::chance::ln;
use crate::descent::Problem;
use crate::fundamental::harmonics_below_nyquist;
use crate::levels::Levels;
use crate::nuisance::{Curve, Nuisances};
use crate::settings::TAXELS;
use crate::solve::{Shape, gain};
use crate::window::Values;
use core::ops::RangeInclusive;

/// Rates of a baseline that are tried first, per half window: time constants of a half of the window, and less by
/// the factor from one to the next.
const RATE_FIRST: f32 = 1.0;
const RATE_FACTOR: f32 = 2.0;
const RATES: usize = 4;
/// Gauss-Newton steps of rate and frequency from the best of them.
const STEPS: usize = 4;
/// Rates there can be: slower ones are a parabola, and time constants below a thirtieth of a window a step.
const RATE: RangeInclusive<f32> = 0.2..=15.0;
/// Parts of itself by which a rate changes in a step at the most, down and up.
const STEP: RangeInclusive<f32> = -0.3..=0.5;

/// What a tone with its baseline leaves of the channels.
#[derive(Clone, Copy, Debug)]
pub struct Model {
    /// Cycles per half window ([`crate::stretch`]); 0 if there is no tone.
    pub nu: f32,
    /// Curve of the baseline.
    pub curve: Curve,
    /// Residual sums of squares.
    pub rest: Values,
    /// Unknowns of a channel.
    pub unknowns: usize,
}

impl Model {
    /// Log-likelihood by which `other` is likelier than this one, where each unknown has to pay for itself (Schwarz's
    /// criterion).
    #[inline(never)]
    pub fn odds(&self, levels: &Levels, other: &Self) -> f32 {
        let more = other.unknowns as f32 - self.unknowns as f32;
        let paid = 0.5 * ln(levels.frames as f32) * more * levels.channels();
        gain(levels, &self.rest, &other.rest, self.unknowns.max(other.unknowns)) - paid
    }

    /// Puts `other` in the place of `best` if it is likelier.
    #[inline(never)]
    pub fn keep(best: &mut Option<Self>, levels: &Levels, other: Self) {
        if best.as_ref().is_none_or(|best| best.odds(levels, &other) > 0.0) {
            *best = Some(other);
        }
    }
}

/// The likeliest tone of one or two harmonics next to `nu` on a baseline that relaxes, or at zero that baseline alone.
/// The inner None says that they cannot be told apart. None if frames were overwritten.
#[inline(never)]
pub fn relaxing(problem: &mut Problem, nu: f32) -> Option<Option<Model>> {
    let (mut best, mut nu, mut rate): (Option<Model>, _, _) = (None, nu, RATE_FIRST);
    for tries in 1..=RATES + STEPS {
        let nuisances = Nuisances::new(problem.stretch, problem.levels, Curve::Relaxing(rate))?;
        let mut problem = Problem::new(problem.stretch, problem.levels, &nuisances, problem.work);
        let harmonics = if nu > 0.0 { 1..=harmonics_below_nyquist(problem.stretch, nu, 2) } else { 0..=0 };
        problem.nu = nu;
        if nu > 0.0 {
            problem.pass(nu, *harmonics.end())?;
        }
        let mut shape = Shape { harmonics: 0, slope: true, nuisances: nuisances.count() - 1 };
        for harmonics in harmonics {
            shape.harmonics = harmonics;
            if problem.step(shape).is_none() {
                return Some(best);
            }
            let model = Model { nu, curve: nuisances.curve, rest: problem.solution().rest, unknowns: shape.unknowns() };
            Model::keep(&mut best, problem.levels, model);
        }
        if tries < RATES {
            rate *= RATE_FACTOR;
        } else if tries == RATES {
            if let Some(Model { curve: Curve::Relaxing(of), .. }) = best {
                rate = of;
            }
        } else if tries < RATES + STEPS {
            let Some((faster, to)) = step(&mut problem, shape) else { return Some(best) };
            // Not `clamp`: its assertion would bring all of float formatting into the image.
            rate += faster.min(STEP.end() * rate).max(STEP.start() * rate);
            if nu > 0.0 {
                nu = to;
            }
        }
        if !RATE.contains(&rate) {
            break;
        }
    }
    Some(best)
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
