//! Known interferer (mains hum): its frequency is refined near the declared one, and the fitted hum
//! is subtracted from the frames. Hum is periodic in time, even in a fit along a path.

mod find;

use crate::frame::Frame;
use crate::phase::{cos_sin, from_turns};
use crate::source::Values;

#[derive(Clone, Copy, Debug)]
pub struct Hum {
    pub cycles_per_frame: f32,
    /// Frame number of the window's centre, where the phase is zero.
    middle: f32,
    /// Amplitudes of cosine and sine in each channel.
    waves: [Values; 2],
}

impl Hum {
    pub fn subtract(&self, frame: &mut Frame) {
        let turns = self.cycles_per_frame * (frame.number as f32 - self.middle);
        let (cos, sin) = cos_sin(from_turns(turns));
        for (k, value) in frame.values.iter_mut().enumerate() {
            *value -= self.waves[0][k] * cos + self.waves[1][k] * sin;
        }
    }
}
