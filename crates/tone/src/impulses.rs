//! Impulses: single outliers. In a least-squares fit an outlier of twenty standard deviations
//! weighs as much as four hundred other values, so impulses are replaced by the model and the
//! window is fitted again.
//!
//! One step of a redescending estimator: P. J. Huber, E. M. Ronchetti, "Robust Statistics" (2nd
//! edition, 2009), section 4.8.

mod find;

use crate::frame::Frame;
use crate::limits::{CHANNELS_MAX, IMPULSES_MAX};
pub use find::{Z_IMPULSE, replace};

/// Places per frame, one for each channel.
const CHANNELS: u32 = CHANNELS_MAX as u32;

#[derive(Clone, Copy, Debug, Default)]
struct Impulse {
    /// Sixteen times the frame number, plus the channel.
    place: u32,
    /// Deviation from the model, which is subtracted.
    off: f32,
}

/// Outliers, sorted by `place`.
#[derive(Debug)]
pub struct Impulses {
    list: [Impulse; IMPULSES_MAX],
    count: usize,
}

/// Outliers that are still ahead in a pass over the frames.
pub struct Ahead<'i>(&'i [Impulse]);

impl Ahead<'_> {
    #[inline]
    pub fn subtract(&mut self, frame: &mut Frame) {
        while let Some((first, others)) = self.0.split_first() {
            if first.place / CHANNELS > frame.number {
                break;
            }
            if first.place / CHANNELS == frame.number {
                frame.values[(first.place % CHANNELS) as usize] -= first.off;
            }
            self.0 = others;
        }
    }
}

impl Impulses {
    /// Empty; all zeros.
    pub const fn new() -> Self {
        Self {
            list: [Impulse { place: 0, off: 0.0 }; IMPULSES_MAX],
            count: 0,
        }
    }

    pub fn clear(&mut self) {
        self.count = 0;
    }

    /// Starts a pass over the frames.
    pub fn iter(&self) -> Ahead<'_> {
        Ahead(self.list.get(..self.count).unwrap_or_default())
    }

    /// Inserts an outlier sorted by `place`, after any at the same place.
    fn add(&mut self, place: u32, off: f32) {
        let list = self.list.get_mut(..=self.count).unwrap_or_default();
        let mut before = list.iter_mut().rev();
        let Some(mut free) = before.next() else {
            return;
        };
        for other in before.take_while(|other| other.place > place) {
            *free = *other;
            free = other;
        }
        *free = Impulse { place, off };
        self.count += 1;
    }
}
