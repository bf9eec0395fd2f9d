//! A speed profile as the PC sends it: speeds at a few times.

use serde::{Deserialize, Serialize};

/// Most knots of a profile.
pub const KNOTS_MAX: usize = 32;

/// A speed at a time.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Knot {
    /// Device time, microseconds, up to 71 minutes.
    pub t_us: u32,
    /// Speed over the surface, millimetres per second; negative against +x.
    pub speed_mm_s: f32,
}

/// What follows the last knot.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum After {
    /// The last knot's speed continues. Before the first knot the first one's speed holds.
    Hold,
    /// The profile repeats: its last knot is at the same time as the first one of the next round.
    Repeat,
}
