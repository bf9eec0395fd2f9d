//! Impulses: single values far off what is around them. Squares weigh one of twenty standard deviations as four hundred others,
//! so where there are some they are replaced and the window is fitted anew.
//!
//! It is one step of a redescending estimator: P. J. Huber, E. M. Ronchetti, "Robust Statistics" (2nd edition, 2009), section 4.8.

use crate::frame_span::{BLOCK, Block, FrameSpan};
use crate::limits::CHANNELS_MAX;
use crate::solve::Solution;
use crate::source::{FrameSource, Overwritten, Values};
use crate::spectrum::POINTS_CHIP;
use crate::statistics::{Channels, Statistics};
use crate::waves::Waves;
use core::ops::Range;

/// Most impulses of a window that the chip can fit: one value in a hundred of its longest, and some more. What are beyond stay.
const IMPULSES_CHIP: usize = 160;
/// The same of any window.
#[cfg(not(feature = "long-windows"))]
const IMPULSES_MAX: usize = IMPULSES_CHIP;
#[cfg(feature = "long-windows")]
const IMPULSES_MAX: usize = 5_300;
/// Most of a window's values that may be impulses.
const SHARE_MAX: f32 = 0.03;
/// Mean magnitude of white noise, in standard deviations: the root of 2 / pi.
const MEAN_MAGNITUDE: f32 = 0.797_884_6;
/// An impulse is so many standard deviations off, by the mean magnitude: white noise is in one of two million values.
const SIGMAS: f32 = 5.0;
/// More values than this, so close to each other, are no impulses.
const TOGETHER: u32 = 2;
const CLOSE: usize = 2;

/// Where an impulse is: its frame in the span times [`CHANNELS_MAX`], plus its channel.
#[cfg(not(feature = "long-windows"))]
type Place = u16;
#[cfg(feature = "long-windows")]
type Place = u32;

/// The impulses of a window, a block of frames after the other.
pub struct Impulses {
    places: [Place; IMPULSES_MAX],
    /// What replaces them.
    values: [f32; IMPULSES_MAX],
    count: usize,
    /// No more on a PC than on the chip where the chip can fit the window: both give the same bits.
    is_of_chip: bool,
}

impl Impulses {
    /// None; a constant is written in its place.
    pub const NONE: Self = Self { places: [0; IMPULSES_MAX], values: [0.0; IMPULSES_MAX], count: 0, is_of_chip: true };

    /// Whether there are some.
    pub fn are_found(&self) -> bool {
        self.count > 0
    }

    /// Those that a solution leaves.
    #[inline(never)]
    pub fn find(
        &mut self,
        span: &mut FrameSpan,
        statistics: &Statistics,
        channels: &Channels,
        solution: &Solution,
        at: (f32, Option<f32>),
    ) -> Result<(), Overwritten> {
        let (abscissa, frames) = (span.abscissa(), span.frames);
        self.is_of_chip = frames as usize <= POINTS_CHIP;
        let mut waves = Waves::new(span, statistics, solution, at);
        let (mut magnitudes, mut limits) = ([0.0; CHANNELS_MAX], [f32::INFINITY; CHANNELS_MAX]);
        for _ in 0..2 {
            self.count = 0;
            span.blocks(&statistics.offset, &mut |block| {
                waves.go(abscissa.block(block.first, frames));
                let there = block.valid.iter().rev().fold(0, |there, valid| there << 1 | (*valid != 0) as u16);
                for ((k, c), limit) in channels.list().iter().enumerate().zip(&limits) {
                    let c = *c as usize % CHANNELS_MAX;
                    let (residuals, mut far) = (waves.residuals(block.values, c, k), 0);
                    for (i, (residual, valid)) in residuals.iter().zip(block.valid).enumerate() {
                        let magnitude = if *valid != 0 { residual.abs() } else { 0.0 };
                        magnitudes[k % CHANNELS_MAX] += magnitude;
                        far |= ((magnitude > *limit) as u16) << i;
                    }
                    if far != 0 {
                        self.add(&block, c, &residuals, [far, there], statistics.scale[c]);
                    }
                }
            })?;
            if self.count as f32 > SHARE_MAX * solution.frames * channels.width as f32 {
                // So many are something else.
                self.count = 0;
            }
            limits = magnitudes.map(|magnitude| SIGMAS / MEAN_MAGNITUDE * magnitude / solution.frames);
        }
        Ok(())
    }

    /// Adds a channel's impulses in a block, of which some frames are far off, and some are there.
    #[inline(never)]
    fn add(&mut self, block: &Block, c: usize, residuals: &[f32; BLOCK], [far, there]: [u16; 2], scale: f32) {
        for i in (0..BLOCK).filter(|i| far & 1 << i != 0) {
            let close = ((1u32 << (i + CLOSE + 1)) - (1 << i.saturating_sub(CLOSE))) as u16 & there;
            if (close & far).count_ones() > TOGETHER {
                continue;
            }
            let others = close & !far;
            let beside = residuals.iter().enumerate().filter(|(i, _)| others & 1 << i != 0).map(|(_, beside)| beside);
            let off = residuals[i % BLOCK] - beside.sum::<f32>() / others.count_ones().max(1) as f32;
            if self.count < self.most()
                && let (Some(place), Some(value)) = (self.places.get_mut(self.count), self.values.get_mut(self.count))
            {
                *place = ((block.first as usize + i) * CHANNELS_MAX + c) as Place;
                *value = block.values[i % BLOCK][c % CHANNELS_MAX] - off / scale;
            }
            self.count += 1;
        }
    }

    fn most(&self) -> usize {
        if self.is_of_chip { IMPULSES_CHIP } else { IMPULSES_MAX }
    }

    /// Those of the frames' blocks: frame, channel and what replaces the value.
    fn of(&self, frames: Range<usize>) -> impl Iterator<Item = (usize, usize, f32)> {
        const BLOCK_PLACES: usize = BLOCK * CHANNELS_MAX;
        let blocks = frames.start / BLOCK..frames.end.div_ceil(BLOCK);
        let places = self.places.get(..self.count.min(self.most())).unwrap_or_default();
        // They are in the order of their blocks.
        let first = places.partition_point(|place| *place as usize / BLOCK_PLACES < blocks.start);
        let all = places.iter().zip(&self.values).skip(first).map(|(place, value)| (*place as usize, *value));
        all.take_while(move |(place, _)| place / BLOCK_PLACES < blocks.end)
            .map(|(place, value)| (place / CHANNELS_MAX, place % CHANNELS_MAX, value))
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
        let impulses = self.impulses;
        self.source.read(first, most.min(BLOCK), &mut |values, valid| {
            let frames = from..from + values.len();
            if impulses.of(frames.clone()).next().is_none() {
                return show(values, valid);
            }
            let mut copies = [[0.0; CHANNELS_MAX]; BLOCK];
            copies.iter_mut().zip(values).for_each(|(copy, values)| *copy = *values);
            for (frame, channel, value) in impulses.of(frames) {
                if let Some(copy) = frame.checked_sub(from).and_then(|place| copies.get_mut(place)) {
                    copy[channel] = value;
                }
            }
            show(copies.get(..values.len()).unwrap_or_default(), valid);
        })
    }
}
