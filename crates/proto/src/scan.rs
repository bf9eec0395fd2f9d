//! Constants common to all scans.

pub use crate::frame::{RING_FRAMES, TAXELS};
use crate::plan::Plan;

/// Frames per second of the default scan at the converter's nominal clock: 241.14 (SBAS297G, rate
/// formula).
pub const FRAME_RATE_HZ: f32 = Plan::PAPER.frame_rate_hz();
