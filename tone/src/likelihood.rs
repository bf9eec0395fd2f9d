//! How much likelier one fit is than another, and whether its residuals are noise alone.

use crate::levels::Levels;
use crate::limits::CHANNELS_MAX;
use crate::significance::ln;
use crate::solution::Solution;
use crate::source::Values;

/// Ratio of the residuals to the noise from which the model does not describe the channels.
const MISFIT_NOISE_RATIO: f32 = 1.5;
/// A step reduces the squares by no more than this share: 60 dB.
const STEP_SHARE_MAX: f32 = 1.0 - 1e-6;

/// Residual variance with `unknowns` unknowns of a channel over that of the noise ([`Levels::noise_variance`]), mean of
/// the channels: 1 if the residuals are noise alone. None if the noise is not known.
#[inline(never)]
pub fn noise_ratio(levels: &Levels, residual_sum_of_squares: &Values, unknowns: usize) -> Option<f32> {
    let freedom = (levels.frames as f32 - unknowns as f32).max(1.0);
    let (mut sum, mut channels) = (0.0, 0.0);
    for c in 0..CHANNELS_MAX {
        if levels.usable & 1 << c != 0 && levels.noise_variance[c] > 0.0 {
            sum += residual_sum_of_squares[c] / (freedom * levels.noise_variance[c]);
            channels += 1.0;
        }
    }
    (channels > 0.0).then_some(sum / channels)
}

/// Whether the model does not describe the channels, by a [`noise_ratio`].
pub fn is_misfit(noise_ratio: Option<f32>) -> bool {
    noise_ratio.is_some_and(|ratio| ratio > MISFIT_NOISE_RATIO)
}

/// Log-likelihood of a model with these residual sums of squares and `unknowns` unknowns of a channel, over that of a model
/// with those `before`: negative if the latter is likelier. With Bartlett's factor, since the logarithm of few frames
/// overstates what many unknowns explain.
#[inline(never)]
pub fn gain(levels: &Levels, before: &Values, residual_sum_of_squares: &Values, unknowns: usize) -> f32 {
    let factor = (levels.frames as f32 - unknowns as f32).max(0.0);
    let mut sum = 0.0;
    // One logarithm for four: a residual is no less than a millionth of its squares, so f32 holds their product.
    for group in 0..CHANNELS_MAX / 4 {
        let mut product = 1.0;
        for c in 4 * group..4 * group + 4 {
            if levels.usable & 1 << c != 0 && residual_sum_of_squares[c] > 0.0 && before[c] > 0.0 {
                product *= before[c] / residual_sum_of_squares[c];
            }
        }
        sum += ln(product);
    }
    0.5 * factor * sum
}

/// Log-likelihood that a solution's step is expected to gain, by the squares that it removes.
#[inline(never)]
pub fn expected_gain(levels: &Levels, solution: &Solution) -> f32 {
    let samples = levels.frames as f32 * levels.channels();
    let taken = solution.step * solution.step * solution.information / samples;
    -0.5 * samples * ln(1.0 - taken.min(STEP_SHARE_MAX))
}
