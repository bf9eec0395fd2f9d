//! The spatial period from the path of the hand, if a robot moves the finger as the hand moves: the
//! length of the path in a window over the window's cycles.

use ridgetone_proto::telemetry::{Estimate, Status};
use std::collections::VecDeque;

/// Maximum path kept, in seconds and in positions.
const KEPT_S: f64 = 30.0;
const KEPT: usize = 16_384;

/// Backward movement that counts as a turn, millimetres: more than the jitter of an encoder that
/// rests on an edge.
const TURN_MM: f64 = 0.02;

/// Maximum time between positions, seconds: after a longer gap the robot jumps along an unknown
/// path.
const GAP_S: f64 = 0.25;

/// Standard deviation of a window's end on this computer's clock, seconds: USB and the system delay
/// bytes.
const TIME_SIGMA_S: f64 = 0.01;

/// Time over which the speed at a window's end is measured, seconds.
const SPEED_S: f64 = 0.05;

/// Received positions of the hand, which a robot follows.
#[derive(Clone, Debug, Default)]
pub struct HandPath(VecDeque<(f64, f64)>);

/// Position on the path, and the step between the positions around it.
#[derive(Clone, Copy, Debug)]
struct Point {
    mm: f64,
    step_mm: f64,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Length {
    pub mm: f64,
    pub sigma_mm: f64,
}

impl HandPath {
    /// Adds a position (millimetres) with its arrival time (seconds). Times must not decrease.
    pub fn push(&mut self, t_s: f64, mm: f64) {
        while self.0.len() >= KEPT || self.0.front().is_some_and(|(at_s, _)| t_s - at_s > KEPT_S) {
            self.0.pop_front();
        }
        self.0.push_back((t_s, mm));
    }

    /// Interpolates the position at `t_s`; `None` outside the known path.
    fn at(&self, t_s: f64) -> Option<Point> {
        let after = self.0.partition_point(|(at_s, _)| *at_s < t_s);
        let (after_s, after_mm) = *self.0.get(after)?;
        if after_s == t_s {
            return Some(Point {
                mm: after_mm,
                step_mm: 0.0,
            });
        }
        let (before_s, before_mm) = *self.0.get(after.checked_sub(1)?)?;
        let step_mm = after_mm - before_mm;
        Some(Point {
            mm: before_mm + step_mm * (t_s - before_s) / (after_s - before_s),
            step_mm: step_mm.abs(),
        })
    }

    fn speed_mm_s(&self, from_s: f64) -> Option<f64> {
        Some((self.at(from_s + SPEED_S)?.mm - self.at(from_s)?.mm) / SPEED_S)
    }

    /// Length of the path between two times; `None` if part of it is unknown, or if the hand turns
    /// in between: frequency and length would then belong to different motions.
    pub fn length(&self, from_s: f64, to_s: f64) -> Option<Length> {
        let (from, to) = (self.at(from_s)?, self.at(to_s)?);
        let way = (to.mm - from.mm).signum();
        let inside = self.0.iter().copied();
        let inside = inside.filter(|(t_s, _)| (from_s..=to_s).contains(t_s));
        let (mut latest_s, mut farthest_mm) = (from_s, way * from.mm);
        for (t_s, mm) in inside.chain([(to_s, to.mm)]) {
            if t_s - latest_s > GAP_S || farthest_mm - way * mm > TURN_MM {
                return None;
            }
            (latest_s, farthest_mm) = (t_s, farthest_mm.max(way * mm));
        }
        // A time shift adds at one end what it removes at the other, unless the speeds differ.
        let change_mm_s = self.speed_mm_s(to_s - SPEED_S)? - self.speed_mm_s(from_s)?;
        let variance = (from.step_mm.powi(2) + to.step_mm.powi(2)) / 12.0
            + (change_mm_s * TIME_SIGMA_S).powi(2);
        Some(Length {
            mm: (to.mm - from.mm).abs(),
            sigma_mm: variance.sqrt(),
        })
    }

    /// Period of the surface from a window that ended at `end_s`: the path's length over the
    /// window's cycles. `None` if the estimate is not `good`, or [`Self::length`] returns `None`.
    pub fn wavelength(&self, end_s: f64, estimate: &Estimate) -> Option<Length> {
        let (window_s, hz) = (f64::from(estimate.window_s), f64::from(estimate.frequency));
        if estimate.status != Status::Good || hz <= 0.0 {
            return None;
        }
        let path = self.length(end_s - window_s, end_s)?;
        let mm = path.mm / (hz * window_s);
        let relative = (path.sigma_mm / path.mm).hypot(f64::from(estimate.sigma) / hz);
        (mm > 0.0).then_some(Length {
            mm,
            sigma_mm: mm * relative,
        })
    }
}

impl Length {
    /// True if two lengths differ by more than three standard deviations.
    pub fn differs(&self, other: &Self) -> bool {
        (self.mm - other.mm).abs() > 3.0 * self.sigma_mm.hypot(other.sigma_mm)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Creates a path with 250 positions per second.
    fn path(position_mm: impl Fn(f64) -> f64) -> HandPath {
        let mut path = HandPath::default();
        for n in 0..1000 {
            let t_s = 0.004 * f64::from(n);
            path.push(t_s, position_mm(t_s));
        }
        path
    }

    #[test]
    fn a_path_without_a_turn_has_a_length() {
        // Uncertainties: steps of 0.16 mm at both ends at a constant speed; or a speed that
        // increases by 40 mm/s, so that 10 ms make 0.4 mm.
        let steady = path(|t_s| -40.0 * t_s).length(1.001, 2.003);
        let faster = path(|t_s| 20.0 * t_s * t_s).length(1.0, 2.0);
        for (length, mm, sigma_mm, max) in [
            (steady, 40.08, 0.16 / 6.0f64.sqrt(), 1e-6),
            (faster, 60.0, 0.4, 0.05),
        ] {
            let length = length.expect("known");
            assert!((length.mm - mm).abs() < 1e-9, "{length:?}");
            assert!((length.sigma_mm - sigma_mm).abs() < max, "{length:?}");
        }
    }

    #[test]
    fn turns_and_unknown_parts_give_none() {
        let turning = path(|t_s| 10.0 * (2.0 * t_s).sin());
        // The hand turns at 0.785 s and at 2.356 s.
        assert!(turning.length(0.9, 2.3).is_some());
        assert_eq!(turning.length(0.7, 0.9), None);
        assert_eq!(turning.length(2.0, 2.5), None);
        // Turns between ends that are far apart: forward, back and forward.
        assert_eq!(path(|t_s| t_s + (3.0 * t_s).sin()).length(0.0, 3.9), None);
        // The jitter of an encoder on an edge is not a turn.
        let resting = path(|t_s| 0.005 * ((250.0 * t_s).round() % 2.0));
        assert!(resting.length(1.0, 2.0).is_some());
        // The link was dead for a second.
        let mut interrupted = path(|t_s| 40.0 * t_s);
        interrupted.push(5.0, 200.0);
        interrupted.push(5.1, 204.0);
        assert_eq!(interrupted.length(3.5, 5.05), None);
        for (from_s, to_s) in [(-0.1, 1.0), (3.5, 4.0)] {
            assert_eq!(turning.length(from_s, to_s), None);
        }
        assert_eq!(HandPath::default().length(0.0, 1.0), None);
    }
}
