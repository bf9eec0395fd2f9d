//! What noise alone reaches: the limits of every test in the fit. Many places call it, but seldom:
//! it is not inlined, to save flash.

/// Natural logarithm.
#[inline(never)]
pub fn ln(x: f32) -> f32 {
    libm::logf(x)
}

/// Point of a chi-square distribution by the normal deviate of the same tail (Wilson and Hilferty's
/// cube; off by under 1 % from two degrees of freedom on).
#[inline(never)]
pub fn chi_square_point(degrees: f32, deviate: f32) -> f32 {
    let cube = 1.0 - 2.0 / (9.0 * degrees) + deviate * libm::sqrtf(2.0 / (9.0 * degrees));
    degrees * cube * cube * cube
}

/// Gain in log-likelihood that one search reaches in noise alone in one window out of a hundred:
/// half the chi-square point of `unknowns` degrees of freedom at one hundredth over the number of
/// tries. A search between the frequencies of a transform counts for twice as many of them, and the
/// number of harmonics and the place of the fundamental are chosen too: four tries a frame.
#[inline(never)]
pub fn significant_search_gain(unknowns: f32, frames: u32) -> f32 {
    // Normal deviate of the tail, by Mills' ratio.
    let tail = 0.01 / (4.0 * frames as f32);
    let z2 = -2.0 * ln(tail * 2.5);
    let z = libm::sqrtf((z2 - ln(z2)).max(1.0));
    0.5 * chi_square_point(unknowns, z)
}
