//! The one place of the lean path where a status is set.

use super::blocks::Blocks;
use super::declaration::Declared;
use super::reference::Reference;
use super::search::Second;
use super::solve::Solution;
use crate::conclude::{CYCLES, CYCLES_ONE, SIGMA_MAX};
use crate::fit::{ChannelFit, Fit, OtherTone, Status, Tests};
use crate::frame_span::FrameSpan;
use crate::limits::CHANNELS_MAX;
use crate::significance::deviate;

/// Deviate of the line in all channels: one of ten million is above, one of ten thousand windows
/// with a thousand places.
const Z_LINE: f32 = 5.2;
/// Deviate of the line in a single channel.
const Z_CHANNEL: f32 = 3.1;
/// Lines of one shape in all channels leave less than this many standard deviations beside it.
const Z_SHAPE: f32 = 4.0;

/// What a status is set by.
pub struct Verdict<'v> {
    /// Cycles a window.
    pub cycles: f32,
    pub reference: &'v Reference,
    pub solution: &'v Solution,
    pub declared: &'v Declared,
    /// Another tone, elsewhere in the spectrum.
    pub second: Option<Second>,
}

impl Verdict<'_> {
    /// The result.
    pub fn fit(&self, span: &FrameSpan, blocks: &Blocks) -> Fit {
        let solution = self.solution;
        let mut fit = Fit::without_tone(Status::NoTone, blocks.frames() as u32);
        let freedom = solution.freedom;
        let width = self.reference.width as f32;
        let [mut cosines, mut sines, mut both] = [0.0; 3];
        let variance = solution.line_variance();
        for c in 0..CHANNELS_MAX {
            if self.reference.inverse[c] <= 0.0 {
                continue;
            }
            let scale = 1.0 / self.reference.inverse[c];
            let (x, y) = (solution.projections[2][c], solution.projections[3][c]);
            let weight = solution.weights[c];
            cosines += weight * x * x;
            sines += weight * y * y;
            both += weight * x * y;
            let power = 0.5 * weight * (x * x + y * y);
            let (a, b) = (solution.coefficients[2][c], solution.coefficients[3][c]);
            fit.usable |= 1 << c;
            if deviate(power, 2.0, freedom) > Z_CHANNEL {
                fit.with_tone |= 1 << c;
            }
            fit.channels[c] = ChannelFit {
                offset: self.reference.level[c] + scale * solution.coefficients[0][c],
                amplitude: scale * libm::hypotf(a, b),
                phase_rad: libm::atan2f(-b, a),
                phase_variance: variance * solution.variances[c] / (a * a + b * b),
                residual: scale * libm::sqrtf(solution.variances[c]),
            };
        }
        // The mean of a ratio whose denominator has few degrees of freedom is above one.
        let ratio = (cosines + sines) / (2.0 * width) * (freedom - 2.0) / freedom;
        let half = 0.5 * (cosines - sines);
        let other = 0.5 * (cosines + sines) - libm::hypotf(half, both);
        let tests = Tests {
            line: deviate(ratio, 2.0 * width, width * freedom),
            beside: self.declared.worst(),
            cycles: self.cycles,
            one_shape: width <= 2.0 || other < width + Z_SHAPE * libm::sqrtf(2.0 * width),
            steady: 1.0,
            degree: 1,
            degrees: 1,
            lines: 0b10,
            ..Tests::default()
        };
        // Each channel's noise is known from a finite number of frames.
        let sigma = solution.sigma() * (1.0 + 2.0 / freedom);
        fit.status = self.status(&tests, sigma, 0.5 * span.frames as f32);
        fit.tests = tests;
        if fit.status.has_tone() {
            fit.frequency = span.frequency(self.cycles);
            fit.sigma = libm::hypotf(span.frequency(sigma), f32::EPSILON * fit.frequency);
            fit.harmonics = 1;
            fit.other_tone = self.second.map(|second| OtherTone {
                frequency: span.frequency(second.cycles),
                share: second.power,
            });
        } else {
            fit.with_tone = 0;
            for channel in &mut fit.channels {
                (channel.amplitude, channel.phase_rad) = (0.0, 0.0);
                channel.phase_variance = f32::INFINITY;
            }
        }
        fit
    }

    fn status(&self, tests: &Tests, sigma: f32, nyquist: f32) -> Status {
        let min = if tests.one_shape { CYCLES_ONE } else { CYCLES };
        let is_tone = tests.line > Z_LINE && self.cycles > 0.0 && sigma.is_finite();
        if !is_tone {
            Status::NoTone
        } else if self.cycles.min(nyquist - self.cycles) < min
            || self.second.is_some()
            || !self.declared.is_met()
        {
            Status::Ambiguous
        } else if sigma > SIGMA_MAX * self.cycles {
            Status::Unsteady
        } else {
            Status::Good
        }
    }
}
