//! Where the fit starts: the strongest line, and whether it is the fundamental.
//!
//! A grating's tone lies far below the frame rate, so the search runs on means of a few frames: a
//! fraction of the work, and a guess is all that is wanted. Only if those means have lost the better
//! part of the signal's power - the tone is fast, or there is none - does it run on the frames
//! themselves.

use crate::levels::{Levels, levels};
use crate::moments::{HARMONICS_MAX, Stretch, moments};
use crate::settings::TAXELS;
use crate::solve::{CYCLES_FOR_SLOPE, CYCLES_MIN, Shape, Solution, converge, gain, solve};
use crate::spectrum::{POINTS_MAX, power_near, strongest};
use crate::window::{FrameSource, Table, Values};

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
/// Means that a search on means has at the most; a window of one second at 241 Hz has 61 of 4 frames.
const COARSE_MAX: usize = 64;
/// Share of the power that the means must keep.
const COARSE_SHARE: f32 = 0.5;
/// Peaks below this many cycles per half window are looked at by exact likelihoods.
const LOW_NU: f32 = 1.75;

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
pub fn search<S: FrameSource>(
    stretch: &mut Stretch<'_, S>,
    levels: &Levels,
    scratch: &mut Scratch,
    harmonics: usize,
) -> Option<Option<Start>> {
    look(stretch, levels, &mut scratch.points, &mut scratch.power, harmonics)
}

/// The same by means of a few frames. The inner None says that they are of no use here.
pub fn search_coarse<S: FrameSource>(
    stretch: &mut Stretch<'_, S>,
    levels_of_all: &Levels,
    scratch: &mut Scratch,
    harmonics: usize,
) -> Option<Option<Start>> {
    let by = stretch.frames.div_ceil(COARSE_MAX as u32);
    if by < 2 {
        return Some(None);
    }
    let (means, _) = scratch.points.as_chunks_mut::<TAXELS>();
    let mut valid = [0; COARSE_MAX];
    let count = condense(stretch, by, means, &mut valid)?;
    let mut table = Table { values: means.get(..count)?, valid: valid.get(..count)? };
    let mut coarse = Stretch::new(&mut table, 0, count as u32);
    let levels = levels(&mut coarse)?;
    if levels.usable != levels_of_all.usable {
        return Some(None);
    }
    let mut kept = 0.0;
    for c in 0..TAXELS {
        if levels.usable & 1 << c != 0 {
            kept += by as f32 * levels.about_line[c] / levels_of_all.about_line[c];
        }
    }
    if !(kept >= COARSE_SHARE * levels.usable.count_ones() as f32) {
        return Some(None);
    }
    let (points, power) = scratch.power.split_at_mut(POINTS_MAX / 4);
    let start = look(&mut coarse, &levels, points, power, harmonics)?;
    // The means cover whole groups of frames only.
    let scale = stretch.frames as f32 / (count as u32 * by) as f32;
    Some(start.map(|start| Start { nu: start.nu * scale, ..start }))
}

/// Means of every `by` frames; returns how many there are. None if the frames were overwritten.
fn condense<S: FrameSource>(
    stretch: &mut Stretch<'_, S>,
    by: u32,
    means: &mut [Values],
    valid: &mut [u16; COARSE_MAX],
) -> Option<usize> {
    let count = ((stretch.frames / by) as usize).min(means.len()).min(COARSE_MAX);
    let (mut sum, mut mask, mut seen, mut group, mut left) = ([0.0; TAXELS], u16::MAX, 0u32, 0, by);
    stretch.blocks(|block| {
        for i in 0..block.frames {
            if block.valid[i] != 0 {
                for c in 0..TAXELS {
                    sum[c] += block.values[i][c];
                }
                mask &= block.valid[i];
                seen += 1;
            }
            left -= 1;
            if left == 0 {
                if let (Some(mean), Some(valid)) = (means.get_mut(group), valid.get_mut(group)) {
                    let share = 1.0 / seen.max(1) as f32;
                    *mean = sum.map(|sum| sum * share);
                    *valid = if seen > 0 { mask } else { 0 };
                }
                (sum, mask, seen, left) = ([0.0; TAXELS], u16::MAX, 0, by);
                group += 1;
            }
        }
    })?;
    Some(count)
}

/// The strongest line and the fundamental it belongs to. The inner None says that there is none.
// Large and called from several places: one copy is enough.
#[inline(never)]
fn look<S: FrameSource>(
    stretch: &mut Stretch<'_, S>,
    levels: &Levels,
    points: &mut [f32],
    power: &mut [f32],
    harmonics: usize,
) -> Option<Option<Start>> {
    let Some(peak) = strongest(stretch, levels, points, power) else { return Some(None) };
    let low = peak <= LOW_NU;
    let nu = if low { strongest_low(stretch, levels, peak)? } else { peak };
    // Low lines lean on each other too much for a periodogram to say that there is nothing.
    let (frames, most) = (stretch.frames as usize, points.len());
    let power_at = |nu: f32| if low { 1.0 } else { power_near(frames, most, power, nu) };
    fundamental(stretch, levels, nu, harmonics, power_at)
}

/// The strongest line among the low ones by exact likelihoods: a line of few cycles leans on its
/// own mirror image, and a periodogram's peak is off by that.
fn strongest_low<S: FrameSource>(stretch: &mut Stretch<'_, S>, levels: &Levels, peak: f32) -> Option<f32> {
    let (mut best, mut most) = (peak, f32::MIN);
    let mut cycles = CYCLES_MIN;
    while cycles < 4.0 {
        let nu = 0.5 * cycles;
        let shape = Shape { harmonics: 1, slope: cycles >= CYCLES_FOR_SLOPE };
        let moments = moments(stretch, levels, nu, 1)?;
        if let Some(solution) = solve(&moments, levels, nu, shape) {
            // All against constants; the slopes' own gain has to pay for their unknowns.
            let constants = Shape { slope: false, ..shape };
            let paid = if shape.slope { 8.0 * libm::logf(levels.frames as f32) } else { 0.0 };
            let gain = gain(levels, &levels.about_mean, &solution.rest, &constants) - paid;
            if gain > most {
                (best, most) = (nu, gain);
            }
        }
        cycles += 0.2 + 0.1 * cycles;
    }
    Some(best)
}

/// As many of `harmonics` as stay clear of half the frame rate.
pub fn harmonics_below_nyquist<S: FrameSource>(stretch: &Stretch<'_, S>, nu: f32, harmonics: usize) -> usize {
    let mut below = 1;
    while below < harmonics && (below + 1) as f32 * nu < 0.48 * stretch.half() {
        below += 1;
    }
    below
}

/// Whether the strongest line is the fundamental, or the second or third harmonic of one; and
/// whether that is open. The inner None says that the window is too short to tell anything.
fn fundamental<S: FrameSource>(
    stretch: &mut Stretch<'_, S>,
    levels: &Levels,
    strongest: f32,
    harmonics: usize,
    power_at: impl Fn(f32) -> f32,
) -> Option<Option<Start>> {
    let Some(line) = converge(stretch, levels, strongest, 1)? else { return Some(None) };
    let mut start = Start { nu: line.nu, ambiguous: false };
    if harmonics < 2 {
        return Some(Some(start));
    }
    let mut highest = AMBIGUOUS_SHARE;
    for part in [2usize, 3] {
        let nu = line.nu / part as f32;
        let harmonics = harmonics_below_nyquist(stretch, nu, (part + 2).min(HARMONICS_MAX));
        if 2.0 * nu < 1.0 || harmonics < part {
            continue;
        }
        let between = match part {
            2 => power_at(nu) + power_at(3.0 * nu),
            _ => power_at(nu) + power_at(2.0 * nu),
        };
        if between < WORTH_A_LOOK * power_at(line.nu) {
            continue;
        }
        let Some(comb) = converge(stretch, levels, nu, harmonics)? else { continue };
        if (comb.nu - nu).abs() > 0.25 {
            continue;
        }
        let share = share_between(&comb, part);
        if share > highest
            && lines_hold(&comb, part, power_by_chance(levels))
            && better_than_overtones(stretch, levels, &comb, line.nu)?
        {
            highest = share;
            let taken = share > SUBHARMONIC_SHARE;
            start = Start { nu: if taken { comb.nu } else { start.nu }, ambiguous: !taken };
        }
    }
    Some(Some(start))
}

/// Whether a comb explains the window clearly better than the strongest line with overtones of its
/// own: across a gap in the window the lines of a comb can be large and cancel each other, and they
/// take up what those overtones leave.
fn better_than_overtones<S: FrameSource>(
    stretch: &mut Stretch<'_, S>,
    levels: &Levels,
    comb: &Solution,
    strongest: f32,
) -> Option<bool> {
    let harmonics = harmonics_below_nyquist(stretch, strongest, comb.shape.harmonics);
    let Some(rival) = converge(stretch, levels, strongest, harmonics)? else { return Some(true) };
    let more = (comb.shape.harmonics - harmonics).max(1) as f32 * levels.usable.count_ones() as f32;
    let gained = gain(levels, &rival.rest, &comb.rest, &comb.shape);
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
