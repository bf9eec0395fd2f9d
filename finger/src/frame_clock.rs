//! When frames were, in device time, and how fast they come by the board's clock.

use crate::ring::Ring;
use crate::scan::FRAME_NS;
use ridgetone_proto::scan::FRAME_RATE_HZ;

/// Times of frames.
#[derive(Clone, Debug)]
pub struct FrameClock {
    /// Number of the latest frame, and the device time of its first slot, microseconds.
    pub latest: (u32, u64),
    /// The same of the first complete frame: the rate is measured from there.
    rate_from: Option<(u32, u64)>,
}

impl FrameClock {
    /// Before the first frame.
    pub const fn new() -> Self {
        Self { latest: (0, 0), rate_from: None }
    }

    /// From now on the rate is measured from the latest frame.
    pub fn measure_rate(&mut self) {
        self.rate_from = Some(self.latest);
    }

    /// Frames per second by the board's clock; zero until there are two.
    pub fn frame_rate_hz(&self) -> f32 {
        /// Frame numbers wrap after so many: 206 days.
        const WRAP_FRAMES: f32 = 4_294_967_296.0;
        match self.rate_from {
            Some((frame, t_us)) if self.latest.1 > t_us => {
                let passed_us = (self.latest.1 - t_us) as f32;
                let beyond_wraps = self.latest.0.wrapping_sub(frame) as f32;
                // The time and the nominal rate say how often the numbers have wrapped.
                let nominal = passed_us * (FRAME_RATE_HZ * 1e-6);
                let wraps = ((nominal - beyond_wraps) / WRAP_FRAMES + 0.5) as u32 as f32;
                (beyond_wraps + wraps * WRAP_FRAMES) * 1e6 / passed_us
            }
            _ => 0.0,
        }
    }

    /// Device time of a frame's first slot, microseconds. For a frame that the ring does not hold it follows from the
    /// nominal rate.
    #[inline(never)]
    pub fn time_us(&self, frame: u32, ring: &Ring) -> u64 {
        let (number, t_us) = self.latest;
        if let Some(low) = ring.t_us(frame) {
            return t_us.wrapping_sub((t_us as u32).wrapping_sub(low) as u64);
        }
        let back = number.wrapping_sub(frame) as i32;
        let away_us = back.unsigned_abs() as u64 * FRAME_NS / 1000;
        if back < 0 { t_us.wrapping_add(away_us) } else { t_us.saturating_sub(away_us) }
    }
}
