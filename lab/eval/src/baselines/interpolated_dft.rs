//! Interpolation between Fourier coefficients half a line to either side of the peak, repeated,
//! with the leakage of the tone's image at the negative frequency taken off.
//!
//! Aboutanios and Mulgrew, "Iterative frequency estimation by interpolation on Fourier
//! coefficients", IEEE Trans. Signal Process. 53(4), 2005, table I, algorithm 1, for one complex
//! exponential. A real tone is two of them, of frequencies f and -f and conjugate amplitudes: each
//! repetition takes the leakage of the second off the coefficients of the first as in Ye and
//! Aboutanios, "Efficient and accurate frequency estimation of multiple superimposed exponentials
//! in noise", 2015 (arXiv 1512.02251). Over channels, which share the correction h, it is the
//! least-squares solution of X(+1/2) - X(-1/2) = 2 h (X(+1/2) + X(-1/2)); the signs are as in the
//! paper, but for time counted from the middle of the window, which turns the sign of one of the
//! two coefficients.

use super::periodogram::Peak;
use super::rotation::Rotation;
use super::samples::{Frame, Scratch, centred};
use ridgetone_tone::phase::{cos_sin, from_turns};

/// Repetitions. Two are enough for a complex exponential (Aboutanios and Mulgrew); the image takes
/// one more.
const REPETITIONS: usize = 3;

/// The frequency, cycles per frame.
pub fn estimate(values: &[Frame], channels: usize, scratch: &mut Scratch) -> Option<f32> {
    let mut frequency = Peak::find(values, channels, scratch)?.frequency(0.0);
    let frames = values.len();
    let half_line = 0.5 / frames as f32;
    for _ in 0..REPETITIONS {
        let places = [-half_line, 0.0, half_line].map(|aside| frequency + aside);
        let rotations = places.map(|place| Rotation::new(place, frames));
        let image = places.map(|place| leakage(place + frequency, frames));
        let (mut product, mut square) = (0.0, 0.0);
        for channel in 0..channels {
            let Some(points) = centred(values, channel, &mut scratch.points) else {
                continue;
            };
            let [below, at, above] = rotations
                .each_ref()
                .map(|rotation| rotation.project(points));
            // With time from the middle both leakages are real: cosine and sine separate.
            let amplitude = (
                at.0 / (frames as f32 + image[1]),
                at.1 / (frames as f32 - image[1]),
            );
            let below = (
                below.0 - amplitude.0 * image[0],
                below.1 + amplitude.1 * image[0],
            );
            let above = (
                above.0 - amplitude.0 * image[2],
                above.1 + amplitude.1 * image[2],
            );
            let (sum, difference) = (
                (above.0 + below.0, above.1 + below.1),
                (above.0 - below.0, above.1 - below.1),
            );
            product += sum.0 * difference.0 + sum.1 * difference.1;
            square += sum.0 * sum.0 + sum.1 * sum.1;
        }
        if !(square > 0.0) {
            return None;
        }
        frequency += 0.5 * product / square / frames as f32;
    }
    Some(frequency)
}

/// The sum of cosines of `cycles` cycles per frame over a window's frames, time counted from its
/// middle.
fn leakage(cycles: f32, frames: usize) -> f32 {
    let sin = |half_turns: f32| cos_sin(from_turns(0.5 * half_turns)).1;
    let below = sin(cycles);
    if below.abs() < 1e-6 {
        frames as f32
    } else {
        sin(cycles * frames as f32) / below
    }
}
