//! The four-parameter sine fit of IEEE Std 1057, by channel, averaged over channels.
//!
//! IEEE Std 1057, "Digitizing waveform recorders", the algorithm for a four-parameter least-squares
//! fit to sine wave data using matrix operations: each repetition solves for cosine, sine, offset
//! and a correction of the frequency. Its properties: Haendel, "Properties of the IEEE-STD-1057
//! four-parameter sine wave fit algorithm", IEEE Trans. Instrum. Meas. 49(6), 2000. It starts at
//! the peak of the periodogram of all channels.

use super::periodogram::Peak;
use super::rotation::{Rotation, middle};
use super::samples::{Frame, Scratch, centred};
use core::f32::consts::TAU;
use nalgebra::{Matrix4, Vector4};

/// Most repetitions; a channel that needs more has not converged and is left out.
const REPETITIONS: usize = 20;

/// A correction of the frequency below this, in cycles per window, ends the repetitions: a
/// hundredth of the bound of a single channel at 40 dB and 241 frames.
const ENOUGH: f32 = 3e-6;

/// A channel that moves farther than this from the guess, in cycles per window, is left out.
const REACH: f32 = 1.0;

/// The frequency, cycles per frame: the mean of the channels that converged.
pub fn estimate(values: &[Frame], channels: usize, scratch: &mut Scratch) -> Option<f32> {
    let guess = Peak::find(values, channels, scratch)?.frequency(0.0);
    let (mut sum, mut count) = (0.0, 0.0);
    for channel in 0..channels {
        let Some(points) = centred(values, channel, &mut scratch.points) else {
            continue;
        };
        if let Some(frequency) = fit(points, guess) {
            sum += frequency;
            count += 1.0;
        }
    }
    (count > 0.0).then(|| sum / count)
}

/// One channel's frequency. None if it leads away from the guess, if the unknowns cannot be
/// separated, or if it does not converge.
fn fit(points: &[f32], guess: f32) -> Option<f32> {
    let frames = points.len();
    let mut frequency = guess;
    let (along_cos, along_sin) = Rotation::new(frequency, frames).project(points);
    let mut direction = unit(along_cos, along_sin)?;
    for _ in 0..REPETITIONS {
        let solution = solve(points, frequency, direction.0, direction.1)?;
        let amplitude = libm::sqrtf(solution.x * solution.x + solution.y * solution.y);
        direction = unit(solution.x, solution.y)?;
        // The fourth unknown is amplitude times the phase by which the window's ends are off.
        let correction = solution.w / amplitude / (TAU * middle(frames));
        frequency += correction;
        if !((frequency - guess).abs() * (frames as f32) < REACH) {
            return None;
        }
        // In a long window the frequency's own last bit is more than that.
        if correction.abs() < (ENOUGH / frames as f32).max(f32::EPSILON * frequency) {
            return Some(frequency);
        }
    }
    None
}

/// Least-squares solution for the factors of cosine, sine, one, and the derivative by the frequency
/// of a wave of these parts of cosine and sine, time running from -1 to 1.
fn solve(points: &[f32], frequency: f32, cos_part: f32, sin_part: f32) -> Option<Vector4<f32>> {
    let per_frame = 1.0 / middle(points.len());
    let (mut normal, mut right) = (Matrix4::zeros(), Vector4::zeros());
    let mut time = -1.0;
    for (point, (cos, sin)) in points
        .iter()
        .zip(Rotation::new(frequency, points.len()).iter())
    {
        let row = Vector4::new(cos, sin, 1.0, time * (sin_part * cos - cos_part * sin));
        time += per_frame;
        right += row * *point;
        // The upper triangle is the lower one's image.
        for j in 0..4 {
            for i in j..4 {
                normal[(i, j)] += row[i] * row[j];
            }
        }
    }
    Some(normal.cholesky()?.solve(&right))
}

/// A vector's direction; none if it has none.
fn unit(x: f32, y: f32) -> Option<(f32, f32)> {
    let length = libm::sqrtf(x * x + y * y);
    (length > 0.0 && length.is_finite()).then(|| (x / length, y / length))
}
