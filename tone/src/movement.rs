//! How a tone's frequency moves within its window, from the phase of its blocks.

use crate::fit::Movement;
use crate::frame_span::FrameSpan;
use crate::neighbourhood::Neighbourhood;
use core::f32::consts::PI;

/// Cycles a window of the fastest movement that counts for the wander: the noise of faster ones hides them.
const WANDER_CYCLES: usize = 3;
/// Least variance of the wander, as a share of that of its noise: an estimate without noise is none.
const NOISE_SHARE_MIN: f32 = 0.05;

/// The movement; `variance` is that of the noise over white noise's, `nu` and `sigma_nu` are the frequency and its standard
/// deviation.
pub fn movement(span: &FrameSpan, of: &Neighbourhood, colour: f32, nu: f32, sigma_nu: f32) -> Movement {
    // A phase of a cos(pi k u) cycles is a frequency of -a pi k sin(pi k u): in nu, and in mean square.
    let noise = colour * of.phase_variance;
    let (mut square, mut square_variance, mut apart) = (0.0, 0.0, 0.0);
    for (k, [cos, sin]) in of.phase.iter().enumerate().take(WANDER_CYCLES) {
        let rate = PI * (k + 1) as f32;
        let power = cos * cos + sin * sin;
        let of_noise = 2.0 * noise;
        square += 0.5 * rate * rate * (power - of_noise);
        // Of a chi-square of two degrees, with the power itself in it.
        let factor = 0.5 * rate * rate;
        square_variance += factor * factor * 2.0 * of_noise * power.max(0.5 * of_noise);
        // The parabola's mean of cos(pi k u) is 3 / (pi k)^2 where the plain mean is none; half of it is of that phase.
        let share = 3.0 / rate;
        apart += 0.5 * share * share * (power - of_noise).max(0.0);
    }
    let wander = libm::sqrtf(square.max(0.0));
    let spread = libm::sqrtf(square_variance);
    // The error of a root; where the square is no larger than its own error, the root of that.
    let wander_sigma = spread / libm::sqrtf(4.0 * square.max(0.0) + spread).max(f32::MIN_POSITIVE);
    let (chirp, chirp_variance) = (of.chirp, of.chirp_variance * colour.max(NOISE_SHARE_MIN));
    Movement {
        wander: wander / nu,
        wander_sigma: wander_sigma / nu,
        sigma_of_mean: span.frequency(libm::sqrtf(sigma_nu * sigma_nu + apart)),
        // Per unit of the abscissa twice: once for the frequency, once for its change.
        chirp: span.frequency(span.frequency(chirp)),
        chirp_sigma: span.frequency(span.frequency(libm::sqrtf(chirp_variance))),
    }
}
