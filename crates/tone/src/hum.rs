//! A known interferer, mains hum: its frequency is refined near where it is said to be, and its waves
//! are subtracted from the frames. It is in time, also along a path.

mod find;

use crate::frame::Frame;
use crate::phase::{cos_sin, from_turns};
use crate::source::Values;

/// An interferer's wave.
#[derive(Clone, Copy, Debug)]
pub struct Hum {
    /// Cycles per frame.
    pub cycles_per_frame: f32,
    /// Half of the window's frames less one: where its phase is zero.
    middle: f32,
    /// Cosine and sine of each channel.
    waves: [Values; 2],
}

impl Hum {
    /// Takes it out of a frame.
    pub fn subtract(&self, frame: &mut Frame) {
        let turns = self.cycles_per_frame * (frame.number as f32 - self.middle);
        let (cos, sin) = cos_sin(from_turns(turns));
        for (k, value) in frame.values.iter_mut().enumerate() {
            *value -= self.waves[0][k] * cos + self.waves[1][k] * sin;
        }
    }
}
