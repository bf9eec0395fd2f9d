//! Impulses: single values far off what is around them. Squares weigh one of twenty standard deviations as four hundred others,
//! so where there are some they are replaced and the window is fitted anew.
//!
//! It is one step of a redescending estimator: P. J. Huber, E. M. Ronchetti, "Robust Statistics" (2nd edition, 2009), section 4.8.

use crate::frame_span::{BLOCK, FrameSpan};
use crate::limits::CHANNELS_MAX;
use crate::solve::Solution;
use crate::source::{FrameSource, Overwritten, Values};
use crate::statistics::{Channels, Statistics};
use crate::waves::Waves;

/// Most impulses of a window: one value in a hundred of the chip's longest.
#[cfg(not(feature = "long-windows"))]
const IMPULSES_MAX: usize = 164;
#[cfg(feature = "long-windows")]
const IMPULSES_MAX: usize = 5_300;
/// Mean magnitude of white noise, in standard deviations: the root of 2 / pi.
const MEAN_MAGNITUDE: f32 = 0.797_884_6;
/// An impulse is so many standard deviations off, by the mean magnitude: white noise is in one of two million values.
const SIGMAS: f32 = 5.0;
/// More values than this, so close to each other, are no impulses.
const TOGETHER: u32 = 2;
const CLOSE: usize = 2;

/// A value that is replaced.
#[derive(Clone, Copy)]
struct Impulse {
    /// In the span.
    frame: u16,
    channel: u8,
    value: f32,
}

/// The impulses of a window, a block of frames after the other.
pub struct Impulses {
    all: [Impulse; IMPULSES_MAX],
    count: usize,
}

impl Impulses {
    pub const NONE: Self = Self { all: [Impulse { frame: 0, channel: 0, value: 0.0 }; IMPULSES_MAX], count: 0 };

    /// Those that a solution leaves. None if there are too many for impulses.
    #[inline(never)]
    pub fn find(
        &mut self,
        span: &mut FrameSpan,
        statistics: &Statistics,
        channels: &Channels,
        solution: &Solution,
        at: (f32, Option<f32>),
    ) -> Result<bool, Overwritten> {
        let (abscissa, frames) = (span.abscissa(), span.frames);
        let mut waves = Waves::new(span, statistics, solution, at);
        let mut magnitudes = [0.0; CHANNELS_MAX];
        let mut residuals =
            |span: &mut FrameSpan, visit: &mut dyn FnMut(usize, u32, u8, &Values, &[f32; BLOCK], u16)| {
                span.blocks(&statistics.offset, &mut |block| {
                    waves.go(abscissa.block(block.first, frames));
                    let there = block.valid.iter().rev().fold(0, |there, valid| there << 1 | (*valid != 0) as u16);
                    for (k, c) in channels.list().iter().enumerate() {
                        let c = *c as usize % CHANNELS_MAX;
                        let values = block.values.map(|values| values[c]);
                        visit(k, block.first, c as u8, &values, &waves.residuals(block.values, c, k), there);
                    }
                })
            };
        residuals(span, &mut |k, _, _, _, residuals, there| {
            for (_, residual) in residuals.iter().enumerate().filter(|(i, _)| there & 1 << i != 0) {
                magnitudes[k % CHANNELS_MAX] += residual.abs();
            }
        })?;
        let limit = SIGMAS / (MEAN_MAGNITUDE * solution.frames);
        let mut count = 0;
        residuals(span, &mut |k, first, channel, values, residuals, there| {
            let limit = limit * magnitudes[k % CHANNELS_MAX];
            let mut far = 0u16;
            for (i, residual) in residuals.iter().enumerate() {
                far |= ((residual.abs() > limit) as u16) << i;
            }
            for i in (0..BLOCK).filter(|i| far & there & 1 << i != 0) {
                let close = ((1u32 << (i + CLOSE + 1)) - (1 << i.saturating_sub(CLOSE))) as u16 & there;
                if (close & far).count_ones() > TOGETHER {
                    continue;
                }
                let others = close & !far;
                let sum: f32 = (0..BLOCK).filter(|i| others & 1 << i != 0).map(|i| residuals[i]).sum();
                let off = residuals[i] - sum / others.count_ones().max(1) as f32;
                if let Some(impulse) = self.all.get_mut(count) {
                    let value = values[i] - off / statistics.scale[channel as usize % CHANNELS_MAX];
                    *impulse = Impulse { frame: first as u16 + i as u16, channel, value };
                }
                count += 1;
            }
        })?;
        self.count = if count <= IMPULSES_MAX { count } else { 0 };
        Ok(self.count > 0)
    }
}

/// A source whose impulses are replaced.
pub struct Cleaned<'c> {
    pub source: &'c mut dyn FrameSource,
    /// Number of the span's first frame.
    pub first: u32,
    pub impulses: &'c Impulses,
}

impl FrameSource for Cleaned<'_> {
    fn read(&mut self, first: u32, most: usize, show: &mut dyn FnMut(&[Values], &[u16])) -> Result<(), Overwritten> {
        let from = first.wrapping_sub(self.first) as usize;
        let all = self.impulses.all.get(..self.impulses.count).unwrap_or_default();
        // They are in the order of their blocks.
        let all = all
            .get(all.partition_point(|impulse| (impulse.frame as usize) / BLOCK < from / BLOCK)..)
            .unwrap_or_default();
        self.source.read(first, most, &mut |values, valid| {
            let end = from + values.len();
            if values.len() > BLOCK
                || !all.first().is_some_and(|impulse| (impulse.frame as usize) / BLOCK * BLOCK < end)
            {
                return show(values, valid);
            }
            let mut copies = [[0.0; CHANNELS_MAX]; BLOCK];
            copies.iter_mut().zip(values).for_each(|(copy, values)| *copy = *values);
            for impulse in all.iter().take_while(|impulse| (impulse.frame as usize) / BLOCK * BLOCK < end) {
                let place = (impulse.frame as usize).checked_sub(from).and_then(|place| copies.get_mut(place));
                if let Some(copy) = place {
                    copy[impulse.channel as usize % CHANNELS_MAX] = impulse.value;
                }
            }
            show(copies.get(..values.len()).unwrap_or_default(), valid);
        })
    }
}
