//! Frame as used by the steps of a fit.

use crate::domain::Domain;
use crate::source::Values;

/// A frame, centred and scaled.
pub struct Frame {
    /// Number of the frame in the window.
    pub number: u32,
    /// Time or position of the frame, -1 to 1 over the window.
    pub u: f32,
    /// Values in the order of [`Statistics::order`](crate::statistics::Statistics::order).
    pub values: Values,
}

impl Frame {
    /// Index of the transform point to which the frame is added. Points are `each` frames apart in
    /// a window of `frames` frames.
    pub fn point(&self, domain: &Domain, frames: u32, each: u32) -> usize {
        let number = match domain {
            Domain::Time { .. } => self.number,
            Domain::Position { .. } => (0.5 * (self.u + 1.0) * frames as f32) as u32,
        };
        number.checked_div(each).unwrap_or_default() as usize
    }
}
