//! Where the fit starts: the strongest line, the baseline under it, and the fundamental it belongs to.
//!
//! A grating's tone lies far below the frame rate, so the search runs on means of a few frames: a
//! fraction of the work, and a guess is all that is wanted. Only if those means have lost the better
//! part of the signal's power - the tone is fast, or there is none - does it run on the frames
//! themselves.

use crate::chance::{ONE_IN_A_THOUSAND, gain_by_chance, gain_by_search};
use crate::descent::{CYCLES_FOR_SLOPE, CYCLES_MIN, LINE_CLOSE, Problem, Work};
use crate::fundamental::{fundamental, harmonics_below_nyquist};
use crate::levels::{Levels, Means, QUAD, levels};
use crate::nuisance::{CURVE, Curve, Nuisances};
use crate::settings::TAXELS;
use crate::solve::{Shape, Solution, gain, rest};
use crate::spectrum::{POINTS_MAX, power_near, strongest};
use crate::stretch::Stretch;
use crate::window::{Table, Values};

/// Power in the periodogram from which it is worth to fit lines below the strongest at all: half of what
/// makes the fundamental open.
const WORTH_A_LOOK: f32 = 0.02;
/// Means that a search on means has at the most; a window of one second at 241 Hz has 60 of 4 frames.
const MEANS_MAX: usize = 64;
/// Fewer frames than this are searched themselves.
const FRAMES_FOR_MEANS: u32 = 41;
/// Fewer means than this are not enough for a handful of harmonics.
const MEANS_FOR_HARMONICS: usize = 48;
/// Share of the power that the means must keep.
const MEANS_SHARE: f32 = 0.5;
/// Peaks below this many cycles per half window are looked at by exact likelihoods.
const LOW_NU: f32 = 1.75;
/// Channels whose means are transformed: a guess is all that is wanted.
const CLEAREST: usize = 4;
/// Steps from a periodogram's peak to the line it belongs to.
const LINE_STEPS: usize = 4;
/// Normal deviate from which a curve of the baseline is taken for one: a wrong one costs little.
const CURVED: f32 = 3.0;
/// Relaxing baselines that are tried: their slowest rate per half window (a time constant of a third of it), from
/// one to the next, how many, and how often the steps about the best are halved.
const RELAXING_LEAST: f32 = 1.5;
/// From one rate to the next.
const RELAXING_FACTOR: f32 = 1.5;
/// How many of them: down to a time constant of a thirtieth of the window.
const RELAXING_RATES: usize = 7;
/// How often the factor about the best one is reduced to its root.
const RELAXING_CLOSER: usize = 3;
/// Gain over a drift by which a line of few cycles is a line and not that curve.
const NO_CURVE: f32 = 8.0;

/// The strongest line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Line {
    /// Cycles per half window ([`crate::stretch`]).
    pub nu: f32,
    /// Whether there is a slope under it, and a curve.
    pub slope: bool,
    /// Whether there is a curve under it.
    pub curved: bool,
    /// Whether it may be the second, or the third, harmonic of its tone.
    pub suspects: [bool; 2],
}

/// Where the fit starts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Start {
    /// Cycles per half window ([`crate::stretch`]).
    pub nu: f32,
    /// It is open whether this is the fundamental.
    pub ambiguous: bool,
    /// It is the fundamental of a stronger line.
    pub comb: bool,
    /// Whether each channel has a slope.
    pub slope: bool,
    /// Whether each channel has a curve.
    pub curved: bool,
}

/// Scratch memory of the search: transforms, or the means and their transforms.
#[derive(Debug)]
pub struct Scratch {
    points: [f32; POINTS_MAX],
    power: [f32; POINTS_MAX / 2],
}

impl Scratch {
    /// Scratch memory; `const`, so that it can live in a static.
    pub const fn new() -> Self {
        Self { points: [0.0; POINTS_MAX], power: [0.0; POINTS_MAX / 2] }
    }
}

impl Default for Scratch {
    fn default() -> Self {
        Self::new()
    }
}

/// Where to start the fit of a stretch with up to `harmonics` harmonics, by the frames themselves.
/// None if they were overwritten; the inner None says that the window holds nothing to start from.
pub fn search(
    stretch: &mut Stretch,
    levels: &Levels,
    scratch: &mut Scratch,
    work: &mut Work,
    harmonics: usize,
) -> Option<Option<Start>> {
    let Scratch { points, power } = scratch;
    match look(stretch, levels, u16::MAX, points, power, work)? {
        Some(line) => settle(stretch, levels, work, line, harmonics).map(Some),
        None => Some(None),
    }
}

/// What the means of groups of frames say.
pub struct Coarse {
    /// Frames of a group; 0 if there are no means.
    by: u32,
    count: usize,
    valid: [u16; MEANS_MAX],
}

/// Levels of a stretch, and its means in `scratch`. None if frames were overwritten.
pub fn levels_and_means(stretch: &mut Stretch, scratch: &mut Scratch) -> Option<(Levels, Coarse)> {
    let mut coarse = Coarse { by: 0, count: 0, valid: [0; MEANS_MAX] };
    if stretch.frames < FRAMES_FOR_MEANS || !stretch.is_in_time() {
        return Some((levels(stretch, None)?, coarse));
    }
    coarse.by = QUAD as u32;
    while stretch.frames / coarse.by > MEANS_MAX as u32 {
        coarse.by *= 2;
    }
    coarse.count = (stretch.frames / coarse.by) as usize;
    let (values, _) = scratch.points.as_chunks_mut();
    let means =
        Means { by: coarse.by, values: values.get_mut(..coarse.count)?, valid: coarse.valid.get_mut(..coarse.count)? };
    Some((levels(stretch, Some(means))?, coarse))
}

/// The same as [`search`] by the means of `coarse`, which [`levels_and_means`] left in `scratch`. The inner None says
/// that they are of no use here.
pub fn search_coarse(
    stretch: &mut Stretch,
    levels_of_all: &Levels,
    coarse: &Coarse,
    scratch: &mut Scratch,
    work: &mut Work,
    harmonics: usize,
) -> Option<Option<Start>> {
    // A gap gives a line high skirts: that takes all channels and all frames to see through.
    if coarse.by == 0 || 10 * levels_of_all.frames < 9 * stretch.frames {
        return Some(None);
    }
    let (values, _) = scratch.points.as_chunks();
    let mut table = Table { values: values.get(..coarse.count)?, valid: coarse.valid.get(..coarse.count)? };
    let mut means = stretch.means(&mut table, coarse.count as u32, coarse.by);
    let levels = levels(&mut means, None)?;
    if levels.usable != levels_of_all.usable {
        return Some(None);
    }
    let (mut kept, mut shares) = (0.0, [0.0; TAXELS]);
    for c in 0..TAXELS {
        if levels.usable & 1 << c != 0 {
            shares[c] = coarse.by as f32 * levels.about_line[c] / levels_of_all.about_line[c];
            kept += shares[c];
        }
    }
    if !(kept >= MEANS_SHARE * levels.channels()) {
        return Some(None);
    }
    let channels = clearest(&shares, levels.usable);
    let (points, power) = scratch.power.split_at_mut(POINTS_MAX / 4);
    let Some(line) = look(&mut means, &levels, channels, points, power, work)? else {
        return Some(None);
    };
    // The means cover whole groups of frames only.
    let scale = stretch.frames as f32 / (coarse.count as u32 * coarse.by) as f32;
    if levels.frames as usize >= MEANS_FOR_HARMONICS || harmonics == 1 {
        let start = settle(&mut means, &levels, work, line, harmonics)?;
        Some(Some(Start { nu: start.nu * scale, ..start }))
    } else {
        let line = Line { nu: line.nu * scale, ..line };
        settle(stretch, levels_of_all, work, line, harmonics).map(Some)
    }
}

/// The channels that means keep most of: what is slow in them is no noise.
#[inline(never)]
fn clearest(shares: &Values, usable: u16) -> u16 {
    let (mut channels, mut left) = (0, usable);
    for _ in 0..CLEAREST {
        let (mut best, mut most, mut rest) = (0, -1.0, left);
        while rest != 0 {
            let c = rest.trailing_zeros() as usize % TAXELS;
            rest &= rest - 1;
            if shares[c] > most {
                (best, most) = (1 << c, shares[c]);
            }
        }
        channels |= best;
        left &= !best;
    }
    channels
}

/// The strongest line. The inner None says that there is none.
// Large and called from several places: one copy is enough.
#[inline(never)]
fn look(
    stretch: &mut Stretch,
    levels: &Levels,
    channels: u16,
    points: &mut [f32],
    power: &mut [f32],
    work: &mut Work,
) -> Option<Option<Line>> {
    let nuisances = Nuisances::new(stretch, levels, Curve::Bent)?;
    let straight = nuisances.count() - CURVE;
    let peak = strongest(stretch, levels, &nuisances, straight, 0.5, channels, points, power)?;
    let Some(peak) = peak else { return Some(None) };
    let mut problem = Problem::new(stretch, levels, &nuisances, work);
    if peak > LOW_NU {
        if !problem.descend(peak, Shape { harmonics: 1, slope: true, nuisances: straight }, LINE_STEPS, LINE_CLOSE)? {
            return Some(None);
        }
        let (frames, most, nu) = (problem.stretch.frames as usize, points.len(), problem.solution().nu);
        let power_at = |nu: f32| power_near(frames, most, power, nu);
        let worth = WORTH_A_LOOK * power_at(nu);
        let suspects =
            [power_at(nu / 2.0) + power_at(nu * 1.5) >= worth, power_at(nu / 3.0) + power_at(nu / 1.5) >= worth];
        return Some(Some(Line { nu, slope: true, curved: is_curved(&problem), suspects }));
    }
    // Low lines lean on each other too much for a periodogram to say that there is nothing.
    let suspects = [true; 2];
    let nu = strongest_low(&mut problem, peak, straight)?;
    let shape = Shape { harmonics: 1, slope: 2.0 * nu >= CYCLES_FOR_SLOPE, nuisances: straight };
    let found = problem.descend(nu, shape, LINE_STEPS, LINE_CLOSE)?;
    let nu = problem.solution().nu;
    let Some(drift) = best_drift(&mut problem)? else { return Some(None) };
    if found && is_wave(&mut problem, nu, &drift, straight)? {
        return Some(Some(Line { nu, slope: shape.slope, curved: false, suspects }));
    }
    // It is a drift, but there may be a tone on it.
    let peak = strongest(stretch, levels, &nuisances, nuisances.count(), CYCLES_FOR_SLOPE, channels, points, power)?;
    let Some(peak) = peak else { return Some(None) };
    let shape = Shape { harmonics: 1, slope: true, nuisances: nuisances.count() };
    let mut problem = Problem::new(stretch, levels, &nuisances, work);
    if !problem.descend(peak, shape, LINE_STEPS, LINE_CLOSE)? {
        return Some(None);
    }
    let gained = gain(levels, &drift, &problem.solution().rest, shape.unknowns());
    let line = Line { nu: problem.solution().nu, slope: true, curved: true, suspects };
    Some((gained > gain_by_search(2.0 * levels.channels(), levels.frames)).then_some(line))
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
        let Some(rest) = rest(&problem.work.sums, problem.levels, problem.nuisances, &shape) else { continue };
        let more = 2 * (shape.harmonics - 1);
        let paid = if more > 0 { gain_by_chance(problem.levels, more, ONE_IN_A_THOUSAND) } else { 0.0 };
        if gain(problem.levels, drift, &rest, shape.unknowns()) > NO_CURVE + paid {
            return Some(true);
        }
    }
    Some(false)
}

/// Whether a curve besides takes more off what the latest solution leaves than noise would let it. Both are
/// compared where their steps lead.
#[inline(never)]
pub fn is_curved(problem: &Problem) -> bool {
    let Problem { levels, nuisances, work, nu, .. } = problem;
    let (straight, mut curved) = (&work.solution, Solution::new());
    let shape = Shape { nuisances: nuisances.count(), ..straight.shape };
    if curved.solve(&work.sums, levels, nuisances, *nu, shape).is_none() {
        return false;
    }
    let ahead = |solution: &Solution| 0.5 * solution.step * solution.step * solution.information;
    let gained = gain(levels, &straight.rest, &curved.rest, shape.unknowns());
    gained + ahead(&curved) - ahead(straight) > gain_by_chance(levels, CURVE, CURVED)
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
        if let Some(rest) = rest(&problem.work.sums, problem.levels, problem.nuisances, &shape) {
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

/// From the strongest line to where the fit starts: its fundamental, close to where all harmonics want it.
/// None if frames were overwritten.
// Called with means and with frames: one copy is enough.
#[inline(never)]
fn settle(stretch: &mut Stretch, levels: &Levels, work: &mut Work, line: Line, harmonics: usize) -> Option<Start> {
    let mut start = Start { nu: line.nu, ambiguous: false, comb: false, slope: line.slope, curved: line.curved };
    if harmonics < 2 {
        return Some(start);
    }
    let nuisances = Nuisances::new(stretch, levels, Curve::Bent)?;
    let used = nuisances.count() - if line.curved { 0 } else { CURVE };
    let mut problem = Problem::new(stretch, levels, &nuisances, work);
    start = fundamental(&mut problem, &line, used)?;
    let harmonics = harmonics_below_nyquist(problem.stretch, start.nu, harmonics);
    let shape = Shape { harmonics, slope: start.slope, nuisances: used };
    if 2.0 * start.nu >= CYCLES_FOR_SLOPE && problem.descend(start.nu, shape, 1, LINE_CLOSE)? {
        start.nu = problem.solution().nu;
        start.curved = line.curved || is_curved(&problem);
    }
    Some(start)
}
