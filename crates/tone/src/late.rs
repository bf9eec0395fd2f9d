//! Multiplexing delays and an input low-pass, in fits along a path: each channel is sampled at its
//! own position, and harmonics are shifted and attenuated at high speed. At the mean speed the
//! effect is a constant phase and gain, which stays in the waves; the effect of deviations from the
//! mean speed is computed from the waves and subtracted.

mod find;

use crate::domain::Domain;
use crate::frame::Frame;
use crate::limits::{CHANNELS_MAX, HARMONICS_MAX};
use crate::lines::Lines;
use crate::phase::first_powers;
use crate::source::Values;
use crate::trajectory::Trajectory;
use core::f32::consts::PI;

/// Delays of the channels along a path. In time, or at the mean speed, a delay is a constant phase,
/// which stays in the result.
#[derive(Clone, Copy, Debug, Default)]
pub struct Delays {
    /// Delay of each channel relative to its frame's position, in frames, at most one; negative if
    /// earlier.
    pub frames: Values,
    /// Time constant of a first-order low-pass before the converter, in frames; 0 if none.
    /// Positions along the path are assumed to include this delay already; fast harmonics are
    /// delayed less than that and attenuated, depending on their frequency.
    pub low_pass: f32,
}

/// Response of the low-pass to a line: phase lead relative to a pure delay, and gain.
#[derive(Clone, Copy, Debug, Default)]
struct Response {
    ahead: f32,
    gain: f32,
}

impl Response {
    /// Response to a line that advances by `turn` radians per time constant. Positions are delayed
    /// by a time constant already, so slow lines have no lead.
    fn at(turn: f32) -> Self {
        Self {
            ahead: turn - libm::atanf(turn),
            gain: 1.0 / crate::sqrt(1.0 + turn * turn),
        }
    }
}

/// Fitted waves of a tone, to correct channels for their delays.
#[derive(Clone, Debug)]
pub struct Late {
    /// Multiplexing delay of each channel, frames, in the order of the channels.
    frames: Values,
    /// Mean step of `u` per frame.
    step: f32,
    last: u32,
    /// Time constant of the low-pass, frames.
    low_pass: f32,
    /// Mean response to each line, by line number.
    mean: [Response; HARMONICS_MAX + 1],
    trajectory: Trajectory,
    lines: Lines,
    /// Cosine and sine of each line.
    waves: [Values; 2 * HARMONICS_MAX],
    /// Function that subtracts the change from a frame. A pointer, so that firmware without delays
    /// does not link it.
    subtract: fn(&Self, &Domain, &mut Frame),
}

impl Late {
    fn mean_response(&self, domain: &Domain) -> [Response; HARMONICS_MAX + 1] {
        let mut mean = [Response::default(); HARMONICS_MAX + 1];
        for frame in 0..=self.last {
            let step = self.step_at(domain, frame);
            for (line, mean) in mean.iter_mut().enumerate() {
                let Response { ahead, gain } = self.response(step, line);
                mean.ahead += ahead / (self.last + 1) as f32;
                mean.gain += gain / (self.last + 1) as f32;
            }
        }
        mean
    }

    /// Response of the low-pass to a line where `u` advances by `step` per frame.
    fn response(&self, step: f32, line: usize) -> Response {
        Response::at(PI * self.trajectory.cycles * step * line as f32 * self.low_pass)
    }

    /// Step of `u` per frame around a frame (central difference).
    fn step_at(&self, domain: &Domain, frame: u32) -> f32 {
        let (before, after) = (frame.saturating_sub(1), (frame + 1).min(self.last));
        (domain.u(after) - domain.u(before)) / (after - before).max(1) as f32
    }

    pub fn subtract(&self, domain: &Domain, frame: &mut Frame) {
        (self.subtract)(self, domain, frame);
    }

    fn take_change(&self, domain: &Domain, frame: &mut Frame) {
        let change = self.change(domain, frame);
        let pairs = frame.values.iter_mut().zip(&change);
        pairs.for_each(|(value, change)| *value -= change);
    }

    /// Change of each channel of a frame because the speed differs from its mean, to second order
    /// in the delay angle.
    fn change(&self, domain: &Domain, frame: &Frame) -> Values {
        let step = self.step_at(domain, frame.number);
        let turn = PI * self.trajectory.cycles * (step - self.step);
        let powers: [_; HARMONICS_MAX + 1] =
            first_powers(self.trajectory.at(frame.u, 1.0), self.lines.max());
        let mut change = [0.0; CHANNELS_MAX];
        let pairs = self.waves.as_chunks::<2>().0.iter();
        for ([of_cos, of_sin], line) in pairs.zip(self.lines.iter()) {
            let line = line.min(HARMONICS_MAX);
            let [cos, sin] = powers[line];
            let (own, mean) = (self.response(step, line), self.mean[line]);
            let gain = own.gain / mean.gain;
            let (sin_ahead, cos_ahead) = libm::sincosf(own.ahead - mean.ahead);
            let (ahead_cos, ahead_sin) = (
                gain * (cos * cos_ahead - sin * sin_ahead),
                gain * (sin * cos_ahead + cos * sin_ahead),
            );
            for k in 0..CHANNELS_MAX {
                let angle = turn * line as f32 * self.frames[k];
                let (wave, quarter) = (
                    of_cos[k] * ahead_cos + of_sin[k] * ahead_sin,
                    of_sin[k] * ahead_cos - of_cos[k] * ahead_sin,
                );
                let at_mean = of_cos[k] * cos + of_sin[k] * sin;
                change[k] += wave - at_mean + angle * quarter - 0.5 * angle * angle * wave;
            }
        }
        change
    }
}
