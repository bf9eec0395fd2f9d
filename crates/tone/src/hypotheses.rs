//! Tests of a tone. All compute a normal deviate by the same formula.

use crate::blocks::{Blocks, Pass};
use crate::covariance::power;
use crate::fit::Tests;
use crate::limits::{BAND, CHANNELS_MAX, HARMONICS_MAX};
use crate::lines::Lines;
use crate::matrix::Square;
use crate::movement::Followed;
use crate::noise_bins::{LineFrequencies, NoiseBins, line};
use crate::nyquist::Nyquist;
use crate::residual::Model;
use crate::significance::{Sum, Z_TEST, deviate};
use crate::solve::{Power, ProjectedModel, Shape, Solution};
use crate::source::Values;
use crate::spectrum::{Spectrum, Sums};
use crate::statistics::Products;
use crate::window_frames::WindowFrames;
use crate::workspace::Workspace;

/// Threshold for a line over the local noise. Noise exceeds it in a given bin with a probability of
/// 1e-5, and in any of a hundred bins with 1e-3.
pub const Z_LINE: f32 = 4.3;
/// Threshold for the larger of two lines; noise exceeds it once in a thousand windows.
pub const Z_BETWEEN: f32 = 3.3;
/// Maximum power of another line that is ignored, as a fraction of the tone's.
const OTHER: f32 = 1e-2;
/// Maximum power of a line relative to a sum of squares. It is above 1 because cosine and sine are
/// not quite orthogonal over a few cycles.
const OF_SQUARES: f32 = 1.22;
/// Minimum distance of another line from the comb, cycles per window.
const CLEAR_CYCLES: f32 = 0.9;
/// Distance from a line to the centre of a noise band, and half-width of the band, cycles per
/// window.
const NOISE_CYCLES: f32 = 2.5;
const NOISE_WIDTH: f32 = 1.6;
/// Minimum number of bins for the local noise.
const PLACES_MIN: usize = 4;
/// Minimum number of noise bins on each side of a line.
const SIDE_MIN: usize = 3;
/// Minimum number of cycles of a line in a single channel: slower lines look like level and slope.
const CYCLES_OWN: f32 = 1.0;
/// Lines tested between the harmonics, in halves of the fundamental.
const BETWEEN: [usize; 2] = [1, 3];

/// A line outside the comb.
#[derive(Clone, Copy, Debug, Default)]
pub struct Other {
    pub deviate: f32,
    /// Frequency, cycles per window.
    pub cycles: f32,
    /// Power relative to the tone.
    pub fraction: f32,
    /// Normal deviate of the most significant line in any channel that lacks the tone.
    pub own: f32,
    /// Frequency of the line in the channel that lacks the tone, cycles per window.
    pub own_cycles: f32,
}

/// Noise bins to fill in, and inverse noise covariance.
pub struct Noise<'n> {
    pub noise_bins: &'n mut NoiseBins,
    /// Products of the noise bins with the channels.
    pub memory: &'n mut [Values],
    /// Inverse covariance of the channels' noise.
    pub weights: &'n Square<CHANNELS_MAX>,
    pub all: &'n Products,
}

/// Inputs of the tests.
pub struct Tested<'t> {
    pub followed: &'t Followed,
    /// Power of each line over the noise next to the lines.
    pub powers: [Power; HARMONICS_MAX],
    /// Power of each line, summed over the channels in units of their noise variances.
    plains: [f32; HARMONICS_MAX],
    /// Power of the tone in units of the residuals' variances.
    power: f32,
    /// Power of the tone in units of the channels' variances.
    plain: f32,
    /// Number of the line with the most power, in units of the channels' variances.
    pub loudest: usize,
    /// Mask of the channels in which the tone is significant by itself.
    pub with_tone: u16,
    pub shape: Shape,
    pub nyquist: Nyquist,
    /// Number of channels.
    pub width: usize,
}

impl<'t> Tested<'t> {
    #[inline(never)]
    pub fn new(
        followed: &'t Followed,
        workspace: &Workspace,
        nyquist: Nyquist,
        width: usize,
    ) -> Self {
        let (all, shape) = (workspace.solution.line_factors(), followed.shape);
        let factors = all.get(..shape.lines.count()).unwrap_or_default();
        let mut powers = [Power::default(); HARMONICS_MAX];
        for (power, factors) in powers.iter_mut().zip(factors) {
            *power = Power::new(factors, &workspace.weights);
        }
        let mut plains = [0.0; HARMONICS_MAX];
        for (plain, [cos, sin]) in plains.iter_mut().zip(factors) {
            for k in 0..width.min(CHANNELS_MAX) {
                *plain += (cos[k] * cos[k] + sin[k] * sin[k]) / followed.noise.variances[k];
            }
        }
        let (mut tone, mut plain, mut with_tone) = (0.0, 0.0, 0);
        for k in 0..width.min(CHANNELS_MAX) {
            let mut max = 0.0;
            for [cos, sin] in factors {
                let power = cos[k] * cos[k] + sin[k] * sin[k];
                tone += power / followed.variances[k];
                plain += power;
                max = f32::max(max, power);
            }
            let over = max / (2.0 * followed.noise.variances[k]);
            if deviate(over, 2.0, followed.count) > Z_TEST {
                with_tone |= 1 << k;
            }
        }
        let (mut loudest, mut max) = (1, 0.0);
        for (line, [cos, sin]) in shape.lines.iter().zip(factors) {
            let squares = cos.iter().zip(sin).take(width);
            let own = squares.map(|(cos, sin)| cos * cos + sin * sin).sum();
            if own > max {
                (loudest, max) = (line, own);
            }
        }
        Self {
            followed,
            powers,
            plains,
            loudest,
            power: tone.max(f32::MIN_POSITIVE),
            plain: plain.max(f32::MIN_POSITIVE),
            with_tone,
            shape,
            nyquist,
            width,
        }
    }

    /// Tests the lines against their noise bins, and the power next to the lines.
    #[inline(never)]
    pub fn near(&self, noise_bins: &NoiseBins, tests: &mut Tests) {
        let (followed, powers) = (self.followed, &self.powers);
        let (width, lines) = (self.width as f32, self.shape.lines);
        let strongest = powers
            .iter()
            .copied()
            .fold(Power::default(), |strongest, power| {
                if power.all > strongest.all {
                    power
                } else {
                    strongest
                }
            });
        tests.line = deviate(strongest.all / (2.0 * width), 2.0, followed.count);
        for number in lines.iter() {
            tests.line = tests.line.max(self.over_loudest(noise_bins, number));
        }
        // Two channels span no more than a cosine and a sine, whatever the signal.
        tests.one_shape =
            self.width <= 2 || strongest.second < width + 4.0 * crate::sqrt(2.0 * width);
        let mut own = Sum::default();
        for member in noise_bins.members() {
            if lines.iter().next() == Some(usize::from(member.line)) {
                own.add(member.power * followed.taken / width);
            }
        }
        let channels = followed.noise.channels;
        if noise_bins.count() == 0 {
            // In white noise, every frame is a noise sample.
            (own.sum, own.count) = (followed.count, followed.count);
        }
        tests.fundamental = if own.count > 3.0 {
            let over = powers[0].all / (2.0 * width) / own.mean().max(f32::MIN_POSITIVE);
            deviate(over, 2.0 * channels, own.count * channels)
        } else {
            tests.line
        };
        tests.beside = noise_bins.near_over_far(channels);
        tests.beside_fraction = noise_bins.nearest / self.power;
    }

    /// Normal deviate of a line in all channels over the loudest noise bin next to it; minus
    /// infinity with too few bins. With the mean of the bins instead, noise with a rising, falling
    /// or widely peaked spectrum would pass for a line.
    fn over_loudest(&self, noise_bins: &NoiseBins, number: usize) -> f32 {
        let (followed, width) = (self.followed, self.width as f32);
        let place = self.shape.lines.index(number) % HARMONICS_MAX;
        let (mut loudest, mut sides) = (2.0 * width, [0; 2]);
        for next in noise_bins.places(number) {
            loudest = f32::max(loudest, next.power * followed.taken);
            sides[usize::from(next.is_above())] += 1;
        }
        let [below, above] = sides;
        if below.min(above) < SIDE_MIN {
            return f32::NEG_INFINITY;
        }
        // Correlated noise spans few directions, and weights may suppress it in the bins but not in
        // the line. So also test with the channels' variances alone.
        let of_channels = followed.loudest[number % followed.loudest.len()] * followed.taken;
        let ratio = self.powers[place].all / loudest;
        let ratio = ratio.min(self.plains[place] / of_channels.max(f32::MIN_POSITIVE));
        // Channels with correlated noise may have a noise line in common.
        let channels = 1.0 + followed.noise.shrinkage * (followed.noise.channels - 1.0);
        let count = 2 * (below + above);
        deviate(ratio, 2.0 * channels, count as f32 * channels)
    }

    /// Finds the most significant line in the residuals of the comb.
    #[inline(never)]
    pub fn other(
        &self,
        window: &mut WindowFrames,
        model: &Model,
        sums: Sums,
        transforms: &mut [f32],
    ) -> Other {
        let followed = self.followed;
        let (domain, each, frames) = (window.domain, window.frames_each(), window.count());
        let half = window.cycles_max() / each as f32;
        let Some(mut spectrum) = Spectrum::new(window, each, sums, transforms) else {
            return Other::default();
        };
        let places = Bins {
            lines: self.shape.lines,
            cycles: followed.trajectory.cycles,
            max: half,
            step: spectrum.cycles(1.0),
            last: (spectrum.bin(half - 0.5) as usize).min(spectrum.last()),
        };
        let mut found = Other::default();
        let every = ((1u32 << self.width) - 1) as u16;
        let weights = followed.variances.map(|variance| 1.0 / variance);
        for first in (0..self.width).step_by(spectrum.channels()) {
            // A line in the remaining channels cannot have more power than their residuals.
            let variances = followed.variances.iter().take(self.width);
            let left: f32 = variances.skip(first).sum();
            let max = OF_SQUARES * window.statistics.frames as f32 * left;
            let all_with_tone = (every & !self.with_tone) >> first == 0;
            if all_with_tone && spectrum.strongest_plain() + max < OTHER * self.plain {
                break;
            }
            let channels = first..(first + spectrum.channels()).min(self.width);
            spectrum.clear(channels.len());
            window.visit_channels(channels.clone(), &mut |frame| {
                let values = model.residual(frame, channels.clone());
                let point = frame.point(&domain, frames, each);
                let values = values.get(channels.clone()).unwrap_or_default();
                for (i, value) in values.iter().enumerate() {
                    spectrum.put(i, point, *value);
                }
            });
            spectrum.add_powers(weights.get(channels.clone()).unwrap_or_default());
            // A channel without the tone may have a separate line.
            for k in channels.filter(|k| self.with_tone >> k & 1 == 0) {
                let power = |i: usize| spectrum.of_channel(k - first, i);
                let from = spectrum.bin(CYCLES_OWN) as usize + 1;
                for i in from..places.last {
                    let deviate = places.deviate(i, &power);
                    if deviate > found.own {
                        found.own = deviate;
                        found.own_cycles = places.at(i);
                    }
                }
            }
        }
        for i in 1..places.last {
            let fraction = spectrum.plain(i) / self.plain;
            // A line stronger than the tone cannot be an overtone that was left out.
            if fraction <= OTHER || fraction < 1.0 && places.is_multiple(i) {
                continue;
            }
            let deviate = places.deviate(i, &|i| spectrum.power(i));
            if deviate > found.deviate {
                found.deviate = deviate;
                found.cycles = places.at(i);
                found.fraction = fraction;
            }
        }
        found
    }

    /// Model of the frames: a solution without modulation, plus the modulation.
    pub fn model<'m>(&self, solution: &'m Solution) -> Model<'m> {
        Model {
            solution,
            motion: self.followed.moves.then(|| self.followed.motion()),
            trajectory: self.followed.trajectory,
        }
    }

    /// Normal deviate of the lines at half and three halves of the fundamental over their local
    /// noise, in the residuals: evidence of a comb at half the frequency. The solution must be
    /// projected, and also solved if the tone is modulated.
    #[inline(never)]
    pub fn between(
        &self,
        window: &mut WindowFrames,
        solution: &Solution,
        blocks: &mut Blocks,
        noise: &mut Noise,
    ) -> f32 {
        let followed = self.followed;
        let shape = Shape {
            lines: self.shape.lines.times(2),
            degree: self.shape.degree,
        };
        let lines = BETWEEN
            .iter()
            .fold(Lines::NONE, |lines, line| lines.with(*line));
        let pass = Pass {
            trajectory: followed.trajectory,
            scale: 0.5,
            lines,
            multiple_max: shape.lines.max() + lines.max(),
        };
        let moving = followed.moves.then(|| self.model(solution));
        blocks.collect(window, &pass, moving.as_ref());
        let place = |number: usize| LineFrequencies {
            lines: Lines::NONE.with(number),
            cycles: 0.5 * followed.trajectory.cycles,
            nyquist: self.nyquist,
            band: BAND,
        };
        let projected = ProjectedModel {
            shape: &shape,
            factor: solution.factor(),
            projections: moving.is_none().then_some(&solution.rows),
        };
        let Noise {
            noise_bins,
            memory,
            weights,
            all,
        } = noise;
        // All rounding power may fall into one line, half of it in the cosine and half in the sine.
        let rounding = 0.5 * all.rounding(weights, self.width);
        let mut found = f32::NEG_INFINITY;
        for number in BETWEEN {
            let cycles = 0.5 * number as f32 * followed.trajectory.cycles;
            if cycles >= self.nyquist.max || !self.nyquist.is_clear(cycles) {
                continue;
            }
            noise_bins.collect(blocks, projected, place(number), memory);
            let count = noise_bins.count();
            let Some(tested) = line(blocks, projected, number) else {
                continue;
            };
            if count < PLACES_MIN {
                continue;
            }
            let [mut beside, mut own] = [Sum::default(); 2];
            for values in memory.iter().take(count) {
                beside.add(power(values, weights));
            }
            for values in &tested {
                own.add(power(values, weights));
            }
            let channels = followed.noise.channels;
            let over = (own.mean() - rounding) / beside.mean().max(f32::MIN_POSITIVE);
            found = found.max(deviate(over, 2.0 * channels, beside.count * channels));
        }
        found
    }
}

/// Bins of a spectrum.
struct Bins {
    lines: Lines,
    cycles: f32,
    /// Nyquist limit of the transform, cycles per window.
    max: f32,
    /// Distance between bins, cycles per window.
    step: f32,
    last: usize,
}

impl Bins {
    /// Frequency, cycles per window.
    fn at(&self, i: usize) -> f32 {
        i as f32 * self.step
    }

    /// Normal deviate of a line at bin `i` against the noise bins beside it; minus infinity if the
    /// bin is not clear, or too few beside it are.
    fn deviate(&self, i: usize, power: &dyn Fn(usize) -> f32) -> f32 {
        let own = power(i);
        if !self.is_clear(i) {
            return f32::NEG_INFINITY;
        }
        let mut beside = Sum::default();
        let far = ((NOISE_CYCLES + NOISE_WIDTH) / self.step) as usize;
        let near = ((NOISE_CYCLES - NOISE_WIDTH) / self.step) as usize + 1;
        for distance in near..=far {
            for j in [i.saturating_sub(distance), i + distance] {
                if j > 0 && j < self.last && self.is_clear(j) {
                    beside.add(power(j));
                }
            }
        }
        if beside.count < PLACES_MIN as f32 {
            return f32::NEG_INFINITY;
        }
        deviate(
            own / beside.mean().max(f32::MIN_POSITIVE),
            2.0,
            beside.count,
        )
    }

    /// True if a bin is clear of the lines of the comb.
    fn is_clear(&self, i: usize) -> bool {
        let x = self.at(i);
        let far = |line: usize| {
            let line = line as f32 * self.cycles;
            let folded = line - 2.0 * self.max * libm::roundf(0.5 * line / self.max);
            (x - folded.abs()).abs() > CLEAR_CYCLES
        };
        self.lines.iter().all(far)
    }

    fn is_multiple(&self, i: usize) -> bool {
        let x = self.at(i);
        let nearest = libm::roundf(x / self.cycles).max(1.0);
        (x - nearest * self.cycles).abs() <= CLEAR_CYCLES
    }
}
