//! How a tone's frequency moves within its window, from the phase of its blocks.

use crate::fit::Movement;
use crate::frame_span::FrameSpan;
use crate::neighbourhood::{Neighbourhood, PHASE_DEGREES};

/// Degrees that always count: the noise of higher ones hides slow movement, and they count where they are so many times it.
const SLOW_DEGREES: usize = 5;
const CLEAR: f32 = 9.0;
/// Least variance of the wander, as a share of that of its noise: an estimate without noise is none.
const NOISE_SHARE_MIN: f32 = 0.05;

/// Share of the wander, and of the chirp, by which they are off beside the noise's part, and in one cycle: what is faster than the
/// blocks show and, in few cycles, what baseline and harmonics take. Chosen on other seeds than those of docs/noise.md.
const WANDER_OFF: [f32; 2] = [0.4, 0.6];
const CHIRP_OFF: [f32; 2] = [0.06, 0.9];

/// The movement; `colour` is the noise's variance over white noise's, `nu` and `sigma_nu` are the frequency and its standard
/// deviation.
///
/// The phase's deviation is a sum of Legendre's polynomials P_l with factors p_l, the frequency's that of their slopes. By parts, the
/// integral of two slopes of equal parity is twice that of P_l at 1, which is l (l + 1) / 2, for the lesser l: the rest of it is
/// a product of the greater polynomial with one of a lower degree. The mean of a slope is 1 for odd l and 0 for even. The line that
/// least squares finds has the slope of P_1 alone: the plain mean is away from it by the sum of the odd p_l.
pub fn movement(span: &FrameSpan, of: &Neighbourhood, colour: f32, nu: f32, sigma_nu: f32) -> Movement {
    // What is above white noise may be the movement itself: then the amplitude says what is noise.
    let noise = if colour > 1.0 { colour.min(of.of_amplitude) } else { colour };
    let mut factors = [[0.0; 2]; PHASE_DEGREES];
    for (k, (factor, [value, variance])) in factors.iter_mut().zip(of.phase).enumerate() {
        let variance = noise * variance;
        if k < SLOW_DEGREES || value * value > CLEAR * variance {
            *factor = [value, variance];
        }
    }
    let (mut square, mut square_variance, mut apart, mut apart_variance) = (0.0, 0.0, 0.0, 0.0);
    for (k, [value, variance]) in factors.into_iter().enumerate() {
        let mut slope = 0.0;
        for (m, [other, of_other]) in factors.into_iter().enumerate().filter(|(m, _)| (m + k) % 2 == 0) {
            let product = mean_product(k.min(m), k);
            slope += product * other;
            square_variance += 2.0 * product * product * variance * of_other;
        }
        square += value * slope - mean_product(k, k) * variance;
        square_variance += 4.0 * slope * slope * variance;
        if k % 2 == 1 {
            (apart, apart_variance) = (apart + value, apart_variance + variance);
        }
    }
    let wander = libm::sqrtf(square.max(0.0));
    let spread = libm::sqrtf(square_variance);
    // Of a frequency that moves the mean is as uncertain as it is measured; of a steady one it is the weighted mean.
    let of_noise = if square > spread { apart_variance } else { -apart_variance };
    let apart = (apart * apart + of_noise).max(0.0);
    // The error of a root; where the square is no larger than its own error, the root of that.
    let wander_sigma = spread / libm::sqrtf(4.0 * square.max(0.0) + spread).max(f32::MIN_POSITIVE);
    let off = |[share, of_cycles]: [f32; 2], value: f32| value * (share + of_cycles / (2.0 * nu));
    let with_off = |sigma: f32, off: f32| libm::sqrtf(sigma * sigma + off * off);
    let [bend, bend_variance] = of.phase[0];
    // The slope of P_2 at the window's end is 3.
    let (chirp, chirp_variance) = (3.0 * bend, 9.0 * bend_variance * noise.max(NOISE_SHARE_MIN));
    Movement {
        wander: wander / nu,
        wander_sigma: with_off(wander_sigma, off(WANDER_OFF, wander)) / nu,
        sigma_of_mean: span.frequency(libm::sqrtf(sigma_nu * sigma_nu + apart)),
        // Per unit of the abscissa twice: once for the frequency, once for its change.
        chirp: span.frequency(span.frequency(chirp)),
        chirp_sigma: span.frequency(span.frequency(with_off(libm::sqrtf(chirp_variance), off(CHIRP_OFF, chirp)))),
    }
}

/// The mean product of two slopes of equal parity, less that of their means, by the place of the lesser; both begin with degree 2.
fn mean_product(least: usize, other: usize) -> f32 {
    let degree = (least + 2) as f32;
    0.5 * degree * (degree + 1.0) - (other % 2) as f32
}
