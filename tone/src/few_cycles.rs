//! Few cycles, or a drift: what a window holds below four cycles.
//!
//! Lines of few cycles lean on each other too much for a periodogram to tell them; a baseline that drifts looks like a
//! part of a wave, and a slow wave with its overtones like a drift with a faster tone. So all that there may be - a level,
//! a slope, a bend or a relaxation, with nothing or a tone of up to so many harmonics on it - are compared by
//! their likelihoods, and where two tones are about as likely it is left open which of them it is.

use crate::descent::{CYCLES_FOR_SLOPE, Problem, Work};
use crate::frame_span::FrameSpan;
use crate::fundamental::harmonics_below_nyquist;
use crate::levels::Levels;
use crate::model::{Model, expected_gain};
use crate::nuisance::{Curve, Nuisances};
use crate::relaxing::relax;
use crate::search::{Place, SpectralLine};
use crate::significance::{ONE_IN_A_THOUSAND, significant_gain, significant_search_gain};
use crate::solve::{Shape, gain, over_noise};
use crate::survey::Survey;

/// Cycles from which on harmonics may be missing below a line.
const MANY: f32 = 5.0;
/// Two tones are different if their frequencies are, by this share.
const DIFFERENT: f32 = 0.1;
/// Normal deviate up to which what more unknowns gain is chance.
const PLAIN: f32 = 2.0;
/// Odds that leave it open which of two tones it is, as a logarithm.
const OPEN: f32 = 8.0;

/// Gauss-Newton steps to the summit of a model's likelihood at the most.
const STEPS: usize = 6;
/// How often all that there may be is looked at at the likeliest summits.
const ROUNDS: usize = 2;
/// Of baselines without a curve.
const PLAIN_KINDS: usize = 2;
/// Share of a frequency by which summits of several models are one.
const SAME: f32 = 0.02;
/// Log-likelihood that is not worth another one.
const ARRIVED: f32 = 1.0;
/// What a step promises may be less than there is, by this factor.
const OPTIMISM: f32 = 4.0;
/// What the likeliest model leaves over the frames' own noise, which few of them do not tell better, from which on the
/// truth is none of them.
const MISFIT: f32 = 3.0;

/// The strongest line where the periodogram's peak is a low one, or where there is nothing but a drift. The
/// inner None says that there is none. `line` is that peak, or another line that there may be. None if frames were
/// overwritten.
pub fn few_cycles(
    span: &mut FrameSpan,
    levels: &Levels,
    work: &mut Work,
    most: usize,
    place: Option<Place>,
    line: f32,
) -> Option<Option<SpectralLine>> {
    let mut survey = Survey::default();
    survey.look_around(span, levels, work, most, line)?;
    let mut drift = None;
    survey.without.iter().flatten().for_each(|without| Model::keep(&mut drift, levels, without));
    for without in survey.without.iter().flatten() {
        refine(span, levels, work, without, &mut drift)?;
    }
    let Some(drift) = drift else { return Some(None) };
    if let Some(place) = place {
        survey.look_on_drift(span, levels, work, most, place, drift.curve)?;
    }
    // From the likeliest on, so that most others are seen not to be worth the way.
    let mut first = None;
    survey.tones.as_flattened().iter().flatten().for_each(|tone| Model::keep(&mut first, levels, tone));
    let mut best = None;
    if let Some(first) = first {
        refine(span, levels, work, &first, &mut best)?;
    }
    // What is at another summit there has not been compared with the rest at this one.
    let mut known = [0.0; 1 + PLAIN_KINDS];
    for _ in 0..ROUNDS {
        for (k, known) in known.iter_mut().enumerate() {
            let mut likeliest = best;
            if let Some(plain) = k.checked_sub(1).and_then(|plain| survey.tones.get(plain)) {
                likeliest = None;
                plain
                    .iter()
                    .flatten()
                    .filter(|tone| tone.refined)
                    .for_each(|tone| Model::keep(&mut likeliest, levels, tone));
            }
            let Some(Model { nu, .. }) = likeliest else { continue };
            if (nu - *known).abs() > SAME * nu {
                *known = nu;
                survey.look_at_summit(span, levels, work, most, nu)?;
            }
        }
        for place in survey.tones.as_flattened_mut() {
            if let Some(tone) = place.filter(|tone| !tone.refined) {
                *place = refine(span, levels, work, &tone, &mut best)?;
            }
        }
    }
    let Some(best) = best else { return Some(None) };
    let gained = gain(levels, &drift.residual_sum_of_squares, &best.residual_sum_of_squares, best.shape.unknowns());
    // A drift of more unknowns has to pay for them.
    let by_chance = match best.shape.unknowns() > drift.shape.unknowns() {
        true => significant_search_gain(2.0 * levels.channels(), levels.frames),
        false => gained - drift.odds(levels, &best),
    };
    if !(gained > by_chance) {
        return Some(None);
    }
    let competitor = |tone: &&Model| {
        let apart = (tone.nu - best.nu).abs() > DIFFERENT * best.nu;
        let more = tone.shape.unknowns().saturating_sub(best.shape.unknowns());
        let by_chance = if more > 0 { significant_gain(levels, more, PLAIN) } else { f32::NEG_INFINITY };
        let gained =
            gain(levels, &best.residual_sum_of_squares, &tone.residual_sum_of_squares, best.shape.unknowns() + more);
        apart && gained > by_chance && best.odds(levels, tone) > -OPEN
    };
    let few = 2.0 * best.nu < CYCLES_FOR_SLOPE;
    let over_noise = over_noise(levels, &best.residual_sum_of_squares, best.shape.unknowns());
    let misfit = few && over_noise.is_some_and(|over| over > MISFIT);
    let ambiguous = misfit || survey.tones.as_flattened().iter().flatten().find(competitor).is_some();
    let harmonics = if few { carried(span, levels, work, &best, most)? } else { 0 };
    Some(Some(SpectralLine {
        nu: best.nu,
        slope: best.shape.slope || !few,
        curve: best.curve,
        suspects: [2.0 * best.nu >= MANY; 2],
        harmonics,
        ambiguous,
    }))
}

/// Harmonics of the likeliest model, and above them as many as stand out of the noise: those have not to
/// pay for telling it from another.
fn carried(span: &mut FrameSpan, levels: &Levels, work: &mut Work, best: &Model, most: usize) -> Option<usize> {
    let nuisances = Nuisances::new(span, levels, best.curve)?;
    let shape = Shape { harmonics: harmonics_below_nyquist(span, best.nu, most), ..best.shape };
    work.sums.collect(span, levels, &nuisances, best.nu, shape.harmonics)?;
    let (mut carried, mut least) = (best.shape.harmonics, best.residual_sum_of_squares);
    let Work { sums, solution } = work;
    solution.residual_sums(sums, levels, &nuisances, &shape, &mut |harmonics, residual_sum_of_squares| {
        let more = 2 * harmonics.saturating_sub(carried);
        let unknowns = Shape { harmonics, ..shape }.unknowns();
        if more > 0
            && gain(levels, &least, residual_sum_of_squares, unknowns)
                > significant_gain(levels, more, ONE_IN_A_THOUSAND)
        {
            (carried, least) = (harmonics, *residual_sum_of_squares);
        }
    });
    Some(carried)
}

/// A model at the summit of its likelihood, which is `best` if it is likelier; None if that cannot be, or if its unknowns
/// cannot be told apart. The outer None if frames were overwritten.
#[inline(never)]
fn refine(
    span: &mut FrameSpan,
    levels: &Levels,
    work: &mut Work,
    from: &Model,
    best: &mut Option<Model>,
) -> Option<Option<Model>> {
    let (mut top, mut model) = (None, Model { refined: true, ..*from });
    let straight = matches!(from.curve, Curve::Relaxing(_)) || from.nu == 0.0;
    let nuisances = Nuisances::new(span, levels, if straight { Curve::None } else { from.curve })?;
    for _ in 0..STEPS {
        let ahead = match model.curve {
            Curve::Relaxing(_) => relax(span, levels, work, &mut model)?,
            _ if model.nu > 0.0 => step(&mut Problem::new(span, levels, &nuisances, work), &mut model)?,
            _ => Some((model, 0.0)),
        };
        let Some((next, expected_gain)) = ahead else { break };
        Model::keep(&mut top, levels, &model);
        let behind = best.as_ref().map_or(0.0, |best| best.odds(levels, &model));
        if expected_gain < ARRIVED || behind + OPTIMISM * expected_gain < -OPEN {
            break;
        }
        (model.nu, model.curve) = (next.nu, next.curve);
    }
    if let Some(top) = &top {
        Model::keep(best, levels, top);
    }
    Some(top)
}

/// What a model leaves where it is, and where a step leads, with the log-likelihood that is promised there.
fn step(problem: &mut Problem, model: &mut Model) -> Option<Option<(Model, f32)>> {
    problem.pass(model.nu, model.shape.harmonics)?;
    if problem.step(model.shape).is_none() {
        return Some(None);
    }
    let solution = problem.solution();
    model.residual_sum_of_squares = solution.residual_sum_of_squares;
    Some(Some((Model { nu: solution.nu, ..*model }, expected_gain(problem.levels, solution))))
}
