//! How much the arrays of a fit hold.

/// Most channels of a frame.
pub const CHANNELS_MAX: usize = 16;
/// Most harmonics, the fundamental included.
pub const HARMONICS_MAX: usize = 5;
/// Functions of a curved baseline.
pub const CURVE_FUNCTIONS: usize = 2;
/// Most functions beside level, slope and tone: two of an interferer, and behind them those of a curve.
pub const NUISANCES_MAX: usize = 2 + CURVE_FUNCTIONS;
/// Most unknowns of a channel: offset, slope, nuisances, and cosine and sine of each harmonic.
pub const UNKNOWNS_MAX: usize = 2 + NUISANCES_MAX + 2 * HARMONICS_MAX;
