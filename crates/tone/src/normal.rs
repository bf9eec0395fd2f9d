//! Normal equations of phase and amplitude modulation: Legendre polynomials times the tone's
//! derivatives, after projecting out the model, over all channels.

use crate::blocks::Blocks;
use crate::legendre::{fill_legendre, legendre_after};
use crate::limits::{
    BLOCKS_MAX, CHANNELS_MAX, DEGREES_MAX, HARMONICS_MAX, NOISE_BINS_MAX, UNKNOWNS_MAX,
};
use crate::lines::Lines;
use crate::matrix::Square;
use crate::solve::{Shape, Solution};
use crate::source::Values;
use crate::totals::{LINE_FUNCTIONS, LIST_MAX, OfLines, OfModel, by_wave, fold, list_len, unfold};

/// Maximum number of unknowns of a modulation.
pub const MOVEMENT_MAX: usize = 2 * DEGREES_MAX;
const _: () = assert!(DEGREES_MAX * LIST_MAX <= NOISE_BINS_MAX * CHANNELS_MAX);

/// Degrees of phase and amplitude.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Degrees {
    /// Degrees of the phase, from the first on.
    pub phase: usize,
    pub amplitude: usize,
}

impl Degrees {
    /// A constant frequency, without modulation.
    pub const STEADY: Self = Self {
        phase: 1,
        amplitude: 0,
    };

    /// Limits both to the capacity of the memory.
    fn bounded(self) -> Self {
        Self {
            phase: self.phase.min(DEGREES_MAX),
            amplitude: self.amplitude.min(DEGREES_MAX),
        }
    }

    pub fn count(self) -> usize {
        self.phase + self.amplitude
    }
}

/// Maximum number of degrees of the phase, or of the amplitude, that the blocks resolve.
pub fn degrees_max(blocks: &Blocks) -> usize {
    DEGREES_MAX.min(blocks.count().saturating_sub(2))
}

/// Normal equations; the unknowns are the phase's degrees, then the amplitude's.
#[derive(Clone, Debug)]
pub struct Normal {
    /// Information matrix, lower triangle.
    pub matrix: Square<MOVEMENT_MAX>,
    pub right: [f32; MOVEMENT_MAX],
    pub degrees: Degrees,
}

/// Products of the tone, weighted by the inverse noise covariance.
///
/// The derivative with respect to amplitude is the tone itself; that with respect to phase is each
/// line times its number, rotated by a quarter turn.
struct Weighted {
    /// Products of the lines' weighted coefficients with those of all unknowns.
    fitted: OfModel,
    /// Channels times the derivative with respect to phase, per block.
    phases: [f32; BLOCKS_MAX],
    /// Channels times the derivative with respect to amplitude, per block.
    amplitudes: [f32; BLOCKS_MAX],
}

impl Weighted {
    #[inline(never)]
    fn new(
        blocks: &Blocks,
        solution: &Solution,
        weights: &Square<CHANNELS_MAX>,
        has_amplitude: bool,
    ) -> Self {
        let mut weighted = Self {
            fitted: [[0.0; UNKNOWNS_MAX]; LINE_FUNCTIONS],
            phases: [0.0; BLOCKS_MAX],
            amplitudes: [0.0; BLOCKS_MAX],
        };
        let (unknowns, groups) = (solution.shape.unknowns(), blocks.groups());
        let pairs = solution.lines().as_chunks::<2>().0;
        let fitted = weighted.fitted.as_chunks_mut::<2>().0.iter_mut();
        for ((line, pair), fitted) in solution.shape.lines.iter().zip(pairs).zip(fitted) {
            for (r, (coefficients, fitted)) in pair.iter().zip(fitted).enumerate() {
                let mut own = [0.0; CHANNELS_MAX];
                let rows = own.iter_mut().zip(weights).take(4 * groups);
                rows.for_each(|(own, row)| *own = dot(row, coefficients, groups));
                for (product, row) in fitted.iter_mut().zip(&solution.rows).take(unknowns) {
                    *product = dot(row, &own, groups);
                }
                let number = if r == 0 { -(line as f32) } else { line as f32 };
                let sums = weighted.phases.iter_mut().zip(&mut weighted.amplitudes);
                for (b, (phase, amplitude)) in sums.enumerate().take(blocks.count()) {
                    let [cos, sin] = blocks.line(b, line);
                    let (own_line, other) = if r == 0 { (cos, sin) } else { (sin, cos) };
                    *phase += number * dot(other, &own, groups);
                    if has_amplitude {
                        *amplitude += dot(own_line, &own, groups);
                    }
                }
            }
        }
        weighted
    }

    /// Multiplies rows by the weighted products of the lines' coefficients.
    fn weigh(&self, rows: &OfModel, shape: &Shape, weighed: &mut OfModel) {
        let (first, unknowns) = (shape.first_line(), shape.unknowns());
        for (own, weights) in weighed.iter_mut().zip(&self.fitted).take(unknowns - first) {
            own.fill(0.0);
            for (row, weight) in rows.iter().zip(&weights[first..]).take(unknowns - first) {
                let pairs = own.iter_mut().zip(row).take(unknowns);
                pairs.for_each(|(sum, x)| *sum += weight * x);
            }
        }
    }

    /// Weighted products of the lines' coefficients with each other.
    fn power(&self, first: usize) -> OfLines {
        self.fitted.map(|row| {
            let mut power = [0.0; LINE_FUNCTIONS];
            let columns = row.iter().skip(first);
            power
                .iter_mut()
                .zip(columns)
                .for_each(|(place, x)| *place = *x);
            power
        })
    }
}

/// Part of the information matrix: phase-phase, amplitude-phase or amplitude-amplitude.
#[derive(Clone, Copy)]
enum Kind {
    Phases,
    Both,
    Amplitudes,
}

/// Converts pairs of rows from the derivative with respect to amplitude to that with respect to
/// phase.
fn turn_rows<const N: usize>(rows: &mut [[f32; N]; LINE_FUNCTIONS], lines: Lines) {
    for ([one, other], line) in rows.as_chunks_mut::<2>().0.iter_mut().zip(lines.iter()) {
        let number = line as f32;
        for (cos, sin) in one.iter_mut().zip(other) {
            (*cos, *sin) = (number * *sin, -number * *cos);
        }
    }
}

impl Normal {
    pub const NONE: Self = Self {
        matrix: [[0.0; MOVEMENT_MAX]; MOVEMENT_MAX],
        right: [0.0; MOVEMENT_MAX],
        degrees: Degrees {
            phase: 0,
            amplitude: 0,
        },
    };

    /// Sets up the equations of a modulation on top of a solution; `memory` holds one list of
    /// totals for each degree.
    #[inline(never)]
    pub fn make(
        &mut self,
        blocks: &Blocks,
        solution: &Solution,
        weights: &Square<CHANNELS_MAX>,
        memory: &mut [f32],
    ) {
        let has_amplitude = self.degrees.amplitude > 0;
        let weighted = Weighted::new(blocks, solution, weights, has_amplitude);
        let count = self.degrees.count();
        for row in self.matrix.iter_mut().take(count) {
            row.iter_mut().take(count).for_each(|x| *x = 0.0);
        }
        self.inform_all(blocks, solution, &weighted);
        self.gather(blocks, solution, &weighted, memory);
        if self.degrees == Degrees::STEADY {
            self.project_frequency(solution, &weighted, memory);
        } else {
            self.project(solution, &weighted, memory);
        }
    }

    /// Projects the model out of the frequency only: a fifth of the work of [`Self::project`].
    #[inline(never)]
    fn project_frequency(&mut self, solution: &Solution, weighted: &Weighted, memory: &[f32]) {
        let (shape, factor) = (&solution.shape, solution.factor());
        let functions = 2 * shape.lines.count().min(HARMONICS_MAX);
        let mut rows = [[0.0; UNKNOWNS_MAX]; LINE_FUNCTIONS];
        unfold(shape, memory, &mut rows);
        turn_rows(&mut rows, shape.lines);
        for (i, fitted) in weighted.fitted.iter().enumerate().take(functions) {
            self.right[0] += product(&rows[i], fitted);
            factor.forward(&mut rows[i]);
            let powers = fitted.iter().skip(shape.first_line());
            for (j, (power, other)) in powers.zip(&rows).enumerate().take(i + 1) {
                let twice = if j < i { 2.0 } else { 1.0 };
                self.matrix[0][0] -= twice * power * product(&rows[i], other);
            }
        }
    }

    /// Adds all parts of the information matrix.
    #[inline(never)]
    fn inform_all(&mut self, blocks: &Blocks, solution: &Solution, weighted: &Weighted) {
        let lines = solution.shape.lines;
        let mut power = weighted.power(solution.shape.first_line());
        // Steps that refine only the phase need no amplitudes.
        let has_amplitude = self.degrees.amplitude > 0;
        if has_amplitude {
            self.inform(blocks, lines, Kind::Amplitudes, &power);
        }
        turn_rows(&mut power, lines);
        if has_amplitude {
            self.inform(blocks, lines, Kind::Both, &power);
        }
        for row in &mut power {
            for (pair, line) in row.as_chunks_mut::<2>().0.iter_mut().zip(lines.iter()) {
                let number = line as f32;
                *pair = [number * pair[1], -number * pair[0]];
            }
        }
        self.inform(blocks, lines, Kind::Phases, &power);
    }

    /// Adds one part of the information matrix, summed over all blocks.
    fn inform(&mut self, blocks: &Blocks, lines: Lines, kind: Kind, power: &OfLines) {
        let Degrees { phase, amplitude } = self.degrees.bounded();
        let (rows, columns) = match kind {
            Kind::Phases => (0..phase, 0..phase),
            Kind::Both => (phase..phase + amplitude, 0..phase),
            Kind::Amplitudes => (phase..phase + amplitude, phase..phase + amplitude),
        };
        let by_wave = by_wave(power, 0, lines);
        for b in 0..blocks.count() {
            let waves = by_wave.iter().enumerate().take(2 * lines.max() + 1);
            let information = waves
                .map(|(m, [cos, sin])| {
                    let wave = blocks.wave(b, m);
                    cos * wave[0] + sin * wave[1]
                })
                .sum::<f32>();
            let mut p = [1.0; DEGREES_MAX + 1];
            fill_legendre(blocks.middle(b), &mut p[..=phase.max(amplitude)]);
            let polynomial =
                |i: usize| p[(if i < phase { i } else { i - phase } + 1).min(DEGREES_MAX)];
            for i in rows.clone() {
                let weight = information * polynomial(i);
                for j in columns.start..columns.end.min(i + 1) {
                    self.matrix[i][j] += weight * polynomial(j);
                }
            }
        }
    }

    /// Collects the right-hand side, and a list of the totals of each polynomial.
    #[inline(never)]
    fn gather(
        &mut self,
        blocks: &Blocks,
        solution: &Solution,
        weighted: &Weighted,
        memory: &mut [f32],
    ) {
        let shape = &solution.shape;
        let Degrees { phase, amplitude } = self.degrees.bounded();
        // Polynomials of the previous and the present degree at the middles of the blocks.
        let (mut before, mut by_block) = ([0.0; BLOCKS_MAX], [1.0; BLOCKS_MAX]);
        let lists = memory.chunks_exact_mut(list_len(shape));
        for (k, list) in lists.enumerate().take(phase.max(amplitude)) {
            for (b, (last, p)) in before.iter_mut().zip(&mut by_block).enumerate() {
                let next = legendre_after(k, blocks.middle(b), [*last, *p]);
                (*last, *p) = (*p, next);
            }
            blocks.totals(shape, &by_block).list(shape, list);
            if k < phase {
                self.right[k] = product(&by_block, &weighted.phases);
            }
            if k < amplitude {
                self.right[phase + k] = product(&by_block, &weighted.amplitudes);
            }
        }
    }

    #[inline(never)]
    fn project(&mut self, solution: &Solution, weighted: &Weighted, memory: &[f32]) {
        let shape = &solution.shape;
        let Degrees { phase, amplitude } = self.degrees.bounded();
        let lists = memory.chunks_exact(list_len(shape));
        let mut list = [0.0; LIST_MAX];
        let mut rows = weighted.fitted;
        if amplitude > 0 {
            fold(shape, &rows, &mut list);
            let pairs = self.right.iter_mut().skip(phase).zip(lists.clone());
            pairs
                .take(amplitude)
                .for_each(|(right, own)| *right -= product(own, &list));
        }
        turn_rows(&mut rows, shape.lines);
        fold(shape, &rows, &mut list);
        let pairs = self.right.iter_mut().zip(lists.clone());
        pairs
            .take(phase)
            .for_each(|(right, own)| *right -= product(own, &list));
        let mut solved = [[0.0; UNKNOWNS_MAX]; LINE_FUNCTIONS];
        for (l, own) in lists.clone().enumerate().take(phase.max(amplitude)) {
            unfold(shape, own, &mut solved);
            for row in solved.iter_mut().take(2 * shape.lines.count()) {
                solution.factor().solve(row);
            }
            let later = |from: usize| lists.clone().skip(from);
            if l < amplitude {
                weighted.weigh(&solved, shape, &mut rows);
                fold(shape, &rows, &mut list);
                let rows = self.matrix.iter_mut().skip(phase + l).zip(later(l));
                for (row, other) in rows.take(amplitude - l) {
                    row[phase + l] -= product(other, &list);
                }
            }
            if l < phase {
                // The transpose of a rotation rotates backwards.
                turn_rows(&mut solved, shape.lines);
                weighted.weigh(&solved, shape, &mut rows);
                if amplitude > 0 {
                    fold(shape, &rows, &mut list);
                    let rows = self.matrix.iter_mut().skip(phase).zip(later(0));
                    for (row, other) in rows.take(amplitude) {
                        row[l] += product(other, &list);
                    }
                }
                turn_rows(&mut rows, shape.lines);
                fold(shape, &rows, &mut list);
                let rows = self.matrix.iter_mut().skip(l).zip(later(l));
                for (row, other) in rows.take(phase - l) {
                    row[l] += product(other, &list);
                }
            }
        }
    }
}

fn product(one: &[f32], other: &[f32]) -> f32 {
    one.iter().zip(other).map(|(x, y)| x * y).sum()
}

/// Dot product over the first groups of four channels.
#[inline(always)]
fn dot(one: &Values, other: &Values, groups: usize) -> f32 {
    let pairs = one.iter().zip(other).map(|(x, y)| x * y);
    // A constant number of channels needs no loop.
    if groups == CHANNELS_MAX / 4 {
        pairs.sum()
    } else {
        pairs.take(4 * groups).sum()
    }
}
