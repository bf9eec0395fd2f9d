//! Where the fit starts: the strongest line, and whether it is the fundamental.
//!
//! A grating's tone lies far below the frame rate, so the search runs on means of a few frames: a
//! fraction of the work, and a guess is all that is wanted. Only if those means have lost the better
//! part of the signal's power - the tone is fast, or there is none - does it run on the frames
//! themselves.

use crate::descent::{CYCLES_MIN, Problem, Work, shape_at};
use crate::levels::{Levels, Means, QUAD, levels};
use crate::moments::HARMONICS_MAX;
use crate::nuisance::Nuisances;
use crate::settings::TAXELS;
use crate::solve::{Solution, gain, rest};
use crate::spectrum::{POINTS_MAX, power_near, strongest};
use crate::stretch::Stretch;
use crate::window::{Table, Values};

/// Share of the tone's power that the lines in between must have for a tone an octave (or a
/// twelfth) below the strongest line.
const SUBHARMONIC_SHARE: f32 = 0.1;
/// Share from which such lines leave it open which of the two it is.
const AMBIGUOUS_SHARE: f32 = 0.04;
/// Power in the periodogram from which it is worth to fit them at all: half of that.
const WORTH_A_LOOK: f32 = 0.02;
/// A harmonic is a line where the fundamental says it is, within this many cycles per window: real
/// combs in recordings keep to 0.01, the skirts of drifts and of other lines are off by 0.1 and more.
const LINE_OFFSET_MAX: f32 = 0.06;
/// Means that a search on means has at the most; a window of one second at 241 Hz has 60 of 4 frames.
const MEANS_MAX: usize = 64;
/// Fewer frames than this are searched themselves.
const FRAMES_FOR_MEANS: u32 = 41;
/// Share of the power that the means must keep.
const MEANS_SHARE: f32 = 0.5;
/// Peaks below this many cycles per half window are looked at by exact likelihoods.
const LOW_NU: f32 = 1.75;
/// Channels whose means are transformed: a guess is all that is wanted.
const CLEAREST: usize = 4;
/// An error of a line this many standard deviations large is none: the fit goes on from there.
const LINE_CLOSE: f32 = 2.0;
/// Steps from a periodogram's peak to the line it belongs to.
const LINE_STEPS: usize = 2;

/// Where the fit starts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Start {
    /// Cycles per half window ([`crate::moments`]).
    pub nu: f32,
    /// It is open whether this is the fundamental.
    pub ambiguous: bool,
}

/// Scratch memory of the search: transforms, or the means and their transforms.
#[derive(Debug)]
pub struct Scratch {
    points: [f32; POINTS_MAX],
    power: [f32; POINTS_MAX / 2],
    /// Sums and solution of the latest pass.
    pub work: Work,
}

impl Scratch {
    /// Scratch memory; `const`, so that it can live in a static.
    pub const fn new() -> Self {
        Self { points: [0.0; POINTS_MAX], power: [0.0; POINTS_MAX / 2], work: Work::new() }
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
    harmonics: usize,
) -> Option<Option<Start>> {
    look(stretch, levels, u16::MAX, &mut scratch.points, &mut scratch.power, &mut scratch.work, harmonics)
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

/// The same by the means of `coarse`, which [`levels_and_means`] left in `scratch`. The inner None says that they are of
/// no use here.
pub fn search_coarse(
    stretch: &Stretch,
    levels_of_all: &Levels,
    coarse: &Coarse,
    scratch: &mut Scratch,
    harmonics: usize,
) -> Option<Option<Start>> {
    if coarse.by == 0 {
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
    if !(kept >= MEANS_SHARE * levels.usable.count_ones() as f32) {
        return Some(None);
    }
    let channels = clearest(&shares, levels.usable);
    let (points, power) = scratch.power.split_at_mut(POINTS_MAX / 4);
    let start = look(&mut means, &levels, channels, points, power, &mut scratch.work, harmonics)?;
    // The means cover whole groups of frames only.
    let scale = stretch.frames as f32 / (coarse.count as u32 * coarse.by) as f32;
    Some(start.map(|start| Start { nu: start.nu * scale, ..start }))
}

/// The channels that means keep most of: what is slow in them is no noise.
fn clearest(shares: &Values, usable: u16) -> u16 {
    let mut channels = 0;
    for _ in 0..CLEAREST {
        let left = (0..TAXELS).filter(|c| usable & !channels & 1 << c != 0);
        let best = left.reduce(|best, c| if shares[c] > shares[best] { c } else { best });
        channels |= best.map_or(0, |c| 1 << c);
    }
    channels
}

/// The strongest line and the fundamental it belongs to. The inner None says that there is none.
// Large and called from several places: one copy is enough.
#[inline(never)]
fn look(
    stretch: &mut Stretch,
    levels: &Levels,
    channels: u16,
    points: &mut [f32],
    power: &mut [f32],
    work: &mut Work,
    harmonics: usize,
) -> Option<Option<Start>> {
    let nuisances = Nuisances::new(stretch, levels, false)?;
    let Some(peak) = strongest(stretch, levels, &nuisances, channels, points, power) else { return Some(None) };
    let low = peak <= LOW_NU;
    // Low lines lean on each other too much for a periodogram to say that there is nothing.
    let (frames, most) = (stretch.frames as usize, points.len());
    let power_at = |nu: f32| if low { 1.0 } else { power_near(frames, most, power, nu) };
    let mut problem = Problem::new(stretch, levels, &nuisances, work);
    let nu = if low { strongest_low(&mut problem, peak)? } else { peak };
    fundamental(&mut problem, nu, harmonics, power_at)
}

/// The strongest line among the low ones by exact likelihoods: a line of few cycles leans on its
/// own mirror image, and a periodogram's peak is off by that.
fn strongest_low(problem: &mut Problem, peak: f32) -> Option<f32> {
    let (mut best, mut most) = (peak, f32::MIN);
    let mut cycles = CYCLES_MIN;
    while cycles < 5.0 {
        let nu = 0.5 * cycles;
        let shape = shape_at(nu, 1, problem.nuisances.count());
        problem.pass(nu, 1)?;
        if let Some(rest) = rest(&problem.work.sums, problem.levels, problem.nuisances, &shape) {
            // All against constants; the slopes' own gain has to pay for their unknowns.
            let paid = if shape.slope { 8.0 * libm::logf(problem.levels.frames as f32) } else { 0.0 };
            let gain =
                gain(problem.levels, &problem.levels.about_mean, &rest, shape.unknowns() - shape.slope as usize) - paid;
            if gain > most {
                (best, most) = (nu, gain);
            }
        }
        cycles += 0.2 + 0.1 * cycles;
    }
    Some(best)
}

/// As many of `harmonics` as stay clear of half the frame rate.
pub fn harmonics_below_nyquist(stretch: &Stretch, nu: f32, harmonics: usize) -> usize {
    let mut below = 1;
    while below < harmonics && (below + 1) as f32 * nu < 0.96 * stretch.nu_most() {
        below += 1;
    }
    below
}

/// Whether the strongest line is the fundamental, or the second or third harmonic of one; and
/// whether that is open. The inner None says that the window is too short to tell anything.
fn fundamental(
    problem: &mut Problem,
    strongest: f32,
    harmonics: usize,
    power_at: impl Fn(f32) -> f32,
) -> Option<Option<Start>> {
    let nuisances = problem.nuisances.count();
    if !problem.descend(strongest, shape_at(strongest, 1, nuisances), LINE_STEPS, LINE_CLOSE)? {
        return Some(None);
    }
    let line = problem.solution().nu;
    let mut start = Start { nu: line, ambiguous: false };
    if harmonics < 2 {
        return Some(Some(start));
    }
    let mut highest = AMBIGUOUS_SHARE;
    for part in [2usize, 3] {
        let nu = line / part as f32;
        let harmonics = harmonics_below_nyquist(problem.stretch, nu, (part + 2).min(HARMONICS_MAX));
        if 2.0 * nu < 1.0 || harmonics < part {
            continue;
        }
        let between = match part {
            2 => power_at(nu) + power_at(3.0 * nu),
            _ => power_at(nu) + power_at(2.0 * nu),
        };
        if between < WORTH_A_LOOK * power_at(line) {
            continue;
        }
        let shape = shape_at(nu, harmonics, nuisances);
        // Most are seen not to be one at first sight.
        if !problem.descend(nu, shape, 1, LINE_CLOSE)?
            || share_between(problem.solution(), part) < 0.5 * highest
            || !problem.converge(problem.solution().nu, shape)?
        {
            continue;
        }
        let comb = problem.solution();
        if (comb.nu - nu).abs() > 0.25 {
            continue;
        }
        let (share, nu) = (share_between(comb, part), comb.nu);
        if share > highest
            && lines_hold(comb, part, power_by_chance(problem.levels))
            && better_than_overtones(problem, line)?
        {
            highest = share;
            let taken = share > SUBHARMONIC_SHARE;
            start = Start { nu: if taken { nu } else { start.nu }, ambiguous: !taken };
        }
    }
    Some(Some(start))
}

/// Whether a comb, the latest solution, explains the window clearly better than the strongest line with overtones of its
/// own: across a gap in the window the lines of a comb can be large and cancel each other, and they
/// take up what those overtones leave.
fn better_than_overtones(problem: &mut Problem, strongest: f32) -> Option<bool> {
    let (shape, rest) = (problem.solution().shape, problem.solution().rest);
    let harmonics = harmonics_below_nyquist(problem.stretch, strongest, shape.harmonics);
    if !problem.converge(strongest, shape_at(strongest, harmonics, shape.nuisances))? {
        return Some(true);
    }
    let more = (shape.harmonics - harmonics).max(1) as f32 * problem.levels.usable.count_ones() as f32;
    let gained = gain(problem.levels, &problem.solution().rest, &rest, shape.unknowns());
    Some(gained > 0.5 * chi_square_point(2.0 * more, ONE_IN_A_THOUSAND))
}

/// Share of the power in harmonics that are no multiple of `part`.
fn share_between(comb: &Solution, part: usize) -> f32 {
    let (mut between, mut all) = (0.0, 0.0);
    for (h, power) in comb.power.iter().enumerate().take(comb.shape.harmonics) {
        all += power;
        if (h + 1) % part != 0 {
            between += power;
        }
    }
    if all > 0.0 { between / all } else { 0.0 }
}

/// Normal deviate that is exceeded once in a thousand times.
const ONE_IN_A_THOUSAND: f32 = 3.09;

/// Point of a chi-square distribution by the normal deviate of the same tail (Wilson and Hilferty's
/// cube; off by under 1 % from two degrees of freedom on).
pub fn chi_square_point(degrees: f32, deviate: f32) -> f32 {
    let cube = 1.0 - 2.0 / (9.0 * degrees) + deviate * libm::sqrtf(2.0 / (9.0 * degrees));
    degrees * cube * cube * cube
}

/// Power of one line over all channels, in units of their noise, that noise alone reaches once in a
/// thousand times: two degrees of freedom for each channel.
pub fn power_by_chance(levels: &Levels) -> f32 {
    chi_square_point(2.0 * levels.usable.count_ones() as f32, ONE_IN_A_THOUSAND)
}

/// Whether the lines of a comb below its strongest one, the `part`-th, are lines of their own: each
/// stands out of the noise, and the first is at its place, so that it is not the skirt of a drift or
/// of another line.
fn lines_hold(comb: &Solution, part: usize, by_chance: f32) -> bool {
    let off = comb.offset[0].abs();
    // Offsets are in `nu`, half of what they are in cycles per window.
    let at_its_place = off <= (0.5 * LINE_OFFSET_MAX).max(3.0 * comb.offset_sigma[0]).min(0.25);
    at_its_place && comb.power.iter().take(part - 1).all(|power| *power > by_chance)
}
