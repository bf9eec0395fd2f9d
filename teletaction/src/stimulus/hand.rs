//! Position of the hand from an encoder, predicted slightly ahead.

use super::error::{Error, within};

/// An encoder, and the sampling of its counts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Encoder {
    /// One count, millimetres, 0.0001 to 1.
    pub count_mm: f32,
    /// Samples per second, 500 to 100,000; 5000 in the paper.
    pub rate_hz: f32,
    /// Time from reading the encoder to the middle of the held output, seconds, 0 to 0.02, over
    /// which the hand's motion is predicted. A zero-order hold takes half a sample, and a filter
    /// adds to it.
    pub latency_s: f32,
}

impl Encoder {
    /// Counts of 5 um, 5 kHz (Okamoto et al., section III-A), and half a sample.
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

/// Gains of the tracker, per sample. It follows a constant speed without lag. Under acceleration it
/// lags by (1 - ALPHA) / BETA times the movement that the acceleration adds in a sample: 2 um at 5
/// kHz for the paper's hand (197 mm/s at 1.07 Hz, section IV-A). It multiplies the rounding error
/// of counts by 0.39, the root of (2 ALPHA^2 + BETA (2 - 3 ALPHA)) / (ALPHA (4 - 2 ALPHA - BETA)):
/// 0.6 um RMS remain for counts of 5 um.
const ALPHA: f32 = 0.2;
const BETA: f32 = 0.02;

/// Maximum speed of the hand, millimetres per second; faster motion is a fault of the encoder.
const SPEED_MAX_MM_S: f32 = 3000.0;

/// Position and speed of the hand from an alpha-beta filter. Positions are relative to the latest
/// count, so f32 is exact anywhere.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Hand {
    counts: Option<i32>,
    /// Position relative to the middle of the count, counts.
    off: f32,
    /// Counts per sample.
    speed: f32,
}

impl Hand {
    pub fn speed(&self) -> f32 {
        self.speed
    }

    /// Takes a reading. Returns the count, the predicted lead of the hand after the latency, in
    /// counts, and the speed, in counts per sample.
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
        // The hand is somewhere within the count, whose middle is half a count ahead.
        (
            counts,
            0.5 + self.off + self.speed * encoder.latency_s * encoder.rate_hz,
            self.speed,
        )
    }
}
