//! What channels have in common: the covariance of their residuals, and whether it is more than
//! chance.

use crate::limits::CHANNELS_MAX;
use crate::normal::channels_dot;
use crate::solve::Solution;
use crate::source::Values;

/// Power in a direction, over the mean of those left, from which on it is shared and no chance:
/// white noise in sixteen channels has it in two of a thousand windows of nine blocks, the fewest,
/// and in none of twelve. With 10 in its place intervals in autoregressive noise of 0.9 and 0.2 s
/// held in 89 % of windows, with 14 in 93 to 94 % (cells of docs/results/noise.md, seeds 5 and 6).
pub const SHARED_MIN: f32 = 14.0;
/// Fewer channels have no mixture to spare.
const CHANNELS_MIN: usize = 3;
/// In fewer cycles the solution takes most of what is next to the line.
const CYCLES_MIN: f32 = 1.55;
/// And fewer frames say too little of sixteen channels.
const FRAMES_MIN: f32 = 40.0;

/// A covariance of channels, each in units of its own residuals: both triangles.
pub type Covariance = [Values; CHANNELS_MAX];

/// Whether channels may share a direction. The greatest of `n` eigenvalues is at most their mean
/// and the root of `n - 1` times their standard deviation: P. A. Samuelson, "How deviant can you
/// be?", J. Am. Stat. Assoc. 63 (1968).
pub fn may_share(covariance: &Covariance, solution: &Solution) -> bool {
    let width = solution.width;
    let (mut trace, mut squares) = (0.0, 0.0);
    for (c, row) in covariance.iter().enumerate() {
        (trace, squares) = (
            trace + row[c % CHANNELS_MAX],
            squares + channels_dot(row, row),
        );
    }
    let others = width as f32 - 1.0;
    let beyond = SHARED_MIN * trace / (others + SHARED_MIN) - trace / width as f32;
    let is_enough =
        width >= CHANNELS_MIN && solution.frames >= FRAMES_MIN && 2.0 * solution.nu >= CYCLES_MIN;
    is_enough && others * (squares - trace * trace / width as f32) > width as f32 * beyond * beyond
}
