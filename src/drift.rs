//! Few cycles, or a drift: what a window holds below four cycles.
//!
//! Lines of few cycles lean on each other too much for a periodogram to tell them, and a skin that relaxes
//! looks like a part of a wave. So the low lines are compared by exact likelihoods, with each other and with
//! drifts.

use crate::chance::{ONE_IN_A_THOUSAND, gain_by_chance, gain_by_search, ln};
use crate::descent::{CYCLES_FOR_SLOPE, CYCLES_MIN, LINE_CLOSE, Problem};
use crate::fundamental::harmonics_below_nyquist;
use crate::nuisance::{CURVE, Curve, Nuisances};
use crate::relaxing::{Model, relaxing};
use crate::search::{LINE_STEPS, Line, Start};
use crate::solve::{Shape, gain, is_misfit, over_noise, rest};
use crate::spectrum::strongest;
use crate::window::Values;

/// Gain over a drift by which a line of few cycles is a line and not that curve.
const NO_CURVE: f32 = 8.0;
/// Cycles from which on no wave looks like a drift that relaxes.
const CYCLES_UNLIKE_DRIFT: f32 = 2.5;
/// Log-likelihood by which a curve that relaxes may be worse than a bent one and be there all the same, under a tone.
const UNRELAXED: f32 = 30.0;
/// Odds of a tone on a drift against a wave of few cycles that leave it open which of the two it is, as a
/// logarithm: e to the eighth is three thousand to one.
const OPEN: f32 = 8.0;
/// A tone on a drift is another than the wave that it is compared with if it is faster by this factor.
const OTHER: f32 = 1.4;
/// Harmonics of a wave that may stand for a drift and its tone.
const OVERTONES: usize = 4;

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
    // A step that leads below all waves misleads.
    let nu = if 2.0 * problem.solution().nu >= CYCLES_MIN { problem.solution().nu } else { nu };
    let line = Line { nu, slope: shape.slope, curve: Curve::None, suspects: [true; 2], ambiguous: false };
    let Some((bent, relaxing)) = drifts(problem)? else { return Some(None) };
    let relaxed = bent.odds(levels, &relaxing);
    let drift = if gain(levels, &bent.rest, &relaxing.rest, 0) > 0.0 { relaxing } else { bent };
    let wave = found && is_wave(problem, nu, &drift.rest, straight)?;
    if wave && (2.0 * nu >= CYCLES_UNLIKE_DRIFT || relaxed < -UNRELAXED) {
        return Some(Some(line));
    }
    // There may be a tone on a drift.
    let Some((on, without)) = on_a_drift(problem, place, drift.curve)? else { return Some(wave.then_some(line)) };
    if wave && on.nu < OTHER * nu {
        return Some(Some(line));
    }
    let other = tone_relaxing(problem, on.nu)?;
    let on_drift = |on: &Model| Line { nu: on.nu, slope: true, curve: on.curve, ..line };
    if wave {
        let Some(other) = other else { return Some(Some(line)) };
        let shape = Shape { harmonics: OVERTONES, ..shape };
        return Some(Some(match weigh(problem, nu, shape, &other)? {
            Verdict::Wave => line,
            Verdict::Open => Line { ambiguous: true, ..line },
            Verdict::Tone => on_drift(&other),
        }));
    }
    let better = other.filter(|other| on.odds(levels, other) > 0.0);
    let (on, without) = better.map_or((on, without), |other| (other, drift.rest));
    let gained = gain(levels, &without, &on.rest, on.unknowns);
    Some((gained > gain_by_search(2.0 * levels.channels(), levels.frames)).then_some(on_drift(&on)))
}

/// Where to start if `start` has, or may have, a fundamental of few cycles below `line`: those lines may be a drift, and
/// then it is `line`.
pub fn comb_or_drift(problem: &mut Problem, start: Start, line: &Line, shape: Shape) -> Option<Start> {
    if !(start.below > 0.0 && 2.0 * start.below < CYCLES_UNLIKE_DRIFT) {
        return Some(start);
    }
    let Some(on) = tone_relaxing(problem, line.nu)? else { return Some(start) };
    Some(match weigh(problem, start.below, shape, &on)? {
        Verdict::Wave => start,
        Verdict::Open => Start { ambiguous: true, ..start },
        // Neither: a tone that comes or goes, for one.
        Verdict::Tone if is_misfit(over_noise(problem.levels, &on.rest, on.unknowns)) => {
            Start { ambiguous: true, ..start }
        }
        Verdict::Tone => Start { nu: on.nu, ambiguous: false, below: 0.0, slope: true, curve: on.curve },
    })
}

/// What a window of few cycles holds.
enum Verdict {
    /// A wave.
    Wave,
    /// Either.
    Open,
    /// A tone on a drift.
    Tone,
}

/// A wave of few cycles next to `nu`, of as many harmonics as it carries of those of `shape`, against a tone `on` a
/// drift.
#[inline(never)]
fn weigh(problem: &mut Problem, nu: f32, shape: Shape, on: &Model) -> Option<Verdict> {
    let levels = problem.levels;
    let mut harmonics = harmonics_below_nyquist(problem.stretch, nu, shape.harmonics);
    while !problem.converge(nu, Shape { harmonics, ..shape })? {
        harmonics -= 1;
        if harmonics == 0 {
            return Some(Verdict::Wave);
        }
    }
    let mut wave = None;
    for index in 0..2 * harmonics {
        let shape = Shape { harmonics: 1 + index / 2, slope: shape.slope || index % 2 == 1, ..shape };
        if let Some(rest) = rest(&problem.work.sums, levels, problem.nuisances, &shape, false) {
            let model = Model { nu: problem.nu, curve: Curve::None, rest, unknowns: shape.unknowns() };
            Model::keep(&mut wave, levels, model);
        }
    }
    let odds = wave.map_or(0.0, |wave| wave.odds(levels, on));
    Some(if odds > OPEN {
        Verdict::Tone
    } else if odds > -OPEN {
        Verdict::Open
    } else {
        Verdict::Wave
    })
}

/// The strongest line on a drift like `curve`, and what the drift alone leaves.
// Apart, so that its nuisances are off the stack when others are looked for.
#[inline(never)]
fn on_a_drift(problem: &mut Problem, place: Place, curve: Curve) -> Option<Option<(Model, Values)>> {
    let Place { channels, points, power } = place;
    let nuisances = Nuisances::new(problem.stretch, problem.levels, curve)?;
    let count = nuisances.count();
    let mut problem = Problem::new(problem.stretch, problem.levels, &nuisances, problem.work);
    let Problem { stretch, levels, .. } = &mut problem;
    let peak = strongest(stretch, levels, &nuisances, CYCLES_FOR_SLOPE, channels, points, power)?;
    let Some(peak) = peak else { return Some(None) };
    let shape = Shape { harmonics: 1, slope: true, nuisances: count };
    if !problem.descend(peak, shape, LINE_STEPS, LINE_CLOSE)? {
        return Some(None);
    }
    let (nu, rest) = (problem.solution().nu, problem.solution().rest);
    // Below that the line is what a bent curve leaves of a steeper one.
    if 2.0 * nu < CYCLES_FOR_SLOPE {
        return Some(None);
    }
    let without = nuisances.baseline(problem.levels, count);
    Some(without.map(|(_, without)| (Model { nu, curve, rest, unknowns: shape.unknowns() }, without)))
}

/// The likeliest tone next to `nu` on a baseline that relaxes, unless there is too little of it to be told from that.
fn tone_relaxing(problem: &mut Problem, nu: f32) -> Option<Option<Model>> {
    Some(relaxing(problem, nu)?.filter(|on| 2.0 * on.nu >= CYCLES_FOR_SLOPE))
}

/// The likeliest drifts if there were no tone: bent, and relaxing. The inner None says that there is not enough to tell.
fn drifts(problem: &mut Problem) -> Option<Option<(Model, Model)>> {
    let (levels, count) = (problem.levels, problem.nuisances.count());
    let Some((_, rest)) = problem.nuisances.baseline(levels, count) else { return Some(None) };
    let bent = Model { nu: 0.0, curve: Curve::Bent, rest, unknowns: 2 + count };
    Some(Some((bent, relaxing(problem, 0.0)?.unwrap_or(bent))))
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
            let paid = 0.5 * slopes * ln(problem.levels.frames as f32);
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
