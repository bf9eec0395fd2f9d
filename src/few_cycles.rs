//! Few cycles, or a drift: what a window holds below four cycles.
//!
//! Lines of few cycles lean on each other too much for a periodogram to tell them; a baseline that drifts looks like a
//! part of a wave, and a slow wave with its overtones like a drift with a faster tone. So all that there may be - a level,
//! a slope, a bend or a relaxation, with nothing or a tone of up to so many harmonics on it - are compared by
//! their likelihoods, and where two tones are about as likely it is left open which of them it is.

use crate::chance::{ONE_IN_A_THOUSAND, gain_by_chance, gain_by_search};
use crate::descent::{CYCLES_FOR_SLOPE, CYCLES_MIN, Problem, Work};
use crate::fundamental::harmonics_below_nyquist;
use crate::levels::Levels;
use crate::model::Model;
use crate::moments::HARMONICS_MAX;
use crate::nuisance::{CURVE, Curve, Nuisances};
use crate::relaxing::refine;
use crate::search::{Line, Place};
use crate::solve::{Shape, gain, over_noise, rests};
use crate::spectrum::strongest;
use crate::stretch::Stretch;

/// Rates of a baseline that relaxes, per half window: time constants of a half of the window, and less by
/// the factor from one to the next.
const RATE_FIRST: f32 = 1.0;
const RATE_FACTOR: f32 = 2.0;
const RATES: usize = 4;
/// Cycles up to which there are few.
const FEW: f32 = 5.0;
/// Factor from one frequency to the next.
const NEXT: f32 = 1.15;
/// Two frequencies with a larger factor between them belong to two summits of the likelihood.
const APART: f32 = 1.25;
/// Two tones are different if their frequencies are, by this share.
const DIFFERENT: f32 = 0.1;
/// Normal deviate up to which what more unknowns gain is chance.
const PLAIN: f32 = 2.0;
/// Odds that leave it open which of two tones it is, as a logarithm.
const OPEN: f32 = 8.0;

/// What the likeliest model leaves over the frames' own noise, which few of them do not tell better, from which on the
/// truth is none of them.
const MISFIT: f32 = 3.0;

/// Kinds of baselines: level, slope, bend, relaxation.
const KINDS: usize = 4;

/// The likeliest models.
#[derive(Default)]
struct Survey {
    /// Of each kind of baseline without a tone.
    without: [Option<Model>; KINDS],
    /// Of each kind with one.
    tones: [[Option<Model>; HARMONICS_MAX]; KINDS],
}

/// Puts `model` in its place if it is likelier.
#[inline(never)]
fn keep(place: &mut Option<Model>, levels: &Levels, model: &Model) {
    if place.as_ref().is_none_or(|place| model.is_likelier_than(place, levels)) {
        *place = Some(*model);
    }
}

fn is_apart(a: f32, b: f32, factor: f32) -> bool {
    a > factor * b || b > factor * a
}

impl Survey {
    #[inline(never)]
    fn add(&mut self, levels: &Levels, model: &Model) {
        let kind = match model.curve {
            Curve::None => model.shape.slope as usize,
            Curve::Bent => 2,
            Curve::Relaxing(_) => 3,
        };
        if model.shape.harmonics == 0 {
            return keep(&mut self.without[kind], levels, model);
        }
        keep(&mut self.tones[kind][model.shape.harmonics - 1], levels, model);
    }

    /// All models at `nu`.
    fn look_at(
        &mut self,
        stretch: &mut Stretch,
        levels: &Levels,
        work: &mut Work,
        nuisances: &[Nuisances],
        nu: f32,
        most: usize,
    ) -> Option<()> {
        let harmonics = harmonics_below_nyquist(stretch, nu, most);
        for (k, nuisances) in nuisances.iter().enumerate() {
            let sums = &mut work.sums;
            match k {
                0 => sums.collect(stretch, levels, nuisances, nu, harmonics)?,
                _ => sums.collect(stretch, levels, nuisances, nu, harmonics)?,
            }
            let straight = nuisances.count() - CURVE;
            let shapes: &[_] = match nuisances.curve {
                Curve::Relaxing(_) => &[(true, 1)],
                _ => &[(false, 0), (true, 0), (true, CURVE)],
            };
            for (slope, curve) in shapes {
                let shape = Shape { harmonics, slope: *slope, nuisances: straight + curve };
                let curve = if *curve > 0 { nuisances.curve } else { Curve::None };
                rests(sums, levels, nuisances, &shape, &mut |harmonics, rest| {
                    let nu = if harmonics > 0 { nu } else { 0.0 };
                    let model = Model { nu, curve, shape: Shape { harmonics, ..shape }, rest: *rest };
                    self.add(levels, &model);
                });
            }
        }
        Some(())
    }
}

/// The strongest line where the periodogram's peak is a low one, or where there is nothing but a drift. The
/// inner None says that there is none. `fast` is another frequency to be looked at. None if frames were
/// overwritten.
pub fn few_cycles(
    stretch: &mut Stretch,
    levels: &Levels,
    work: &mut Work,
    most: usize,
    place: Option<Place>,
    mut fast: f32,
) -> Option<Option<Line>> {
    let mut rate = RATE_FIRST;
    let mut nuisances: [Nuisances; 1 + RATES] = Default::default();
    nuisances[0] = Nuisances::new(stretch, levels, Curve::Bent)?;
    for nuisances in &mut nuisances[1..] {
        *nuisances = Nuisances::new(stretch, levels, Curve::Relaxing(rate))?;
        rate *= RATE_FACTOR;
    }
    let mut survey = Survey::default();
    let mut nu = 0.5 * CYCLES_MIN;
    while 2.0 * nu < FEW {
        survey.look_at(stretch, levels, work, &nuisances, nu, most)?;
        nu *= NEXT;
    }
    let mut drift = None;
    for without in &mut survey.without {
        if let Some(without) = without {
            refine(stretch, levels, work, without)?;
            keep(&mut drift, levels, without);
        }
    }
    let Some(drift) = drift else { return Some(None) };
    let relaxed;
    let mut likely = &nuisances[..];
    if let Some(Place { channels, points, power }) = place {
        relaxed = [Nuisances::new(stretch, levels, drift.curve)?];
        let peak = strongest(stretch, levels, &relaxed[0], CYCLES_FOR_SLOPE, channels, points, power)?;
        fast = peak.unwrap_or(0.0);
        if matches!(drift.curve, Curve::Relaxing(_)) {
            likely = &relaxed;
        }
    }
    if 2.0 * fast >= CYCLES_FOR_SLOPE {
        survey.look_at(stretch, levels, work, likely, fast, most)?;
    }
    let mut best = None;
    for tone in survey.tones.as_flattened_mut().iter_mut() {
        if let Some(model) = tone {
            climb(stretch, levels, work, &nuisances[0], model)?;
            if model.nu > 0.0 {
                keep(&mut best, levels, model);
            }
        }
    }
    let Some(best) = best else { return Some(None) };
    let gained = gain(levels, &drift.rest, &best.rest, best.shape.unknowns());
    // A drift of more unknowns has to pay for them.
    let by_chance = match best.shape.unknowns() > drift.shape.unknowns() {
        true => gain_by_search(2.0 * levels.channels(), levels.frames),
        false => gained - drift.odds(levels, &best),
    };
    if !(gained > by_chance) {
        return Some(None);
    }
    let rival = |tone: &&Model| {
        let apart = (tone.nu - best.nu).abs() > DIFFERENT * best.nu;
        let more = tone.shape.unknowns().saturating_sub(best.shape.unknowns());
        let by_chance = if more > 0 { gain_by_chance(levels, more, PLAIN) } else { f32::NEG_INFINITY };
        let gained = gain(levels, &best.rest, &tone.rest, best.shape.unknowns() + more);
        apart && gained > by_chance && best.odds(levels, tone) > -OPEN
    };
    let few = 2.0 * best.nu < CYCLES_FOR_SLOPE;
    let over_noise = over_noise(levels, &best.rest, best.shape.unknowns());
    let misfit = few && over_noise.is_some_and(|over| over > MISFIT);
    let ambiguous = misfit || survey.tones.as_flattened().iter().flatten().find(rival).is_some();
    let harmonics = if few { carried(stretch, levels, work, &best, most)? } else { 0 };
    Some(Some(Line {
        nu: best.nu,
        slope: best.shape.slope || !few,
        curve: best.curve,
        suspects: [2.0 * best.nu >= FEW; 2],
        harmonics,
        ambiguous,
    }))
}

/// Harmonics of the likeliest model, and above them as many as stand out of the noise: those have not to
/// pay for telling it from another.
fn carried(stretch: &mut Stretch, levels: &Levels, work: &mut Work, best: &Model, most: usize) -> Option<usize> {
    let nuisances = Nuisances::new(stretch, levels, best.curve)?;
    let shape = Shape { harmonics: harmonics_below_nyquist(stretch, best.nu, most), ..best.shape };
    work.sums.collect(stretch, levels, &nuisances, best.nu, shape.harmonics)?;
    let (mut carried, mut least) = (best.shape.harmonics, best.rest);
    rests(&work.sums, levels, &nuisances, &shape, &mut |harmonics, rest| {
        let more = 2 * harmonics.saturating_sub(carried);
        let unknowns = Shape { harmonics, ..shape }.unknowns();
        if more > 0 && gain(levels, &least, rest, unknowns) > gain_by_chance(levels, more, ONE_IN_A_THOUSAND) {
            (carried, least) = (harmonics, *rest);
        }
    });
    Some(carried)
}

/// Moves a model to the summit of its likelihood.
fn climb(
    stretch: &mut Stretch,
    levels: &Levels,
    work: &mut Work,
    nuisances: &Nuisances,
    model: &mut Model,
) -> Option<()> {
    if matches!(model.curve, Curve::Relaxing(_)) {
        return refine(stretch, levels, work, model);
    }
    let mut problem = Problem::new(stretch, levels, nuisances, work);
    if problem.converge(model.nu, model.shape)? {
        let solution = problem.solution();
        (model.nu, model.rest) = (solution.nu, solution.rest);
    } else {
        model.nu = 0.0;
    }
    Some(())
}
