//! Few cycles, or a drift: what a window holds below four cycles.
//!
//! Lines of few cycles lean on each other too much for a periodogram to tell them, and a skin that relaxes
//! looks like a part of a wave. So the low lines are compared by exact likelihoods, with each other and with
//! drifts.

use crate::chance::{ONE_IN_A_THOUSAND, gain_by_chance, gain_by_search};
use crate::descent::{CYCLES_FOR_SLOPE, CYCLES_MIN, LINE_CLOSE, Problem};
use crate::fundamental::harmonics_below_nyquist;
use crate::nuisance::{CURVE, Curve, Nuisances};
use crate::search::{LINE_STEPS, Line};
use crate::solve::{Shape, gain, rest};
use crate::spectrum::strongest;
use crate::window::Values;

/// Slowest rate of a relaxing baseline that is tried, per half window: a time constant of a third of the window.
const RELAXING_LEAST: f32 = 1.5;
/// From one rate to the next.
const RELAXING_FACTOR: f32 = 1.5;
/// How many of them: down to a time constant of a thirtieth of the window.
const RELAXING_RATES: usize = 7;
/// How often the factor about the best one is reduced to its root.
const RELAXING_CLOSER: usize = 3;
/// Gain over a drift by which a line of few cycles is a line and not that curve.
const NO_CURVE: f32 = 8.0;

/// Room for transforms, and the channels to be transformed, bit k for taxel k.
pub struct Place<'a> {
    /// Which channels.
    pub channels: u16,
    /// Room for transforms.
    pub points: &'a mut [f32],
    /// For half of one.
    pub power: &'a mut [f32],
}

/// The strongest line where the periodogram's `peak` is a low one, or where there is nothing but a drift. The
/// inner None says that there is none. The problem's nuisances have a bent curve. None if frames were
/// overwritten.
pub fn few_cycles(problem: &mut Problem, peak: f32, place: Place) -> Option<Option<Line>> {
    let levels = problem.levels;
    let straight = problem.nuisances.count() - CURVE;
    let nu = strongest_low(problem, peak, straight)?;
    let shape = Shape { harmonics: 1, slope: 2.0 * nu >= CYCLES_FOR_SLOPE, nuisances: straight };
    let found = problem.descend(nu, shape, LINE_STEPS, LINE_CLOSE)?;
    let nu = problem.solution().nu;
    let line = Line { nu, slope: shape.slope, curve: Curve::None, suspects: [true; 2] };
    let Some(drift) = best_drift(problem)? else { return Some(None) };
    if found && is_wave(problem, nu, &drift, straight)? {
        return Some(Some(line));
    }
    // It is a drift, but there may be a tone on it.
    let Some((faster, left)) = on_a_drift(problem, place)? else { return Some(None) };
    let gained = gain(levels, &drift, &left, shape.unknowns() + CURVE);
    Some((gained > gain_by_search(2.0 * levels.channels(), levels.frames)).then_some(faster))
}

/// The strongest line on a bent baseline, and what both leave.
fn on_a_drift(problem: &mut Problem, place: Place) -> Option<Option<(Line, Values)>> {
    let Place { channels, points, power } = place;
    let Problem { stretch, levels, nuisances, .. } = problem;
    let count = nuisances.count();
    let peak = strongest(stretch, levels, nuisances, CYCLES_FOR_SLOPE, channels, points, power)?;
    let Some(peak) = peak else { return Some(None) };
    let shape = Shape { harmonics: 1, slope: true, nuisances: count };
    if !problem.descend(peak, shape, LINE_STEPS, LINE_CLOSE)? {
        return Some(None);
    }
    let nu = problem.solution().nu;
    let line = Line { nu, slope: true, curve: Curve::Bent, suspects: [true; 2] };
    // Below that the line is what a bent curve leaves of a steeper one.
    Some((2.0 * nu >= CYCLES_FOR_SLOPE).then_some((line, problem.solution().rest)))
}

/// What the likeliest drift leaves of the channels, if there were no tone. The inner None says that there is not enough
/// to tell.
fn best_drift(problem: &mut Problem) -> Option<Option<Values>> {
    let levels = problem.levels;
    let Some((_, mut best)) = problem.nuisances.baseline(levels, problem.nuisances.count()) else { return Some(None) };
    // Rates by the factor from one to the next: first apart, then ever closer about the best.
    let (mut at, mut factor) = (RELAXING_LEAST, RELAXING_FACTOR);
    let mut rate = at;
    for _ in 0..RELAXING_RATES {
        if relax(problem, rate, &mut best)? {
            at = rate;
        }
        rate *= factor;
    }
    for _ in 0..RELAXING_CLOSER {
        factor = libm::sqrtf(factor);
        let about = at;
        for rate in [about / factor, about * factor] {
            if relax(problem, rate, &mut best)? {
                at = rate;
            }
        }
    }
    Some(Some(best))
}

/// Whether a baseline that relaxes at `rate` leaves less than `best`, which is then what it leaves. None if frames
/// were overwritten.
fn relax(problem: &mut Problem, rate: f32, best: &mut Values) -> Option<bool> {
    let nuisances = Nuisances::new(problem.stretch, problem.levels, Curve::Relaxing(rate))?;
    let baseline = nuisances.baseline(problem.levels, nuisances.count());
    let better = baseline.filter(|(_, rest)| gain(problem.levels, best, rest, 0) > 0.0);
    if let Some((_, rest)) = &better {
        *best = *rest;
    }
    Some(better.is_some())
}

/// Whether a line of few cycles at `nu`, with a slope and overtones if need be, is likelier than a drift that
/// leaves `drift`.
fn is_wave(problem: &mut Problem, nu: f32, drift: &Values, nuisances: usize) -> Option<bool> {
    for harmonics in [1, 3] {
        let shape =
            Shape { harmonics: harmonics_below_nyquist(problem.stretch, nu, harmonics), slope: true, nuisances };
        problem.pass(nu, shape.harmonics)?;
        let Some(rest) = rest(&problem.work.sums, problem.levels, problem.nuisances, &shape, false) else { continue };
        let more = 2 * (shape.harmonics - 1);
        let paid = if more > 0 { gain_by_chance(problem.levels, more, ONE_IN_A_THOUSAND) } else { 0.0 };
        if gain(problem.levels, drift, &rest, shape.unknowns()) > NO_CURVE + paid {
            return Some(true);
        }
    }
    Some(false)
}

/// The strongest line among the low ones by exact likelihoods: a line of few cycles leans on its own mirror
/// image, and a periodogram's peak is off by that.
fn strongest_low(problem: &mut Problem, peak: f32, nuisances: usize) -> Option<f32> {
    let (mut best, mut most) = (peak, f32::MIN);
    let mut cycles = CYCLES_MIN;
    while cycles < 5.0 {
        let nu = 0.5 * cycles;
        problem.pass(nu, 1)?;
        let shape = Shape { harmonics: 1, slope: cycles >= CYCLES_FOR_SLOPE, nuisances };
        if let Some(rest) = rest(&problem.work.sums, problem.levels, problem.nuisances, &shape, false) {
            // All against constants; the slopes' own gain has to pay for their unknowns (Schwarz's criterion).
            let slopes = if shape.slope { problem.levels.channels() } else { 0.0 };
            let paid = 0.5 * slopes * libm::logf(problem.levels.frames as f32);
            let unknowns = shape.unknowns() - shape.slope as usize;
            let gained = gain(problem.levels, &problem.levels.about_mean, &rest, unknowns) - paid;
            if gained > most {
                (best, most) = (nu, gained);
            }
        }
        cycles += 0.2 + 0.1 * cycles;
    }
    Some(best)
}
