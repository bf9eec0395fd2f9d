//! A frame as the steps see it.

use crate::domain::Domain;
use crate::source::Values;

/// A frame, centred and scaled.
pub struct Frame {
    /// Number of the frame in the window.
    pub number: u32,
    /// Time or position of the frame, -1 to 1 over the window.
    pub u: f32,
    /// Values by place in [`Statistics::order`](crate::statistics::Statistics::order).
    pub values: Values,
}

impl Frame {
    /// Point in a transform, whose points are `each` of `frames` that are evenly spaced.
    pub fn point(&self, domain: &Domain, frames: u32, each: u32) -> usize {
        let number = match domain {
            Domain::Time { .. } => self.number,
            Domain::Position { .. } => (0.5 * (self.u + 1.0) * frames as f32) as u32,
        };
        number.checked_div(each).unwrap_or_default() as usize
    }
}
