//! A speed profile as it travels: speeds at a few times.

use serde::{Deserialize, Serialize};

/// Most knots of a profile.
pub const KNOTS_MAX: usize = 32;

/// A speed at a time.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Knot {
    /// Device time, microseconds, up to 71 minutes; what comes later is [`After`].
    pub t_us: u32,
    /// Speed over the surface, millimetres per second; negative is back.
    pub speed_mm_s: f32,
}

/// What happens after the last knot.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum After {
    /// The last knot's speed goes on; before the first knot, the first one's does.
    Hold,
    /// It begins again, for ever: the last knot falls on the first one of the next round.
    Repeat,
}
