//! The window in memory: centred and scaled means of a few frames. All passes but the first two
//! read these.

use crate::abscissa::Abscissa;
use crate::limits::{CHANNELS_MAX, PIECES_MAX};
use crate::phase::{cos_sin, from_turns};
use crate::source::Values;
use core::f32::consts::PI;
use core::ops::Range;

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

/// The low pass by which a piece is the mean of the frames about it: half of the power at half of the
/// pieces' rate, a sixth of the amplitude at two thirds of it.
pub struct Filter {
    each: u32,
    /// By distance of a frame from a piece's centre, in halves of a frame.
    weights: [f32; Self::WEIGHTS],
}

impl Filter {
    /// Pieces that a frame counts for.
    pub const PIECES: usize = 5;
    /// Most distances: four frames of a piece.
    const WEIGHTS: usize = 16;

    /// The filter for pieces of so many frames.
    pub fn new(each: u32) -> Self {
        let mut weights = [0.0; Self::WEIGHTS];
        weights[0] = 1.0;
        if each > 1 {
            for (i, weight) in weights.iter_mut().enumerate().take(4 * each as usize) {
                let x = 0.5 * i as f32 / each as f32;
                let sinc = if i == 0 {
                    1.0
                } else {
                    cos_sin(from_turns(0.5 * x)).1 / (PI * x)
                };
                let window = cos_sin(from_turns(0.125 * x)).0;
                *weight = sinc * window * window / each as f32;
            }
        }
        Self { each, weights }
    }

    /// Pieces that a frame counts for.
    pub fn pieces(&self, frame: u32) -> Range<u32> {
        let own = frame / self.each;
        if self.each > 1 {
            own.saturating_sub(2)..own + 3
        } else {
            own..own + 1
        }
    }

    /// How much a frame counts for a piece.
    pub fn weight(&self, frame: u32, piece: u32) -> f32 {
        let distance = (2 * frame).abs_diff(2 * piece * self.each + self.each - 1);
        self.weights
            .get(distance as usize)
            .copied()
            .unwrap_or_default()
    }

    /// What is left of the amplitude of a wave of some cycles per piece.
    pub fn gain(&self, cycles: f32) -> f32 {
        if self.each == 1 {
            return 1.0;
        }
        let (mut gain, mut all) = (0.0, 0.0);
        for (i, weight) in self.weights.iter().enumerate() {
            if i % 2 == (self.each as usize - 1) % 2 {
                let both = if i == 0 { 1.0 } else { 2.0 } * weight;
                gain += both * cos_sin(from_turns(0.5 * i as f32 * cycles / self.each as f32)).0;
                all += both;
            }
        }
        gain / all
    }
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

    /// Visits the pieces that have frames.
    pub fn visit(&self, mut visit: impl FnMut(&Piece)) {
        let mut piece = Piece {
            number: 0,
            u: 0.0,
            values: [0.0; CHANNELS_MAX],
        };
        for number in 0..self.pieces.count() {
            if self.pieces.is_present(number) {
                piece.number = number;
                piece.u = self.u(number);
                let values = &self.pieces.values[number];
                for (place, value) in piece.values.iter_mut().zip(values) {
                    *place = f32::from(*value) * UNIT;
                }
                visit(&piece);
            }
        }
    }

    /// Visits a channel: places in a transform of the window, along a path by where they are, and
    /// values.
    pub fn channel(&self, k: usize, mut visit: impl FnMut(usize, f32)) {
        for number in 0..self.pieces.count() {
            if self.pieces.is_present(number) {
                let value = f32::from(self.pieces.values[number][k]) * UNIT;
                visit(self.slot(number), value);
            }
        }
    }

    /// Place of a piece in a transform.
    pub fn slot(&self, number: usize) -> usize {
        match self.place {
            Abscissa::Time { .. } => number,
            Abscissa::Path { .. } => {
                (0.5 * (self.u(number) + 1.0) * self.pieces.count() as f32) as usize
            }
        }
    }
}
