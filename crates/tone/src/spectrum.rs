//! Periodogram over the channels: where lines may be.
//!
//! Each channel, less its straight line, is transformed on its own and counts by the share of its
//! own power that a line takes, so that a noisy channel does not hide the others.

use crate::frame_span::{BLOCK, FrameSpan};
use crate::limits::{CHANNELS_MAX, CHANNELS_SEARCHED, POINTS_CHIP, POINTS_MAX};
use crate::phase::{cos_sin, from_turns};
use crate::source::Overwritten;
use crate::statistics::{Channels, Statistics};
use crate::waves::Waves;
use core::f32::consts::PI;

/// In windows in time of more than 192 frames fewer channels are transformed.
const CHANNELS_LONG: usize = 2;
const FRAMES_LONG: u32 = 192;
/// Shortest transform, points.
const POINTS_MIN: usize = 64;

/// A line of a periodogram.
#[derive(Clone, Copy, Debug)]
pub struct Peak {
    /// Cycles in the window.
    pub cycles: f32,
    /// Share of the power.
    pub power: f32,
}

/// The powers of a span's lines.
pub struct Periodogram<'m> {
    pub power: &'m mut [f32],
    pub bins_per_cycle: f32,
}

impl<'m> Periodogram<'m> {
    /// The channels of a periodogram, those with the least share of noise.
    pub fn channels<'c>(span: &FrameSpan, channels: &'c Channels) -> &'c [u8] {
        let list = channels.list();
        // A long window has enough of a line in two.
        let most = if span.is_in_time() && span.frames > FRAMES_LONG {
            CHANNELS_LONG
        } else {
            CHANNELS_SEARCHED
        };
        list.get(..most).unwrap_or(list)
    }

    /// Of some channels, or of what a solution leaves of them, where each counts by its weight
    /// there; `memory` is for transforms. Without power if the memory is too small for the frames.
    pub fn new(
        span: &mut FrameSpan,
        statistics: &Statistics,
        channels: &[u8],
        mut rest: Option<&mut Waves>,
        memory: &mut [f32],
        power: &'m mut [f32],
    ) -> Result<Self, Overwritten> {
        let frames = span.frames as usize;
        let points = transform_size(frames, memory.len().min(2 * power.len()));
        // A path's first and last frame lie at its very ends, those in time half a frame inside.
        let bins_per_cycle = points as f32
            / if span.is_in_time() {
                frames
            } else {
                frames - 1
            } as f32;
        let (power, memory) = (power.get_mut(..points / 2), memory.get_mut(..points));
        let (Some(power), Some(memory), true) = (power, memory, frames <= points) else {
            return Ok(Self {
                power: &mut [],
                bins_per_cycle,
            });
        };
        power.fill(0.0);
        for (k, channel) in channels.iter().enumerate() {
            let c = *channel as usize % CHANNELS_MAX;
            let weight = match &rest {
                Some(waves) => waves.solution.weights[k % CHANNELS_MAX],
                None => 1.0 / statistics.about_line[c],
            };
            copy(
                span,
                statistics,
                (c, k, libm::sqrtf(weight)),
                rest.as_deref_mut(),
                memory,
            )?;
            add_power(memory, power);
        }
        // A line alone has a magnitude of half its amplitude times the frames; half its square is
        // the power.
        let all = 0.5 * statistics.frames as f32 * channels.len() as f32;
        power.iter_mut().for_each(|power| *power /= all);
        // A path that turns back has places closer together than its frames can separate lines.
        if !span.is_in_time() {
            let highest = (2.0 * span.nu_max() * bins_per_cycle) as usize;
            power
                .iter_mut()
                .skip(highest + 1)
                .for_each(|power| *power = 0.0);
        }
        Ok(Self {
            power,
            bins_per_cycle,
        })
    }

    /// The strongest line of at least `least_cycles` cycles, interpolated between bins by the
    /// higher neighbour of the peak.
    pub fn strongest(&self, least_cycles: f32) -> Option<Peak> {
        let least = ((least_cycles * self.bins_per_cycle) as usize).max(1);
        let (mut bin, mut peak) = (0, 0.0);
        for (k, power) in self.power.iter().enumerate().skip(least) {
            if *power > peak {
                (bin, peak) = (k, *power);
            }
        }
        let left = self.power.get(bin.checked_sub(1)?).copied()?;
        let right = self.power.get(bin + 1).copied().unwrap_or(0.0);
        // A line half way between two bins is as high in both; one in the middle of a bin has its
        // skirt in the next.
        let half_turns = 1.0 / self.bins_per_cycle;
        let (_, sin) = cos_sin(from_turns(0.5 * half_turns));
        let skirt = sin / (PI * half_turns);
        let beside = libm::sqrtf(left.max(right) / peak.max(f32::MIN_POSITIVE));
        // Where bins are close both are small differences.
        let between = ((beside - skirt) / (1.0 + beside - 2.0 * skirt).max(f32::MIN_POSITIVE))
            .clamp(0.0, 0.5);
        let between = if right > left { between } else { -between };
        Some(Peak {
            cycles: (bin as f32 + between) / self.bins_per_cycle,
            power: peak,
        })
    }

    /// Takes out the bins next to an interferer.
    pub fn blank(&mut self, cycles: f32) {
        let (from, to) = (
            (cycles - 0.8) * self.bins_per_cycle,
            (cycles + 0.8) * self.bins_per_cycle + 1.0,
        );
        self.power
            .iter_mut()
            .take(to as usize)
            .skip(from as usize)
            .for_each(|power| *power = 0.0);
    }
}

/// Copies a channel, less its line or what a solution says of it, in units of its scale, with a
/// weight, frame by frame; along a path each frame goes to its place, which makes the transform
/// that of the path. Zeros behind them and where frames are missing.
fn copy(
    span: &mut FrameSpan,
    statistics: &Statistics,
    (c, k, weight): (usize, usize, f32),
    mut rest: Option<&mut Waves>,
    out: &mut [f32],
) -> Result<(), Overwritten> {
    out.fill(0.0);
    let (abscissa, frames, in_time, c) = (
        span.abscissa(),
        span.frames,
        span.is_in_time(),
        c % CHANNELS_MAX,
    );
    let (offset, slope) = (statistics.offset[c], statistics.slope[c]);
    let scale = statistics.scale[c] * weight;
    span.blocks(&statistics.offset, &mut |block| {
        let u = abscissa.block(block.first, frames);
        let values: [f32; BLOCK] = match &mut rest {
            Some(waves) => {
                waves.go(u);
                waves
                    .residuals(block.values, c, k)
                    .map(|residual| weight * residual)
            }
            None => core::array::from_fn(|i| (block.values[i][c] - offset - slope * u[i]) * scale),
        };
        let places = out
            .get_mut(block.first as usize..)
            .and_then(|out| out.first_chunk_mut::<BLOCK>());
        if let (true, true, Some(places)) = (block.complete, in_time, places) {
            *places = values;
            return;
        }
        for (i, ((value, valid), u)) in values.iter().zip(block.valid).zip(u).enumerate() {
            let place = match in_time {
                true => block.first as usize + i,
                false => (0.5 * (u + 1.0) * (frames - 1) as f32 + 0.5) as usize,
            };
            if let (Some(out), true) = (out.get_mut(place), *valid != 0) {
                *out += value;
            }
        }
    })
}

/// Points of the transform of `frames` frames with memory for `most`.
fn transform_size(frames: usize, most: usize) -> usize {
    // No longer on a PC than on the chip where the chip can do it at all: both give the same bits.
    let most = most.min(if frames > POINTS_CHIP {
        POINTS_MAX
    } else {
        POINTS_CHIP
    });
    let mut size = POINTS_MIN;
    while size < frames {
        // In steps of four on the chip: each size of transform takes a kilobyte of flash.
        let next = if size < POINTS_CHIP {
            4 * size
        } else {
            2 * size
        };
        if next > most {
            break;
        }
        size = next;
    }
    size
}

/// The transform of a real signal in its place, as real and imaginary parts; the first two are bin
/// 0 and the Nyquist bin. Nothing is done if the length is none of the transform's own.
pub fn transform(signal: &mut [f32]) {
    macro_rules! transform {
        ($($points:literal $name:ident),*) => {
            match signal.len() {
                $($points => if let Ok(signal) = <&mut [f32; $points]>::try_from(signal) {
                    let _ = microfft::real::$name(signal);
                },)*
                _ => {}
            }
        };
    }
    #[cfg(not(feature = "long-windows"))]
    transform!(64 rfft_64, 256 rfft_256, 1024 rfft_1024);
    #[cfg(feature = "long-windows")]
    transform!(64 rfft_64, 256 rfft_256, 1024 rfft_1024,
        2048 rfft_2048, 4096 rfft_4096, 8192 rfft_8192, 16384 rfft_16384, 32768 rfft_32768);
}

/// Adds the squared magnitudes of a signal's transform to `power`, bin 0 left out.
fn add_power(signal: &mut [f32], power: &mut [f32]) {
    transform(signal);
    for (power, bin) in power.iter_mut().zip(signal.as_chunks::<2>().0).skip(1) {
        *power += bin[0] * bin[0] + bin[1] * bin[1];
    }
}
