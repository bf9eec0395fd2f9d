//! Periodogram over the channels: a first guess of the common frequency.
//!
//! Each channel, less its straight line, is transformed on its own and counts by the share of its
//! own power that a line takes, so that a noisy channel cannot shout the others down.

use crate::frame_span::{BLOCK, FrameSpan};
use crate::levels::Levels;
use crate::nuisance::{NUISANCES_MAX, Nuisances};
use crate::phase::{cos_sin, from_turns};
use crate::source::CHANNELS_MAX;
use crate::source::Values;
use core::f32::consts::PI;

/// Longest transform on the chip, points.
const POINTS_CHIP: usize = 1024;
/// Longest transform, points: 1024 on the chip; 32,768 with the feature `long-windows`.
#[cfg(not(feature = "long-windows"))]
pub const POINTS_MAX: usize = POINTS_CHIP;
/// Longest transform, points: 1024 on the chip; 32,768 with the feature `long-windows`.
#[cfg(feature = "long-windows")]
pub const POINTS_MAX: usize = 32_768;

/// Shortest transform, points.
const POINTS_MIN: usize = 64;

/// The strongest line in cycles per half window ([`crate::frame_span`]'s `nu`), between bins by
/// the higher of its neighbours. `points` is scratch memory for transforms, `power` for half of one. None if
/// the frames were overwritten; the inner None if there are more of them than fit `points` or
/// [`POINTS_MAX`], or if no channel is usable.
///
/// Only `channels` are looked at, bit k for taxel k, and only lines of `least_cycles` in the window and more:
/// a straight line has been taken off, and what there is of `nuisances`.
pub fn strongest(
    span: &mut FrameSpan,
    levels: &Levels,
    nuisances: &Nuisances,
    least_cycles: f32,
    channels: u16,
    points: &mut [f32],
    power: &mut [f32],
) -> Option<Option<f32>> {
    let frames = span.frames as usize;
    let most = points.len().min(2 * power.len());
    let size = transform_size(frames, most);
    if frames > size || levels.usable == 0 {
        return Some(None);
    }
    let mut baseline = [[0.0; CHANNELS_MAX]; 2 + NUISANCES_MAX];
    baseline[1] = levels.slope;
    let count = nuisances.count().min(NUISANCES_MAX);
    if count > 0 {
        let Some(all) = nuisances.baseline(levels) else { return Some(None) };
        baseline = all;
    }
    let power = power.get_mut(..size / 2)?;
    power.fill(0.0);
    // As many channels at a time as there is room for.
    let together = (points.len() / size).clamp(1, CHANNELS_MAX);
    let mut taxels = heapless::Vec::<usize, CHANNELS_MAX>::new();
    for taxel in (0..CHANNELS_MAX).filter(|taxel| channels & levels.usable & 1 << taxel != 0) {
        // It has room for all.
        let _ = taxels.push(taxel);
    }
    for taxels in taxels.chunks(together) {
        let points = points.get_mut(..taxels.len() * size)?;
        copy(span, levels, nuisances, &baseline[..2 + count], taxels, points)?;
        points.chunks_exact_mut(size).for_each(|points| add_power(points, power));
    }
    // A path's first and last frame lie at its very ends, those in time half a frame inside.
    let bins_per_cycle = size as f32 / if span.is_in_time() { frames } else { frames - 1 } as f32;
    let least = ((least_cycles * bins_per_cycle) as usize).max(1);
    // A path that turns has places closer together than its frames can tell lines.
    let highest = if span.is_in_time() { power.len() } else { (2.0 * span.nu_most() * bins_per_cycle) as usize };
    let (mut at, mut peak) = (least, 0.0);
    for (k, p) in power.iter().enumerate().take(highest + 1).skip(least) {
        if *p > peak {
            (at, peak) = (k, *p);
        }
    }
    let left = *power.get(at - 1)?;
    let right = power.get(at + 1).copied();
    let Some(right) = right.filter(|_| left <= peak) else {
        return Some(Some(0.5 * at as f32 / bins_per_cycle));
    };
    // A line half way between two bins is as high in both; one in the middle of a bin has its skirt in the next.
    let half_turns = 1.0 / bins_per_cycle;
    let (_, sin) = cos_sin(from_turns(0.5 * half_turns));
    let skirt = sin / (PI * half_turns);
    let beside = libm::sqrtf(left.max(right) / peak.max(f32::MIN_POSITIVE));
    let between = ((beside - skirt) / (1.0 + beside - 2.0 * skirt)).max(0.0);
    let between = if right > left { between } else { -between };
    Some(Some(0.5 * (at as f32 + between) / bins_per_cycle))
}

/// Copies some channels, less their baselines and each in its own measure, into equal parts of `out`, frame
/// by frame; along a path each frame goes to its place, which makes the transform that of the path. Zeros
/// behind them and where frames are missing.
fn copy(
    span: &mut FrameSpan,
    levels: &Levels,
    nuisances: &Nuisances,
    baseline: &[Values],
    taxels: &[usize],
    out: &mut [f32],
) -> Option<()> {
    out.fill(0.0);
    let size = out.len() / taxels.len().max(1);
    let (abscissa, frames, in_time) = (span.abscissa(), span.frames, span.is_in_time());
    let mut columns = [[0.0; NUISANCES_MAX]; BLOCK];
    // Scaled before it is squared: codes reach 2^24 and their squares' sums would not fit f32.
    let mut weights = [0.0; CHANNELS_MAX];
    for c in taxels {
        weights[*c] = 1.0 / libm::sqrtf(levels.about_line[*c]);
    }
    span.blocks(&levels.offset, &mut |block| {
        let u = abscissa.block(block.at, frames);
        if baseline.len() > 2 {
            nuisances.fill(&block, &u, &mut columns);
        }
        for (out, c) in out.chunks_exact_mut(size.max(1)).zip(taxels) {
            let weight = weights[*c];
            let (zero, slope) = (levels.offset[*c] + baseline[0][*c], baseline[1][*c]);
            let mut residual_sum_of_squares: [f32; BLOCK] =
                core::array::from_fn(|i| block.values[i][*c] - zero - slope * u[i]);
            for (k, factors) in baseline[2..].iter().enumerate() {
                for i in 0..BLOCK {
                    residual_sum_of_squares[i] -= factors[*c] * columns[i][k];
                }
            }
            if block.whole
                && in_time
                && let Some(out) = out.get_mut(block.at as usize..).and_then(|out| out.first_chunk_mut::<BLOCK>())
            {
                *out = residual_sum_of_squares.map(|residual_sum_of_squares| weight * residual_sum_of_squares);
                continue;
            }
            for i in 0..BLOCK {
                let place = match in_time {
                    true => block.at as usize + i,
                    false => (0.5 * (u[i] + 1.0) * (frames - 1) as f32 + 0.5) as usize,
                };
                if let Some(out) = out.get_mut(place).filter(|_| block.valid[i] != 0) {
                    *out += weight * residual_sum_of_squares[i];
                }
            }
        }
    })
}

/// The highest power within a bin of `nu` in the periodogram that [`strongest`] left of so many frames,
/// with so many `points` of scratch memory; zero beyond its end.
pub fn power_near(frames: usize, points: usize, power: &[f32], nu: f32) -> f32 {
    let size = transform_size(frames, points.min(2 * power.len()));
    let bin = (2.0 * nu * size as f32 / frames as f32 + 0.5) as usize;
    let near = power.get(bin.saturating_sub(1)..(bin + 2).min(size / 2)).unwrap_or_default();
    near.iter().fold(0.0, |most, power| most.max(*power))
}

/// Points of the transform of so many frames where there is room for `most`: a quarter more than frames, if there are many
/// of them and they fit. A peak between two bins then loses little height.
pub fn transform_size(frames: usize, most: usize) -> usize {
    // No longer on a PC than on the chip where the chip can do it at all: both give the same bits.
    let most = most.min(if frames > POINTS_CHIP { POINTS_MAX } else { POINTS_CHIP });
    let wanted = if frames <= POINTS_MIN { frames } else { frames + frames / 4 };
    let mut size = POINTS_MIN;
    while size < wanted {
        // In steps of four on the chip: each size of transform takes a kilobyte of flash.
        let next = if size < POINTS_CHIP { 4 * size } else { 2 * size };
        if next > most {
            break;
        }
        size = next;
    }
    size
}

/// Adds the squared magnitudes of a real signal's transform to `power`, bin 0 and the Nyquist bin
/// left out. The length is one of the transform's own, else nothing is added.
fn add_power(signal: &mut [f32], power: &mut [f32]) {
    macro_rules! transform {
        ($($points:literal $name:ident),*) => {
            match signal.len() {
                $($points => match <&mut [f32; $points]>::try_from(signal) {
                    Ok(signal) => &*microfft::real::$name(signal),
                    Err(_) => return,
                },)*
                _ => return,
            }
        };
    }
    #[cfg(not(feature = "long-windows"))]
    let bins: &[microfft::Complex32] = transform!(64 rfft_64, 128 rfft_128, 256 rfft_256, 512 rfft_512, 1024 rfft_1024);
    #[cfg(feature = "long-windows")]
    let bins: &[microfft::Complex32] = transform!(64 rfft_64, 128 rfft_128, 256 rfft_256, 512 rfft_512, 1024 rfft_1024,
        2048 rfft_2048, 4096 rfft_4096, 8192 rfft_8192, 16384 rfft_16384, 32768 rfft_32768);
    let [_, bins @ ..] = bins else { return };
    let Some((_, power)) = power.split_first_mut() else { return };
    for (power, bin) in power.iter_mut().zip(bins) {
        *power += bin.re * bin.re + bin.im * bin.im;
    }
}
