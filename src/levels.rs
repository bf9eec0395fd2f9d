//! The level and the slope of every channel in a window, and which channels can be used.

use crate::moments::{BLOCK, Stretch};
use crate::settings::TAXELS;
use crate::window::{FrameSource, Values};

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
    /// Taxels with valid values in nearly all frames, and not constant.
    pub usable: u16,
    /// Frames that count.
    pub frames: u32,
}

/// A taxel without a valid value in more than this share of the frames is left out. Of the others
/// every frame must have one: all channels share one abscissa.
const INVALID_MAX: f32 = 0.1;

/// Taxels that have valid values in nearly all frames that have any. None if the frames were
/// overwritten.
fn reliable_taxels<S: FrameSource>(stretch: &mut Stretch<'_, S>) -> Option<u16> {
    let (mut frames, mut invalid) = (0u32, [0u32; TAXELS]);
    stretch.taxels = 0;
    stretch.blocks(|block| {
        for valid in block.valid.iter().filter(|valid| **valid != 0) {
            frames += 1;
            if *valid != u16::MAX {
                for (c, invalid) in invalid.iter_mut().enumerate() {
                    *invalid += (valid & 1 << c == 0) as u32;
                }
            }
        }
    })?;
    let mut taxels = 0;
    for (c, invalid) in invalid.iter().enumerate() {
        taxels |= ((*invalid as f32 <= INVALID_MAX * frames as f32) as u16) << c;
    }
    Some(taxels)
}

/// First pass: levels, and which taxels and frames count. None if the frames were overwritten.
pub fn levels<S: FrameSource>(stretch: &mut Stretch<'_, S>) -> Option<Levels> {
    stretch.taxels = reliable_taxels(stretch)?;
    let mut reference: Option<Values> = None;
    let usable = stretch.taxels;
    let (mut n, mut sum_u, mut sum_uu) = (0u32, 0.0, 0.0);
    let (mut y0, mut y1, mut yy) = ([0f32; TAXELS], [0f32; TAXELS], [0f32; TAXELS]);
    let (start, step) = (stretch.u(0), 1.0 / stretch.half());
    stretch.blocks(|block| {
        let mut us = [0.0; BLOCK];
        let mut whole = true;
        for i in 0..BLOCK {
            if block.valid[i] == 0 {
                whole = false;
                continue;
            }
            let u = start + step * (block.at + i as u32) as f32;
            us[i] = u;
            n += 1;
            sum_u += u;
            sum_uu += u * u;
            reference.get_or_insert(block.values[i]);
        }
        let Some(zero) = &reference else { return };
        for c in 0..TAXELS {
            let (mut sum, mut u_sum, mut squares) = (0.0, 0.0, 0.0);
            for i in 0..BLOCK {
                if whole || block.valid[i] != 0 {
                    let y = block.values[i][c] - zero[c];
                    sum += y;
                    u_sum += us[i] * y;
                    squares += y * y;
                }
            }
            y0[c] += sum;
            y1[c] += u_sum;
            yy[c] += squares;
        }
    })?;
    let mut result = Levels {
        offset: [0.0; TAXELS],
        slope: [0.0; TAXELS],
        about_line: [0.0; TAXELS],
        about_mean: [0.0; TAXELS],
        y: [0.0; TAXELS],
        uy: [0.0; TAXELS],
        yy: [0.0; TAXELS],
        usable: 0,
        frames: n,
    };
    let Some(reference) = reference.filter(|_| n >= 4) else { return Some(result) };
    let count = n as f32;
    let spread = sum_uu - sum_u * sum_u / count;
    for c in 0..TAXELS {
        let mean = y0[c] / count;
        let along = y1[c] - sum_u * mean;
        let slope = along / spread;
        let about_mean = yy[c] - y0[c] * mean;
        let about = about_mean - along * slope;
        let offset = reference[c] + (mean - slope * sum_u / count);
        // By how much the offset, as f32 holds it, is off the reference.
        let moved = offset - reference[c];
        result.offset[c] = offset;
        result.y[c] = y0[c] - count * moved;
        result.uy[c] = y1[c] - sum_u * moved;
        result.yy[c] = yy[c] - moved * (2.0 * y0[c] - count * moved);
        result.slope[c] = slope;
        result.about_line[c] = about;
        result.about_mean[c] = about_mean;
        // Below this the sum is what rounding left of it: the channel is constant, or a ramp.
        if usable & 1 << c != 0 && about > 1e-6 * yy[c] && about > 0.0 {
            result.usable |= 1 << c;
        }
    }
    Some(result)
}

/// Copies one channel, less its straight line, into `out` (zeros behind it and where frames are
/// missing). None if the frames were overwritten.
pub fn detrended<S: FrameSource>(
    stretch: &mut Stretch<'_, S>,
    levels: &Levels,
    taxel: usize,
    out: &mut [f32],
) -> Option<()> {
    out.fill(0.0);
    let (start, step) = (stretch.u(0), 1.0 / stretch.half());
    stretch.blocks(|block| {
        for i in 0..BLOCK {
            let frame = block.at + i as u32;
            if let Some(place) = out.get_mut(frame as usize).filter(|_| block.valid[i] != 0) {
                let u = start + step * frame as f32;
                *place = block.values[i][taxel] - levels.offset[taxel] - levels.slope[taxel] * u;
            }
        }
    })
}
