//! Where the fit starts: the strongest line, the baseline under it, and the fundamental it belongs to.
//!
//! A tone often lies far below the frame rate, so the search runs on means of a few frames, which is enough for a guess
//! and a fraction of the work. Only if those means have lost the better part of the signal's power - the tone is fast, or
//! there is none - does it run on the frames themselves.

use crate::coarse::{Coarse, Scratch};
use crate::curvature::is_curved;
use crate::descent::{CYCLES_FOR_SLOPE, GUESS_SIGMAS, Problem};
use crate::equations::Shape;
use crate::few_cycles::few_cycles;
use crate::fundamental::{AMBIGUOUS_POWER_SHARE, fundamental};
use crate::guess::{InitialGuess, SpectralLine};
use crate::limits::CURVE_FUNCTIONS;
use crate::nuisance::Curve;
use crate::source::Overwritten;
use crate::spectrum::TransformMemory;
use crate::window::Window;

/// Power at the places of a subharmonic's lines, as a share of the strongest line's, from which they are fitted: half of
/// what makes the fundamental ambiguous.
const SUSPECT_POWER_SHARE: f32 = 0.02;
/// Fewer means than this are not enough for several harmonics.
const MEANS_FOR_HARMONICS: u32 = 48;
/// Peaks below this many cycles per half window are compared by exact likelihoods.
const FEW_CYCLES_NU: f32 = 1.75;
/// Cycles from which on no wave resembles a drift that relaxes.
const CYCLES_UNLIKE_DRIFT: f32 = 2.5;
/// Most steps from a periodogram's peak to its line.
const LINE_STEPS: usize = 4;
/// Fewest cycles in the window of a peak.
const PEAK_CYCLES_MIN: f32 = 0.5;
/// Normal deviate within which residuals are noise alone.
const NOISE_DEVIATE: f32 = 3.0;

/// A guess from the frames themselves; None if the window holds nothing to start from.
pub fn search(window: &mut Window, scratch: &mut Scratch) -> Result<Option<InitialGuess>, Overwritten> {
    let Some(line) = strongest_line(window, scratch.for_transforms())? else { return Ok(None) };
    let harmonics = window.harmonics(line.nu);
    guess_from(window, line, harmonics).map(Some)
}

/// A guess from the means of `coarse`, which are in `scratch`; None if they are of no use here.
pub fn search_means(
    window: &mut Window,
    coarse: Option<&Coarse>,
    scratch: &mut Scratch,
) -> Result<Option<InitialGuess>, Overwritten> {
    let Some(coarse) = coarse else { return Ok(None) };
    let (span, all) = (&window.span, window.levels);
    // A gap gives a line high skirts: only all channels and all frames separate them from lines.
    if 10 * all.frames < 9 * span.frames || coarse.levels.usable != all.usable {
        return Ok(None);
    }
    let Some((mut table, memory)) = coarse.split(all, scratch) else { return Ok(None) };
    let mut means = Window {
        span: span.means(&mut table, coarse.count as u32, coarse.by),
        levels: &coarse.levels,
        work: &mut *window.work,
        harmonics_max: window.harmonics_max,
    };
    let Some(line) = strongest_line(&mut means, memory)? else { return Ok(None) };
    // The means cover whole groups of frames only.
    let scale = span.frames as f32 / (coarse.count as u32 * coarse.by) as f32;
    // Of the harmonics beyond half the rate of the means the aliases are fitted.
    let harmonics = span.harmonics_below_nyquist(line.nu * scale, window.harmonics_max);
    if coarse.levels.frames >= MEANS_FOR_HARMONICS || window.harmonics_max == 1 {
        let guess = guess_from(&mut means, line, harmonics)?;
        return Ok(Some(InitialGuess { nu: guess.nu * scale, ..guess }));
    }
    guess_from(window, SpectralLine { nu: line.nu * scale, ..line }, harmonics).map(Some)
}

/// The strongest line; None if there is none.
// Large and called from several places: one copy is enough.
#[inline(never)]
fn strongest_line(window: &mut Window, mut memory: TransformMemory) -> Result<Option<SpectralLine>, Overwritten> {
    let nuisances = window.nuisances(Curve::None)?;
    let peak = memory.strongest(&mut window.span, window.levels, &nuisances, PEAK_CYCLES_MIN)?;
    let Some(peak) = peak else { return Ok(None) };
    if peak <= FEW_CYCLES_NU {
        return few_cycles(window, Some(memory), peak);
    }
    let mut problem = Problem::new(window, &nuisances);
    let shape = Shape { harmonics: 1, slope: true, nuisances: nuisances.count() };
    if !problem.descend(peak, shape, LINE_STEPS, GUESS_SIGMAS)? {
        return Ok(None);
    }
    let (frames, nu) = (problem.window.span.frames as usize, problem.solution().nu);
    let power = |nu: f32| memory.power_near(frames, nu);
    let least = SUSPECT_POWER_SHARE * power(nu);
    let suspects = [power(nu / 2.0) + power(nu * 1.5) >= least, power(nu / 3.0) + power(nu / 1.5) >= least];
    Ok(Some(SpectralLine { nu, slope: true, curve: Curve::None, harmonics: 0, suspects, ambiguous: false }))
}

/// From the strongest line, fitted with `harmonics` harmonics, to where the fit starts: at its fundamental, close to the
/// maximum of the likelihood.
// Called with means and with frames: one copy is enough.
#[inline(never)]
fn guess_from(window: &mut Window, mut line: SpectralLine, harmonics: usize) -> Result<InitialGuess, Overwritten> {
    if window.harmonics_max < 2 || line.harmonics > 0 && !line.is_suspected() {
        return Ok(InitialGuess::at(&line));
    }
    let separates_slope = 2.0 * line.nu >= CYCLES_FOR_SLOPE;
    if separates_slope && line.curve == Curve::None {
        if harmonics < 2 && !line.is_suspected() {
            return Ok(InitialGuess::at(&line));
        }
        let nuisances = window.nuisances(Curve::None)?;
        let mut problem = Problem::new(window, &nuisances);
        let shape = Shape { harmonics, slope: line.slope, nuisances: nuisances.count() };
        if problem.descend(line.nu, shape, 1, GUESS_SIGMAS)? && (!line.is_suspected() || explains_all(&problem)) {
            return Ok(InitialGuess { nu: problem.solution().nu, ..InitialGuess::at(&line) });
        }
    }
    let harmonics = window.harmonics(line.nu);
    let nuisances = window.nuisances(if line.curve == Curve::None { Curve::Bent } else { line.curve })?;
    let straight = nuisances.count() - CURVE_FUNCTIONS;
    let mut problem = Problem::new(window, &nuisances);
    if separates_slope && line.curve == Curve::None {
        let shape = Shape { harmonics, slope: line.slope, nuisances: straight };
        if problem.descend(line.nu, shape, 1, GUESS_SIGMAS)? && is_curved(&problem) {
            line.curve = Curve::Bent;
        }
    }
    let nuisances = straight + if line.curve == Curve::None { 0 } else { CURVE_FUNCTIONS };
    let mut guess = fundamental(&mut problem, &line, nuisances)?;
    if guess.below > 0.0 && 2.0 * guess.below < CYCLES_UNLIKE_DRIFT {
        // Its lines may be a drift.
        let line = few_cycles(problem.window, None, line.nu)?;
        return Ok(line.map_or(guess, |line| InitialGuess::at(&line)));
    }
    // The step below would have another baseline than a relaxing one.
    if matches!(guess.curve, Curve::Relaxing(_)) {
        return Ok(guess);
    }
    let shape = Shape { harmonics: problem.window.harmonics(guess.nu), slope: guess.slope, nuisances };
    if 2.0 * guess.nu >= CYCLES_FOR_SLOPE && problem.descend(guess.nu, shape, 1, GUESS_SIGMAS)? {
        guess.nu = problem.solution().nu;
    }
    Ok(guess)
}

/// Whether the residuals of the latest solution are noise alone: lines in between, strong enough to make the fundamental
/// ambiguous, would show in them.
fn explains_all(problem: &Problem) -> bool {
    let (levels, solution) = (problem.window.levels, problem.solution());
    let unknowns = solution.shape.unknowns();
    let Some(noise_ratio) = problem.noise_ratio() else { return false };
    // Of the residuals and of as many third differences.
    let variance = 2.0 / (levels.frames as f32 - unknowns as f32).max(1.0) + 2.0 / levels.frames as f32;
    let sigma = libm::sqrtf(variance / levels.channels());
    let power = solution.power.iter().sum::<f32>() / (levels.frames as f32 * levels.channels());
    (noise_ratio - 1.0).abs() < NOISE_DEVIATE * sigma
        && 0.5 * AMBIGUOUS_POWER_SHARE * power > 2.0 * NOISE_DEVIATE * sigma
}
