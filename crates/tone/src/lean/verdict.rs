//! Verdict of the lean path: the status of a line, and the result.

use super::blocks::Blocks;
use super::declaration::Declared;
use super::reference::Reference;
use super::search::Second;
use super::solve::Solution;
use crate::conclude::{CYCLES, CYCLES_ONE, SIGMA_MAX, overtone};
use crate::fit::{ChannelFit, Fit, OtherTone, Status, Tests};
use crate::frame_span::FrameSpan;
use crate::limits::CHANNELS_MAX;
use crate::significance::{Z_TEST, deviate, square_root};

/// Threshold for the line in all channels: by chance one in ten million, or one window in ten
/// thousand with a thousand bins.
const Z_LINE: f32 = 5.2;
/// Threshold for the line in a single channel.
const Z_CHANNEL: f32 = 3.1;
/// Maximum excess of the power outside a single waveform, standard deviations of its noise, if all
/// channels count as having one waveform.
const Z_SHAPE: f32 = 4.0;

/// Minimum fraction of the information that is not noise.
const FAINT_MIN: f32 = 0.3;

/// Figures that determine the status.
pub struct Verdict<'v> {
    /// Cycles per window.
    pub cycles: f32,
    pub reference: &'v Reference,
    pub solution: &'v Solution,
    /// The strongest line.
    pub strongest: &'v Line,
    pub fundamental: &'v Line,
    /// Spurious information on the turn, from noise in all lines.
    pub noise: f32,
    pub declared: &'v Declared,
    /// A second tone, elsewhere in the spectrum.
    pub second: Option<Second>,
}

/// A line of a solution.
#[derive(Clone, Copy, Debug)]
pub struct Line {
    /// Index in the solution.
    pub place: usize,
    /// Covariance of cosine and sine for unit noise.
    covariance: [[f32; 2]; 2],
    /// Normal deviate of the power in all channels.
    pub deviate: f32,
    /// Power in all channels over the noise.
    pub power: f32,
    /// Power outside a single waveform in all channels, over the noise.
    other: f32,
    /// Information on the turn that noise alone would give the line.
    pub noise: f32,
}

impl Line {
    /// The line at an index of a solution.
    pub fn new(solution: &Solution, reference: &Reference, place: usize) -> Self {
        let covariance = solution.covariance(place);
        let [[p, q], [_, r]] = covariance;
        let determinant = (p * r - q * q).max(f32::MIN_POSITIVE);
        // Factor of the information.
        let (first, both) = (r / determinant, -q / determinant);
        let root = square_root(first);
        let (first, both) = (root, both / root.max(f32::MIN_POSITIVE));
        let second = 1.0 / square_root(r).max(f32::MIN_POSITIVE);
        let [mut cosines, mut sines, mut products] = [0.0; 3];
        let rows = solution.coefficients.get(2 + 2 * place..4 + 2 * place);
        if let Some([a, b]) = rows {
            for ((a, b), weight) in a.iter().zip(b).zip(&solution.weights) {
                let (x, y) = (first * a + both * b, second * b);
                cosines += weight * x * x;
                sines += weight * y * y;
                products += weight * x * y;
            }
        }
        let (freedom, width) = (solution.freedom, reference.width as f32);
        let power = cosines + sines;
        let half = 0.5 * (cosines - sines);
        // The mean of a ratio whose denominator has few degrees of freedom is above one.
        let ratio = power / (2.0 * width) * (freedom - 2.0) / freedom;
        Self {
            place,
            covariance,
            deviate: deviate(ratio, 2.0 * width, width * freedom),
            power,
            other: 0.5 * power - square_root(half * half + products * products),
            noise: width * solution.noise_information(place, 0.5 * (p + r)),
        }
    }
}

impl Verdict<'_> {
    pub fn fit(&self, span: &FrameSpan, blocks: &Blocks, fit: &mut Fit) {
        let solution = self.solution;
        *fit = Fit::without_tone(Status::NoTone, blocks.frames() as u32);
        let freedom = solution.freedom;
        let width = self.reference.width as f32;
        let [[p, q], [_, r]] = self.fundamental.covariance;
        let determinant = (p * r - q * q).max(f32::MIN_POSITIVE);
        let own = 2 + 2 * self.fundamental.place;
        let [level, _, ..] = &solution.coefficients;
        let (Some(cosines), Some(sines)) = (
            solution.coefficients.get(own),
            solution.coefficients.get(own + 1),
        ) else {
            return;
        };
        for c in 0..CHANNELS_MAX {
            if self.reference.inverse[c] <= 0.0 {
                continue;
            }
            let (a, b) = (cosines[c], sines[c]);
            let power = (r * a * a - 2.0 * q * a * b + p * b * b) / determinant;
            fit.usable |= 1 << c;
            if deviate(0.5 * power * solution.weights[c], 2.0, freedom) > Z_CHANNEL {
                fit.with_tone |= 1 << c;
            }
            let square = a * a + b * b;
            fit.channels[c] = ChannelFit {
                offset: self.reference.level[c] + level[c],
                amplitude: square_root(square),
                phase_rad: libm::atan2f(-b, a),
                phase_variance: 0.5 * (p + r) * solution.variances[c] / square,
                residual: square_root(solution.variances[c]),
            };
        }
        let tests = Tests {
            line: self.strongest.deviate,
            fundamental: self.fundamental.deviate,
            beside: self.declared.worst(),
            cycles: self.cycles,
            // If all channels have one waveform, only noise remains outside it.
            one_shape: width <= 2.0
                || self.strongest.other < width + Z_SHAPE * square_root(2.0 * width),
            steady: 1.0,
            degree: 1,
            degrees: 1,
            lines: solution.mask(),
            ..Tests::default()
        };
        // Noise in the amplitudes looks like information, and scatters the score: inflate sigma.
        let noise = self.noise * solution.turn_sigma * solution.turn_sigma;
        let faint = 1.0 / (1.0 - noise).max(FAINT_MIN);
        // Each channel's noise is known from a finite number of frames.
        let sigma = faint * solution.sigma() * (1.0 + 2.0 / freedom);
        fit.status = self.status(&tests, sigma, 0.5 * span.frames as f32);
        fit.tests = tests;
        if fit.status.has_tone() {
            fit.frequency = span.frequency(self.cycles);
            let (sigma, rounding) = (span.frequency(sigma), f32::EPSILON * fit.frequency);
            fit.sigma = square_root(sigma * sigma + rounding * rounding);
            fit.harmonics = solution.orders().last().map_or(1, |order| *order as u8);
            self.fill_overtones(fit);
            fit.other_tone = self.second.map(|second| OtherTone {
                frequency: span.frequency(second.cycles),
                fraction: second.power,
            });
        } else {
            fit.with_tone = 0;
            for channel in &mut fit.channels {
                (channel.amplitude, channel.phase_rad) = (0.0, 0.0);
                channel.phase_variance = f32::INFINITY;
            }
        }
    }

    /// Ratios of the overtones to the fundamental.
    fn fill_overtones(&self, fit: &mut Fit) {
        let solution = self.solution;
        let pairs = solution.coefficients.as_chunks::<2>().0;
        let [_, first, others @ ..] = pairs else {
            return;
        };
        for (order, wave) in solution.orders().iter().skip(1).zip(others) {
            if let Some(ratio) = fit.overtones.get_mut(order - 2) {
                *ratio = overtone(*order, wave, first, &solution.variances, CHANNELS_MAX);
            }
        }
    }

    fn status(&self, tests: &Tests, sigma: f32, nyquist: f32) -> Status {
        let min = if tests.one_shape { CYCLES_ONE } else { CYCLES };
        let is_tone = tests.line > Z_LINE && self.cycles > 0.0 && sigma.is_finite();
        if !is_tone {
            Status::NoTone
        } else if self.cycles.min(nyquist - self.cycles) < min
            || self.second.is_some()
            || tests.fundamental < Z_TEST
            // Drift next to a strong overtone looks like a fundamental of one or two cycles.
            || self.strongest.place > 0 && self.cycles < CYCLES_ONE
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
