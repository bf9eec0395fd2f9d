//! The default scan, and what holds for every scan.

pub use crate::frame::{RING_FRAMES, TAXELS};
use crate::plan::Plan;
use ads1258::Config;

/// The chip's configuration by default: 21 slots at 15.72864 MHz / (128 x 24.265625), which makes
/// 241.14 scans a second (SBAS297G, rate formula).
pub const SCAN: Config = Plan::PAPER.config();

/// Frames per second of the default scan at the chip's nominal clock.
pub const FRAME_RATE_HZ: f32 = SCAN.frame_rate_hz();
