//! How a tone's frequency moves within its window, from the phase of its blocks.

use crate::fit::Movement;
use crate::frame_span::FrameSpan;
use crate::neighbourhood::{Neighbourhood, PHASE_DEGREES};

/// Degrees that always count: the noise of higher ones hides slow movement, and they count where
/// they are nine times it.
const SLOW_DEGREES: usize = 5;
const CLEAR: f32 = 9.0;
/// Least variance of the wander, as a share of that of its noise: an estimate without noise is
/// none.
const NOISE_SHARE_MIN: f32 = 0.05;

/// Share of the wander, and of the chirp, by which they are off beside the noise's part, and in one
/// cycle: in few cycles baseline and harmonics take a part. Chosen on other seeds than those of
/// docs/results/noise.md, as are the next two.
const WANDER_OFF: [f32; 2] = [0.4, 0.6];
const CHIRP_OFF: [f32; 2] = [0.06, 2.0];
/// Number of degrees that are too fast to be seen. Each counts with the mean energy of the last
/// degrees that are seen.
const FAST_DEGREES: f32 = 20.0;
const LAST_DEGREES: u8 = 3;
/// Share of a degree's energy by which a degree that is not seen may move the mean: 1 / (2 l - 1),
/// where l is about six.
const FAST_MEAN: f32 = 0.1;

/// The movement; `colour` is the noise's variance over white noise's, `nu` and `sigma_nu` are the
/// frequency and its standard deviation.
///
/// The phase's deviation is a sum of Legendre's polynomials P_l with factors p_l. Of the slope of
/// P_l the factor of P_(l-1) is 2 l - 1, that of P_(l-3) 2 l - 5, and so on: so the frequency's
/// factor of P_(l-1) is (2 l - 1) t_l, with t_l = p_l + p_(l+2) + ..., its mean square (2 l - 1)
/// t_l^2, and its mean t_3 beside the slope of P_1, which is what least squares finds.
pub fn movement(
    span: &FrameSpan,
    of: &Neighbourhood,
    colour: f32,
    nu: f32,
    sigma_nu: f32,
) -> Movement {
    // What is above white noise may be the movement itself: then the amplitude says what is noise.
    let noise = if colour > 1.0 {
        colour.min(of.of_amplitude)
    } else {
        colour
    };
    let mut tails = [[0.0; 3]; PHASE_DEGREES + 2];
    let (mut square, mut square_variance) = (0.0, 0.0);
    let (mut fast, mut last) = (0.0, 0);
    for (k, [value, variance]) in of.phase.iter().enumerate().rev() {
        let (value, variance) = (*value, noise * variance);
        let counts = k < SLOW_DEGREES || value * value > CLEAR * variance;
        let (value, variance) = if counts {
            (value, variance)
        } else {
            (0.0, 0.0)
        };
        let [after, variance_after, _] = tails[k + 2];
        let [tail, tail_variance] = [value + after, variance + variance_after];
        tails[k] = [tail, tail_variance, variance];
        let degree = (k + 2) as f32;
        let energy = (2.0 * degree - 1.0) * (tail * tail - tail_variance);
        square += energy;
        if (counts || last > 0) && last < LAST_DEGREES {
            (fast, last) = (fast + energy.abs() * (1.0 / LAST_DEGREES as f32), last + 1);
        }
        // The square of noise alone: what a degree has in common with a higher one is its own mean
        // square.
        let own = 0.5 * degree * (degree + 1.0) - (k % 2) as f32;
        square_variance += 2.0 * own * own * variance * (variance + 2.0 * variance_after);
    }
    // And its product with what moves.
    let mut slopes = [0.0; 2];
    for (k, [tail, _, variance]) in tails.iter().enumerate() {
        let slope = &mut slopes[k % 2];
        *slope += (2 * k + 3) as f32 * tail;
        square_variance += 4.0 * *slope * *slope * variance;
    }
    let [apart, apart_variance, _] = tails[1];
    let wander = libm::sqrtf(square.max(0.0));
    // Of a frequency that moves the mean is as uncertain as it is measured, and may have a part
    // that is not seen.
    let moves = square > libm::sqrtf(square_variance);
    let of_moving = if moves {
        apart_variance + FAST_MEAN * fast
    } else {
        0.0
    };
    let apart = apart * apart + of_moving;
    let spread = libm::sqrtf(square_variance + FAST_DEGREES * FAST_DEGREES * fast * fast);
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
        chirp_sigma: span.frequency(
            span.frequency(with_off(libm::sqrtf(chirp_variance), off(CHIRP_OFF, chirp))),
        ),
    }
}
