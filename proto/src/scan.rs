//! The default scan, and what holds for every scan.

use crate::plan::Plan;
use ads1258::Config;

/// Places for taxels in a frame and in a message: one for each analog input of the chip, AIN0 to AIN15.
pub const TAXELS: usize = 16;

/// The chip's configuration by default: 21 slots at 15.72864 MHz / (128 x 24.265625), which makes 241.14 scans a second (SBAS297G, rate
/// formula).
pub const SCAN: Config = Plan::PAPER.config();

/// Frames per second of the default scan at the chip's nominal clock.
pub const FRAME_RATE_HZ: f32 = SCAN.frame_rate_hz();

/// Frames of sixteen taxels in the window's ring: the paper's longest slide (60 mm at 15 mm/s, 965 frames at 241 Hz) with
/// 0.6 s to spare for noticing its end and for the fit. Of fewer taxels it holds more frames: [`Plan::ring_frames`].
pub const RING_FRAMES: usize = 1120;
