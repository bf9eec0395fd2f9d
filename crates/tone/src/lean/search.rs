//! Frequency of the tone from transforms of mixtures of channels.
//!
//! A mixture is the sum of up to eight channels over their scales, with signs. Mixtures are added
//! until the highest peak of their summed power is clear, so that a loud tone costs two transforms
//! and a faint one has the evidence of all channels.

use super::blocks::Blocks;
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
/// Channels of a mixture.
const MIXED: usize = CHANNELS_MAX / 2;
/// Most mixtures of each half of the channels.
const MIXTURES: usize = 4;
/// Deviate of a peak that is clear.
const Z_CLEAR: f32 = 7.0;
/// Deviate of a second peak: one of 100,000 is above, one of a thousand windows.
const Z_SECOND: f32 = 4.3;
/// Fewest cycles of a peak.
const CYCLES_MIN: f32 = 0.7;
/// Half of the main lobe of a Hann window, and some more, cycles.
const LOBE: f32 = 2.6;
/// Fewest cycles of a second peak: a level that is not straight is found by the blocks.
const SECOND_CYCLES_MIN: f32 = 2.0;

/// Summed power of some mixtures of channels.
pub struct Search<'m> {
    /// Signals that are transformed.
    points: &'m mut [f32],
    /// Power of each bin.
    power: &'m mut [f32],
    grid: Grid,
    /// Mixtures whose power was summed.
    mixtures: usize,
}

/// Bins of a transform.
#[derive(Clone, Copy, Debug, Default)]
struct Grid {
    points: usize,
    /// Frames of a point.
    each: usize,
    /// Points that frames fill.
    pieces: usize,
    /// Cycles a window from one bin to the next.
    step: f32,
}

/// Where the tone may be.
#[derive(Clone, Copy, Debug, Default)]
pub struct Peak {
    /// Cycles a window.
    pub cycles: f32,
    /// False if the frequency is that of the window before.
    pub is_searched: bool,
    /// Power over the noise of a bin.
    height: f32,
}

impl Peak {
    /// The frequency of the window before.
    pub const fn expected(cycles: f32) -> Self {
        Self {
            cycles,
            is_searched: false,
            height: 0.0,
        }
    }
}

/// Another tone of the window.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Second {
    /// Cycles a window.
    pub cycles: f32,
    /// Power over that of the reported tone.
    pub power: f32,
}

/// A sum of a half of the channels, with weights.
#[derive(Clone, Copy)]
struct Mixture {
    half: usize,
    weights: [f32; MIXED],
    level: [f32; MIXED],
}

impl Mixture {
    /// Mixture `number` of a half of the channels: signs are a row of a Hadamard matrix, the
    /// alternating ones first, so that channels in phase do not stand out at once.
    fn new(reference: &Reference, half: usize, number: usize) -> Self {
        let part = |values: &Values| values.as_chunks::<MIXED>().0[half % 2];
        let (mut weights, level) = (part(&reference.inverse), part(&reference.level));
        for (k, weight) in weights.iter_mut().enumerate() {
            if (k & (number + 1)).count_ones() % 2 == 1 {
                *weight = -*weight;
            }
        }
        Self {
            half,
            weights,
            level,
        }
    }

    #[inline(always)]
    fn value(&self, values: &Values) -> f32 {
        let values = &values.as_chunks::<MIXED>().0[self.half % 2];
        let mut sums = [0.0; 2];
        for k in 0..MIXED {
            sums[k % 2] += self.weights[k] * (values[k] - self.level[k]);
        }
        sums[0] + sums[1]
    }
}

impl<'m> Search<'m> {
    /// A search in memory for [`POINTS_MAX`] points at least, and for half as many bins.
    pub fn new(points: &'m mut [f32], power: &'m mut [f32]) -> Self {
        Self {
            points,
            power,
            grid: Grid::default(),
            mixtures: 0,
        }
    }

    /// The highest peak in a band of cycles a window.
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
        let halves = reference.inverse.as_chunks::<MIXED>().0;
        let widest = halves
            .iter()
            .map(|half| half.iter().filter(|x| **x > 0.0).count())
            .max()
            .unwrap_or_default();
        let mut peak = Peak::default();
        for number in 0..MIXTURES.min(widest.next_power_of_two()) {
            self.add(span, reference, number)?;
            peak = self.highest(band);
            let samples = 2.0 * self.mixtures as f32;
            if deviate(peak.height, samples, samples * bins as f32) > Z_CLEAR {
                break;
            }
        }
        Ok(peak)
    }

    /// Adds the power of one more mixture of each half of the channels.
    fn add(
        &mut self,
        span: &mut FrameSpan,
        reference: &Reference,
        number: usize,
    ) -> Result<(), Overwritten> {
        let Grid { points, pieces, .. } = self.grid;
        let halves = reference.inverse.as_chunks::<MIXED>().0;
        let used = [0, 1].map(|half| halves[half].iter().any(|inverse| *inverse > 0.0));
        let both = used[0] && used[1] && 2 * points <= self.points.len();
        if both && let Some((first, second)) = self.points.split_at_mut_checked(points) {
            let signals = [first, second.get_mut(..points).unwrap_or_default()];
            mix_both(span, reference, &self.grid, number, signals)?;
        }
        for half in 0..2 {
            if !used[half] {
                continue;
            }
            let from = if both { half * points } else { 0 };
            let Some(signal) = self.points.get_mut(from..from + points) else {
                continue;
            };
            if !both {
                let mixture = Mixture::new(reference, half, number);
                mix_half(span, reference, &self.grid, &mixture, signal)?;
            }
            straighten(signal, pieces);
            transform(signal);
            let bins = signal.as_chunks::<2>().0;
            for (power, [re, im]) in self.power.iter_mut().zip(bins).skip(1) {
                *power += re * re + im * im;
            }
            self.mixtures += 1;
        }
        Ok(())
    }

    /// The highest bin of a band, and where its line is.
    fn highest(&self, band: Band) -> Peak {
        let Grid { points, step, .. } = self.grid;
        let bins = self.power.get(..points / 2).unwrap_or_default();
        let first = ((band.least.max(CYCLES_MIN) / step) as usize).max(1);
        let last = match band.most > 0.0 {
            true => (band.most / step) as usize + 1,
            false => bins.len(),
        };
        let mut best = (0, 0.0);
        let looked = bins
            .iter()
            .enumerate()
            .take(last.saturating_add(1))
            .skip(first);
        for (bin, power) in looked {
            if *power > best.1 {
                best = (bin, *power);
            }
        }
        let at = |bin: usize| bins.get(bin).copied().unwrap_or_default();
        let cycles =
            step * best.0 as f32 + offset(at(best.0.saturating_sub(1)), at(best.0 + 1), step);
        let noise = self.noise(cycles);
        Peak {
            cycles,
            is_searched: true,
            height: best.1 / noise.max(f32::MIN_POSITIVE),
        }
    }

    /// Mean power of the bins that are not next to a line, nor next to zero.
    fn noise(&self, cycles: f32) -> f32 {
        let Grid { points, step, .. } = self.grid;
        let (mut sum, mut count) = (0.0, 0.0f32);
        let bins = self.power.get(..points / 2).unwrap_or_default();
        for (bin, power) in bins.iter().enumerate().skip((LOBE / step) as usize) {
            if f32::abs(bin as f32 * step - cycles) > LOBE {
                sum += power;
                count += 1.0;
            }
        }
        sum / count.max(1.0)
    }

    /// Another tone outside the main lobe of the one at `cycles`, if it stands out of the noise and
    /// of that tone's own side lobes. None if nothing was searched.
    #[inline(never)]
    pub fn second(
        &self,
        span: &FrameSpan,
        peak: &Peak,
        cycles: f32,
        blocks: &Blocks,
    ) -> Option<Second> {
        if !peak.is_searched {
            return None;
        }
        let Grid { points, step, .. } = self.grid;
        let noise = self.noise(cycles).max(f32::MIN_POSITIVE);
        // Missing frames are a window of their own, whose side lobes are at most this high.
        let missing = 2.0 * (1.0 - blocks.frames() / span.frames.max(1) as f32);
        let floor = missing * missing;
        let bins = self.power.get(..points / 2).unwrap_or_default();
        let first = (SECOND_CYCLES_MIN / step) as usize + 1;
        let mut best = Second::default();
        for (bin, power) in bins.iter().enumerate().skip(first) {
            let distance = f32::abs(bin as f32 * step - cycles);
            if distance <= LOBE {
                continue;
            }
            let x = bin as f32 * step;
            // The tone's line, its negative frequency, and the level and slope that were taken out
            // of it; a factor of two in amplitude for interference with the noise.
            let lobes = [lobe(distance), lobe(x + cycles), lobe(x) / cycles];
            let lobes: f32 = lobes.iter().map(|lobe| lobe * lobe).sum();
            let own = 4.0 * peak.height * noise * (lobes + floor);
            let left = power - own;
            if left > best.power {
                best = Second {
                    cycles: bin as f32 * step,
                    power: left,
                };
            }
        }
        let samples = 2.0 * self.mixtures as f32;
        let is_clear = deviate(best.power / noise, samples, samples * bins.len() as f32) > Z_SECOND;
        is_clear.then(|| Second {
            power: best.power / (peak.height * noise),
            ..best
        })
    }
}

/// Envelope of a Hann window's side lobes, over its peak, at a distance in cycles.
fn lobe(distance: f32) -> f32 {
    1.0 / (PI * distance * (distance * distance - 1.0))
}

/// Distance in cycles of a Hann window's peak from the highest bin, by the powers of the bins before
/// and after it: the logarithm of the main lobe is a quadratic and a quartic term.
fn offset(before: f32, after: f32, step: f32) -> f32 {
    const SQUARE: f32 = PI * PI / 6.0 - 1.0;
    const QUARTIC: f32 = PI * PI * PI * PI / 180.0 - 0.5;
    if before <= 0.0 || after <= 0.0 {
        return 0.0;
    }
    let difference = 0.5 * libm::logf(after / before);
    let linear = 4.0 * SQUARE * step + 8.0 * QUARTIC * step * step * step;
    let mut x = difference / linear;
    x = (difference - 8.0 * QUARTIC * step * x * x * x) / linear;
    x.max(-0.5 * step).min(0.5 * step)
}

/// Mixes both halves of the channels in one pass.
#[inline(never)]
fn mix_both(
    span: &mut FrameSpan,
    reference: &Reference,
    grid: &Grid,
    number: usize,
    signals: [&mut [f32]; 2],
) -> Result<(), Overwritten> {
    let mixtures = [0, 1].map(|half| Mixture::new(reference, half, number));
    let [first, second] = signals;
    first.fill(0.0);
    second.fill(0.0);
    let mut memory = [0.0; CHANNELS_MAX];
    span.visit(reference.wanted, &mut |frame, values| {
        let values = reference.clean(values, &mut memory);
        let point = frame as usize / grid.each.max(1);
        if let (Some(a), Some(b)) = (first.get_mut(point), second.get_mut(point)) {
            *a += mixtures[0].value(values);
            *b += mixtures[1].value(values);
        }
    })
}

/// Mixes a half of the channels.
#[inline(never)]
fn mix_half(
    span: &mut FrameSpan,
    reference: &Reference,
    grid: &Grid,
    mixture: &Mixture,
    signal: &mut [f32],
) -> Result<(), Overwritten> {
    signal.fill(0.0);
    let mut memory = [0.0; CHANNELS_MAX];
    span.visit(reference.wanted, &mut |frame, values| {
        let values = reference.clean(values, &mut memory);
        if let Some(place) = signal.get_mut(frame as usize / grid.each.max(1)) {
            *place += mixture.value(values);
        }
    })
}

/// Takes level and slope out of the first `pieces` points, and weighs them with a Hann window.
#[inline(never)]
fn straighten(signal: &mut [f32], pieces: usize) {
    let signal = signal.get_mut(..pieces).unwrap_or_default();
    let count = pieces as f32;
    let step = 2.0 / count;
    let start = 0.5 * step - 1.0;
    let (mut sum, mut moment, mut u) = (0.0, 0.0, start);
    for value in &*signal {
        sum += value;
        moment += u * value;
        u += step;
    }
    let (level, slope) = (sum / count, 3.0 * moment / count);
    let (cos, sin) = cos_sin(from_turns(1.0 / count));
    let (mut c, mut s) = cos_sin(from_turns(0.5 / count));
    u = start;
    for value in signal {
        *value = (1.0 - c) * (*value - level - slope * u);
        (c, s) = (c * cos - s * sin, s * cos + c * sin);
        u += step;
    }
}
