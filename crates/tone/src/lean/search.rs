//! Finds the frequency of the tone by transforming mixtures of channels.
//!
//! A mixture is a sum of up to eight channels, each divided by its scale and given a sign. Mixtures
//! are added until the highest peak of their summed power is clear, so that a loud tone costs one
//! or two transforms and a faint one has the evidence of all channels.

use super::blocks::LINES;
use super::reference::Reference;
use crate::frame_span::FrameSpan;
use crate::limits::{CHANNELS_MAX, POINTS_MAX};
use crate::phase::{cos_sin, from_turns};
use crate::scene::Band;
use crate::significance::deviate;
use crate::source::{Overwritten, Values};
use crate::spectrum::transform;
use core::f32::consts::PI;

/// Shortest transform, points.
const POINTS_MIN: usize = 128;
/// Number of channels in a mixture.
const MIXED: usize = CHANNELS_MAX / 2;
/// Maximum number of mixtures per half of the channels.
const MIXTURES: usize = 4;
/// Number of frames above which one mixture may be enough.
const FRAMES_LONG: usize = 512;
/// Deviate above which a peak is clear, and no more mixtures are added.
const Z_CLEAR: f32 = 7.0;
/// Threshold for a second peak: by chance one bin in 100,000, or one window in a thousand.
const Z_SECOND: f32 = 4.3;
/// Threshold for a possible line: one bin in a hundred by chance.
const Z_LINE: f32 = 2.3;
/// Powers above this many times their mean are lines rather than noise.
const NOISE_MAX: f32 = 2.0;
/// Relative excess of the mean noise over the mean below `NOISE_MAX`, times the number of mixtures.
const NOISE_ABOVE: f32 = 0.45;
/// Minimum number of cycles of a peak.
const CYCLES_MIN: f32 = 0.7;
/// Half-width of a Hann window's main lobe, with some margin, cycles.
const LOBE: f32 = 2.6;
/// Minimum number of cycles of a second peak: a curved level is detected by the blocks.
const SECOND_CYCLES_MIN: f32 = 2.0;

/// Sum of the power spectra of several mixtures of channels.
pub struct Search<'m> {
    /// Signal to transform.
    points: &'m mut [Values],
    /// Power of each bin.
    power: &'m mut [f32],
    grid: Grid,
    /// Number of mixtures whose power was summed.
    mixtures: usize,
}

/// Bins of a transform.
#[derive(Clone, Copy, Debug, Default)]
struct Grid {
    points: usize,
    /// Frames per point.
    each: usize,
    /// Number of points that frames fill.
    pieces: usize,
    /// Distance between bins, cycles per window.
    step: f32,
}

/// A candidate frequency.
#[derive(Clone, Copy, Debug, Default)]
pub struct Peak {
    /// Cycles per window.
    pub cycles: f32,
    /// False if the frequency is the expected one.
    pub is_searched: bool,
}

/// Lines at the multiples of a frequency.
#[derive(Clone, Copy, Debug)]
pub struct Comb {
    /// Apparent frequencies of the lines, from the first on: those above half the frame rate are
    /// aliases.
    at: [f32; LINES],
    lines: usize,
}

impl Comb {
    /// The first `lines` multiples of `cycles` per window of `frames` frames.
    pub fn new(cycles: f32, lines: usize, frames: u32) -> Self {
        let frames = frames as f32;
        let seen = |number: usize| {
            let turns = number as f32 * cycles / frames;
            f32::abs(turns - (turns + 0.5) as i32 as f32) * frames
        };
        Self {
            at: core::array::from_fn(|i| seen(i + 1)),
            lines: lines.min(LINES),
        }
    }

    fn lines(&self) -> &[f32] {
        self.at.get(..self.lines).unwrap_or_default()
    }

    /// Distance to the nearest line, cycles.
    fn distance(&self, cycles: f32) -> f32 {
        let mut min = f32::abs(cycles - self.at[0]);
        for line in self.lines().iter().skip(1) {
            let distance = f32::abs(cycles - line);
            if distance < min {
                min = distance;
            }
        }
        min
    }
}

/// A second tone in the window.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Second {
    /// Cycles per window.
    pub cycles: f32,
    /// Power over that of the reported tone.
    pub power: f32,
}

/// Weighted sum of half of the channels.
#[derive(Clone, Copy)]
struct Mixture {
    half: usize,
    weights: [f32; MIXED],
    level: [f32; MIXED],
}

impl Mixture {
    /// Mixture `number` of half of the channels: signs are a row of a Hadamard matrix, the
    /// alternating one first, so that common-mode signals do not stand out at once.
    fn new(reference: &Reference, half: usize, number: usize) -> Self {
        let part = |values: &Values| values.as_chunks::<MIXED>().0[half % 2];
        let (mut weights, level) = (part(&reference.inverse), part(&reference.level));
        for (k, weight) in weights.iter_mut().enumerate() {
            if (k & (number + 1)).count_ones() % 2 == 1 {
                *weight = -*weight;
            }
        }
        Self {
            half: half % 2,
            weights,
            level,
        }
    }

    /// Mixes several frames at once, so that levels and weights are loaded only once.
    #[inline(always)]
    fn values<const N: usize>(&self, frames: &[Values; N]) -> [f32; N] {
        let frames = frames.each_ref();
        let frames = frames.map(|frame| &frame.as_chunks::<MIXED>().0[self.half % 2]);
        let mut sums = [0.0; N];
        for k in 0..MIXED {
            for (sum, frame) in sums.iter_mut().zip(&frames) {
                *sum += self.weights[k] * (frame[k] - self.level[k]);
            }
        }
        sums
    }

    /// Fills points with the mixed frames of a span.
    #[inline(never)]
    fn fill(
        &self,
        span: &mut FrameSpan,
        reference: &Reference,
        each: usize,
        points: &mut [f32],
    ) -> Result<(), Overwritten> {
        points.fill(0.0);
        let all = 0..span.frames;
        span.visit_runs(all, reference.wanted, &mut |first, run| {
            let mut frame = first as usize;
            let mut add = |value: f32| {
                let point = if each == 1 {
                    frame
                } else {
                    frame / each.max(1)
                };
                if let Some(point) = points.get_mut(point) {
                    *point += value;
                }
                frame += 1;
            };
            if reference.width < CHANNELS_MAX {
                for values in run {
                    let mut values = *values;
                    reference.clear(&mut values);
                    self.values(&[values]).into_iter().for_each(&mut add);
                }
                return;
            }
            let (fours, rest) = run.as_chunks::<4>();
            for frames in fours {
                self.values(frames).into_iter().for_each(&mut add);
            }
            for frame in rest {
                self.values(&[*frame]).into_iter().for_each(&mut add);
            }
        })
    }
}

impl<'m> Search<'m> {
    /// Search with memory for at least [`POINTS_MAX`] points, and for half as many bins.
    pub fn new(points: &'m mut [Values], power: &'m mut [f32]) -> Self {
        Self {
            points,
            power,
            grid: Grid::default(),
            mixtures: 0,
        }
    }

    /// Scratch memory, free between searches.
    pub fn scratch(&mut self) -> &mut [Values] {
        self.points
    }

    /// The highest peak in a band of cycles per window.
    #[inline(never)]
    pub fn peak(
        &mut self,
        span: &mut FrameSpan,
        reference: &Reference,
        band: Band,
    ) -> Result<Peak, Overwritten> {
        let frames = span.frames as usize;
        let each = frames.div_ceil(POINTS_MAX).max(1);
        let pieces = frames.div_ceil(each);
        let points = pieces.next_power_of_two().clamp(POINTS_MIN, POINTS_MAX);
        self.grid = Grid {
            points,
            each,
            pieces,
            step: pieces as f32 / points as f32,
        };
        self.mixtures = 0;
        let bins = points / 2;
        self.power.iter_mut().take(bins).for_each(|bin| *bin = 0.0);
        let counts = reference.inverse.as_chunks::<MIXED>().0;
        let counts = [0, 1].map(|half| counts[half].iter().filter(|x| **x > 0.0).count());
        let max = MIXTURES.min(counts[0].max(counts[1]).next_power_of_two());
        let mut peak = Peak::default();
        for number in 0..2 * max {
            let half = number % 2;
            if counts[half] == 0 {
                continue;
            }
            self.add(span, reference, half, number / 2)?;
            if half == 0 && counts[1] > 0 && frames <= FRAMES_LONG {
                continue;
            }
            let bin = self.highest(band);
            peak = self.peak_at(bin);
            let comb = Comb::new(peak.cycles, 1, span.frames);
            if self.deviate(self.at(bin), self.noise(&comb)) > Z_CLEAR {
                break;
            }
        }
        Ok(peak)
    }

    /// Adds the power of one more mixture.
    fn add(
        &mut self,
        span: &mut FrameSpan,
        reference: &Reference,
        half: usize,
        number: usize,
    ) -> Result<(), Overwritten> {
        let Grid {
            points,
            pieces,
            each,
            ..
        } = self.grid;
        let Some(signal) = self.points.as_flattened_mut().get_mut(..points) else {
            return Ok(());
        };
        let mixture = Mixture::new(reference, half, number);
        mixture.fill(span, reference, each, signal)?;
        straighten(signal.get_mut(..pieces).unwrap_or_default());
        transform(signal);
        let bins = signal.as_chunks::<2>().0;
        for (power, [re, im]) in self.power.iter_mut().zip(bins).skip(1) {
            *power += re * re + im * im;
        }
        self.mixtures += 1;
        Ok(())
    }

    fn bins(&self) -> &[f32] {
        self.power.get(..self.grid.points / 2).unwrap_or_default()
    }

    fn at(&self, bin: usize) -> f32 {
        self.bins().get(bin).copied().unwrap_or_default()
    }

    /// Deviate of a bin's power over the noise.
    fn deviate(&self, power: f32, noise: f32) -> f32 {
        let samples = 2.0 * self.mixtures as f32;
        let ratio = power / noise.max(f32::MIN_POSITIVE);
        deviate(ratio, samples, samples * self.bins().len() as f32)
    }

    /// The highest bin of a band.
    fn highest(&self, band: Band) -> usize {
        let (bins, step) = (self.bins(), self.grid.step);
        let first = ((band.min.max(CYCLES_MIN) / step) as usize).max(1);
        let last = match band.max > 0.0 {
            true => (band.max / step) as usize + 1,
            false => bins.len(),
        };
        let mut best = (0, 0.0);
        let looked = bins.iter().enumerate();
        for (bin, power) in looked.take(last.saturating_add(1)).skip(first) {
            if *power > best.1 {
                best = (bin, *power);
            }
        }
        best.0
    }

    /// Refines the frequency of a line from its highest bin.
    fn peak_at(&self, bin: usize) -> Peak {
        let step = self.grid.step;
        let (before, after) = (self.at(bin.saturating_sub(1)), self.at(bin + 1));
        Peak {
            cycles: step * bin as f32 + offset(before, after, step),
            is_searched: true,
        }
    }

    /// Mean power of the bins away from zero and from a comb's lines.
    fn noise(&self, comb: &Comb) -> f32 {
        let all = self.mean(comb, f32::INFINITY);
        if comb.lines == 1 {
            return all;
        }
        // In a short window, lines of a different comb may fill the spectrum: leave out high bins.
        let below = 1.0 + NOISE_ABOVE / self.mixtures as f32;
        below * self.mean(comb, NOISE_MAX * all)
    }

    /// Mean of the bins' powers up to `max`, away from zero and from a comb's lines.
    fn mean(&self, comb: &Comb, max: f32) -> f32 {
        let step = self.grid.step;
        let (mut sum, mut count) = (0.0, 0.0f32);
        let bins = self.bins().iter().enumerate();
        for (bin, power) in bins.skip((LOBE / step) as usize) {
            if *power <= max && comb.distance(bin as f32 * step) > LOBE {
                sum += power;
                count += 1.0;
            }
        }
        sum / count.max(1.0)
    }

    /// Higher power of the two bins around a frequency.
    fn near(&self, cycles: f32) -> f32 {
        let bin = (cycles / self.grid.step) as usize;
        self.at(bin).max(self.at(bin + 1))
    }

    /// True if a line of `comb` other than the multiples of `part` may stand out of the noise, or
    /// is too near to a line of `peak` to tell.
    #[inline(never)]
    pub fn may_have(&self, comb: &Comb, peak: &Comb, part: usize) -> bool {
        let noise = self.noise(peak);
        let own = comb.lines().iter().enumerate();
        let mut own = own.filter(|(i, _)| !(i + 1).is_multiple_of(part));
        own.any(|(_, line)| {
            // If main lobes touch, no bin between them shows the noise.
            peak.distance(*line) < 2.0 * LOBE || self.deviate(self.near(*line), noise) > Z_LINE
        })
    }

    /// Another tone outside the main lobes of a comb's lines, if it stands out of the noise and of
    /// the lines' side lobes. `missing` is the fraction of missing frames.
    #[inline(never)]
    pub fn second(&self, comb: &Comb, missing: f32) -> Option<Second> {
        let step = self.grid.step;
        let noise = self.noise(comb).max(f32::MIN_POSITIVE);
        // Missing frames add side lobes, which are at most this high.
        let floor = 4.0 * missing * missing;
        let first = (SECOND_CYCLES_MIN / step) as usize + 1;
        let mut best = Second {
            cycles: 0.0,
            power: noise,
        };
        for (bin, power) in self.bins().iter().enumerate().skip(first) {
            let x = bin as f32 * step;
            if *power <= best.power || comb.distance(x) <= LOBE {
                continue;
            }
            let mut own = 0.0;
            for line in comb.lines() {
                // The line, its negative frequency, and the level and slope that were subtracted; a
                // factor of two in amplitude for interference with the noise.
                let lobes = [lobe(x - line), lobe(x + line), lobe(x) / line];
                let lobes: f32 = lobes.iter().map(|lobe| lobe * lobe).sum();
                own += 4.0 * self.near(*line) * (lobes + floor);
            }
            if power - own > best.power {
                (best.cycles, best.power) = (x, power - own);
            }
        }
        let is_clear = self.deviate(best.power, noise) > Z_SECOND;
        is_clear.then(|| Second {
            power: best.power / self.near(comb.at[0]).max(noise),
            ..best
        })
    }
}

/// Envelope of a Hann window's side lobes, over its peak, at a distance in cycles.
fn lobe(distance: f32) -> f32 {
    1.0 / (PI * distance * (distance * distance - 1.0))
}

/// Distance of a Hann window's peak from the highest bin, cycles, from the powers of the adjacent
/// bins.
fn offset(before: f32, after: f32, step: f32) -> f32 {
    // The logarithm of the main lobe is nearly a quadratic plus a quartic term.
    const SQUARE: f32 = PI * PI / 6.0 - 1.0;
    const QUARTIC: f32 = PI * PI * PI * PI / 180.0 - 0.5;
    if before <= 0.0 || after <= 0.0 {
        return 0.0;
    }
    let difference = 0.5 * libm::logf(after / before);
    let linear = 4.0 * SQUARE * step + 8.0 * QUARTIC * step * step * step;
    let max = 0.5 * step;
    let mut x = 0.0;
    for _ in 0..3 {
        // The adjacent bins are at `step - x` and `step + x` from the peak.
        let lobe = |distance: f32| {
            let (_, sine) = cos_sin(from_turns(0.5 * distance));
            sine / (distance * (1.0 - distance * distance))
        };
        let at = match x == 0.0 {
            true => 0.0,
            false => libm::logf(f32::abs(lobe(step - x) / lobe(step + x))),
        };
        x = (x + (difference - at) / linear).max(-max).min(max);
    }
    x
}

/// Subtracts level and slope from a signal, and applies a Hann window.
#[inline(never)]
fn straighten(signal: &mut [f32]) {
    let count = signal.len() as f32;
    let step = 2.0 / count;
    let start = 0.5 * step - 1.0;
    let (mut sum, mut double) = (0.0, 0.0);
    for value in &*signal {
        sum += value;
        double += sum;
    }
    // `double`, the sum of running sums, weights value i by `count` - i: this is the first moment.
    let moment = start * sum + step * (count * sum - double);
    let (level, slope) = (sum / count, 3.0 * moment / count);
    let (cos, sin) = cos_sin(from_turns(1.0 / count));
    let (mut c, mut s) = cos_sin(from_turns(0.5 / count));
    let (mut line, step) = (level + slope * start, slope * step);
    for value in signal {
        *value = (1.0 - c) * (*value - line);
        (c, s) = (c * cos - s * sin, s * cos + c * sin);
        line += step;
    }
}
