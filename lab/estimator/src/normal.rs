//! Normal equations of how phase and amplitude move: Legendre polynomials times the tone's
//! derivatives, beside the model, over all channels.

use crate::blocks::{Blocks, WAVES};
use crate::legendre::{fill_legendre, legendre_after};
use crate::limits::{
    BLOCKS_MAX, CHANNELS_MAX, DEGREES_MAX, HARMONICS_MAX, MOVES_MAX, UNKNOWNS_MAX,
};
use crate::lines::Lines;
use crate::matrix::Square;
use crate::solve::{Shape, Solution};
use crate::source::Values;

/// Functions of all lines: cosine and sine of each.
const LINE_FUNCTIONS: usize = 2 * HARMONICS_MAX;
/// Most unknowns of a movement.
pub const MOVEMENT_MAX: usize = 2 * DEGREES_MAX;

/// Products of functions of the lines.
type OfLines = Square<LINE_FUNCTIONS>;

/// How many degrees of phase and amplitude.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Degrees {
    /// Degrees of the phase, from the first on.
    pub phase: usize,
    /// Degrees of the amplitude.
    pub amplitude: usize,
}

impl Degrees {
    /// A frequency, and nothing that moves.
    pub const STEADY: Self = Self {
        phase: 1,
        amplitude: 0,
    };

    /// Both.
    pub fn count(self) -> usize {
        self.phase + self.amplitude
    }
}

/// Floats of what the model explains of each polynomial times the lines: all degrees of four lines,
/// ten of five.
pub const EXPLAINED: usize = 1536;
const _: () = assert!(DEGREES_MAX * (UNKNOWNS_MAX - 2) * (LINE_FUNCTIONS - 2) <= EXPLAINED);
const _: () = assert!(MOVES_MAX * UNKNOWNS_MAX * LINE_FUNCTIONS <= EXPLAINED);

/// Most degrees of the phase, or of the amplitude, that there is room for.
pub fn degrees_max(shape: &Shape) -> usize {
    let size = shape.unknowns() * 2 * shape.lines.count();
    (EXPLAINED / size.max(1)).min(DEGREES_MAX)
}

/// Normal equations: the phase's degrees, then the amplitude's.
#[derive(Clone, Debug)]
pub struct Normal {
    /// Information, in the lower triangle.
    pub matrix: Square<MOVEMENT_MAX>,
    /// Right side.
    pub right: [f32; MOVEMENT_MAX],
    /// What is asked for.
    pub degrees: Degrees,
}

/// The tone's coefficients by the noise's weights.
///
/// What the tone gains by its amplitude are its own lines; by its phase it gains each line times its
/// number, a quarter of a turn behind.
struct Weighted {
    /// Weighted coefficients of the lines.
    lines: [Values; LINE_FUNCTIONS],
    /// Their products with all coefficients.
    fitted: [[f32; UNKNOWNS_MAX]; LINE_FUNCTIONS],
    /// Their products with the lines' coefficients.
    power: OfLines,
}

impl Weighted {
    fn new(solution: &Solution, weights: &Square<CHANNELS_MAX>) -> Self {
        let mut weighted = Self {
            lines: [[0.0; CHANNELS_MAX]; LINE_FUNCTIONS],
            fitted: [[0.0; UNKNOWNS_MAX]; LINE_FUNCTIONS],
            power: [[0.0; LINE_FUNCTIONS]; LINE_FUNCTIONS],
        };
        let (first, unknowns) = (solution.shape.first_line(), solution.shape.unknowns());
        for (i, line) in solution.lines().iter().enumerate() {
            let own = &mut weighted.lines[i];
            for (own, row) in own.iter_mut().zip(weights) {
                *own = dot(row, line);
            }
            let fitted = &mut weighted.fitted[i];
            for (product, row) in fitted.iter_mut().zip(&solution.rows).take(unknowns) {
                *product = dot(row, own);
            }
            weighted.power[i][..unknowns - first].copy_from_slice(&fitted[first..unknowns]);
        }
        weighted
    }
}

/// What information is between.
#[derive(Clone, Copy)]
enum Kind {
    Phases,
    Both,
    Amplitudes,
}

/// Turns columns of the lines: those of the amplitude's gain become those of the phase's.
fn turn(row: &mut [f32], lines: Lines) {
    for (pair, line) in row.chunks_exact_mut(2).zip(lines.iter()) {
        let number = line as f32;
        (pair[0], pair[1]) = (number * pair[1], -number * pair[0]);
    }
}

/// Rows of the lines turned in the same way.
fn turn_rows(power: &OfLines, lines: Lines) -> OfLines {
    let mut turned = [[0.0; LINE_FUNCTIONS]; LINE_FUNCTIONS];
    for (i, line) in lines.iter().enumerate() {
        let number = line as f32;
        turned[2 * i] = power[2 * i + 1].map(|x| number * x);
        turned[2 * i + 1] = power[2 * i].map(|x| -number * x);
    }
    turned
}

impl Normal {
    /// No equations; all zeros.
    pub const NONE: Self = Self {
        matrix: [[0.0; MOVEMENT_MAX]; MOVEMENT_MAX],
        right: [0.0; MOVEMENT_MAX],
        degrees: Degrees {
            phase: 0,
            amplitude: 0,
        },
    };

    /// Makes the equations of a movement beside a solution, with memory of [`EXPLAINED`].
    #[inline(never)]
    pub fn make(
        &mut self,
        blocks: &Blocks,
        solution: &Solution,
        weights: &Square<CHANNELS_MAX>,
        memory: &mut [f32],
    ) {
        let lines = solution.shape.lines;
        let weighted = Weighted::new(solution, weights);
        let count = self.degrees.count();
        for row in self.matrix.iter_mut().take(count) {
            row[..count].fill(0.0);
        }
        // Steps of the phase need nothing of the amplitude.
        let has_amplitude = self.degrees.amplitude > 0;
        if has_amplitude {
            self.inform(blocks, lines, Kind::Amplitudes, &weighted.power);
        }
        let mut power = turn_rows(&weighted.power, lines);
        if has_amplitude {
            self.inform(blocks, lines, Kind::Both, &power);
        }
        for row in &mut power {
            turn(row, lines);
        }
        self.inform(blocks, lines, Kind::Phases, &power);
        self.gradients(blocks, solution, &weighted, memory);
        self.project(&solution.shape, &weighted.power, memory);
    }

    /// The right side, and what the model explains of each polynomial times the lines.
    #[inline(never)]
    fn gradients(
        &mut self,
        blocks: &Blocks,
        solution: &Solution,
        weighted: &Weighted,
        memory: &mut [f32],
    ) {
        let shape = &solution.shape;
        let (unknowns, n) = (shape.unknowns(), 2 * shape.lines.count());
        let Degrees { phase, amplitude } = self.degrees;
        let mut of_model = [[0.0; UNKNOWNS_MAX]; LINE_FUNCTIONS];
        let mut of_data = [[0.0; CHANNELS_MAX]; LINE_FUNCTIONS];
        // Polynomials of the degree before and of this one in the middles of the blocks.
        let (mut before, mut by_block) = ([0.0; BLOCKS_MAX], [1.0; BLOCKS_MAX]);
        let chunks = memory.chunks_exact_mut(unknowns * n);
        for (k, explained) in chunks.enumerate().take(phase.max(amplitude)) {
            for (b, (last, p)) in before.iter_mut().zip(&mut by_block).enumerate() {
                let next = legendre_after(k, blocks.middle(b), [*last, *p]);
                (*last, *p) = (*p, next);
            }
            blocks
                .totals(shape, &by_block)
                .of_shape(shape, &mut of_model);
            blocks.products(shape, &by_block, &mut of_data);
            let gain = |i: usize, of: usize| {
                let model = of_model[i].iter().zip(&weighted.fitted[of]).take(unknowns);
                dot(&of_data[i], &weighted.lines[of]) - model.map(|(x, y)| x * y).sum::<f32>()
            };
            if k < phase {
                let pairs = shape.lines.iter().enumerate();
                self.right[k] = pairs
                    .map(|(i, line)| {
                        line as f32 * (gain(2 * i, 2 * i + 1) - gain(2 * i + 1, 2 * i))
                    })
                    .sum();
            }
            if k < amplitude {
                self.right[phase + k] = (0..n).map(|i| gain(i, i)).sum();
            }
            for (j, row) in explained.chunks_exact_mut(n).enumerate() {
                for (value, products) in row.iter_mut().zip(&of_model) {
                    *value = products[j];
                }
            }
            solution.factor().forward_columns(explained, n);
        }
    }

    /// Adds the information of all blocks, between phases, between phase and amplitude, or between
    /// amplitudes.
    #[inline(never)]
    fn inform(&mut self, blocks: &Blocks, lines: Lines, kind: Kind, power: &OfLines) {
        let Degrees { phase, amplitude } = self.degrees;
        let (rows, columns) = match kind {
            Kind::Phases => (0..phase, 0..phase),
            Kind::Both => (phase..phase + amplitude, 0..phase),
            Kind::Amplitudes => (phase..phase + amplitude, phase..phase + amplitude),
        };
        let by_wave = by_wave(power, &lines);
        for b in 0..blocks.count() {
            let waves = by_wave.iter().enumerate().take(2 * lines.most() + 1);
            let information = waves
                .map(|(m, [cos, sin])| {
                    let wave = blocks.wave(b, m);
                    cos * wave[0] + sin * wave[1]
                })
                .sum::<f32>();
            let mut p = [1.0; DEGREES_MAX + 1];
            fill_legendre(blocks.middle(b), &mut p[..=phase.max(amplitude)]);
            let polynomial = |i: usize| {
                if i < phase {
                    p[i + 1]
                } else {
                    p[i - phase + 1]
                }
            };
            for i in rows.clone() {
                let weight = information * polynomial(i);
                for j in columns.start..columns.end.min(i + 1) {
                    self.matrix[i][j] += weight * polynomial(j);
                }
            }
        }
    }

    /// Takes out what the model explains.
    #[inline(never)]
    fn project(&mut self, shape: &Shape, power: &OfLines, memory: &[f32]) {
        let Degrees { phase, .. } = self.degrees;
        let (count, n) = (self.degrees.count(), 2 * shape.lines.count());
        let size = shape.unknowns() * n;
        let explained = |i: usize| {
            let degree = if i < phase { i } else { i - phase };
            &memory[degree * size..(degree + 1) * size]
        };
        let mut weighted = [0.0; UNKNOWNS_MAX * LINE_FUNCTIONS];
        for j in 0..count {
            let rows = explained(j).chunks_exact(n);
            for (weighted, row) in weighted.chunks_exact_mut(n).zip(rows) {
                let mut own = [0.0; LINE_FUNCTIONS];
                own[..n].copy_from_slice(row);
                if j < phase {
                    // The transpose of a turn goes backwards.
                    turn(&mut own[..n], shape.lines);
                    own.iter_mut().for_each(|x| *x = -*x);
                }
                weighted.fill(0.0);
                for (x, power) in own.iter().zip(power).take(n) {
                    for (sum, power) in weighted.iter_mut().zip(power) {
                        *sum += x * power;
                    }
                }
            }
            // Amplitudes take the lines as they are, phases take them turned.
            for i in phase.max(j)..count {
                self.matrix[i][j] -= product(&weighted[..size], explained(i));
            }
            if j < phase {
                for row in weighted[..size].chunks_exact_mut(n) {
                    turn(row, shape.lines);
                }
                for i in j..phase {
                    self.matrix[i][j] -= product(&weighted[..size], explained(i));
                }
            }
        }
    }
}

fn product(one: &[f32], other: &[f32]) -> f32 {
    one.iter().zip(other).map(|(x, y)| x * y).sum()
}

fn dot(one: &Values, other: &Values) -> f32 {
    one.iter().zip(other).map(|(x, y)| x * y).sum()
}

/// Coefficients of the multiples of the phase in the sum of all products of two lines, each with its
/// weight.
fn by_wave(weights: &OfLines, lines: &Lines) -> [[f32; 2]; WAVES] {
    let mut by_wave = [[0.0; 2]; WAVES];
    for (i, one) in lines.iter().enumerate() {
        for (j, other) in lines.iter().enumerate() {
            let [cos, sin] = [&weights[2 * i], &weights[2 * i + 1]];
            let (cc, cs, sc, ss) = (cos[2 * j], cos[2 * j + 1], sin[2 * j], sin[2 * j + 1]);
            let sign = if one < other { -0.5 } else { 0.5 };
            let difference = &mut by_wave[one.abs_diff(other) % WAVES];
            difference[0] += 0.5 * (cc + ss);
            difference[1] += sign * (sc - cs);
            let sum = &mut by_wave[(one + other) % WAVES];
            sum[0] += 0.5 * (cc - ss);
            sum[1] += 0.5 * (cs + sc);
        }
    }
    by_wave
}
