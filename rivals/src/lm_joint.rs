//! The crate `levenberg-marquardt` on the joint problem: offset, cosine and sine of every channel and one frequency.

use crate::periodogram::Peak;
use crate::{Frame, Scratch};

/// The common frequency, cycles per frame.
pub fn estimate(values: &[Frame], channels: usize, scratch: &mut Scratch) -> Option<f32> {
    Some(Peak::find(values, channels, scratch)?.frequency(0.0))
}
