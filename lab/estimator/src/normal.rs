//! Normal equations of how phase and amplitude move: Legendre polynomials times the tone's
//! derivatives, beside the model, over all channels.

use crate::blocks::Blocks;
use crate::legendre::legendre;
use crate::limits::{CHANNELS_MAX, DEGREES_MAX, HARMONICS_MAX, UNKNOWNS_MAX};
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
        let (unknowns, first) = (shape.unknowns(), shape.first_line());
        let highest = degrees.phase.max(degrees.amplitude);
        // Steps of the phase need nothing of the amplitude.
        let kinds = if degrees.amplitude > 0 { 2 } else { 1 };
        let Derivatives(derivatives) = Derivatives::new(solution);
        let mut weighted = [[[0.0; CHANNELS_MAX]; LINE_FUNCTIONS]; 2];
        for (weighted, derivative) in weighted.iter_mut().zip(&derivatives).take(kinds) {
            for (weighted, derivative) in weighted.iter_mut().zip(derivative).take(n) {
                for (sum, row) in weighted.iter_mut().zip(weights) {
                    *sum = row.iter().zip(derivative).map(|(w, x)| w * x).sum();
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
        let mut fitted = [[[0.0; UNKNOWNS_MAX]; LINE_FUNCTIONS]; 2];
        for (fitted, weighted) in fitted.iter_mut().zip(&weighted).take(kinds) {
            for (fitted, weighted) in fitted.iter_mut().zip(weighted).take(n) {
                for (sum, row) in fitted.iter_mut().zip(&solution.coefficients).take(unknowns) {
                    *sum = row.iter().zip(weighted).map(|(x, w)| x * w).sum();
                }
            }
        }
        let mut normal = Self {
            matrix: [[0.0; MOVEMENT_MAX]; MOVEMENT_MAX],
            right: [0.0; MOVEMENT_MAX],
            degrees,
        };
        explained.0[..highest].fill([[0.0; LINE_FUNCTIONS]; UNKNOWNS_MAX]);
        for b in 0..blocks.count() {
            let p = legendre::<{ DEGREES_MAX + 1 }>(blocks.middle(b));
            let baselines = blocks.baselines(b);
            let mut products = [[0.0; UNKNOWNS_MAX]; LINE_FUNCTIONS];
            for (i, line) in shape.lines.iter().enumerate() {
                for (j, baseline) in baselines.iter().enumerate().take(first) {
                    let [cos, sin] = blocks.with_baseline(b, line, *baseline);
                    (products[2 * i][j], products[2 * i + 1][j]) = (cos, sin);
                }
                for (j, other) in shape.lines.iter().enumerate() {
                    let product = blocks.of_lines(b, line, other);
                    for r in 0..2 {
                        products[2 * i + r][first + 2 * j] = product[r][0];
                        products[2 * i + r][first + 2 * j + 1] = product[r][1];
                    }
                }
            }
            let mut information = [0.0; 3];
            for (information, power) in information.iter_mut().zip(&power).take(2 * kinds - 1) {
                for (products, power) in products.iter().zip(power).take(n) {
                    let pairs = products[first..].iter().zip(power).take(n);
                    *information += pairs.map(|(x, y)| x * y).sum::<f32>();
                }
            }
            let mut gradient = [0.0; 2];
            for (which, gradient) in gradient.iter_mut().enumerate().take(kinds) {
                for (i, line) in shape.lines.iter().enumerate() {
                    for (r, data) in blocks.line(b, line).into_iter().enumerate() {
                        let row = 2 * i + r;
                        let of_data = data.iter().zip(&weighted[which][row]);
                        let of_model = products[row].iter().zip(&fitted[which][row]).take(unknowns);
                        *gradient += of_data.map(|(x, y)| x * y).sum::<f32>()
                            - of_model.map(|(x, y)| x * y).sum::<f32>();
                    }
                }
            }
            for i in 0..degrees.count() {
                let (p_i, second) = normal.part(i, &p);
                normal.right[i] += p_i * gradient[second];
                for j in 0..=i {
                    let (p_j, other) = normal.part(j, &p);
                    normal.matrix[i][j] += p_i * p_j * information[second + other];
                }
            }
            for (k, explained) in explained.0.iter_mut().enumerate().take(highest) {
                for (j, row) in explained.iter_mut().enumerate().take(unknowns) {
                    for (sum, products) in row.iter_mut().zip(&products).take(n) {
                        *sum += p[k + 1] * products[j];
                    }
                }
            }
        }
        for explained in explained.0.iter_mut().take(highest) {
            for a in 0..n {
                let mut column = [0.0; UNKNOWNS_MAX];
                for (value, row) in column.iter_mut().zip(explained.iter()) {
                    *value = row[a];
                }
                solution.factor.forward(&mut column);
                for (row, value) in explained.iter_mut().zip(column) {
                    row[a] = value;
                }
            }
        }
        normal.project(explained, &power, unknowns, n);
        normal
    }

    /// Polynomial of an unknown, and whether it is of the amplitude.
    fn part<const N: usize>(&self, i: usize, p: &[f32; N]) -> (f32, usize) {
        if i < self.degrees.phase {
            (p[i + 1], 0)
        } else {
            (p[i - self.degrees.phase + 1], 1)
        }
    }

    /// Takes out what the model explains.
    fn project(&mut self, explained: &Explained, power: &[OfLines; 3], unknowns: usize, n: usize) {
        let degree = |i: usize| {
            if i < self.degrees.phase {
                (i, 0)
            } else {
                (i - self.degrees.phase, 1)
            }
        };
        let count = self.degrees.count();
        for i in 0..count {
            let (k, second) = degree(i);
            for j in 0..=i {
                let (l, other) = degree(j);
                let power = &power[second + other];
                let is_swapped = second > other;
                let mut sum = 0.0;
                for (one, two) in explained.0[k].iter().zip(&explained.0[l]).take(unknowns) {
                    let (one, two) = if is_swapped { (two, one) } else { (one, two) };
                    for (x, power) in one.iter().zip(power).take(n) {
                        let pairs = power.iter().zip(two).take(n);
                        sum += x * pairs.map(|(p, y)| p * y).sum::<f32>();
                    }
                }
                self.matrix[i][j] -= sum;
                self.matrix[j][i] = self.matrix[i][j];
            }
        }
    }
}
