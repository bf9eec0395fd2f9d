//! The level and the slope of every channel of a span, and which channels can be used: the first pass.

use crate::frame_span::{BLOCK, FrameSpan};
use crate::limits::CHANNELS_MAX;
use crate::means::Means;
use crate::source::{Overwritten, Values};
use crate::sums::{Bend, QUAD, Sums};

/// Level and slope of every channel, and which of them can be used.
#[derive(Clone, Debug)]
pub struct Levels {
    /// Offset of each channel, on its straight line at the centre; the passes that follow subtract it.
    pub offset: Values,
    /// Slope per unit of `u` of a straight line through each channel.
    pub slope: Values,
    /// Sum of squares about that straight line.
    pub about_line: Values,
    /// Sum of squares about the mean.
    pub about_mean: Values,
    /// Sum of y, each channel less its `offset`.
    pub y: Values,
    /// Sum of u y.
    pub uy: Values,
    /// Sum of y squared.
    pub yy: Values,
    /// Variance of a frame's noise by the third differences of consecutive frames: a tone below a tenth of the frame
    /// rate adds very little. 0 if no four consecutive frames count.
    pub noise_variance: Values,
    /// Sum of u.
    pub u: f32,
    /// Sum of u squared.
    pub uu: f32,
    /// Sums with the steps of a bent baseline.
    pub bend: Bend,
    /// Mask of the channels with valid values in nearly all frames that are neither constant nor a ramp.
    pub usable: u16,
    /// Frames that count.
    pub frames: u32,
    /// Step of quantization; 0: none.
    pub quantization_step: f32,
}

/// A channel without a valid value in more than this share of the frames is left out. Of the others every frame must
/// have one: all channels share one abscissa.
const INVALID_SHARE_MAX: f32 = 0.1;

/// Channels that have valid values in nearly all frames that have any.
fn reliable_channels(span: &mut FrameSpan) -> Result<u16, Overwritten> {
    let (mut frames, mut invalid) = (0u32, [0u32; CHANNELS_MAX]);
    span.channels = 0;
    span.blocks(&[0.0; CHANNELS_MAX], &mut |block| {
        if block.complete && block.valid.iter().all(|valid| *valid == u16::MAX) {
            frames += BLOCK as u32;
            return;
        }
        for valid in block.valid.iter().filter(|valid| **valid != 0) {
            frames += 1;
            if *valid != u16::MAX {
                for (c, invalid) in invalid.iter_mut().enumerate() {
                    *invalid += (valid & 1 << c == 0) as u32;
                }
            }
        }
    })?;
    let mut channels = 0;
    for (c, invalid) in invalid.iter().enumerate() {
        channels |= ((*invalid as f32 <= INVALID_SHARE_MAX * frames as f32) as u16) << c;
    }
    Ok(channels)
}

/// First pass: levels, and which channels and frames count; fills `means` too.
pub fn levels(span: &mut FrameSpan, means: Option<&mut Means>) -> Result<Levels, Overwritten> {
    span.channels = reliable_channels(span)?;
    let zero = span.first_counted()?.unwrap_or_default();
    let mut sums = Sums::new(zero);
    let (abscissa, frames, channels) = (span.abscissa(), span.frames, span.channels);
    let mut unused = Means::new(QUAD as u32, &mut [], &mut []);
    let means = means.unwrap_or(&mut unused);
    span.blocks(&zero, &mut |block| match abscissa.step() {
        Some(step) => {
            let from = abscissa.u(block.first);
            means.add(&mut sums, &block, from, step, channels);
            if !block.complete {
                sums.add_each(&block, &abscissa.block(block.first, frames));
            }
        }
        None => {
            let u = abscissa.block(block.first, frames);
            means.add(&mut sums, &block, 0.0, 0.0, channels);
            sums.add_each(&block, &u);
            sums.add_along(&block, &u);
        }
    })?;
    Ok(Levels::new(&sums, channels, span.quantization_step))
}

impl Levels {
    /// How many channels are usable.
    pub fn channels(&self) -> f32 {
        self.usable.count_ones() as f32
    }

    /// Levels of the means' groups; `all` are those of the frames themselves, and have their noise.
    pub fn of_means(means: &Means, all: &Self, channels: u16) -> Self {
        let mut levels = Self::new(&means.sums, channels, all.quantization_step);
        for c in 0..CHANNELS_MAX {
            levels.noise_variance[c] = all.noise_variance[c] * means.by as f32;
        }
        levels
    }

    fn new(sums: &Sums, channels: u16, quantization_step: f32) -> Self {
        let empty = [0.0; CHANNELS_MAX];
        let mut result = Self {
            offset: empty,
            slope: empty,
            about_line: empty,
            about_mean: empty,
            y: empty,
            uy: empty,
            yy: empty,
            noise_variance: empty,
            bend: sums.bend.clone(),
            u: sums.u,
            uu: sums.uu,
            usable: 0,
            frames: sums.n,
            quantization_step,
        };
        if sums.n < 4 {
            return result;
        }
        let count = sums.n as f32;
        let spread = sums.uu - sums.u * sums.u / count;
        for c in (0..CHANNELS_MAX).filter(|c| channels & 1 << c != 0) {
            let mean = sums.y[c] / count;
            let along = sums.uy[c] - sums.u * mean;
            let slope = along / spread;
            let about_mean = sums.yy[c] - sums.y[c] * mean;
            let about = about_mean - along * slope;
            // Below this the sum is rounding: the channel is constant, or a ramp. A NaN is not above it.
            if !(about > 1e-6 * sums.yy[c] && about > 0.0 && about.is_finite()) {
                continue;
            }
            result.usable |= 1 << c;
            let offset = sums.zero[c] + (mean - slope * sums.u / count);
            // How far the offset, as f32 holds it, is from the first value.
            let moved = offset - sums.zero[c];
            result.offset[c] = offset;
            result.y[c] = sums.y[c] - count * moved;
            result.uy[c] = sums.uy[c] - sums.u * moved;
            result.yy[c] = sums.yy[c] - moved * (2.0 * sums.y[c] - count * moved);
            for k in 0..2 {
                result.bend.y[k][c] -= sums.bend.one[k] * moved;
            }
            result.slope[c] = slope;
            // 1 + 9 + 9 + 1: the squared factors of a third difference.
            result.noise_variance[c] = sums.third_squares[c] / (20 * sums.quads).max(1) as f32;
            result.about_line[c] = about;
            result.about_mean[c] = about_mean;
        }
        result
    }
}
