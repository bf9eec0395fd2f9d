//! The paper's own method: gradient descent on seven parameters of two channels, from the
//! periodogram's peak.
//!
//! Oddo et al., "Artificial roughness encoding with a bio-inspired MEMS-based tactile sensor
//! array", Sensors 9 (2009): h = B + A sin(2 pi f (t - t0)) for each of two channels (equation 8),
//! f common, and E, the sum of the squares of what is left of both (equation 9), descended by its
//! gradient. The first guess of f is the periodogram's highest line (equation 6), here of both
//! channels together.
//!
//! The paper leaves open:
//! - the other first guesses: here offset, amplitude and time by projection on the guessed
//!   frequency;
//! - the origin of time: here the middle of the window, where f and t0 disturb each other least;
//! - the units of the parameters, which a gradient depends on: here such that E of the first guess
//!   bends by 1 along each of them, if the window were whole cycles;
//! - the length of a step: here it grows by a fifth after a step down; a step up is halved and
//!   tried again;
//! - the end: here a step shorter than [`ENOUGH`], or [`STEPS`] of them.

use super::periodogram::Peak;
use super::rotation::{Rotation, middle};
use super::samples::{Frame, Scratch, centred};
use core::f32::consts::TAU;

/// Channels that take part: piezoresistor 1 of two of the paper's sensors.
pub const CHANNELS_MAX: usize = 2;

pub const STEPS: usize = 500;

/// A step shorter than this share of the tone itself is the last. It moves the frequency by 5.5e-6
/// cycles per window at most: a fortieth of the bound of two channels at 40 dB and 241 frames.
pub const ENOUGH: f32 = 1e-5;

/// Offset, amplitude and time of two channels, and the frequency, with time in frames.
type Parameters = [f32; 7];

/// The common frequency of the first two channels, cycles per frame.
pub fn estimate(values: &[Frame], channels: usize, scratch: &mut Scratch) -> Option<f32> {
    let channels = channels.min(CHANNELS_MAX);
    let frequency = Peak::find(values, channels, scratch)?.frequency(0.0);
    let frames = values.len();
    let mut at = [0.0; 7];
    at[6] = frequency;
    // How much E bends along each parameter. A channel that does not vary stays where it is: a sine
    // of no amplitude.
    let mut bend = [1.0; 7];
    bend[6] = 0.0;
    let buffers = [&mut scratch.points, &mut scratch.second];
    let mut signals: [&[f32]; CHANNELS_MAX] = [&[], &[]];
    let mut size = 0.0;
    for (channel, points) in buffers.into_iter().enumerate().take(channels) {
        let Some(points) = centred(values, channel, points) else {
            continue;
        };
        let (along_cos, along_sin) = Rotation::new(frequency, frames).project(points);
        let amplitude =
            2.0 / frames as f32 * libm::sqrtf(along_cos * along_cos + along_sin * along_sin);
        let (turn, tone) = (TAU * frequency, amplitude * amplitude * frames as f32);
        at[3 * channel + 1] = amplitude;
        at[3 * channel + 2] = -libm::atan2f(along_cos, along_sin) / turn;
        bend[3 * channel..3 * channel + 3].copy_from_slice(&[
            2.0 * frames as f32,
            frames as f32,
            tone * turn * turn,
        ]);
        bend[6] += tone * TAU * TAU * middle(frames) * middle(frames) / 3.0;
        size += tone;
        signals[channel] = points;
    }
    descend(&signals, at, &bend, ENOUGH * ENOUGH * size)
}

/// Goes down until a step's square is less than `enough`. Gives the frequency.
fn descend(
    signals: &[&[f32]; CHANNELS_MAX],
    mut at: Parameters,
    bend: &Parameters,
    enough: f32,
) -> Option<f32> {
    let (mut error, mut gradient) = slope(signals, &at);
    let mut length = 1.0;
    for _ in 0..STEPS {
        let (mut next, mut square) = (at, 0.0);
        for ((next, gradient), bend) in next.iter_mut().zip(&gradient).zip(bend) {
            let step = length * gradient / bend;
            *next -= step;
            square += step * step * bend;
        }
        let (next_error, next_gradient) = slope(signals, &next);
        if next_error <= error {
            (at, error, gradient) = (next, next_error, next_gradient);
            length *= 1.2;
        } else {
            length *= 0.5;
        }
        if !(square >= enough) {
            break;
        }
    }
    Some(at[6])
}

fn slope(signals: &[&[f32]; CHANNELS_MAX], at: &Parameters) -> (f32, Parameters) {
    let frequency = at[6];
    let (mut error, mut gradient) = (0.0, [0.0; 7]);
    for (channel, points) in signals.iter().enumerate() {
        let (offset, amplitude, delay) =
            (at[3 * channel], at[3 * channel + 1], at[3 * channel + 2]);
        let [
            mut along_one,
            mut along_sin,
            mut along_cos,
            mut along_cos_time,
        ] = [0.0; 4];
        let mut time = -middle(points.len()) - delay;
        let rotation = Rotation::delayed(frequency, points.len(), frequency * delay);
        for (point, (cos, sin)) in points.iter().zip(rotation.iter()) {
            let rest = offset + amplitude * sin - point;
            error += rest * rest;
            along_one += rest;
            along_sin += rest * sin;
            along_cos += rest * cos;
            along_cos_time += rest * cos * time;
            time += 1.0;
        }
        gradient[3 * channel] = 2.0 * along_one;
        gradient[3 * channel + 1] = 2.0 * along_sin;
        gradient[3 * channel + 2] = -2.0 * amplitude * TAU * frequency * along_cos;
        gradient[6] += 2.0 * amplitude * TAU * along_cos_time;
    }
    (error, gradient)
}
