//! Normal equations of how phase and amplitude move: Legendre polynomials times the tone's
//! derivatives, beside the model, over all channels.

use crate::blocks::{Blocks, WAVES};
use crate::legendre::legendre;
use crate::limits::{BLOCKS_MAX, CHANNELS_MAX, DEGREES_MAX, HARMONICS_MAX, UNKNOWNS_MAX};
use crate::lines::Lines;
use crate::matrix::Square;
use crate::solve::Solution;
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
    /// Both.
    pub fn count(self) -> usize {
        self.phase + self.amplitude
    }
}

/// What the model explains of each polynomial times the lines.
#[derive(Debug)]
pub struct Explained([[[f32; LINE_FUNCTIONS]; UNKNOWNS_MAX]; DEGREES_MAX]);

impl Explained {
    /// Zeros.
    pub const fn new() -> Self {
        Self([[[0.0; LINE_FUNCTIONS]; UNKNOWNS_MAX]; DEGREES_MAX])
    }
}

/// Normal equations: the phase's degrees, then the amplitude's.
#[derive(Clone, Debug)]
pub struct Normal {
    /// Information.
    pub matrix: Square<MOVEMENT_MAX>,
    /// Right side.
    pub right: [f32; MOVEMENT_MAX],
    /// What is asked for.
    pub degrees: Degrees,
}

/// Coefficients of the tone's derivatives by its phase and by its amplitude.
struct Derivatives([[Values; LINE_FUNCTIONS]; 2]);

impl Derivatives {
    fn new(solution: &Solution) -> Self {
        let lines = solution.lines();
        let mut phase = [[0.0; CHANNELS_MAX]; LINE_FUNCTIONS];
        for (i, line) in solution.shape.lines.iter().enumerate() {
            phase[2 * i] = lines[2 * i + 1].map(|sin| line as f32 * sin);
            phase[2 * i + 1] = lines[2 * i].map(|cos| -(line as f32) * cos);
        }
        Self([phase, lines])
    }
}

/// Products over channels, weighted.
fn between(one: &[Values], other: &[Values; LINE_FUNCTIONS]) -> OfLines {
    let mut products = [[0.0; LINE_FUNCTIONS]; LINE_FUNCTIONS];
    for (row, one) in products.iter_mut().zip(one) {
        for (sum, other) in row.iter_mut().zip(other) {
            *sum = one.iter().zip(other).map(|(x, y)| x * y).sum();
        }
    }
    products
}

impl Normal {
    /// The equations of a movement beside a solution.
    #[inline(never)]
    pub fn new(
        blocks: &Blocks,
        solution: &Solution,
        weights: &Square<CHANNELS_MAX>,
        degrees: Degrees,
        explained: &mut Explained,
    ) -> Self {
        let (shape, n) = (&solution.shape, 2 * solution.shape.lines.count());
        let unknowns = shape.unknowns();
        let highest = degrees.phase.max(degrees.amplitude);
        // Steps of the phase need nothing of the amplitude.
        let kinds = if degrees.amplitude > 0 { 2 } else { 1 };
        let Derivatives(derivatives) = Derivatives::new(solution);
        let mut weighted = [[[0.0; CHANNELS_MAX]; LINE_FUNCTIONS]; 2];
        let mut fitted = [[[0.0; UNKNOWNS_MAX]; LINE_FUNCTIONS]; 2];
        for kind in 0..kinds {
            for i in 0..n {
                weighted[kind][i] = weights.map(|row| dot(&row, &derivatives[kind][i]));
                for (sum, row) in fitted[kind][i]
                    .iter_mut()
                    .zip(&solution.coefficients)
                    .take(unknowns)
                {
                    *sum = dot(row, &weighted[kind][i]);
                }
            }
        }
        // Information of phase with phase, phase with amplitude, amplitude with amplitude.
        let mut power = [[[0.0; LINE_FUNCTIONS]; LINE_FUNCTIONS]; 3];
        for (power, [one, other]) in power
            .iter_mut()
            .zip([[0, 0], [0, 1], [1, 1]])
            .take(2 * kinds - 1)
        {
            *power = between(&weighted[one][..n], &derivatives[other]);
        }
        let mut normal = Self {
            matrix: [[0.0; MOVEMENT_MAX]; MOVEMENT_MAX],
            right: [0.0; MOVEMENT_MAX],
            degrees,
        };
        let polynomials: [[f32; DEGREES_MAX + 1]; BLOCKS_MAX] =
            core::array::from_fn(|b| legendre(blocks.middle(b)));
        for (kind, power) in power.iter().enumerate().take(2 * kinds - 1) {
            let by_wave = by_wave(power, &shape.lines);
            for b in 0..blocks.count() {
                let information = by_wave
                    .iter()
                    .enumerate()
                    .take(2 * shape.lines.most() + 1)
                    .map(|(m, [cos, sin])| {
                        let wave = blocks.wave(b, m);
                        cos * wave[0] + sin * wave[1]
                    })
                    .sum::<f32>();
                normal.inform(kind, information, &polynomials[b]);
            }
        }
        for k in 0..highest {
            let by_block = core::array::from_fn(|b| polynomials[b][k + 1]);
            let of_model = blocks.totals(shape, &by_block).of_shape(shape);
            let of_data = blocks.products(shape, &by_block);
            for kind in 0..kinds {
                let gradient: f32 = (0..n)
                    .map(|i| {
                        let model = of_model[i].iter().zip(&fitted[kind][i]).take(unknowns);
                        dot(&of_data[i], &weighted[kind][i])
                            - model.map(|(x, y)| x * y).sum::<f32>()
                    })
                    .sum();
                if kind == 0 && k < degrees.phase {
                    normal.right[k] = gradient;
                } else if kind == 1 && k < degrees.amplitude {
                    normal.right[degrees.phase + k] = gradient;
                }
            }
            let explained = &mut explained.0[k];
            for (j, row) in explained.iter_mut().enumerate().take(unknowns) {
                for (value, products) in row.iter_mut().zip(&of_model).take(n) {
                    *value = products[j];
                }
            }
            solution.factor.forward_rows(explained);
        }
        normal.project(explained, &power, unknowns, n);
        normal
    }

    /// Adds the information of a block, between phases, between phase and amplitude, or between
    /// amplitudes.
    fn inform(&mut self, kind: usize, information: f32, p: &[f32; DEGREES_MAX + 1]) {
        let Degrees { phase, amplitude } = self.degrees;
        let (rows, columns) = match kind {
            0 => (0..phase, 0..phase),
            1 => (phase..phase + amplitude, 0..phase),
            _ => (phase..phase + amplitude, phase..phase + amplitude),
        };
        let polynomial = |i: usize| {
            if i < phase {
                p[i + 1]
            } else {
                p[i - phase + 1]
            }
        };
        for i in rows {
            let weight = information * polynomial(i);
            for j in columns.start..columns.end.min(i + 1) {
                self.matrix[i][j] += weight * polynomial(j);
            }
        }
    }

    /// Takes out what the model explains.
    fn project(&mut self, explained: &Explained, power: &[OfLines; 3], unknowns: usize, n: usize) {
        let Degrees { phase, .. } = self.degrees;
        let count = self.degrees.count();
        for j in 0..count {
            let (of_j, other) = if j < phase { (j, 0) } else { (j - phase, 1) };
            for second in other..=usize::from(count > phase) {
                let mut weighted = [[0.0; LINE_FUNCTIONS]; UNKNOWNS_MAX];
                for (weighted, row) in weighted.iter_mut().zip(&explained.0[of_j]).take(unknowns) {
                    for (x, power) in row.iter().zip(&power[second + other]).take(n) {
                        for (sum, power) in weighted.iter_mut().zip(power).take(n) {
                            *sum += x * power;
                        }
                    }
                }
                let rows = if second == 0 {
                    j..phase
                } else {
                    phase.max(j)..count
                };
                for i in rows {
                    let of_i = if i < phase { i } else { i - phase };
                    let pairs = weighted.iter().zip(&explained.0[of_i]).take(unknowns);
                    self.matrix[i][j] -= pairs
                        .map(|(x, y)| x.iter().zip(y).take(n).map(|(x, y)| x * y).sum::<f32>())
                        .sum::<f32>();
                    self.matrix[j][i] = self.matrix[i][j];
                }
            }
        }
    }
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
