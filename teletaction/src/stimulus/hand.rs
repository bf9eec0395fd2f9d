//! The position of the hand, from an encoder, a little ahead of time.

use super::error::{Error, within};

/// An encoder and the samples that are made from it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Encoder {
    /// One count, millimetres, 0.0001 to 1.
    pub count_mm: f32,
    /// Samples a second, 500 to 100,000; the paper has 5000.
    pub rate_hz: f32,
    /// From the reading of the encoder to the middle of what the output holds, seconds, 0 to 0.02:
    /// the hand's motion meanwhile is predicted. An output that holds its samples has half of a
    /// sample, and more for its filter.
    pub latency_s: f32,
}

impl Encoder {
    /// Steps of 5 um, 5 kHz (Okamoto et al., section III-A), and half of a sample.
    pub const OKAMOTO: Self = Self {
        count_mm: 0.005,
        rate_hz: 5000.0,
        latency_s: 1e-4,
    };

    pub(crate) fn check(&self) -> Result<(), Error> {
        within("count_mm", self.count_mm, 1e-4, 1.0)?;
        within("rate_hz", self.rate_hz, 500.0, 1e5)?;
        within("latency_s", self.latency_s, 0.0, 0.02)
    }
}

/// Gains of the tracker, per sample. It follows a steady speed without lag. Under an acceleration
/// it lags by (1 - ALPHA) / BETA times what that moves in a sample: 2 um at 5 kHz for the paper's
/// hand (197 mm/s at 1.07 Hz, section IV-A). Of the rounding to counts 0.39 is left, the root of (2
/// ALPHA^2 + BETA (2 - 3 ALPHA)) / (ALPHA (4 - 2 ALPHA - BETA)): 0.6 um rms of counts of 5 um.
const ALPHA: f32 = 0.2;
const BETA: f32 = 0.02;

/// Fastest hand, millimetres per second: what is faster is a fault of the encoder.
const SPEED_MAX_MM_S: f32 = 3000.0;

/// Position and speed of the hand, by an alpha-beta filter. Positions are relative to the latest count,
/// so that f32 is exact anywhere.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Hand {
    counts: Option<i32>,
    /// Position less the middle of the count, counts.
    off: f32,
    /// Counts per sample.
    speed: f32,
}

impl Hand {
    /// Counts a sample.
    pub fn speed(&self) -> f32 {
        self.speed
    }

    /// Takes a reading. Gives the count, how far ahead of it the hand is once the latency is over,
    /// and its speed: in counts, and counts a sample.
    pub(crate) fn advance(&mut self, encoder: &Encoder, counts: i32) -> (i32, f32, f32) {
        let moved = self
            .counts
            .map_or(0.0, |last| counts.wrapping_sub(last) as f32);
        self.counts = Some(counts);
        if libm::fabsf(moved) * encoder.count_mm * encoder.rate_hz > SPEED_MAX_MM_S {
            (self.off, self.speed) = (0.0, 0.0);
        } else {
            let predicted = self.off + self.speed - moved;
            self.off = predicted - ALPHA * predicted;
            self.speed -= BETA * predicted;
        }
        // The hand is somewhere within the count: its middle is half a count ahead.
        (
            counts,
            0.5 + self.off + self.speed * encoder.latency_s * encoder.rate_hz,
            self.speed,
        )
    }
}
