//! Size of a frame, and number of frames stored.

/// Number of taxels in a frame and in a message: one for each analogue input of the chip, AIN0 to
/// AIN15.
pub const TAXELS: usize = 16;

/// Capacity of the window's ring in frames of sixteen taxels: the paper's longest slide (60 mm at
/// 15 mm/s, 965 frames at 241 Hz) plus 0.6 s for detecting its end and for the fit. With fewer
/// taxels the ring holds more frames: [`Plan::ring_frames`](crate::plan::Plan::ring_frames).
#[cfg(not(feature = "short-ring"))]
pub const RING_FRAMES: usize = 1120;
/// Capacity of the window's ring in frames of sixteen taxels, on a chip with less RAM: 2.3 s at 241
/// Hz.
#[cfg(feature = "short-ring")]
pub const RING_FRAMES: usize = 560;
