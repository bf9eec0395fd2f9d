//! The contact spike: the paper's equations 2 and 3.

use crate::touch::block::BLOCK_FRAMES;
use crate::touch::chi_square::{Limit, limit};
use crate::touch::onset::Frames;
use ridgetone_proto::settings::TAXELS;
use ridgetone_tone::Values;

/// A higher frame replaces a taxel's peak if it comes within this number of frames after it: 20 ms.
const PEAK_FRAMES: u32 = 5;
/// A higher frame that comes later replaces the peak only if it is higher by more than this number
/// of standard deviations.
const CLEAR: f32 = 4.0;
/// It must also be higher by more than this fraction of the peak: otherwise a slide that has begun
/// would look like the contact.
const CLEAR_FRACTION: f32 = 0.25;
/// The spike may have begun this number of frames before the block that shows the first touch.
const LOOK_BACK: u32 = 4;
/// The load may have begun to rise this number of frames before that block: 133 ms.
const ONSET_FRAMES: u32 = 32;
/// Time within which the spike's peak is looked for after the first touch, frames: 0.3 s. The paper
/// looks for it in the first 0.8 s of a record that contains it.
pub const SPIKE_FRAMES: u32 = 72;
/// Blocks in a row without a quick change after which the spike is over: 100 ms.
pub const SPIKE_STILL_BLOCKS: u32 = 6;
/// After a spike the skin creeps back to its idle level. A deviation that is below a twentieth of
/// the spike's peak is taken for that; this is the square of the twentieth.
pub const BACK_FROM_SPIKE: f32 = 1.0 / 400.0;
/// A tap that leaves no load is reported if the squared height of its spike, in units of the noise,
/// is at least this: 30 standard deviations in every taxel. A lower spike is a vibration.
pub const TAP: Limit = limit(900.0, 0.0);

/// The highest deviation of every taxel so far.
#[derive(Clone, Debug)]
pub struct Spike {
    /// Deviation of each taxel from the idle level, codes.
    peak: Values,
    /// Frame of each taxel's deviation, counted from `first`.
    frame: [u8; TAXELS],
    /// Number of the first frame that was examined.
    first: u32,
    /// Frame in which the load begins to rise.
    pub onset: u32,
}

impl Spike {
    pub const fn new() -> Self {
        Self {
            peak: [0.0; TAXELS],
            frame: [0; TAXELS],
            first: 0,
            onset: 0,
        }
    }

    /// Looks at the block that ends with frame `number`, which shows the first touch, and at the
    /// [`LOOK_BACK`] frames before it.
    pub fn begin(number: u32, idle: &Values, frames: &Frames) -> Self {
        let first = number.wrapping_sub(BLOCK_FRAMES - 1 + LOOK_BACK);
        let mut spike = Self {
            first,
            onset: frames.departure(idle, number, number.wrapping_sub(ONSET_FRAMES)),
            ..Self::new()
        };
        for number in (0..BLOCK_FRAMES + LOOK_BACK).map(|frames| first.wrapping_add(frames)) {
            if let Some(values) = frames.values(number, &mut [0.0; TAXELS]) {
                spike.follow(number, values, idle, frames.motion.weights());
            }
        }
        spike
    }

    /// Equation 3: takes the next frame.
    pub fn follow(&mut self, number: u32, values: &Values, idle: &Values, weights: &Values) {
        // A spike lasts fewer than 255 frames.
        let frame = number.wrapping_sub(self.first).min(u8::MAX.into()) as u8;
        for c in 0..TAXELS {
            let off = values[c] - idle[c];
            let higher = off.abs() - self.peak[c].abs();
            if higher > 0.0 {
                // A touch without a spike is a step: noise decides which of its frames is the
                // highest. So a frame that comes long after the peak replaces it only if it is
                // higher by more than noise.
                let late = u32::from(frame - self.frame[c]) > PEAK_FRAMES;
                let clear = higher * higher * weights[c] > CLEAR * CLEAR
                    && higher > CLEAR_FRACTION * self.peak[c].abs();
                if !late || clear {
                    (self.peak[c], self.frame[c]) = (off, frame);
                }
            }
        }
    }

    /// Squared height over all taxels, in units of the noise.
    pub fn height(&self, weights: &Values) -> f32 {
        self.peak
            .iter()
            .zip(weights)
            .fold(0.0, |sum, (peak, weight)| sum + peak * peak * weight)
    }

    /// Equation 2: frame, taxel and height of the highest peak. If noise may have decided which
    /// peak is the highest, the earliest of these peaks.
    pub fn highest(&self, weights: &Values) -> (u32, u8, f32) {
        let height = |c: usize| self.peak[c].abs();
        let highest =
            (1..TAXELS).fold(0, |best, c| if height(c) > height(best) { c } else { best });
        let mut best = highest;
        for c in 0..TAXELS {
            let less = height(highest) - height(c);
            if less * less * weights[c] < CLEAR * CLEAR && self.frame[c] <= self.frame[best] {
                best = c;
            }
        }
        (
            self.first.wrapping_add(self.frame[best].into()),
            best as u8,
            self.peak[best],
        )
    }
}
