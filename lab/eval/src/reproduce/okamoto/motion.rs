//! How the finger moves over a scale.

use hal_mock::sliding::Hand;
use std::f64::consts::TAU;

/// So long after a turn friction still turns, seconds: a hand that leaves it with 1.3 m/s^2 has 4
/// mm/s after 3 ms, where the finger's friction, tanh(v / 1 mm/s), is whole but for 0.1 %; the
/// bridges' low-pass takes five of its 0.4 ms more.
pub const SETTLES_S: f64 = 0.005;

/// How the finger moves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Motion {
    Steady(f64),
    Hand,
}

impl Motion {
    /// Speed at a time after the slide's beginning, mm/s.
    pub fn speed_mm_s(self, t_s: f64) -> f64 {
        let Hand {
            peak_mm_s,
            swing_hz,
            ..
        } = Hand::default();
        match self {
            Self::Steady(speed_mm_s) => speed_mm_s,
            Self::Hand => peak_mm_s * (TAU * swing_hz * t_s).sin(),
        }
    }

    pub fn place_mm(self, t_s: f64) -> f64 {
        let Hand {
            peak_mm_s,
            swing_hz,
            ..
        } = Hand::default();
        match self {
            Self::Steady(speed_mm_s) => speed_mm_s * t_s,
            Self::Hand => peak_mm_s / (TAU * swing_hz) * (1.0 - (TAU * swing_hz * t_s).cos()),
        }
    }

    /// Whether the finger goes back at a time after the slide's beginning.
    pub fn is_backward(self, t_s: f64) -> bool {
        self.speed_mm_s(t_s) < 0.0
    }

    /// Whether it turns between two times that are less than half a swing apart.
    pub fn turns(self, from_s: f64, until_s: f64) -> bool {
        self.is_backward(from_s) != self.is_backward(until_s)
    }

    /// From the lowest place of a window to the highest, mm.
    pub fn range_mm(self, from_s: f64, until_s: f64) -> f64 {
        let places = (0..=32)
            .map(|step| self.place_mm(from_s + (until_s - from_s) * f64::from(step) / 32.0));
        let (least, most) = places.fold((f64::MAX, f64::MIN), |(least, most), mm| {
            (least.min(mm), most.max(mm))
        });
        most - least
    }
}
