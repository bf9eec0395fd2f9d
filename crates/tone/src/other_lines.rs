//! Lines that a solution leaves: another tone, or one between the harmonics that says that the
//! fundamental is lower.

use crate::blocks::Blocks;
use crate::frame_span::{BLOCK, FrameSpan};
use crate::limits::{CHANNELS_SEARCHED, HARMONICS_MAX};
use crate::neighbourhood::Neighbourhood;
use crate::phase::{cos_sin, from_turns};
use crate::significance::chi_square_point;
use crate::solve::Solution;
use crate::source::Overwritten;
use crate::spectrum::Periodogram;
use crate::statistics::{Channels, Statistics};
use crate::waves::{Waves, along};

/// Fewest cycles in the window of a line: below, it is a baseline.
const CYCLES_MIN: f32 = 1.0;

/// The strongest line of the residuals.
#[derive(Clone, Copy, Debug)]
pub struct OtherLine {
    /// Cycles in the window.
    pub cycles: f32,
    /// Its power over that of the tone's strongest harmonic.
    pub share: f32,
    /// Its power over the residuals' mean in as wide a part of the spectrum.
    pub contrast: f32,
}

/// The strongest line of the residuals of the channels with the least noise; None if there are too
/// many frames to transform. It uses the blocks' memory.
#[inline(never)]
pub fn strongest_other_line(
    span: &mut FrameSpan,
    statistics: &Statistics,
    channels: &Channels,
    solution: &Solution,
    blocks: &mut Blocks,
) -> Result<Option<OtherLine>, Overwritten> {
    let list = Periodogram::channels(span, channels);
    let at = (solution.nu, blocks.lines.interferer);
    let (power, points) = blocks.transform_memory();
    let mut waves = Waves::new(span, statistics, solution, at);
    let periodogram = Periodogram::new(span, statistics, list, Some(&mut waves), points, power)?;
    let Some(peak) = periodogram.strongest(CYCLES_MIN) else {
        return Ok(None);
    };
    // In the units of the periodogram.
    let (mut strongest, count) = (f32::MIN_POSITIVE, list.len() as f32);
    for h in 0..solution.shape.harmonics.min(HARMONICS_MAX) {
        let (cos, sin) = solution.harmonic(h);
        let waves = cos.iter().zip(sin).map(|(cos, sin)| cos * cos + sin * sin);
        let power = waves
            .zip(&solution.weights)
            .take(list.len())
            .map(|(power, weight)| power * weight)
            .sum::<f32>();
        strongest = strongest.max(0.5 * solution.frames * power / count);
    }
    let mean = periodogram.power.iter().sum::<f32>() / periodogram.power.len().max(1) as f32;
    Ok(Some(OtherLine {
        cycles: peak.cycles,
        share: peak.power / strongest,
        contrast: peak.power / mean,
    }))
}

/// Shares of a line's frequency at which a comb has lines of which it is the second or third.
const BETWEEN: [f32; 4] = [1.0 / 2.0, 3.0 / 2.0, 1.0 / 3.0, 2.0 / 3.0];
/// How many of them are those of the second.
const OF_SECOND: usize = 2;
/// Fewest cycles in the window of such a line, and beside a curved baseline.
const BETWEEN_CYCLES: f32 = 2.5;
const BETWEEN_CYCLES_CURVED: f32 = 4.0;
/// Frames that are examined, of all channels together.
const BETWEEN_FRAMES: u32 = 384;
/// Their least power, as a share of the tone's, and the normal deviate that noise does not reach.
const BETWEEN_SHARE: f32 = 5e-4;
const BETWEEN_DEVIATE: f32 = 4.0;

/// Whether the residuals of a solution, which are otherwise noise, have lines that say that its
/// fundamental is an overtone.
#[inline(never)]
pub fn lines_between(
    span: &mut FrameSpan,
    statistics: &Statistics,
    channels: &Channels,
    solution: &Solution,
    interferer: Option<f32>,
) -> Result<bool, Overwritten> {
    let (abscissa, frames, nu) = (span.abscissa(), span.frames, solution.nu);
    let list = channels.list();
    let list = list
        .get(..(BETWEEN_FRAMES / frames.max(1)).clamp(1, CHANNELS_SEARCHED as u32) as usize)
        .unwrap_or(list);
    let mut waves = Waves::new(span, statistics, solution, (nu, interferer));
    let turns = abscissa
        .step()
        .map(|step| BETWEEN.map(|share| cos_sin(from_turns(share * nu * step))));
    let mut sums = [[[0.0; 2]; BETWEEN.len()]; CHANNELS_SEARCHED];
    let (mut cosines, mut sines) = ([0.0; BLOCK], [0.0; BLOCK]);
    span.blocks(&statistics.offset, &mut |block| {
        if block.first >= BETWEEN_FRAMES {
            return;
        }
        waves.go(abscissa.block(block.first, frames));
        let mut residuals = [[0.0; BLOCK]; CHANNELS_SEARCHED];
        for (k, (residuals, c)) in residuals.iter_mut().zip(list).enumerate() {
            *residuals = waves.residuals(block.values, *c as usize, k);
            if !block.complete {
                residuals
                    .iter_mut()
                    .zip(block.valid)
                    .for_each(|(rest, valid)| *rest *= (*valid != 0) as u8 as f32);
            }
        }
        for (line, share) in BETWEEN.iter().enumerate() {
            along(
                share * nu,
                turns.map(|turns| turns[line]),
                &waves.u,
                [&mut cosines, &mut sines],
            );
            for (sums, residuals) in sums.iter_mut().zip(&residuals).take(list.len()) {
                let [with_cos, with_sin] = &mut sums[line];
                for (residual, (cos, sin)) in residuals.iter().zip(cosines.iter().zip(&sines)) {
                    *with_cos += residual * cos;
                    *with_sin += residual * sin;
                }
            }
        }
    })?;
    let count = solution.frames.min(BETWEEN_FRAMES as f32);
    // A chi-square of two degrees for each line and channel; slow lines are a part of the baseline.
    let least = if solution.shape.curves > 0 {
        BETWEEN_CYCLES_CURVED
    } else {
        BETWEEN_CYCLES
    };
    let (mut powers, mut degrees) = ([0.0; 2], [0.0; 2]);
    for (line, _) in BETWEEN
        .iter()
        .enumerate()
        .filter(|(_, share)| 2.0 * *share * nu >= least)
    {
        let order = (line >= OF_SECOND) as usize;
        for (sums, weight) in sums.iter().zip(&solution.weights).take(list.len()) {
            let [cos, sin] = sums.get(line).copied().unwrap_or_default();
            powers[order] += 2.0 * weight / count * (cos * cos + sin * sin);
            degrees[order] += 2.0;
        }
    }
    // As much of the tone's power as these channels and frames have.
    let part = list.len() as f32 / solution.width as f32 * count / solution.frames;
    let share = BETWEEN_SHARE * part * solution.power.iter().sum::<f32>();
    let is_there = |(power, degrees): (f32, f32)| {
        power > share && power > chi_square_point(degrees, BETWEEN_DEVIATE)
    };
    Ok(powers
        .into_iter()
        .zip(degrees)
        .filter(|(_, degrees)| *degrees > 0.0)
        .any(is_there))
}

/// Fewest cycles in the window of a line at half a tone's frequency; the same beside a curved
/// baseline, which it resembles.
pub const HALF_CYCLES: f32 = 1.5;
const HALF_CYCLES_CURVED: f32 = 2.5;
/// Least share of the tone's power of such a line, the normal deviate that noise does not reach,
/// and by how much more it must stand out beside a curved baseline, which leaves something
/// everywhere, and where channels may share their noise.
const HALF_SHARE: f32 = 1e-4;
const HALF_DEVIATE: f32 = 3.5;
const HALF_CURVED: f32 = 3.0;
const HALF_SHARED: f32 = 1.4;
/// How much higher the noise's density may be at half the frequency than where it is known, about
/// the tone. Of pink noise it is twice as high, but then it is high at the tone too. Chosen on
/// other seeds than those of docs/results/noise.md, as the others.
const HALF_DENSITY: f32 = 1.5;

/// Whether there is a line at half a solution's frequency, of this power in all channels. The tone
/// is then the second harmonic of another, whose fundamental is faint. If all other harmonics of
/// that one are even, no other line shows it.
#[inline(never)]
pub fn has_half_line(
    power: f32,
    solution: &Solution,
    around: &Neighbourhood,
    noise_ratio: f32,
) -> bool {
    let is_curved = solution.shape.curves > 0;
    let density = HALF_DENSITY * around.colour.max(around.band).max(noise_ratio).max(1.0);
    let by = if is_curved {
        HALF_CURVED
    } else if around.may_share {
        HALF_SHARED
    } else {
        1.0
    };
    let least = by * density * chi_square_point(2.0 * solution.width as f32, HALF_DEVIATE);
    let is_line = solution.nu
        >= if is_curved {
            HALF_CYCLES_CURVED
        } else {
            HALF_CYCLES
        };
    is_line && power > least && power > HALF_SHARE * solution.power.iter().sum::<f32>()
}
