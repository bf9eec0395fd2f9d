//! The noise next to the lines: orthonormal functions a few cycles a window to either side of each
//! line, beside the model, and their products with the residuals.

use crate::blocks::{Blocks, WAVES, Wave};
use crate::limits::{CHANNELS_MAX, HARMONICS_MAX, NEIGHBOURS_MAX, UNKNOWNS_MAX};
use crate::lines::Lines;
use crate::matrix::{Factor, Square};
use crate::phase::{cos_sin, from_turns};
use crate::solve::{Shape, Solution};
use crate::source::Values;

/// Cycles a window on either side of a line that count as next to it.
const BAND: i8 = 4;
/// Distances between two functions of a line's neighbourhood.
const DISTANCES: usize = 4 * BAND as usize + 1;
/// Functions next to different lines are as far apart, cycles a window.
const APART: f32 = 0.7;
/// A function must have as much of its power beside the model and the others.
const LEFT_MIN: f32 = 0.25;
/// Least share of the power of a tested line beside the model and the others.
const LEFT_LINE: f32 = 0.16;

/// A function next to a line.
#[derive(Clone, Copy, Debug)]
pub struct Member {
    /// The line's number.
    pub line: u8,
    /// Cycles a window from it.
    pub offset: i8,
    /// A sine; else a cosine.
    pub is_sine: bool,
    /// Cycles a window from the nearest line.
    pub distance: f32,
}

impl Member {
    const NONE: Self = Self {
        line: 0,
        offset: 0,
        is_sine: false,
        distance: 0.0,
    };
}

/// Where lines are, cycles a window.
#[derive(Clone, Copy, Debug)]
pub struct Place {
    /// The unit line.
    pub cycles: f32,
    /// Half the frame rate.
    pub most: f32,
}

/// A model beside which functions are, by the factor of its normal equations.
#[derive(Clone, Copy, Debug)]
pub struct Beside<'b> {
    /// What is fitted.
    pub shape: &'b Shape,
    /// Factor of the normal equations.
    pub factor: &'b Factor<UNKNOWNS_MAX>,
}

/// Orthonormal functions next to the lines.
#[derive(Debug)]
pub struct Neighbours {
    members: [Member; NEIGHBOURS_MAX],
    /// Products with the residuals.
    values: [Values; NEIGHBOURS_MAX],
    /// Products with the model's orthonormal functions.
    explained: [[f32; UNKNOWNS_MAX]; NEIGHBOURS_MAX],
    /// Rows of the factor of their products with each other, one after the other.
    rows: [f32; NEIGHBOURS_MAX * (NEIGHBOURS_MAX + 1) / 2],
    count: usize,
}

/// Sums over the blocks of the multiples of the phase, turned by whole cycles a window.
struct Turned([[Wave; DISTANCES]; WAVES]);

impl Turned {
    fn new(blocks: &Blocks, most: usize) -> Self {
        let mut sums = [[[0.0; 2]; DISTANCES]; WAVES];
        for b in 0..blocks.count() {
            for (d, by) in powers(blocks.middle(b)).iter().enumerate() {
                for (m, sums) in sums.iter_mut().enumerate().take(most + 1) {
                    let [c, s] = blocks.wave(b, m as isize);
                    sums[d][0] += c * by[0] - s * by[1];
                    sums[d][1] += s * by[0] + c * by[1];
                }
            }
        }
        Self(sums)
    }

    fn at(&self, multiple: i8, offset: i8) -> Wave {
        let sign = if multiple < 0 { -1 } else { 1 };
        let place = (sign * offset + 2 * BAND) as usize;
        let [c, s] = self.0[multiple.unsigned_abs() as usize % WAVES][place % DISTANCES];
        [c, f32::from(sign) * s]
    }

    /// Product of two functions.
    fn product(&self, one: &Member, other: &Member) -> f32 {
        let (line, second) = (one.line as i8, other.line as i8);
        let difference = self.at(line - second, one.offset - other.offset);
        let sum = self.at(line + second, one.offset + other.offset);
        0.5 * match (one.is_sine, other.is_sine) {
            (false, false) => difference[0] + sum[0],
            (true, true) => difference[0] - sum[0],
            (true, false) => sum[1] + difference[1],
            (false, true) => sum[1] - difference[1],
        }
    }
}

/// Powers -2 BAND to 2 BAND of a cycle a window at `u`.
fn powers(u: f32) -> [Wave; DISTANCES] {
    core::array::from_fn(|d| turn(u, d as i8 - 2 * BAND))
}

/// Cosine and sine of `offset` cycles a window at `u`.
fn turn(u: f32, offset: i8) -> Wave {
    let (cos, sin) = cos_sin(from_turns(0.5 * f32::from(offset) * u));
    [cos, sin]
}

impl Neighbours {
    /// None; all zeros.
    pub const fn new() -> Self {
        Self {
            members: [Member::NONE; NEIGHBOURS_MAX],
            values: [[0.0; CHANNELS_MAX]; NEIGHBOURS_MAX],
            explained: [[0.0; UNKNOWNS_MAX]; NEIGHBOURS_MAX],
            rows: [0.0; NEIGHBOURS_MAX * (NEIGHBOURS_MAX + 1) / 2],
            count: 0,
        }
    }

    /// The functions next to `lines` beside a model of `shape`, whose normal equations have
    /// `factor`.
    #[inline(never)]
    pub fn collect(&mut self, blocks: &Blocks, model: Beside, lines: Lines, place: Place) {
        let shape = model.shape;
        let most = (lines.most() + shape.lines.most().max(lines.most())).min(WAVES - 1);
        let turned = Turned::new(blocks, most);
        let mut wanted = [Member::NONE; 2 * BAND as usize * HARMONICS_MAX];
        let mut count = 0;
        for line in lines.iter() {
            for offset in -BAND..=BAND {
                let at = |member: &Member| {
                    f32::from(member.line) * place.cycles + f32::from(member.offset)
                };
                let mut member = Member {
                    line: line as u8,
                    offset,
                    ..Member::NONE
                };
                let x = at(&member);
                let is_free = wanted[..count]
                    .iter()
                    .all(|other| (at(other) - x).abs() > APART);
                if offset == 0 || x <= 0.5 || x >= place.most - 0.5 || !is_free {
                    continue;
                }
                let distance = |line: usize| (x - line as f32 * place.cycles).abs();
                member.distance = lines.iter().map(distance).fold(f32::INFINITY, f32::min);
                // The nearest first.
                let mut i = count.min(wanted.len() - 1);
                while i > 0 && wanted[i - 1].distance > member.distance + 1e-4 {
                    wanted[i] = wanted[i - 1];
                    i -= 1;
                }
                wanted[i] = member;
                count = (count + 1).min(wanted.len());
            }
        }
        self.count = 0;
        for member in &wanted[..count] {
            for is_sine in [false, true] {
                let member = Member { is_sine, ..*member };
                self.push(blocks, model, &turned, member);
            }
        }
    }

    /// Adds a function, if enough of it is beside the model and the others.
    fn push(&mut self, blocks: &Blocks, model: Beside, turned: &Turned, member: Member) -> bool {
        if self.count == NEIGHBOURS_MAX {
            return false;
        }
        let Beside { shape, factor } = model;
        let mut explained = [0.0; UNKNOWNS_MAX];
        let first = shape.first_line();
        for b in 0..blocks.count() {
            let by = turn(blocks.middle(b), member.offset);
            for (sum, baseline) in explained.iter_mut().zip(blocks.baselines(b)).take(first) {
                let [c, s] = blocks.with_baseline(b, usize::from(member.line), baseline);
                *sum += if member.is_sine {
                    s * by[0] + c * by[1]
                } else {
                    c * by[0] - s * by[1]
                };
            }
        }
        for (i, line) in shape.lines.iter().enumerate() {
            for is_sine in [false, true] {
                let one = Member {
                    line: line as u8,
                    is_sine,
                    ..Member::NONE
                };
                explained[first + 2 * i + usize::from(is_sine)] = turned.product(&member, &one);
            }
        }
        factor.forward(&mut explained);
        let n = shape.unknowns();
        let start = self.count * (self.count + 1) / 2;
        let all = turned.product(&member, &member);
        let mut left = all - explained[..n].iter().map(|x| x * x).sum::<f32>();
        for j in 0..self.count {
            let row = j * (j + 1) / 2;
            let both: f32 = (0..n).map(|i| explained[i] * self.explained[j][i]).sum();
            let before: f32 = (0..j)
                .map(|k| self.rows[start + k] * self.rows[row + k])
                .sum();
            let value =
                (turned.product(&member, &self.members[j]) - both - before) / self.rows[row + j];
            self.rows[start + j] = value;
            left -= value * value;
        }
        let least = if member.offset == 0 {
            LEFT_LINE
        } else {
            LEFT_MIN
        };
        if left <= least * all.max(f32::MIN_POSITIVE) {
            return false;
        }
        self.rows[start + self.count] = libm::sqrtf(left);
        self.explained[self.count] = explained;
        self.members[self.count] = member;
        self.count += 1;
        true
    }

    /// Adds cosine and sine of a line itself behind all; whether both are beside the others.
    pub fn push_line(&mut self, blocks: &Blocks, model: Beside, line: usize) -> bool {
        let turned = Turned::new(blocks, line + model.shape.lines.most().max(line));
        [false, true].into_iter().all(|is_sine| {
            let member = Member {
                line: line as u8,
                is_sine,
                ..Member::NONE
            };
            self.push(blocks, model, &turned, member)
        })
    }

    /// Multiplies with the residuals of a solution; without one the blocks have residuals.
    #[inline(never)]
    pub fn multiply(&mut self, blocks: &Blocks, solution: Option<&Solution>) {
        for i in 0..self.count {
            let member = self.members[i];
            let mut value = [0.0; CHANNELS_MAX];
            for b in 0..blocks.count() {
                let [cos, sin] = turn(blocks.middle(b), member.offset);
                let [c, s] = blocks.line(b, usize::from(member.line));
                let [c_weight, s_weight] = if member.is_sine {
                    [sin, cos]
                } else {
                    [cos, -sin]
                };
                for (k, value) in value.iter_mut().enumerate() {
                    *value += c_weight * c[k] + s_weight * s[k];
                }
            }
            if let Some(solution) = solution {
                let rows = self.explained[i].iter().zip(&solution.projections);
                for (explained, row) in rows.take(solution.shape.unknowns()) {
                    for (value, projection) in value.iter_mut().zip(row) {
                        *value -= explained * projection;
                    }
                }
            }
            let (before, rest) = self.values.split_at_mut(i);
            let row = &self.rows[i * (i + 1) / 2..][..=i];
            for (factor, other) in row.iter().zip(before.iter()) {
                for (value, other) in value.iter_mut().zip(other) {
                    *value -= factor * other;
                }
            }
            rest[0] = value.map(|value| value / row[i]);
        }
    }

    /// How many there are.
    pub fn count(&self) -> usize {
        self.count
    }

    /// The functions with their products.
    pub fn iter(&self) -> impl Iterator<Item = (&Member, &Values)> {
        self.members.iter().zip(&self.values).take(self.count)
    }

    /// Products of the channels, each function with its weight.
    pub fn products(&self, weight: &dyn Fn(&Member) -> f32) -> Square<CHANNELS_MAX> {
        let mut products = [[0.0; CHANNELS_MAX]; CHANNELS_MAX];
        for (member, values) in self.iter() {
            let weight = weight(member);
            for (row, value) in products.iter_mut().zip(values) {
                for (sum, other) in row.iter_mut().zip(values) {
                    *sum += weight * value * other;
                }
            }
        }
        products
    }
}
