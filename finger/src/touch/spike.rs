//! The contact spike: the paper's equations 2 and 3.

use crate::touch::chi_square::{Limit, limit};
use crate::touch::motion::BLOCK_FRAMES;
use crate::touch::onset::Frames;
use ridgetone_proto::settings::TAXELS;
use ridgetone_tone::Values;

/// Frames after a peak in which any higher frame is a better one: 20 ms.
const PEAK_FRAMES: u32 = 5;
/// Standard deviations by which a later one must be higher.
const CLEAR: f32 = 4.0;
/// Share of the peak by which it must be higher too: a slide that has begun is no contact.
const CLEAR_SHARE: f32 = 0.25;
/// Frames before the block of the first touch where the spike may have begun.
const LOOK_BACK: u32 = 4;
/// Time within which the spike's peak is looked for after the first touch, frames: 0.3 s. The paper looks for it in the
/// first 0.8 s of a record that contains it.
pub const SPIKE_FRAMES: u32 = 72;
/// Blocks in a row without a quick change after which the spike is over: 100 ms.
pub const SPIKE_STILL_BLOCKS: u32 = 6;
/// Within this share of the way to a spike's peak, squared, the skin that it left is creeping back: a twentieth.
pub const BACK_FROM_SPIKE: f32 = 1.0 / 400.0;
/// Squared height of a spike, in units of the noise, from which a tap that leaves no load is reported: 30 standard
/// deviations in every taxel. Less is a vibration.
pub const TAP: Limit = limit(900.0, 0.0);

/// The highest deviation of every taxel so far.
#[derive(Clone, Debug)]
pub struct Spike {
    /// That deviation from the idle level, codes.
    peak: Values,
    /// Its frame, counted from the first one that is looked at.
    frame: [u8; TAXELS],
    /// That one.
    first: u32,
}

impl Spike {
    pub const fn new() -> Self {
        Self { peak: [0.0; TAXELS], frame: [0; TAXELS], first: 0 }
    }

    /// The first touch was in the block that ends with frame `number`: looks at that block and what is before it.
    #[inline(never)]
    pub fn begin(number: u32, idle: &Values, frames: &Frames) -> Self {
        let first = number.wrapping_sub(BLOCK_FRAMES - 1 + LOOK_BACK);
        let mut spike = Self { first, ..Self::new() };
        for number in (0..BLOCK_FRAMES + LOOK_BACK).map(|frames| first.wrapping_add(frames)) {
            if let Some(values) = frames.values(number, &mut [0.0; TAXELS]) {
                spike.follow(number, values, idle, frames.weights);
            }
        }
        spike
    }

    /// Equation 3: takes the next frame.
    #[inline(never)]
    pub fn follow(&mut self, number: u32, values: &Values, idle: &Values, weights: &Values) {
        // A spike is over after fewer frames than that.
        let frame = number.wrapping_sub(self.first).min(u8::MAX.into()) as u8;
        for c in 0..TAXELS {
            let off = values[c] - idle[c];
            let higher = off.abs() - self.peak[c].abs();
            if higher > 0.0 {
                // A touch without a spike is a step, whose highest frame is any: long after a peak only what stands
                // clear of the noise is a higher one.
                let late = u32::from(frame - self.frame[c]) > PEAK_FRAMES;
                let clear = higher * higher * weights[c] > CLEAR * CLEAR && higher > CLEAR_SHARE * self.peak[c].abs();
                if !late || clear {
                    (self.peak[c], self.frame[c]) = (off, frame);
                }
            }
        }
    }

    /// Squared height over all taxels, in units of the noise.
    pub fn height(&self, weights: &Values) -> f32 {
        self.peak.iter().zip(weights).fold(0.0, |sum, (peak, weight)| sum + peak * peak * weight)
    }

    /// Equation 2: frame, taxel and height of the highest peak; of those that the noise does not tell apart, the first.
    pub fn highest(&self, weights: &Values) -> (u32, u8, f32) {
        let height = |c: usize| self.peak[c].abs();
        let highest = (1..TAXELS).fold(0, |best, c| if height(c) > height(best) { c } else { best });
        let mut best = highest;
        for c in 0..TAXELS {
            let less = height(highest) - height(c);
            if less * less * weights[c] < CLEAR * CLEAR && self.frame[c] <= self.frame[best] {
                best = c;
            }
        }
        (self.first.wrapping_add(self.frame[best].into()), best as u8, self.peak[best])
    }
}
