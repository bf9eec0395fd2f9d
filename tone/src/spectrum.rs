//! Periodogram over the channels: a first guess of the common frequency.
//!
//! Each channel, less its straight line, is transformed on its own and counts by the share of its own power that a line
//! takes, so that a noisy channel does not hide the others.

use crate::descent::CYCLES_FOR_SLOPE;
use crate::frame_span::{BLOCK, FrameSpan};
use crate::levels::Levels;
use crate::limits::{CHANNELS_MAX, NUISANCES_MAX};
use crate::nuisance::Nuisances;
use crate::phase::{cos_sin, from_turns};
use crate::source::{Overwritten, Values};
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

/// A periodogram over the channels.
#[derive(Clone, Copy, Debug)]
pub struct Spectrum<'m> {
    /// Share of the channels' power that a line at each bin's frequency takes; all zero if there are more frames than a
    /// transform has points, or if no channel is usable.
    pub power: &'m [f32],
    /// Points of the transform: bin k has k cycles in as many frames.
    pub points: usize,
    /// Cycles in the window of the strongest line of [`CYCLES_FOR_SLOPE`] and more.
    pub strongest_cycles: Option<f32>,
}

impl<'m> Spectrum<'m> {
    pub(crate) fn new(
        mut memory: TransformMemory<'m>,
        span: &mut FrameSpan,
        levels: &Levels,
        nuisances: &Nuisances,
    ) -> Result<Self, Overwritten> {
        memory.power.fill(0.0);
        let strongest = memory.strongest(span, levels, nuisances, CYCLES_FOR_SLOPE)?;
        let points = memory.size(span.frames as usize);
        let power = memory.power.get_mut(..points / 2).unwrap_or_default();
        // A line alone has a magnitude of half its amplitude times the frames; half its square is the power.
        let all = 0.5 * levels.frames as f32 * levels.channels();
        power.iter_mut().filter(|power| **power > 0.0).for_each(|power| *power /= all);
        Ok(Self { power, points, strongest_cycles: strongest.map(|nu| 2.0 * nu) })
    }
}

/// Memory for transforms, and which channels to transform.
pub struct TransformMemory<'m> {
    /// Bit k: channel k.
    pub channels: u16,
    /// For transforms.
    pub points: &'m mut [f32],
    /// For half of one: the periodogram.
    pub power: &'m mut [f32],
}

impl TransformMemory<'_> {
    /// The strongest line in cycles per half window ([`crate::abscissa`]'s `nu`), interpolated between bins by the higher
    /// neighbour of the peak, of at least `least_cycles` in the window. A straight line is subtracted, and the `nuisances`.
    /// None if the memory or [`POINTS_MAX`] is too small for the frames, or if no channel is usable.
    pub fn strongest(
        &mut self,
        span: &mut FrameSpan,
        levels: &Levels,
        nuisances: &Nuisances,
        least_cycles: f32,
    ) -> Result<Option<f32>, Overwritten> {
        let frames = span.frames as usize;
        let size = self.size(frames);
        if frames > size || levels.usable == 0 {
            return Ok(None);
        }
        let mut baseline = [[0.0; CHANNELS_MAX]; 2 + NUISANCES_MAX];
        baseline[1] = levels.slope;
        let count = nuisances.count().min(NUISANCES_MAX);
        if count > 0 {
            let Some(all) = nuisances.baseline(levels) else { return Ok(None) };
            baseline = all;
        }
        let Some(power) = self.power.get_mut(..size / 2) else { return Ok(None) };
        power.fill(0.0);
        // As many channels at a time as the memory has space for.
        let together = (self.points.len() / size).clamp(1, CHANNELS_MAX);
        let mut channels = heapless::Vec::<usize, CHANNELS_MAX>::new();
        for channel in (0..CHANNELS_MAX).filter(|channel| self.channels & levels.usable & 1 << channel != 0) {
            // It has space for all.
            let _ = channels.push(channel);
        }
        for channels in channels.chunks(together) {
            let Some(points) = self.points.get_mut(..channels.len() * size) else { return Ok(None) };
            copy(span, levels, nuisances, &baseline[..2 + count], channels, points)?;
            points.chunks_exact_mut(size).for_each(|points| add_power(points, power));
        }
        // A path's first and last frame lie at its very ends, those in time half a frame inside.
        let bins_per_cycle = size as f32 / if span.is_in_time() { frames } else { frames - 1 } as f32;
        let least = ((least_cycles * bins_per_cycle) as usize).max(1);
        // A path that turns back has places closer together than its frames can separate lines.
        let highest = if span.is_in_time() { power.len() } else { (2.0 * span.nu_max() * bins_per_cycle) as usize };
        let (mut bin, mut peak) = (least, 0.0);
        for (k, p) in power.iter().enumerate().take(highest + 1).skip(least) {
            if *p > peak {
                (bin, peak) = (k, *p);
            }
        }
        let Some(left) = power.get(bin - 1).copied() else { return Ok(None) };
        let Some(right) = power.get(bin + 1).copied().filter(|_| left <= peak) else {
            return Ok(Some(0.5 * bin as f32 / bins_per_cycle));
        };
        // A line half way between two bins is as high in both; one in the middle of a bin has its skirt in the next.
        let half_turns = 1.0 / bins_per_cycle;
        let (_, sin) = cos_sin(from_turns(0.5 * half_turns));
        let skirt = sin / (PI * half_turns);
        let beside = libm::sqrtf(left.max(right) / peak.max(f32::MIN_POSITIVE));
        let between = ((beside - skirt) / (1.0 + beside - 2.0 * skirt)).max(0.0);
        let between = if right > left { between } else { -between };
        Ok(Some(0.5 * (bin as f32 + between) / bins_per_cycle))
    }

    /// The highest power within a bin of `nu` in the periodogram that [`Self::strongest`] made of `frames` frames; zero
    /// beyond its end.
    pub fn power_near(&self, frames: usize, nu: f32) -> f32 {
        let size = self.size(frames);
        let bin = (2.0 * nu * size as f32 / frames as f32 + 0.5) as usize;
        let near = self.power.get(bin.saturating_sub(1)..(bin + 2).min(size / 2)).unwrap_or_default();
        near.iter().fold(0.0, |most, power| most.max(*power))
    }

    /// Points of the transform of `frames` frames.
    pub fn size(&self, frames: usize) -> usize {
        transform_size(frames, self.points.len().min(2 * self.power.len()))
    }
}

/// Copies some channels, less their baselines and each scaled to its own power, into equal parts of `out`, frame by frame;
/// along a path each frame goes to its place, which makes the transform that of the path. Zeros behind them and where
/// frames are missing.
fn copy(
    span: &mut FrameSpan,
    levels: &Levels,
    nuisances: &Nuisances,
    baseline: &[Values],
    channels: &[usize],
    out: &mut [f32],
) -> Result<(), Overwritten> {
    out.fill(0.0);
    let size = out.len() / channels.len().max(1);
    let (abscissa, frames, in_time) = (span.abscissa(), span.frames, span.is_in_time());
    let mut columns = [[0.0; NUISANCES_MAX]; BLOCK];
    // Scaled before it is squared: large values' sums of squares would lose digits in f32.
    let mut weights = [0.0; CHANNELS_MAX];
    for c in channels {
        weights[*c] = 1.0 / libm::sqrtf(levels.about_line[*c]);
    }
    span.blocks(&levels.offset, &mut |block| {
        let u = abscissa.block(block.first, frames);
        if baseline.len() > 2 {
            nuisances.fill(&block, &u, &mut columns);
        }
        for (out, c) in out.chunks_exact_mut(size.max(1)).zip(channels) {
            let weight = weights[*c];
            let (zero, slope) = (levels.offset[*c] + baseline[0][*c], baseline[1][*c]);
            let mut residuals: [f32; BLOCK] = core::array::from_fn(|i| block.values[i][*c] - zero - slope * u[i]);
            for (k, factors) in baseline[2..].iter().enumerate() {
                for i in 0..BLOCK {
                    residuals[i] -= factors[*c] * columns[i][k];
                }
            }
            if block.complete
                && in_time
                && let Some(out) = out.get_mut(block.first as usize..).and_then(|out| out.first_chunk_mut::<BLOCK>())
            {
                *out = residuals.map(|residual| weight * residual);
                continue;
            }
            for i in 0..BLOCK {
                let place = match in_time {
                    true => block.first as usize + i,
                    false => (0.5 * (u[i] + 1.0) * (frames - 1) as f32 + 0.5) as usize,
                };
                if let Some(out) = out.get_mut(place).filter(|_| block.valid[i] != 0) {
                    *out += weight * residuals[i];
                }
            }
        }
    })
}

/// Points of the transform of `frames` frames with memory for `most`: a quarter more than frames, if there are many of them
/// and they fit. A peak between two bins then loses little height.
fn transform_size(frames: usize, most: usize) -> usize {
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
