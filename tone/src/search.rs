//! Where the fit starts: the strongest line, the baseline under it, and the fundamental it belongs to.
//!
//! A grating's tone lies far below the frame rate, so the search runs on means of a few frames: a
//! fraction of the work, and a guess is all that is wanted. Only if those means have lost the better
//! part of the signal's power - the tone is fast, or there is none - does it run on the frames
//! themselves.

use crate::descent::{CYCLES_FOR_SLOPE, LINE_CLOSE, Problem, Work};
use crate::few_cycles::few_cycles;
use crate::frame_span::{BLOCK, FrameSpan};
use crate::fundamental::{AMBIGUOUS_SHARE, fundamental, harmonics_below_nyquist};
use crate::levels::{Levels, Means, QUAD, levels};
use crate::nuisance::{CURVE, Curve, Nuisances};
use crate::significance::significant_gain;
use crate::solve::{Shape, Solution, gain, residual_sum_of_squares};
use crate::source::CHANNELS_MAX;
use crate::source::{Table, Values};
use crate::spectrum::{POINTS_MAX, power_near, strongest};

/// Power in the periodogram from which it is worth to fit lines below the strongest at all: half of what
/// makes the fundamental open.
const WORTH_A_LOOK: f32 = 0.02;
/// Means that a search on means has at the most; a window of one second at 241 Hz has 60 of 4 frames.
const MEANS_MAX: usize = 64;
/// Fewer frames than this are searched themselves.
const FRAMES_FOR_MEANS: u32 = 128;
/// Fewer means than this are not enough for a handful of harmonics.
const MEANS_FOR_HARMONICS: usize = 48;
/// Frames from which steps from block to block, a dozen, show a bend.
const FRAMES_FOR_STEPS: u32 = 12 * BLOCK as u32;
/// Share of the power that the means must keep.
const MEANS_SHARE: f32 = 0.5;
/// Peaks below this many cycles per half window are looked at by exact likelihoods.
const LOW_NU: f32 = 1.75;
/// Cycles from which on no wave looks like a drift that relaxes.
const CYCLES_UNLIKE_DRIFT: f32 = 2.5;
/// Channels whose means are transformed: a guess is all that is wanted.
const CLEAREST: usize = 4;
/// Steps from a periodogram's peak to the line it belongs to.
pub(crate) const LINE_STEPS: usize = 4;
/// Normal deviate from which a curve of the baseline is taken for one: a wrong one costs little.
const CURVED: f32 = 3.0;
/// Normal deviate within which residuals are the noise.
const SURE: f32 = 3.0;

/// The strongest line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpectralLine {
    /// Cycles per half window ([`crate::frame_span`]).
    pub nu: f32,
    /// Whether there is a slope under it.
    pub slope: bool,
    /// The curve under it.
    pub curve: Curve,
    /// Harmonics that it carries; 0 if that is not known yet.
    pub harmonics: usize,
    /// Whether it may be the second, or the third, harmonic of its tone.
    pub suspects: [bool; 2],
    /// It is open whether this is the tone.
    pub ambiguous: bool,
}

/// Where the fit starts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Start {
    /// Cycles per half window ([`crate::frame_span`]).
    pub nu: f32,
    /// It is open whether this is the fundamental.
    pub ambiguous: bool,
    /// The fundamental below the strongest line that it belongs, or may belong, to; 0 if there is none.
    pub below: f32,
    /// Whether each channel has a slope.
    pub slope: bool,
    /// Curve of each channel.
    pub curve: Curve,
    /// Harmonics to fit; 0 if that is not known yet.
    pub harmonics: usize,
}

impl Start {
    /// At a line that is its own fundamental.
    pub(crate) fn at(line: &SpectralLine) -> Self {
        let SpectralLine { nu, ambiguous, slope, curve, harmonics, .. } = *line;
        Self { nu, ambiguous, below: 0.0, slope, curve, harmonics }
    }
}

/// Room for transforms, and the channels to be transformed, bit k for taxel k.
pub struct Place<'a> {
    /// Which channels.
    pub channels: u16,
    /// Room for transforms.
    pub points: &'a mut [f32],
    /// For half of one.
    pub power: &'a mut [f32],
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
    span: &mut FrameSpan,
    levels: &Levels,
    scratch: &mut Scratch,
    work: &mut Work,
    harmonics: usize,
) -> Option<Option<Start>> {
    let Scratch { points, power } = scratch;
    match look(span, levels, Place { channels: u16::MAX, points, power }, work, harmonics)? {
        Some(line) => {
            let carried = harmonics_below_nyquist(span, line.nu, harmonics);
            settle(span, levels, work, line, harmonics, carried).map(Some)
        }
        None => Some(None),
    }
}

/// What the means of groups of frames say.
pub struct Coarse {
    /// Frames of a group.
    by: u32,
    count: usize,
    valid: [u16; MEANS_MAX],
    /// Levels of the means.
    levels: Levels,
}

/// Levels of a stretch, and its means in `scratch` unless it is too short for them. None if frames were overwritten.
pub fn levels_and_means(span: &mut FrameSpan, scratch: &mut Scratch) -> Option<(Levels, Option<Coarse>)> {
    if span.frames < FRAMES_FOR_MEANS || !span.is_in_time() {
        return Some((levels(span, None)?, None));
    }
    let (mut by, mut valid) = (QUAD as u32, [0; MEANS_MAX]);
    while span.frames.checked_div(by)? > MEANS_MAX as u32 {
        by *= 2;
    }
    let count = span.frames.checked_div(by)? as usize;
    let (values, _) = scratch.points.as_chunks_mut();
    let mut means = Means::new(by, values.get_mut(..count)?, valid.get_mut(..count)?);
    let all = levels(span, Some(&mut means))?;
    let levels = means.levels(&all, span.taxels);
    Some((all, Some(Coarse { by, count, valid, levels })))
}

/// The same as [`search`] by the means of `coarse`, which [`levels_and_means`] left in `scratch`. The inner None says
/// that they are of no use here.
pub fn search_coarse(
    span: &mut FrameSpan,
    levels_of_all: &Levels,
    coarse: &Option<Coarse>,
    scratch: &mut Scratch,
    work: &mut Work,
    harmonics: usize,
) -> Option<Option<Start>> {
    let Some(coarse) = coarse else { return Some(None) };
    // A gap gives a line high skirts: that takes all channels and all frames to see through.
    if 10 * levels_of_all.frames < 9 * span.frames {
        return Some(None);
    }
    let (values, _) = scratch.points.as_chunks();
    let mut table = Table { values: values.get(..coarse.count)?, valid: coarse.valid.get(..coarse.count)? };
    let mut means = span.means(&mut table, coarse.count as u32, coarse.by);
    let levels = &coarse.levels;
    if levels.usable != levels_of_all.usable {
        return Some(None);
    }
    let (mut kept, mut shares) = (0.0, [0.0; CHANNELS_MAX]);
    for c in 0..CHANNELS_MAX {
        if levels.usable & 1 << c != 0 {
            shares[c] = levels.about_line[c] / (coarse.by as f32 * levels_of_all.about_line[c]);
            kept += shares[c];
        }
    }
    if !(kept >= MEANS_SHARE * levels.channels()) {
        return Some(None);
    }
    let channels = clearest(&shares, levels.usable);
    let (points, power) = scratch.power.split_at_mut(POINTS_MAX / 4);
    let Some(line) = look(&mut means, levels, Place { channels, points, power }, work, harmonics)? else {
        return Some(None);
    };
    // The means cover whole groups of frames only.
    let scale = span.frames as f32 / (coarse.count as u32 * coarse.by) as f32;
    if levels.frames as usize >= MEANS_FOR_HARMONICS || harmonics == 1 {
        // Those beyond half the rate of the means are where sampling folds them.
        let carried = harmonics_below_nyquist(span, line.nu * scale, harmonics);
        let start = settle(&mut means, levels, work, line, harmonics, carried)?;
        Some(Some(Start { nu: start.nu * scale, ..start }))
    } else {
        let line = SpectralLine { nu: line.nu * scale, ..line };
        let carried = harmonics_below_nyquist(span, line.nu, harmonics);
        settle(span, levels_of_all, work, line, harmonics, carried).map(Some)
    }
}

/// The channels that means keep most of: what is slow in them is no noise.
#[inline(never)]
fn clearest(shares: &Values, usable: u16) -> u16 {
    let (mut channels, mut left) = (0, usable);
    // Not unrolled: that would take half a kilobyte of flash.
    for _ in 0..core::hint::black_box(CLEAREST) {
        let (mut best, mut most, mut residual_sum_of_squares) = (0, -1.0, left);
        while residual_sum_of_squares != 0 {
            let c = residual_sum_of_squares.trailing_zeros() as usize % CHANNELS_MAX;
            residual_sum_of_squares &= residual_sum_of_squares - 1;
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
    span: &mut FrameSpan,
    levels: &Levels,
    place: Place,
    work: &mut Work,
    most: usize,
) -> Option<Option<SpectralLine>> {
    let Place { channels, points, power } = place;
    let nuisances = Nuisances::new(span, levels, Curve::None)?;
    let count = nuisances.count();
    let peak = strongest(span, levels, &nuisances, 0.5, channels, points, power)?;
    let Some(peak) = peak else { return Some(None) };
    if peak <= LOW_NU {
        return few_cycles(span, levels, work, most, Some(Place { channels, points, power }), peak);
    }
    let mut problem = Problem::new(span, levels, &nuisances, work);
    if !problem.descend(peak, Shape { harmonics: 1, slope: true, nuisances: count }, LINE_STEPS, LINE_CLOSE)? {
        return Some(None);
    }
    let (frames, most, nu) = (problem.span.frames as usize, points.len(), problem.solution().nu);
    let power_at = |nu: f32| power_near(frames, most, power, nu);
    let worth = WORTH_A_LOOK * power_at(nu);
    let suspects = [power_at(nu / 2.0) + power_at(nu * 1.5) >= worth, power_at(nu / 3.0) + power_at(nu / 1.5) >= worth];
    Some(Some(SpectralLine { nu, slope: true, curve: Curve::None, harmonics: 0, suspects, ambiguous: false }))
}

/// Whether a converged solution without a curve leaves one: by steps from block to block where there are many of them,
/// else by another pass. None if frames were overwritten.
pub fn is_bent(problem: &mut Problem) -> Option<bool> {
    let Problem { span, levels, nuisances, work, .. } = problem;
    let (shape, nu) = (work.solution.shape, work.solution.nu);
    if span.is_in_time() && span.frames >= FRAMES_FOR_STEPS {
        let bent = residual_sum_of_squares(&work.sums, levels, nuisances, &shape, true);
        let gained = bent
            .map_or(0.0, |bent| gain(levels, &work.solution.residual_sum_of_squares, &bent, shape.unknowns() + CURVE));
        return Some(gained > significant_gain(levels, CURVE, CURVED));
    }
    let nuisances = Nuisances::new(span, levels, Curve::Bent)?;
    let mut bent = Problem::new(span, levels, &nuisances, work);
    bent.pass(nu, shape.harmonics)?;
    Some(bent.step(shape).is_some() && is_curved(&bent))
}

/// Whether a curve besides takes more off what the latest solution leaves than noise would let it. Both are
/// compared where their steps lead.
#[inline(never)]
pub fn is_curved(problem: &Problem) -> bool {
    let Problem { levels, nuisances, work, nu, .. } = problem;
    let (straight, mut curved) = (&work.solution, Solution::NONE);
    let shape = Shape { nuisances: nuisances.count(), ..straight.shape };
    if curved.solve(&work.sums, levels, nuisances, *nu, shape).is_none() {
        return false;
    }
    let ahead = |solution: &Solution| 0.5 * solution.step * solution.step * solution.information;
    let gained = gain(levels, &straight.residual_sum_of_squares, &curved.residual_sum_of_squares, shape.unknowns());
    gained + ahead(&curved) - ahead(straight) > significant_gain(levels, CURVE, CURVED)
}

/// From the strongest line to where the fit starts: its fundamental, of at `most` so many harmonics, close to where
/// all of them want it; the line itself may have `carried`. None if frames were overwritten.
// Called with means and with frames: one copy is enough.
#[inline(never)]
fn settle(
    span: &mut FrameSpan,
    levels: &Levels,
    work: &mut Work,
    mut line: SpectralLine,
    most: usize,
    carried: usize,
) -> Option<Start> {
    if most < 2 || line.harmonics > 0 && line.suspects == [false; 2] {
        return Some(Start::at(&line));
    }
    let harmonics = harmonics_below_nyquist(span, line.nu, most);
    let many = 2.0 * line.nu >= CYCLES_FOR_SLOPE;
    if many && line.curve == Curve::None {
        let suspected = line.suspects != [false; 2];
        if carried < 2 && !suspected {
            return Some(Start::at(&line));
        }
        let nuisances = Nuisances::new(span, levels, Curve::None)?;
        let mut problem = Problem::new(span, levels, &nuisances, work);
        let shape = Shape { harmonics: carried, slope: line.slope, nuisances: nuisances.count() };
        if problem.descend(line.nu, shape, 1, LINE_CLOSE)? && (!suspected || explains_all(&problem)) {
            return Some(Start { nu: problem.solution().nu, ..Start::at(&line) });
        }
    }
    let curve = if line.curve == Curve::None { Curve::Bent } else { line.curve };
    let nuisances = Nuisances::new(span, levels, curve)?;
    let straight = nuisances.count() - CURVE;
    let mut problem = Problem::new(span, levels, &nuisances, work);
    if many && line.curve == Curve::None {
        let shape = Shape { harmonics, slope: line.slope, nuisances: straight };
        if problem.descend(line.nu, shape, 1, LINE_CLOSE)? && is_curved(&problem) {
            line.curve = Curve::Bent;
        }
    }
    let used = straight + if line.curve == Curve::None { 0 } else { CURVE };
    let mut start = fundamental(&mut problem, &line, used)?;
    if start.below > 0.0 && 2.0 * start.below < CYCLES_UNLIKE_DRIFT {
        // Those lines may be a drift.
        let Problem { span, levels, work, .. } = problem;
        if let Some(line) = few_cycles(span, levels, work, most, None, line.nu)? {
            return Some(Start::at(&line));
        }
        return Some(start);
    }
    // What the steps below would take for its baseline is another.
    if matches!(start.curve, Curve::Relaxing(_)) {
        return Some(start);
    }
    let harmonics = harmonics_below_nyquist(problem.span, start.nu, most);
    let shape = Shape { harmonics, slope: start.slope, nuisances: used };
    if 2.0 * start.nu >= CYCLES_FOR_SLOPE && problem.descend(start.nu, shape, 1, LINE_CLOSE)? {
        start.nu = problem.solution().nu;
    }
    Some(start)
}

/// Whether the latest solution leaves noise and no more, by the frames' own ([`Levels::rough`]), where lines in between,
/// strong enough to make the fundamental open, would show.
fn explains_all(problem: &Problem) -> bool {
    let (levels, solution) = (problem.levels, problem.solution());
    let unknowns = solution.shape.unknowns();
    let Some(left) = problem.over_noise() else { return false };
    // Of the residuals and of as many third differences.
    let variance = 2.0 / (levels.frames as f32 - unknowns as f32).max(1.0) + 2.0 / levels.frames as f32;
    let sigma = libm::sqrtf(variance / levels.channels());
    let power = solution.power.iter().sum::<f32>() / (levels.frames as f32 * levels.channels());
    (left - 1.0).abs() < SURE * sigma && 0.5 * AMBIGUOUS_SHARE * power > 2.0 * SURE * sigma
}
