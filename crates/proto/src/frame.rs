//! Size of a frame, and number of frames that are kept.

/// Places for taxels in a frame and in a message: one for each analog input of the chip, AIN0 to
/// AIN15.
pub const TAXELS: usize = 16;

/// Frames of sixteen taxels in the window's ring: the paper's longest slide (60 mm at 15 mm/s, 965
/// frames at 241 Hz) with 0.6 s to spare for noticing its end and for the fit. With fewer taxels it
/// holds more frames: [`Plan::ring_frames`](crate::plan::Plan::ring_frames).
#[cfg(not(feature = "short-ring"))]
pub const RING_FRAMES: usize = 1120;
/// Frames of sixteen taxels in the window's ring, on a chip with less RAM: 2.3 s at 241 Hz.
#[cfg(feature = "short-ring")]
pub const RING_FRAMES: usize = 560;
