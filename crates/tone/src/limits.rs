//! How much the arrays of a fit hold.

/// Most channels of a frame.
pub const CHANNELS_MAX: usize = 16;
/// Channels in which candidates are searched, those with the least share of noise.
pub const CHANNELS_SEARCHED: usize = 4;
/// Most harmonics, the fundamental included.
pub const HARMONICS_MAX: usize = 5;
/// Harmonics above the first whose ratios to it are reported.
pub const OVERTONES: usize = 3;
/// Most spectral lines: the harmonics, and behind them an interferer.
pub const LINES_MAX: usize = HARMONICS_MAX;
/// Functions of a curved baseline.
pub const CURVES_MAX: usize = 3;
/// Most unknowns of a channel: offset, slope, cosine and sine of each line, curves.
pub const UNKNOWNS_MAX: usize = 2 + 2 * LINES_MAX + CURVES_MAX;
/// Most pieces: means of a few frames.
pub const PIECES_MAX: usize = 64;
/// Most blocks.
pub const BLOCKS_MAX: usize = 16;
/// Most candidates for the frequency.
pub const CANDIDATES_MAX: usize = 8;
/// Longest transform on the chip, points.
pub const POINTS_CHIP: usize = 1024;
/// Longest transform, points: 1024 on the chip; 32,768 with the feature `long-windows`.
#[cfg(not(feature = "long-windows"))]
pub const POINTS_MAX: usize = POINTS_CHIP;
/// Longest transform, points: 1024 on the chip; 32,768 with the feature `long-windows`.
#[cfg(feature = "long-windows")]
pub const POINTS_MAX: usize = 32_768;
