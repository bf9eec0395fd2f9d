//! Tests of the scene's declaration: are the residuals of the blocks white and independent?
//!
//! All are F ratios. The levels of the blocks reveal drift and low-frequency noise; cosine and sine
//! in each block reveal a tone that changes, or a second tone next to the line; correlations
//! between channels reveal shared noise. If the line may be a harmonic, lines of lower fundamentals
//! are tested too.

use super::blocks::{BLOCKS, BLOCKS_FEWER, Block, Blocks, LINES};
use super::reference::Reference;
use super::solve::{Solution, Turned};
use crate::limits::CHANNELS_MAX;
use crate::phase::{Wave, cos_sin, from_turns, line_products};
use crate::significance::{deviate, square_root};
use crate::source::Values;
use core::f32::consts::SQRT_2;

/// Threshold of each test: one in 100,000 by chance.
const Z: f32 = 4.3;

/// Deviates of the tests.
#[derive(Clone, Copy, Debug, Default)]
pub struct Declared {
    /// Deviate of the levels.
    pub levels: f32,
    /// Deviate of cosine and sine.
    pub lines: f32,
    /// Deviate of the correlations between channels.
    pub shared: f32,
    /// Deviate of lines at the [`PARTS`] of the tested line's frequency.
    pub parts: f32,
}

impl Declared {
    /// Largest deviate.
    pub fn worst(&self) -> f32 {
        self.levels.max(self.lines).max(self.shared).max(self.parts)
    }

    /// True if the window is as the scene declares.
    pub fn is_met(&self) -> bool {
        self.worst() <= Z
    }
}

/// Lines of lower fundamentals that have the tested line as a harmonic: frequency relative to the
/// tested line, and number of harmonics that the fundamental needs.
pub const PARTS: [(f32, usize); 7] = [
    (1.0 / 2.0, 2),
    (3.0 / 2.0, 3),
    (1.0 / 3.0, 3),
    (2.0 / 3.0, 3),
    (4.0 / 3.0, 4),
    (1.0 / 4.0, 4),
    (3.0 / 4.0, 4),
];

/// Maximum distance of a [`PARTS`] line from the tested line, cycles per block: further away, the
/// line rotates too far within a block.
const PART_MAX: f32 = 0.8;

/// Rows of residuals: levels, followed by cosine and sine of a line if there are few blocks.
const KEPT: usize = 3 * BLOCKS_FEWER;
const _: () = assert!(KEPT >= BLOCKS);

/// A solution to test.
#[derive(Clone, Copy, Debug)]
pub struct Tested<'t> {
    pub solution: &'t Solution,
    /// Index of the tested line in the solution.
    pub place: usize,
    /// Harmonics of the scene.
    pub harmonics: usize,
}

/// Tests the residuals of the blocks' levels and of a line, in memory for [`KEPT`] rows.
#[inline(never)]
pub fn test(
    blocks: &Blocks,
    reference: &Reference,
    tested: &Tested,
    memory: &mut [Values],
) -> Declared {
    let Tested {
        solution,
        place,
        harmonics,
    } = *tested;
    // Residuals of the blocks, each with the variance of a frame.
    let Some(white) = memory.first_chunk_mut::<KEPT>() else {
        return Declared::default();
    };
    white.fill([0.0; CHANNELS_MAX]);
    let (mut levels, mut lines, mut explained, mut count) = (0.0, 0.0, 0.0, 0.0f32);
    let frames = blocks.frames();
    let tested = solution.orders().get(place).copied().unwrap_or(1);
    let highest = solution.orders().last().copied().unwrap_or(1);
    let is_few = blocks.count() <= BLOCKS_FEWER;
    // Summed over the blocks: squared correlations between a block's level, cosine and sine.
    let mut together = 0.0f32;
    let mut turned = Turned::default();
    for (b, (block, rows)) in blocks.iter().enumerate() {
        if block.frames <= 0.0 {
            continue;
        }
        turned.set(block, solution.turn, highest);
        let inverse = 1.0 / block.frames;
        let (of_level, of_lines) = white.split_at_mut(if is_few { BLOCKS_FEWER } else { BLOCKS });
        let mut unused = [[0.0; CHANNELS_MAX]; 2];
        let line = match of_lines.as_chunks_mut::<2>().0.get_mut(b) {
            Some(line) if is_few => line,
            _ => &mut unused,
        };
        let Some(level) = of_level.get_mut(b) else {
            continue;
        };
        let [cosine, sine] = line;
        let rest = [level, cosine, sine];
        let model = Model {
            turned: &turned,
            solution,
            tested,
        };
        let [of_levels, of_line] = residuals(block, rows, &model, rest);
        levels += inverse * of_levels;
        lines += inverse * of_line;
        for order in solution.orders() {
            let [c, s] = turned.waves[order % turned.waves.len()];
            explained += 2.0 * inverse * (c * c + s * s);
        }
        let [[cc, cs], [_, ss]] = line_products(&turned.waves, tested, tested);
        let [c, s] = turned.waves[tested % turned.waves.len()];
        let squares = cc * cc + 2.0 * cs * cs + ss * ss + c * c + s * s;
        together += 1.0 + 4.0 * inverse * inverse * squares;
        count += 1.0;
    }
    let width = reference.width as f32;
    let of_tested = (blocks.cycles + solution.cycles()) * tested as f32;
    let mut parts = 0.0f32;
    let of_line = white[BLOCKS_FEWER..].as_chunks::<2>().0;
    for (part, needed) in PARTS {
        let distance = (part - 1.0) * of_tested;
        if needed <= harmonics && f32::abs(distance) < PART_MAX * blocks.count() as f32 {
            let power = part_power(blocks, of_line, &solution.weights, distance);
            let ratio = power / (2.0 * width * count);
            parts = parts.max(deviate(ratio, 2.0 * width, width * solution.freedom));
        }
    }
    // A line of many cycles per block does not affect the levels.
    let of_levels = (count - 2.0 - explained / frames).max(1.0);
    let of_lines = (count - 2.0).max(1.0);
    let freedom = width * solution.freedom;
    Declared {
        levels: deviate(levels / (width * of_levels), width * of_levels, freedom),
        lines: deviate(lines / (width * of_lines), width * of_levels, freedom),
        shared: if is_few {
            let samples = (of_levels + 2.0 * of_lines) * 3.0 * count / together;
            correlation(white, solution, samples)
        } else {
            correlation(&white[..BLOCKS], solution, of_levels)
        },
        parts,
    }
}

/// A solution in a block.
struct Model<'m> {
    turned: &'m Turned,
    solution: &'m Solution,
    /// Number of the tested line.
    tested: usize,
}

/// Weighted squared residuals of a block's sums: of the values, and of their products with cosine
/// and sine of a line. `rest` receives the residuals, with the variance of a frame.
#[inline(never)]
fn residuals(block: &Block, rows: &[Values], model: &Model, rest: [&mut Values; 3]) -> [f32; 2] {
    let Model {
        turned,
        solution,
        tested,
    } = *model;
    let (n, u) = (block.frames, block.middle);
    let tested = tested.clamp(1, LINES);
    let [x, y] = turned.turns[tested - 1];
    let along = turned.with_u[tested - 1];
    let [c, s] = turned.waves[tested];
    // Projections of the functions on the level, the cosine and the sine.
    let mut seen = [[0.0; 3]; 2 + 2 * LINES];
    seen[0] = [n, c, s];
    seen[1] = [u * n + block.d, along[0], along[1]];
    let pairs = seen.as_chunks_mut::<2>().0.iter_mut().skip(1);
    for (seen, order) in pairs.zip(solution.orders()) {
        let [c, s]: Wave = turned.waves[order % turned.waves.len()];
        let [of_cos, of_sin] = line_products(&turned.waves, *order, tested);
        *seen = [[c, of_cos[0], of_cos[1]], [s, of_sin[0], of_sin[1]]];
    }
    let functions = solution.functions();
    let Some([cosines, sines]) = rows.as_chunks::<2>().0.get(tested - 1) else {
        return [0.0; 2];
    };
    let mut powers = [0.0; 2];
    let rest = rest.map(|values| values.as_chunks_mut::<4>().0);
    let root = square_root(1.0 / n);
    for group in 0..CHANNELS_MAX / 4 {
        let part = |values: &Values| values.as_chunks::<4>().0[group];
        let (cos, sin, mut left) = (part(cosines), part(sines), part(&block.level));
        let mut cosine: [f32; 4] = core::array::from_fn(|k| cos[k] * x - sin[k] * y);
        let mut sine: [f32; 4] = core::array::from_fn(|k| sin[k] * x + cos[k] * y);
        for (coefficients, seen) in solution.coefficients.iter().zip(&seen).take(functions) {
            let coefficients = part(coefficients);
            for k in 0..4 {
                left[k] -= seen[0] * coefficients[k];
                cosine[k] -= seen[1] * coefficients[k];
                sine[k] -= seen[2] * coefficients[k];
            }
        }
        let weights = part(&solution.weights);
        for k in 0..4 {
            powers[0] += weights[k] * (left[k] * left[k]);
            powers[1] += weights[k] * (cosine[k] * cosine[k] + sine[k] * sine[k]);
        }
        rest[0][group] = left.map(|x| root * x);
        rest[1][group] = cosine.map(|x| SQRT_2 * root * x);
        rest[2][group] = sine.map(|x| SQRT_2 * root * x);
    }
    powers
}

/// Weighted power that the residuals contain in a line `distance` cycles from the tested line.
#[inline(never)]
fn part_power(blocks: &Blocks, residuals: &[[Values; 2]], weights: &Values, distance: f32) -> f32 {
    let mut sums = [[0.0; CHANNELS_MAX]; 2];
    for ((block, _), [cosines, sines]) in blocks.iter().zip(residuals) {
        let (c, s) = cos_sin(from_turns(0.5 * distance * block.middle));
        for k in 0..CHANNELS_MAX {
            sums[0][k] += cosines[k] * c - sines[k] * s;
            sums[1][k] += sines[k] * c + cosines[k] * s;
        }
    }
    let [cosines, sines] = &sums;
    let pairs = cosines.iter().zip(sines).zip(weights);
    pairs.map(|((c, s), weight)| weight * (c * c + s * s)).sum()
}

/// Normal deviate of the mean squared correlation between channels.
#[inline(never)]
fn correlation(residuals: &[Values], solution: &Solution, freedom: f32) -> f32 {
    // Rounding does not count as noise.
    let mut inverse = [0.0; CHANNELS_MAX];
    for (c, inverse) in inverse.iter_mut().enumerate() {
        if solution.weights[c] > 0.0 {
            let own: f32 = residuals.iter().map(|row| row[c] * row[c]).sum();
            *inverse = 1.0 / (own + freedom * solution.rounding[c]);
        }
    }
    // Squares of the channels' products in tiles of four by four, whose sums are in registers.
    let mut sum = 0.0;
    for i in 0..CHANNELS_MAX / 4 {
        for j in 0..=i {
            let mut tile = [[0.0; 4]; 4];
            for row in residuals {
                let groups = row.as_chunks::<4>().0;
                let (x, y) = (&groups[i], &groups[j]);
                for k in 0..4 {
                    for l in 0..4 {
                        tile[k][l] += x[k] * y[l];
                    }
                }
            }
            for (k, row) in tile.iter().enumerate() {
                for (l, product) in row.iter().enumerate() {
                    let (a, b) = (4 * i + k, 4 * j + l);
                    if b < a {
                        sum += product * inverse[a] * (product * inverse[b]);
                    }
                }
            }
        }
    }
    let width = inverse.iter().filter(|x| **x > 0.0).count() as f32;
    let pairs = 0.5 * width * (width - 1.0);
    if pairs < 1.0 {
        return 0.0;
    }
    deviate(freedom * sum / pairs, pairs, 1e6)
}
