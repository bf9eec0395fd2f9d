//! Means of a few frames each for the search, and the memory for them and for transforms.

use crate::frame_span::FrameSpan;
use crate::levels::{Levels, levels};
use crate::limits::CHANNELS_MAX;
use crate::means::Means;
use crate::source::{Overwritten, Table, Values};
use crate::spectrum::{POINTS_MAX, TransformMemory};
use crate::sums::QUAD;

/// Most means of a search; a window of one second at 241 Hz has 60 of 4 frames.
const MEANS_MAX: usize = 64;
/// Fewer frames than this are searched themselves.
const FRAMES_FOR_MEANS: u32 = 128;
/// Share of the power that the means must keep.
const KEPT_POWER_SHARE: f32 = 0.5;
/// Channels whose means are transformed: enough for a guess.
const TRANSFORMED_CHANNELS: usize = 4;

/// Memory of the search: transforms, or the means and their transforms.
#[derive(Debug)]
pub struct Scratch {
    points: [f32; POINTS_MAX],
    power: [f32; POINTS_MAX / 2],
}

impl Scratch {
    /// Empty; `const`, so that it can live in a static.
    pub const fn new() -> Self {
        Self { points: [0.0; POINTS_MAX], power: [0.0; POINTS_MAX / 2] }
    }

    /// All of it for transforms of all channels.
    pub fn for_transforms(&mut self) -> TransformMemory<'_> {
        TransformMemory { channels: u16::MAX, points: &mut self.points, power: &mut self.power }
    }
}

/// The means of groups of frames.
pub struct Coarse {
    /// Frames of a group.
    pub by: u32,
    /// Groups.
    pub count: usize,
    /// Levels of the means.
    pub levels: Levels,
    valid: [u16; MEANS_MAX],
}

impl Coarse {
    /// The means, and memory for transforms of the channels of which they keep most. None if they do not keep the better
    /// part of the power.
    pub fn split<'s>(&'s self, all: &Levels, scratch: &'s mut Scratch) -> Option<(Table<'s>, TransformMemory<'s>)> {
        let (values, _) = scratch.points.as_chunks();
        let table = Table { values: values.get(..self.count)?, valid: self.valid.get(..self.count)? };
        let (mut kept, mut shares) = (0.0, [0.0; CHANNELS_MAX]);
        for c in 0..CHANNELS_MAX {
            if self.levels.usable & 1 << c != 0 {
                shares[c] = self.levels.about_line[c] / (self.by as f32 * all.about_line[c]);
                kept += shares[c];
            }
        }
        let (points, power) = scratch.power.split_at_mut(POINTS_MAX / 4);
        let memory = TransformMemory { channels: clearest(&shares, self.levels.usable), points, power };
        (kept >= KEPT_POWER_SHARE * self.levels.channels()).then_some((table, memory))
    }
}

/// Levels of a span, and its means in `scratch` unless it is too short for them.
pub fn levels_and_means(span: &mut FrameSpan, scratch: &mut Scratch) -> Result<(Levels, Option<Coarse>), Overwritten> {
    let (mut by, mut valid) = (QUAD as u32, [0; MEANS_MAX]);
    let groups = |by: u32| span.frames.checked_div(by).unwrap_or(0);
    while groups(by) > MEANS_MAX as u32 {
        by *= 2;
    }
    let count = groups(by) as usize;
    let (values, _) = scratch.points.as_chunks_mut();
    if span.frames >= FRAMES_FOR_MEANS
        && span.is_in_time()
        && let (Some(values), Some(valid_of)) = (values.get_mut(..count), valid.get_mut(..count))
    {
        let mut means = Means::new(by, values, valid_of);
        let all = levels(span, Some(&mut means))?;
        let levels = Levels::of_means(&means, &all, span.channels);
        return Ok((all, Some(Coarse { by, count, levels, valid })));
    }
    Ok((levels(span, None)?, None))
}

/// The channels of which means keep most: they have the least noise.
#[inline(never)]
fn clearest(shares: &Values, usable: u16) -> u16 {
    let (mut channels, mut remaining) = (0, usable);
    // Not unrolled: that would take half a kilobyte of flash.
    for _ in 0..core::hint::black_box(TRANSFORMED_CHANNELS) {
        let (mut best, mut most, mut others) = (0, -1.0, remaining);
        while others != 0 {
            let c = others.trailing_zeros() as usize % CHANNELS_MAX;
            others &= others - 1;
            if shares[c] > most {
                (best, most) = (1 << c, shares[c]);
            }
        }
        channels |= best;
        remaining &= !best;
    }
    channels
}
