//! Forces for a display of pins.

use heapless::Vec;
use serde::{Deserialize, Serialize};

/// Most pins on a side.
pub const PINS_SIDE_MAX: usize = 10;

/// A display releases its pins if no event has come for so long, microseconds. It has to: the board
/// does not know what its line has lost, and goes on from where its pins are. A display that has
/// released moves them by its own slew to the next event.
pub const PINS_SILENCE_US: u64 = 500_000;

/// Forces of a square display's pins, within the limits of
/// [`PinDisplay`](crate::settings::PinDisplay): they press, at most with the greatest force, and
/// change by no more than the slew from one event to the next, unless a new greatest force is
/// lower. Events after a start, with another number of pins, and more than [`PINS_SILENCE_US`]
/// after the last one begin with pins that do not press.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Pins {
    /// Device time at which the update fell due, microseconds. Its forces are those of a mean over
    /// a few frames that ended up to 17 ms before.
    pub t_us: u64,
    /// Taxels that count; bit k is taxel k. A unit without any has no strain. None counts without
    /// touch.
    pub taxels: u16,
    /// Pins whose wanted force is beyond the greatest.
    pub limited: u8,
    /// Updates that fell due after the last one and were left out, as the fit took longer: 255 for
    /// more.
    pub skipped: u8,
    /// Whether the forces are those whose strains are the nearest. If not there was no time to find
    /// them, or no force can be computed.
    pub is_optimal: bool,
    /// Force of a level, newtons.
    pub level_n: f32,
    /// Force of each pin in levels, row by row, as many rows as columns; the columns along the
    /// sliding direction.
    pub levels: Vec<u8, { PINS_SIDE_MAX * PINS_SIDE_MAX }>,
}

impl Pins {
    /// Pins on a side.
    pub fn side(&self) -> usize {
        self.levels.len().isqrt()
    }

    /// Forces, newtons, row by row.
    pub fn forces_n(&self) -> impl ExactSizeIterator<Item = f32> {
        self.levels
            .iter()
            .map(|level| f32::from(*level) * self.level_n)
    }
}
