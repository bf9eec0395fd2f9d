//! A hand that nobody moves: steady, or to and fro as those of Okamoto et al., section IV-A.

use std::f64::consts::TAU;

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hand {
    /// Mean speed, millimetres per second.
    pub speed_mm_s: f64,
    /// Ways to and fro a second; 0: it never turns.
    pub turns_hz: f64,
}

impl Hand {
    /// The paper's mean hand.
    pub const OKAMOTO: Self = Self {
        speed_mm_s: 125.4,
        turns_hz: 1.07,
    };

    /// Position at a time, millimetres: 0 at the beginning.
    pub fn position_mm(&self, t_s: f64) -> f64 {
        if self.turns_hz <= 0.0 {
            return self.speed_mm_s * t_s;
        }
        // The mean of a rectified sine is 2 / pi of its peak.
        let peak_mm_s = self.speed_mm_s * TAU / 4.0;
        let turn = TAU * self.turns_hz;
        peak_mm_s / turn * (1.0 - (turn * t_s).cos())
    }
}
