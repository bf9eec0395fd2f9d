//! The crate `levenberg-marquardt` on the joint problem: offset, cosine and sine of every channel
//! and one frequency, from the periodogram's peak.
//!
//! The crate is MINPACK's algorithm (More, "The Levenberg-Marquardt algorithm: implementation and
//! theory", 1978), here with its own tolerances and with the exact derivatives. It takes the
//! derivatives as a dense matrix of channels x frames rows and 3 x channels + 1 columns, of which
//! all but four in a row are zero: 755 kB for 16 channels and 241 frames in f32, which is more than
//! the chip's memory; 2 channels take 14 kB and fit.

use super::periodogram::Peak;
use super::rotation::{Rotation, middle};
use super::samples::{Frame, Scratch, centred};
use core::f32::consts::TAU;
use levenberg_marquardt::{LeastSquaresProblem, LevenbergMarquardt};
use nalgebra::storage::Owned;
use nalgebra::{DMatrix, DVector, Dyn};

/// Channels whose matrix of a second's window fits the chip's memory.
pub const CHANNELS_ON_CHIP: usize = 2;

/// The common frequency, cycles per frame.
pub fn estimate(values: &[Frame], channels: usize, scratch: &mut Scratch) -> Option<f32> {
    let frequency = Peak::find(values, channels, scratch)?.frequency(0.0);
    let frames = values.len();
    let rotation = Rotation::new(frequency, frames);
    let mut samples = DVector::zeros(channels * frames);
    let mut parameters = DVector::zeros(3 * channels + 1);
    parameters[3 * channels] = frequency * frames as f32;
    for channel in 0..channels {
        // A channel that does not vary stays at zero.
        let Some(points) = centred(values, channel, &mut scratch.points) else {
            continue;
        };
        samples
            .rows_mut(channel * frames, frames)
            .copy_from_slice(points);
        let (along_cos, along_sin) = rotation.project(points);
        parameters[3 * channel] = 2.0 / frames as f32 * along_cos;
        parameters[3 * channel + 1] = 2.0 / frames as f32 * along_sin;
    }
    let problem = Problem {
        samples,
        frames,
        channels,
        parameters,
    };
    // Where it stopped is the best it found, for whatever reason it stopped.
    let (problem, _) = LevenbergMarquardt::new().minimize(problem);
    Some(problem.frequency())
}

struct Problem {
    /// Samples less their mean, channel by channel.
    samples: DVector<f32>,
    frames: usize,
    channels: usize,
    /// Factors of cosine and sine and the offset of each channel; last the frequency in cycles per
    /// window.
    parameters: DVector<f32>,
}

impl Problem {
    fn frequency(&self) -> f32 {
        self.parameters[3 * self.channels] / self.frames as f32
    }
}

impl LeastSquaresProblem<f32, Dyn, Dyn> for Problem {
    type ResidualStorage = Owned<f32, Dyn>;
    type JacobianStorage = Owned<f32, Dyn, Dyn>;
    type ParameterStorage = Owned<f32, Dyn>;

    fn set_params(&mut self, parameters: &DVector<f32>) {
        self.parameters.copy_from(parameters);
    }

    fn params(&self) -> DVector<f32> {
        self.parameters.clone()
    }

    fn residuals(&self) -> Option<DVector<f32>> {
        let rotation = Rotation::new(self.frequency(), self.frames);
        let mut residuals = DVector::zeros(self.samples.len());
        for channel in 0..self.channels {
            let [a, b, offset] = [0, 1, 2].map(|k| self.parameters[3 * channel + k]);
            let first = channel * self.frames;
            let mut rows = residuals.rows_mut(first, self.frames);
            let samples = self.samples.rows(first, self.frames);
            for ((residual, sample), (cos, sin)) in
                rows.iter_mut().zip(samples.iter()).zip(rotation.iter())
            {
                *residual = a * cos + b * sin + offset - sample;
            }
        }
        Some(residuals)
    }

    fn jacobian(&self) -> Option<DMatrix<f32>> {
        let rotation = Rotation::new(self.frequency(), self.frames);
        let mut jacobian = DMatrix::zeros(self.samples.len(), self.parameters.len());
        let per_frame = TAU / self.frames as f32;
        for channel in 0..self.channels {
            let [a, b] = [0, 1].map(|k| self.parameters[3 * channel + k]);
            let mut angle = -per_frame * middle(self.frames);
            for (row, (cos, sin)) in
                (channel * self.frames..).zip(rotation.iter().take(self.frames))
            {
                jacobian[(row, 3 * channel)] = cos;
                jacobian[(row, 3 * channel + 1)] = sin;
                jacobian[(row, 3 * channel + 2)] = 1.0;
                jacobian[(row, 3 * self.channels)] = angle * (b * cos - a * sin);
                angle += per_frame;
            }
        }
        Some(jacobian)
    }
}
