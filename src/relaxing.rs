//! A baseline that relaxes as skin does after a contact, with a tone on it: the likeliest rate and frequency.
//!
//! An exponential is a part of a slow wave to the eye, and a slow wave with its overtones is an exponential with a
//! faster tone to a fit. What tells them apart is that all channels relax at one rate: so the rate is fitted
//! along with the frequency, and each model is judged by its likelihood less what its unknowns are worth.

use crate::descent::Problem;
use crate::fundamental::harmonics_below_nyquist;
use crate::levels::Levels;
use crate::nuisance::{Curve, Nuisances};
use crate::settings::TAXELS;
use crate::solve::{Shape, gain, rest};
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
    pub fn odds(&self, levels: &Levels, other: &Self) -> f32 {
        let more = other.unknowns as f32 - self.unknowns as f32;
        let paid = 0.5 * libm::logf(levels.frames as f32) * more * levels.channels();
        gain(levels, &self.rest, &other.rest, self.unknowns.max(other.unknowns)) - paid
    }

    /// Puts `other` in the place of `best` if it is likelier.
    pub fn keep(best: &mut Option<Self>, levels: &Levels, other: Self) {
        if best.as_ref().is_none_or(|best| best.odds(levels, &other) > 0.0) {
            *best = Some(other);
        }
    }
}

/// The likeliest tone of one or two harmonics next to `nu` on a baseline that relaxes; of no tone, the baseline alone.
/// The inner None says that they cannot be told apart. None if frames were overwritten.
#[inline(never)]
pub fn relaxing(problem: &mut Problem, nu: Option<f32>) -> Option<Option<Model>> {
    let (mut best, mut nu, mut rate) = (None, nu, RATE_FIRST);
    for left in (0..RATES + STEPS).rev() {
        let nuisances = Nuisances::new(problem.stretch, problem.levels, Curve::Relaxing(rate))?;
        let mut problem = Problem::new(problem.stretch, problem.levels, &nuisances, problem.work);
        if let Some(nu) = nu {
            problem.pass(nu, harmonics_below_nyquist(problem.stretch, nu, 2))?;
        }
        keep_if_likelier(&mut problem, nu, &mut best);
        if left >= STEPS {
            rate *= RATE_FACTOR;
        } else if let Some((faster, to)) = step(&mut problem, nu) {
            // Not `clamp`: its assertion would bring all of float formatting into the image.
            rate += faster.min(STEP.end() * rate).max(STEP.start() * rate);
            nu = nu.map(|_| to);
        } else {
            break;
        }
        if left == STEPS {
            let Some(Model { curve: Curve::Relaxing(of), .. }) = best else { return Some(None) };
            rate = of;
        }
        if !RATE.contains(&rate) {
            break;
        }
    }
    Some(best)
}

/// Keeps the problem's baseline, and a tone at `nu`, if they are the likeliest yet.
fn keep_if_likelier(problem: &mut Problem, nu: Option<f32>, best: &mut Option<Model>) {
    let Problem { stretch, levels, nuisances, work, .. } = problem;
    let harmonics = nu.map_or(0..=0, |nu| 1..=harmonics_below_nyquist(stretch, nu, 2));
    for harmonics in harmonics {
        let shape = Shape { harmonics, slope: true, nuisances: nuisances.count() - 1 };
        if let Some(rest) = rest(&work.sums, levels, nuisances, &shape) {
            let (nu, curve) = (nu.unwrap_or(0.0), nuisances.curve);
            Model::keep(best, levels, Model { nu, curve, rest, unknowns: shape.unknowns() });
        }
    }
}

/// A Gauss-Newton step from the latest pass: by how much the rate is too slow, and the frequency. None if the unknowns
/// cannot be told apart.
fn step(problem: &mut Problem, nu: Option<f32>) -> Option<(f32, f32)> {
    problem.nu = nu.unwrap_or(0.0);
    let harmonics = nu.is_some() as usize;
    let both = problem.nuisances.count();
    problem.step(Shape { harmonics, slope: true, nuisances: both - 1 })?;
    // Behind level, slope and an interferer's.
    let (factors, rest) = (problem.solution().unknowns[both], problem.solution().rest);
    problem.step(Shape { harmonics, slope: true, nuisances: both })?;
    // The channels' own wishes, by what each knows.
    let changes = &problem.solution().unknowns[both + 1];
    let (mut common, mut squares) = (0.0, 0.0);
    for c in 0..TAXELS {
        if rest[c] > 0.0 {
            common -= factors[c] * changes[c] / rest[c];
            squares += factors[c] * factors[c] / rest[c];
        }
    }
    (squares > 0.0).then(|| (common / squares, problem.solution().nu))
}
