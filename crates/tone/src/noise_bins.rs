//! Noise bins: cosine and sine functions a few cycles per window to either side of each line, with
//! the model projected out, and their products with the residuals.
//!
//! The bins are whole cycles apart, so they are nearly orthogonal.

use crate::blocks::Blocks;
use crate::covariance::{add_product, power};
use crate::limits::{CHANNELS_MAX, DEGREE_MAX, HARMONICS_MAX, NOISE_BINS_MAX, UNKNOWNS_MAX};
use crate::lines::Lines;
use crate::matrix::Square;
use crate::nyquist::Nyquist;
use crate::phase::{Wave, cos_sin, from_turns};
use crate::significance::{Sum, deviate};
use crate::solve::ProjectedModel;
use crate::source::Values;
use crate::totals::WAVES;

/// Distance from a line below which a function may be a second tone, cycles per window.
const NEAR_CYCLES: f32 = 1.5;
/// Minimum distance between noise bins of different lines, cycles per window.
pub const APART: f32 = 0.85;
/// Minimum fraction of a function's power that the model does not explain.
const LEFT_MIN: f32 = 0.25;
/// Minimum fraction of a tested line's power that the model does not explain.
const LEFT_LINE: f32 = 0.16;

/// One function of a noise bin: its cosine or its sine.
#[derive(Clone, Copy, Debug)]
pub struct Member {
    pub line: u8,
    /// Offset from the line, cycles per window.
    offset: i8,
    /// Power over the noise, all channels together.
    pub power: f32,
}

impl Member {
    const NONE: Self = Self {
        line: 0,
        offset: 0,
        power: 0.0,
    };

    /// True for the cosine and the sine of one noise bin.
    fn is_with(&self, other: &Self) -> bool {
        (self.line, self.offset) == (other.line, other.offset)
    }

    pub fn is_above(&self) -> bool {
        self.offset > 0
    }
}

/// Frequencies of the lines, cycles per window.
#[derive(Clone, Copy, Debug)]
pub struct LineFrequencies {
    pub lines: Lines,
    /// Frequency of the unit line.
    pub cycles: f32,
    pub nyquist: Nyquist,
    /// Half-width of the noise band around a line, cycles per window.
    pub band: usize,
}

/// Noise bins, scaled to unit variance in white noise.
#[derive(Debug)]
pub struct NoiseBins {
    members: [Member; NOISE_BINS_MAX],
    count: usize,
    place: LineFrequencies,
    /// Power of the functions near the lines, in units of the residuals' variances.
    pub nearest: f32,
}

/// Products of a wave and a rotation: cosine with cosine, sine with sine, sine with cosine, cosine
/// with sine.
type Turned = [f32; 4];

fn turned([c, s]: Wave, [cos, sin]: Wave) -> Turned {
    [c * cos, s * sin, s * cos, c * sin]
}

/// Returns the wave rotated forwards or backwards, from its products.
fn wave([cc, ss, sc, cs]: Turned, is_forwards: bool) -> Wave {
    if is_forwards {
        [cc - ss, sc + cs]
    } else {
        [cc + ss, sc - cs]
    }
}

/// Sums over the blocks of waves shifted by some cycles per window.
struct Sums {
    /// Cosine and sine of the shift in each block.
    turns: [Wave; crate::limits::BLOCKS_MAX],
    /// Products of each multiple of the phase with the shift.
    multiples: [Turned; WAVES],
}

impl Sums {
    fn new(blocks: &Blocks, cycles: usize, max: usize) -> Self {
        let mut sums = Self {
            turns: [[1.0, 0.0]; crate::limits::BLOCKS_MAX],
            multiples: [[0.0; 4]; WAVES],
        };
        for (b, turn) in sums.turns.iter_mut().enumerate().take(blocks.count()) {
            let (cos, sin) = cos_sin(from_turns(0.5 * cycles as f32 * blocks.middle(b)));
            *turn = [cos, sin];
            for (m, sum) in sums.multiples.iter_mut().enumerate().take(max + 1) {
                let products = turned(blocks.wave(b, m), [cos, sin]);
                sum.iter_mut().zip(products).for_each(|(sum, x)| *sum += x);
            }
        }
        sums
    }

    /// Sum of a multiple of the phase; negative multiples are conjugates.
    fn multiple(&self, multiple: isize, is_forwards: bool) -> Wave {
        let products = self.multiples[multiple.unsigned_abs() % WAVES];
        if multiple < 0 {
            let [cos, sin] = wave(products, !is_forwards);
            [cos, -sin]
        } else {
            wave(products, is_forwards)
        }
    }
}

/// A line, shifted by some cycles per window.
struct TurnedLine<'l> {
    blocks: &'l Blocks,
    model: ProjectedModel<'l>,
    sums: &'l Sums,
    number: usize,
    /// Products with the baselines.
    baselines: [Turned; DEGREE_MAX + 1],
    values: [Values; 4],
    /// Energy of the cosine, shifted forwards and backwards; that of the sine is `frames` less
    /// this.
    squares: [f32; 2],
    frames: f32,
}

impl<'l> TurnedLine<'l> {
    fn new(blocks: &'l Blocks, model: ProjectedModel<'l>, sums: &'l Sums, number: usize) -> Self {
        let mut baselines = [[0.0; 4]; DEGREE_MAX + 1];
        let (mut frames, mut even, mut odd) = (0.0, 0.0, 0.0);
        for (b, turn) in sums.turns.iter().enumerate().take(blocks.count()) {
            let with_baselines = blocks.with_baselines(b, number);
            let pairs = baselines.iter_mut().zip(with_baselines);
            for (sums, wave) in pairs.take(model.shape.degree + 1) {
                let products = turned(wave, *turn);
                sums.iter_mut().zip(products).for_each(|(sum, x)| *sum += x);
            }
            let ([c, s], [cos, sin]) = (blocks.wave(b, 2 * number), *turn);
            even += c * (cos * cos - sin * sin);
            odd += 2.0 * s * cos * sin;
            frames += blocks.wave(b, 0)[0];
        }
        let mut values = [[0.0; CHANNELS_MAX]; 4];
        for g in 0..blocks.groups().min(CHANNELS_MAX / 4) {
            // Keep a group's sums in registers.
            let mut own = [[0.0; 4]; 4];
            for (pair, [cos, sin]) in blocks.pairs(number).zip(&sums.turns) {
                let [c, s] = pair.each_ref().map(|row| &row.as_chunks::<4>().0[g]);
                for k in 0..4 {
                    own[0][k] += cos * c[k];
                    own[1][k] += sin * s[k];
                    own[2][k] += cos * s[k];
                    own[3][k] += sin * c[k];
                }
            }
            for (values, own) in values.iter_mut().zip(own) {
                values.as_chunks_mut::<4>().0[g] = own;
            }
        }
        Self {
            blocks,
            model,
            sums,
            number,
            baselines,
            values,
            squares: [0.5 * (frames + even - odd), 0.5 * (frames + even + odd)],
            frames,
        }
    }

    /// Products of the cosine or the sine with the channels, scaled to unit variance after
    /// projecting out the model. `None` if the model explains too much of the function.
    fn values(&self, is_forwards: bool, is_sine: bool, min: f32) -> Option<Values> {
        let ProjectedModel {
            shape,
            factor,
            projections,
        } = self.model;
        let first = shape.first_line();
        let mut explained = [0.0; UNKNOWNS_MAX];
        for (explained, baseline) in explained.iter_mut().zip(&self.baselines).take(first) {
            *explained = wave(*baseline, is_forwards)[usize::from(is_sine)];
        }
        let lines = explained.get_mut(first..).unwrap_or_default();
        let pairs = lines.as_chunks_mut::<2>().0.iter_mut();
        for (pair, line) in pairs.zip(shape.lines.iter()) {
            let (number, line) = (self.number as isize, line as isize);
            let difference = self.sums.multiple(number - line, is_forwards);
            let sum = self.sums.multiple(number + line, is_forwards);
            *pair = if is_sine {
                [
                    0.5 * (sum[1] + difference[1]),
                    0.5 * (difference[0] - sum[0]),
                ]
            } else {
                [
                    0.5 * (difference[0] + sum[0]),
                    0.5 * (sum[1] - difference[1]),
                ]
            };
        }
        factor.forward(&mut explained);
        let square = self.squares[usize::from(!is_forwards)];
        let all = if is_sine {
            self.frames - square
        } else {
            square
        };
        let left = all - explained.iter().map(|x| x * x).sum::<f32>();
        if left <= min * all.max(f32::MIN_POSITIVE) {
            return None;
        }
        let scale = 1.0 / crate::sqrt(left);
        let mut values = [0.0; CHANNELS_MAX];
        for k in 0..(4 * self.blocks.groups()).min(CHANNELS_MAX) {
            let [cc, ss, sc, cs] = self.values.each_ref().map(|values| values[k]);
            values[k] = scale * wave([cc, ss, sc, cs], is_forwards)[usize::from(is_sine)];
        }
        if let Some(projections) = projections {
            explained.iter_mut().for_each(|x| *x *= scale);
            let groups = values.as_chunks_mut::<4>().0.iter_mut().enumerate();
            for (g, values) in groups.take(self.blocks.groups()) {
                let [mut a, mut b, mut c, mut d] = *values;
                let rows = explained.iter().zip(projections).take(shape.unknowns());
                for (weight, row) in rows {
                    let Some(row) = row.as_chunks::<4>().0.get(g) else {
                        break;
                    };
                    a -= weight * row[0];
                    b -= weight * row[1];
                    c -= weight * row[2];
                    d -= weight * row[3];
                }
                *values = [a, b, c, d];
            }
        }
        Some(values)
    }
}

impl NoiseBins {
    pub const fn new() -> Self {
        Self {
            members: [Member::NONE; NOISE_BINS_MAX],
            count: 0,
            place: LineFrequencies {
                lines: Lines::NONE,
                cycles: 0.0,
                nyquist: Nyquist::NONE,
                band: 0,
            },
            nearest: 0.0,
        }
    }

    /// Collects the noise bins of lines after projecting out a model. Their products with the
    /// residuals go into rows of `memory`.
    #[inline(never)]
    pub fn collect(
        &mut self,
        blocks: &Blocks,
        model: ProjectedModel,
        place: LineFrequencies,
        memory: &mut [Values],
    ) {
        let lines = place.lines;
        (self.count, self.place) = (0, place);
        let max = lines.max() + model.shape.lines.max();
        for cycles in 1..=place.band {
            let sums = Sums::new(blocks, cycles, max);
            for number in lines.iter() {
                let at = number as f32 * place.cycles;
                let is_wanted = |x: f32| {
                    let seen = place.nyquist.seen(x);
                    place.nyquist.is_clear(x)
                        && self.members().iter().all(|other| {
                            usize::from(other.line) == number
                                || (self.seen(other) - seen).abs() > APART
                        })
                };
                let wanted = [at + cycles as f32, at - cycles as f32].map(|x| (x, is_wanted(x)));
                if !wanted.iter().any(|(_, is_wanted)| *is_wanted) {
                    continue;
                }
                let line = TurnedLine::new(blocks, model, &sums, number);
                for (i, (_, is_wanted)) in wanted.into_iter().enumerate() {
                    let offset = cycles as i8;
                    let member = Member {
                        line: number as u8,
                        offset: if i == 0 { offset } else { -offset },
                        ..Member::NONE
                    };
                    for is_sine in [false, true] {
                        let values = if is_wanted && self.count < NOISE_BINS_MAX {
                            line.values(i == 0, is_sine, LEFT_MIN)
                        } else {
                            None
                        };
                        if let (Some(values), Some(row)) = (values, memory.get_mut(self.count)) {
                            self.members[self.count] = member;
                            *row = values;
                            self.count += 1;
                        }
                    }
                }
            }
        }
    }

    pub fn clear(&mut self) {
        (self.count, self.nearest) = (0, 0.0);
    }

    /// Number of functions.
    pub fn count(&self) -> usize {
        self.count
    }

    /// Apparent frequency of a function, cycles per window.
    fn seen(&self, member: &Member) -> f32 {
        let cycles = f32::from(member.line) * self.place.cycles + f32::from(member.offset);
        self.place.nyquist.seen(cycles)
    }

    /// Distance of a function from the nearest line, cycles per window.
    pub fn distance(&self, member: &Member) -> f32 {
        let (place, x) = (&self.place, self.seen(member));
        let lines = place.lines.iter();
        lines
            .map(|line| (x - place.nyquist.seen(line as f32 * place.cycles)).abs())
            .fold(f32::INFINITY, f32::min)
    }

    /// True if a function is near enough to a line to be a second tone.
    pub fn is_near(&self, member: &Member) -> bool {
        self.distance(member) < NEAR_CYCLES
    }

    /// Normal deviate of the power near the lines over the power further away, for `channels`
    /// independent channels; zero if there is nothing to compare.
    pub fn near_over_far(&self, channels: f32) -> f32 {
        let [mut near, mut far] = [Sum::default(); 2];
        for member in self.members() {
            let sum = if self.is_near(member) {
                &mut near
            } else {
                &mut far
            };
            sum.add(member.power);
        }
        if near.count == 0.0 || far.count == 0.0 {
            return 0.0;
        }
        let over = near.mean() / far.mean().max(f32::MIN_POSITIVE);
        deviate(over, near.count * channels, far.count * channels)
    }

    pub fn members(&self) -> &[Member] {
        self.members.get(..self.count).unwrap_or_default()
    }

    /// Sums the products of the channels over the functions, each with its weight.
    pub fn products(
        &self,
        memory: &[Values],
        weight: &dyn Fn(&Member) -> f32,
        products: &mut Square<CHANNELS_MAX>,
    ) {
        *products = [[0.0; CHANNELS_MAX]; CHANNELS_MAX];
        for (member, values) in self.members().iter().zip(memory) {
            add_product(products, weight(member), values);
        }
    }

    /// Frequency of the strongest function near a line, cycles per window.
    pub fn strongest_near(&self) -> f32 {
        let near = self.members().iter().filter(|member| self.is_near(member));
        let strongest = near.max_by(|a, b| a.power.total_cmp(&b.power));
        strongest.map_or(0.0, |member| self.seen(member))
    }

    /// Measures the power of each function relative to the noise covariance, and of those near the
    /// lines relative to the residuals' variances.
    pub fn measure(
        &mut self,
        memory: &[Values],
        weights: &Square<CHANNELS_MAX>,
        variances: &Values,
    ) {
        let members = self.members.iter_mut().zip(memory).take(self.count);
        members.for_each(|(member, values)| member.power = power(values, weights));
        let near = self.members().iter().zip(memory);
        let near = near.filter(|(member, _)| self.is_near(member));
        let powers = near.map(|(_, values)| {
            let powers = values.iter().zip(variances).map(|(x, v)| x * x / v);
            powers.sum::<f32>()
        });
        self.nearest = powers.sum();
    }

    /// Power of the loudest noise bin next to each line, by the line's number: cosine and sine in
    /// all channels, over the variance of each channel's noise.
    pub fn loudest(&self, memory: &[Values], variances: &Values) -> [f32; HARMONICS_MAX + 1] {
        let mut loudest = [0.0f32; HARMONICS_MAX + 1];
        let power = |values: &Values| {
            let powers = values.iter().zip(variances).filter(|(_, v)| **v > 0.0);
            powers.map(|(x, v)| x * x / v).sum::<f32>()
        };
        let pairs = self.members().windows(2).zip(memory.windows(2));
        for (pair, values) in pairs {
            if let ([cos, sin], [x, y]) = (pair, values)
                && cos.is_with(sin)
                && let Some(loudest) = loudest.get_mut(usize::from(cos.line))
            {
                *loudest = loudest.max(power(x) + power(y));
            }
        }
        loudest
    }

    /// Noise bins next to a line, each with the power of cosine and sine together.
    pub fn places(&self, line: usize) -> impl Iterator<Item = Member> {
        let pairs = self.members().windows(2);
        pairs.filter_map(move |pair| match pair {
            [cos, sin] if cos.is_with(sin) && usize::from(cos.line) == line => {
                let power = cos.power + sin.power;
                Some(Member { power, ..*cos })
            }
            _ => None,
        })
    }
}

/// Products of a line's cosine and sine with the channels, scaled to unit variance after projecting
/// out a model. `None` if the model explains too much of either.
pub fn line(blocks: &Blocks, model: ProjectedModel, number: usize) -> Option<[Values; 2]> {
    let sums = Sums::new(blocks, 0, number + model.shape.lines.max());
    let line = TurnedLine::new(blocks, model, &sums, number);
    Some([
        line.values(true, false, LEFT_LINE)?,
        line.values(true, true, LEFT_LINE)?,
    ])
}
