//! A window of few cycles, or of a drift alone: what it holds below four cycles.
//!
//! Lines of few cycles overlap too much for a periodogram to separate them. A baseline that drifts resembles a part of a
//! wave, and a slow wave with its overtones a drift with a faster tone. So all candidates - a level, a slope, a bend or a
//! relaxation, without a tone or with one of one to five harmonics - are compared by their likelihoods, and where two
//! tones are about as likely the result is ambiguous.

use crate::descent::{CYCLES_FOR_SLOPE, Problem};
use crate::equations::Shape;
use crate::guess::SpectralLine;
use crate::likelihood::{expected_gain, gain, noise_ratio};
use crate::model::Model;
use crate::nuisance::Curve;
use crate::relaxing::relax;
use crate::significance::{ONE_IN_A_THOUSAND, significant_gain, significant_search_gain};
use crate::source::Overwritten;
use crate::spectrum::TransformMemory;
use crate::survey::Survey;
use crate::window::{Window, Work};

/// Cycles from which the line may be a harmonic of a tone below it.
const CYCLES_FOR_SUBHARMONIC: f32 = 5.0;
/// Two tones are different if their frequencies are, by this share.
const DIFFERENT_SHARE: f32 = 0.1;
/// Normal deviate up to which noise explains what more unknowns gain.
const NOISE_DEVIATE: f32 = 2.0;
/// Difference of log-likelihoods up to which two tones are about as likely.
const AMBIGUOUS_LOG_ODDS: f32 = 8.0;

/// Most Gauss-Newton steps to the maximum of a model's likelihood.
const STEPS_MAX: usize = 6;
/// How often all models are surveyed at the maxima of the likeliest.
const ROUNDS: usize = 2;
/// Kinds of baselines without a curve.
const STRAIGHT_KINDS: usize = 2;
/// Share of a frequency within which maxima of several models are the same.
const SAME_MAXIMUM_SHARE: f32 = 0.02;
/// Log-likelihood that is not worth another step.
const GAIN_MIN: f32 = 1.0;
/// A step may gain more than is expected, by this factor.
const UNDERESTIMATE_MAX: f32 = 4.0;
/// Noise ratio of the likeliest model, not well known from few frames, from which on none of the models is right.
const MISFIT_NOISE_RATIO: f32 = 3.0;

/// The strongest line where the periodogram's peak `line` is a low one, or where there may be a drift alone; None if there
/// is no line. With `memory` the periodogram is also taken again, without the drift.
pub fn few_cycles(
    window: &mut Window,
    memory: Option<TransformMemory>,
    line: f32,
) -> Result<Option<SpectralLine>, Overwritten> {
    let levels = window.levels;
    let mut survey = Survey::default();
    survey.add_few_cycles(window, line)?;
    let mut drift = None;
    survey.without.iter().flatten().for_each(|without| Model::replace_if_better(&mut drift, levels, without));
    for without in survey.without.iter().flatten() {
        refine(window, without, &mut drift)?;
    }
    let Some(drift) = drift else { return Ok(None) };
    if let Some(memory) = memory {
        survey.add_on_drift(window, memory, drift.curve)?;
    }
    // The likeliest first: most others are then not worth refining.
    let (mut first, mut best) = (None, None);
    survey.tones.as_flattened().iter().flatten().for_each(|tone| Model::replace_if_better(&mut first, levels, tone));
    if let Some(first) = first {
        refine(window, &first, &mut best)?;
    }
    // A model at another maximum has not been compared with the others at this one.
    let mut known = [0.0; 1 + STRAIGHT_KINDS];
    for _ in 0..ROUNDS {
        for (k, known) in known.iter_mut().enumerate() {
            let mut likeliest = best;
            if let Some(straight) = k.checked_sub(1).and_then(|kind| survey.tones.get(kind)) {
                likeliest = None;
                let refined = straight.iter().flatten().filter(|tone| tone.refined);
                refined.for_each(|tone| Model::replace_if_better(&mut likeliest, levels, tone));
            }
            let Some(Model { nu, .. }) = likeliest else { continue };
            if (nu - *known).abs() > SAME_MAXIMUM_SHARE * nu {
                *known = nu;
                survey.add_at_maximum(window, nu)?;
            }
        }
        for place in survey.tones.as_flattened_mut() {
            if let Some(tone) = place.filter(|tone| !tone.refined) {
                *place = refine(window, &tone, &mut best)?;
            }
        }
    }
    let Some(best) = best else { return Ok(None) };
    let unknowns = best.shape.unknowns();
    let gained = gain(levels, &drift.residual_sum_of_squares, &best.residual_sum_of_squares, unknowns);
    // A drift of more unknowns has a penalty for them.
    let threshold = match unknowns > drift.shape.unknowns() {
        true => significant_search_gain(2.0 * levels.channels(), levels.frames),
        false => gained - drift.log_odds(levels, &best),
    };
    if !(gained > threshold) {
        return Ok(None);
    }
    let competitor = |tone: &&Model| {
        let differs = (tone.nu - best.nu).abs() > DIFFERENT_SHARE * best.nu;
        let more = tone.shape.unknowns().saturating_sub(unknowns);
        let threshold = if more > 0 { significant_gain(levels, more, NOISE_DEVIATE) } else { f32::NEG_INFINITY };
        let gained = gain(levels, &best.residual_sum_of_squares, &tone.residual_sum_of_squares, unknowns + more);
        differs && gained > threshold && best.log_odds(levels, tone) > -AMBIGUOUS_LOG_ODDS
    };
    let without_slope = 2.0 * best.nu < CYCLES_FOR_SLOPE;
    let noise_ratio = noise_ratio(levels, &best.residual_sum_of_squares, unknowns);
    let misfit = without_slope && noise_ratio.is_some_and(|ratio| ratio > MISFIT_NOISE_RATIO);
    let ambiguous = misfit || survey.tones.as_flattened().iter().flatten().find(competitor).is_some();
    let harmonics = if without_slope { significant_harmonics(window, &best)? } else { 0 };
    Ok(Some(SpectralLine {
        nu: best.nu,
        slope: best.shape.slope || !without_slope,
        curve: best.curve,
        suspects: [2.0 * best.nu >= CYCLES_FOR_SUBHARMONIC; 2],
        harmonics,
        ambiguous,
    }))
}

/// Harmonics of the likeliest model, and above them as many as are significant: those need not distinguish it from another
/// model.
fn significant_harmonics(window: &mut Window, best: &Model) -> Result<usize, Overwritten> {
    let nuisances = window.nuisances(best.curve)?;
    let shape = Shape { harmonics: window.harmonics(best.nu), ..best.shape };
    let Window { span, levels, work: Work { sums, solution }, .. } = window;
    sums.collect(span, levels, &nuisances, best.nu, shape.harmonics)?;
    let (mut significant, mut least) = (best.shape.harmonics, best.residual_sum_of_squares);
    solution.residual_sums(sums, levels, &nuisances, &shape, &mut |harmonics, residual_sum_of_squares| {
        let more = 2 * harmonics.saturating_sub(significant);
        let unknowns = Shape { harmonics, ..shape }.unknowns();
        if more > 0
            && gain(levels, &least, residual_sum_of_squares, unknowns)
                > significant_gain(levels, more, ONE_IN_A_THOUSAND)
        {
            (significant, least) = (harmonics, *residual_sum_of_squares);
        }
    });
    Ok(significant)
}

/// A model at the maximum of its likelihood, which replaces `best` if it is likelier; None if there is no maximum, or if
/// its equations are singular.
#[inline(never)]
fn refine(window: &mut Window, from: &Model, best: &mut Option<Model>) -> Result<Option<Model>, Overwritten> {
    let levels = window.levels;
    let (mut top, mut model) = (None, Model { refined: true, ..*from });
    let straight = matches!(from.curve, Curve::Relaxing(_)) || from.nu == 0.0;
    let nuisances = window.nuisances(if straight { Curve::None } else { from.curve })?;
    for _ in 0..STEPS_MAX {
        let next = match model.curve {
            Curve::Relaxing(_) => relax(window, &mut model)?,
            _ if model.nu > 0.0 => step(&mut Problem::new(window, &nuisances), &mut model)?,
            _ => Some((model, 0.0)),
        };
        let Some((next, expected_gain)) = next else { break };
        Model::replace_if_better(&mut top, levels, &model);
        let log_odds = best.as_ref().map_or(0.0, |best| best.log_odds(levels, &model));
        if expected_gain < GAIN_MIN || log_odds + UNDERESTIMATE_MAX * expected_gain < -AMBIGUOUS_LOG_ODDS {
            break;
        }
        (model.nu, model.curve) = (next.nu, next.curve);
    }
    if let Some(top) = &top {
        Model::replace_if_better(best, levels, top);
    }
    Ok(top)
}

/// Finds the residuals of a model, and where a step leads, with the log-likelihood that is expected there; None if the
/// equations are singular.
fn step(problem: &mut Problem, model: &mut Model) -> Result<Option<(Model, f32)>, Overwritten> {
    problem.pass(model.nu, model.shape.harmonics)?;
    if problem.step(model.shape).is_none() {
        return Ok(None);
    }
    let solution = problem.solution();
    model.residual_sum_of_squares = solution.residual_sum_of_squares;
    Ok(Some((Model { nu: solution.nu, ..*model }, expected_gain(problem.window.levels, solution))))
}
