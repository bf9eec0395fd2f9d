//! The window in memory: centred and scaled means of a few frames. All passes but the first two
//! read these.

use crate::abscissa::Abscissa;
use crate::limits::{CHANNELS_MAX, PIECES_MAX};
use crate::source::Values;

/// Pieces of a window that fits on the chip.
const PIECES_CHIP: usize = 512;
/// Unit of the values in memory: a channel's standard deviation is 1, and no value of 1024 frames
/// is farther off than 32.
const UNIT: f32 = 1.0 / 1024.0;
/// Variance of the rounding to that unit.
pub const ROUNDING: f32 = UNIT * UNIT / 12.0;

/// A mean of a few frames, centred and scaled.
pub struct Piece {
    /// Its number in the window.
    pub number: usize,
    /// Its place.
    pub u: f32,
    /// Values by place in [`crate::statistics::Statistics::order`].
    pub values: Values,
}

/// Memory of a window.
#[derive(Debug)]
pub struct Pieces {
    values: [[i16; CHANNELS_MAX]; PIECES_MAX],
    /// A bit for each piece that has frames.
    present: [u32; PIECES_MAX / 32],
    count: usize,
}

/// Frames of a piece in a window of `frames` frames.
pub fn frames_each(frames: u32) -> u32 {
    let most = if frames as usize <= 2 * PIECES_CHIP {
        PIECES_CHIP
    } else {
        PIECES_MAX
    };
    frames.div_ceil(most as u32).max(1)
}

impl Pieces {
    /// None; all zeros.
    pub const fn new() -> Self {
        Self {
            values: [[0; CHANNELS_MAX]; PIECES_MAX],
            present: [0; PIECES_MAX / 32],
            count: 0,
        }
    }

    /// Forgets all, and makes room for `count`.
    pub fn clear(&mut self, count: usize) {
        self.count = count.min(PIECES_MAX);
        self.present = [0; PIECES_MAX / 32];
    }

    /// How many there are, with those that have no frames.
    pub fn count(&self) -> usize {
        self.count
    }

    /// Whether a piece has frames.
    pub fn is_present(&self, number: usize) -> bool {
        self.present[number / 32] >> (number % 32) & 1 == 1
    }

    /// Sets a piece.
    pub fn set(&mut self, number: usize, values: &Values) {
        if number < self.count {
            self.present[number / 32] |= 1 << (number % 32);
            for (place, value) in self.values[number].iter_mut().zip(values) {
                *place = (value * (1.0 / UNIT) + 0.5f32.copysign(*value)) as i16;
            }
        }
    }

    /// Values of a piece.
    pub fn get(&self, number: usize) -> Values {
        self.values[number].map(|value| f32::from(value) * UNIT)
    }
}

/// The pieces of a window, and where they are.
pub struct Data<'d> {
    /// The pieces.
    pub pieces: &'d mut Pieces,
    /// Places of the frames.
    pub place: Abscissa<'d>,
    /// Frames of a piece.
    pub each: u32,
    /// Number of channels.
    pub width: usize,
    /// Cycles a window of half the pieces' rate.
    pub cycles_max: f32,
}

impl Data<'_> {
    /// Place of a piece.
    fn u(&self, number: usize) -> f32 {
        let first = number as u32 * self.each;
        let u = self.place.u(first);
        if self.each > 1 {
            0.5 * (u + self.place.u(first + self.each - 1))
        } else {
            u
        }
    }

    /// A piece that has frames.
    pub fn piece(&self, number: usize) -> Option<Piece> {
        self.pieces.is_present(number).then(|| Piece {
            number,
            u: self.u(number),
            values: self.pieces.get(number),
        })
    }

    /// The pieces that have frames.
    pub fn iter(&self) -> impl Iterator<Item = Piece> {
        (0..self.pieces.count()).filter_map(|number| self.piece(number))
    }

    /// Place of a piece in a transform of the window: along a path by where it is.
    pub fn slot(&self, piece: &Piece) -> usize {
        match self.place {
            Abscissa::Time { .. } => piece.number,
            Abscissa::Path { .. } => (0.5 * (piece.u + 1.0) * self.pieces.count() as f32) as usize,
        }
    }
}
