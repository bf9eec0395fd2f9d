//! A window's impulses, and a source in which they are replaced.

use crate::abscissa::BLOCK;
use crate::limits::{CHANNELS_MAX, POINTS_CHIP};
use crate::source::{FrameSource, Overwritten, Values};
use core::ops::Range;

/// Most impulses of a window that the chip can fit: one value in a hundred of its longest, and some
/// more. What are beyond stay.
const IMPULSES_CHIP: usize = 160;
/// The same of any window.
#[cfg(not(feature = "long-windows"))]
const IMPULSES_MAX: usize = IMPULSES_CHIP;
#[cfg(feature = "long-windows")]
const IMPULSES_MAX: usize = 5_300;

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
    pub const NONE: Self = Self {
        places: [0; IMPULSES_MAX],
        values: [0.0; IMPULSES_MAX],
        count: 0,
        is_of_chip: true,
    };

    /// Whether there are some.
    pub fn are_found(&self) -> bool {
        self.count > 0
    }

    /// Forgets all, for a window of `frames` frames.
    pub fn begin(&mut self, frames: u32) {
        (self.count, self.is_of_chip) = (0, frames as usize <= POINTS_CHIP);
    }

    /// As many as were found, though there may be space for fewer.
    pub fn count(&self) -> usize {
        self.count
    }

    /// The next one: its frame in the span, its channel, and what replaces it.
    pub fn push(&mut self, frame: usize, channel: usize, value: f32) {
        if self.count < self.most()
            && let (Some(place), Some(replaced)) = (
                self.places.get_mut(self.count),
                self.values.get_mut(self.count),
            )
        {
            (*place, *replaced) = ((frame * CHANNELS_MAX + channel) as Place, value);
        }
        self.count += 1;
    }

    fn most(&self) -> usize {
        if self.is_of_chip {
            IMPULSES_CHIP
        } else {
            IMPULSES_MAX
        }
    }

    /// Those of the frames' blocks: frame, channel and what replaces the value.
    fn of(&self, frames: Range<usize>) -> impl Iterator<Item = (usize, usize, f32)> {
        const BLOCK_PLACES: usize = BLOCK * CHANNELS_MAX;
        let blocks = frames.start / BLOCK..frames.end.div_ceil(BLOCK);
        let places = self
            .places
            .get(..self.count.min(self.most()))
            .unwrap_or_default();
        // They are in the order of their blocks.
        let first = places.partition_point(|place| *place as usize / BLOCK_PLACES < blocks.start);
        let all = places
            .iter()
            .zip(&self.values)
            .skip(first)
            .map(|(place, value)| (*place as usize, *value));
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
    fn read(
        &mut self,
        first: u32,
        most: usize,
        show: &mut dyn FnMut(&[Values], &[u16]),
    ) -> Result<(), Overwritten> {
        let from = first.wrapping_sub(self.first) as usize;
        let impulses = self.impulses;
        self.source
            .read(first, most.min(BLOCK), &mut |values, valid| {
                let frames = from..from + values.len();
                if impulses.of(frames.clone()).next().is_none() {
                    return show(values, valid);
                }
                let mut copies = [[0.0; CHANNELS_MAX]; BLOCK];
                copies
                    .iter_mut()
                    .zip(values)
                    .for_each(|(copy, values)| *copy = *values);
                for (frame, channel, value) in impulses.of(frames) {
                    if let Some(copy) = frame
                        .checked_sub(from)
                        .and_then(|place| copies.get_mut(place))
                    {
                        copy[channel] = value;
                    }
                }
                show(copies.get(..values.len()).unwrap_or_default(), valid);
            })
    }
}
