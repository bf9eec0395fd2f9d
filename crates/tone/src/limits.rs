//! Capacities of a fit's arrays.

/// Maximum number of channels of a frame.
pub const CHANNELS_MAX: usize = 16;
/// Maximum number of harmonics, the fundamental included.
pub const HARMONICS_MAX: usize = 5;
/// Number of harmonics above the fundamental whose ratios to it are reported.
pub const OVERTONES: usize = 3;
/// Highest degree of a curved baseline.
pub const DEGREE_MAX: usize = 4;
/// Maximum number of unknowns per channel: baseline, and cosine and sine of each line.
pub const UNKNOWNS_MAX: usize = DEGREE_MAX + 1 + 2 * HARMONICS_MAX;
/// Maximum number of blocks of a window.
pub const BLOCKS_MAX: usize = 16;
/// Capacity in lines on the chip, added over all blocks; with five harmonics, fewer blocks fit.
#[cfg(any(test, not(feature = "long-windows")))]
pub const BLOCK_LINES_CHIP: usize = BLOCKS_MAX * (HARMONICS_MAX - 1);
/// Capacity in lines, added over all blocks.
#[cfg(not(feature = "long-windows"))]
pub const BLOCK_LINES: usize = BLOCK_LINES_CHIP;
/// Capacity in lines, added over all blocks.
#[cfg(feature = "long-windows")]
pub const BLOCK_LINES: usize = BLOCKS_MAX * HARMONICS_MAX;
/// Number of degrees of phase and amplitude that are tested beyond the fitted ones.
pub const MOVES: usize = 4;
/// Maximum number of degrees of the phase, and of the amplitude, that are fitted.
pub const MOVES_MAX: usize = 10;
/// Maximum number of degrees of phase, or of amplitude, that are tested.
pub const DEGREES_MAX: usize = MOVES_MAX + MOVES - 1;
/// Maximum distance of a noise bin from its line, cycles per window.
pub const BAND: usize = 4;
/// Maximum number of noise-bin functions (cosines and sines) for a comb.
pub const NOISE_BINS_COMB: usize = 4 * (BAND / 2) * HARMONICS_MAX;
/// Maximum number of noise-bin functions.
pub const NOISE_BINS_MAX: usize = 64;
/// Longest transform on the chip, points.
pub const POINTS_CHIP: usize = 1024;
/// Longest transform, points.
#[cfg(not(feature = "long-windows"))]
pub const POINTS_MAX: usize = POINTS_CHIP;
/// Longest transform, points.
#[cfg(feature = "long-windows")]
pub const POINTS_MAX: usize = 32_768;
/// Maximum number of frames of a window on the chip.
pub const FRAMES_CHIP: usize = 1024;
/// Maximum number of frames of a window.
#[cfg(not(feature = "long-windows"))]
pub const FRAMES_MAX: usize = FRAMES_CHIP;
/// Maximum number of frames of a window.
#[cfg(feature = "long-windows")]
pub const FRAMES_MAX: usize = 65_536;
/// Maximum number of impulses that are replaced on the chip: one value in eighty.
pub const IMPULSES_CHIP: usize = 192;
/// Maximum number of impulses that are replaced.
pub const IMPULSES_MAX: usize = IMPULSES_CHIP * (FRAMES_MAX / FRAMES_CHIP);
/// Minimum number of frames for a fit.
pub const FRAMES_MIN: u32 = 24;
