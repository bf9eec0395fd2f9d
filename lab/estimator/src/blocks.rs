//! A pass over the frames: for each of a few blocks the products of every channel with level,
//! slope and the lines, and the sums of the lines themselves. All that follows works on these.
//!
//! Within a block what modulates a line is taken to be constant, and baselines to be straight.

use crate::legendre::{legendre, slopes};
use crate::limits::{BLOCKS_MAX, CHANNELS_MAX, DEGREE_MAX, HARMONICS_MAX, POINTS_MAX};
use crate::lines::Lines;
use crate::phase::{cos_sin, from_turns};
use crate::phase_course::Course;
use crate::residual::Model;
use crate::pieces::Data;
use crate::source::Values;
use core::f32::consts::FRAC_1_PI;

/// Functions of a block: level, slope, cosine and sine of each line.
const FUNCTIONS: usize = 2 + 2 * HARMONICS_MAX;
/// Rows of memory: what blocks need, or a transform with four spectra.
const ROWS_BLOCKS: usize = BLOCKS_MAX * FUNCTIONS;
const ROWS_TRANSFORM: usize = (3 * POINTS_MAX).div_ceil(CHANNELS_MAX);
const ROWS: usize = if ROWS_BLOCKS > ROWS_TRANSFORM {
    ROWS_BLOCKS
} else {
    ROWS_TRANSFORM
};
/// Multiples of the unit line whose sums are kept.
pub const WAVES: usize = 2 * HARMONICS_MAX + 4;

/// A cosine and a sine.
pub type Wave = [f32; 2];

/// Sums over the blocks of a window.
#[derive(Debug)]
pub struct Blocks {
    rows: [Values; ROWS],
    /// Sums of cosine and sine of each multiple of the phase.
    waves: [[Wave; WAVES]; BLOCKS_MAX],
    /// Sums of cosine and sine times the distance from the block's middle.
    moments: [[Wave; WAVES]; BLOCKS_MAX],
    /// Sums of that distance squared.
    squares: [f32; BLOCKS_MAX],
    /// Middles of the blocks.
    middles: [f32; BLOCKS_MAX],
    /// How far blocks have been turned since the pass, radians of the unit line.
    turned: [f32; BLOCKS_MAX],
    count: usize,
    lines: Lines,
    most: usize,
}

/// What is passed over.
pub struct Pass<'m> {
    /// The unit line's phase.
    pub course: Course,
    /// The unit is this part of the course's phase: 1, or a half.
    pub scale: f32,
    /// Lines whose products with the channels are wanted.
    pub lines: Lines,
    /// Highest multiple of the unit whose sums are wanted.
    pub most: usize,
    /// What is subtracted from the channels.
    pub model: Option<&'m Model>,
}

impl Blocks {
    /// Empty ones; all zeros.
    pub const fn new() -> Self {
        Self {
            rows: [[0.0; CHANNELS_MAX]; ROWS],
            waves: [[[0.0; 2]; WAVES]; BLOCKS_MAX],
            moments: [[[0.0; 2]; WAVES]; BLOCKS_MAX],
            squares: [0.0; BLOCKS_MAX],
            middles: [0.0; BLOCKS_MAX],
            turned: [0.0; BLOCKS_MAX],
            count: 0,
            lines: Lines::NONE,
            most: 0,
        }
    }

    /// Memory that holds nothing between passes.
    pub fn scratch(&mut self) -> &mut [f32] {
        self.rows.as_flattened_mut()
    }

    /// Passes over the frames.
    #[inline(never)]
    pub fn collect(&mut self, data: &Data, pass: &Pass) {
        let width = data.width;
        self.lines = pass.lines;
        self.most = pass.most.min(WAVES - 1);
        self.rows[..ROWS_BLOCKS].fill([0.0; CHANNELS_MAX]);
        self.waves = [[[0.0; 2]; WAVES]; BLOCKS_MAX];
        self.moments = [[[0.0; 2]; WAVES]; BLOCKS_MAX];
        self.squares = [0.0; BLOCKS_MAX];
        self.turned = [0.0; BLOCKS_MAX];
        let ends = self.divide(data.pieces.count() as u32);
        for frame in data.iter() {
            let b = ends
                .partition_point(|end| *end <= frame.u)
                .min(self.count - 1);
            let from_middle = frame.u - self.middles[b];
            let (cos, sin) = cos_sin(pass.course.at(frame.u, pass.scale));
            let mut powers = [[1.0, 0.0]; WAVES];
            for m in 1..=self.most {
                let [c, s] = powers[m - 1];
                powers[m] = [c * cos - s * sin, s * cos + c * sin];
            }
            self.squares[b] += from_middle * from_middle;
            let sums = self.waves[b].iter_mut().zip(&mut self.moments[b]);
            for ((wave, moment), power) in sums.zip(&powers).take(self.most + 1) {
                for (i, power) in power.iter().enumerate() {
                    wave[i] += power;
                    moment[i] += from_middle * power;
                }
            }
            let residual;
            let values = match pass.model {
                Some(model) => {
                    residual = model.residual(&frame);
                    &residual
                }
                None => &frame.values,
            };
            let rows = &mut self.rows[b * FUNCTIONS..][..FUNCTIONS];
            let mut add = |row: usize, weight: f32| {
                for (sum, value) in rows[row].iter_mut().zip(values).take(width) {
                    *sum += weight * value;
                }
            };
            add(0, 1.0);
            add(1, from_middle);
            for (i, line) in pass.lines.iter().enumerate().take(HARMONICS_MAX) {
                let [cos, sin] = powers[line];
                add(2 + 2 * i, cos);
                add(3 + 2 * i, sin);
            }
        }
    }

    /// Divides the window: blocks are as long as Legendre polynomials change slowly, shortest at the
    /// ends, and hold whole frames. Gives their ends.
    fn divide(&mut self, frames: u32) -> [f32; BLOCKS_MAX] {
        let mut ends = [f32::INFINITY; BLOCKS_MAX];
        let (mut first, half) = (0, 0.5 * frames as f32);
        self.count = 0;
        for i in 1..=BLOCKS_MAX {
            let (cos, _) = cos_sin(from_turns(0.5 * i as f32 / BLOCKS_MAX as f32));
            let end = (half * (1.0 - cos) + 0.5) as u32;
            if end > first {
                self.middles[self.count] = 0.5 * (first + end) as f32 / half - 1.0;
                ends[self.count] = end as f32 / half - 1.0;
                self.count += 1;
                first = end;
            }
        }
        ends
    }

    /// How many blocks there are.
    pub fn count(&self) -> usize {
        self.count
    }

    /// Middle of a block.
    pub fn middle(&self, b: usize) -> f32 {
        self.middles[b]
    }

    /// The lines of the pass.
    pub fn lines(&self) -> Lines {
        self.lines
    }

    /// Products of a line's cosine and sine with the channels in a block.
    pub fn line(&self, b: usize, line: usize) -> [&Values; 2] {
        let row = b * FUNCTIONS + 2 + 2 * self.lines.place(line);
        [&self.rows[row], &self.rows[row + 1]]
    }

    /// Products of level and slope with the channels in a block.
    pub fn level(&self, b: usize) -> [&Values; 2] {
        let row = b * FUNCTIONS;
        [&self.rows[row], &self.rows[row + 1]]
    }

    /// Sums of a multiple of the phase in a block; its cosine and sine, of a negative multiple too.
    pub fn wave(&self, b: usize, multiple: isize) -> Wave {
        let [cos, sin] = self.waves[b][multiple.unsigned_abs().min(WAVES - 1)];
        [cos, if multiple < 0 { -sin } else { sin }]
    }

    /// Products of cosine and sine of a line with the baseline of a degree in a block, whose value
    /// and slope in the middle are given.
    pub fn with_baseline(&self, b: usize, line: usize, baseline: [f32; 2]) -> Wave {
        let (wave, moment) = (self.waves[b][line], self.moments[b][line]);
        [0, 1].map(|i| baseline[0] * wave[i] + baseline[1] * moment[i])
    }

    /// Product of two baselines in a block.
    pub fn of_baselines(&self, b: usize, one: [f32; 2], other: [f32; 2]) -> f32 {
        one[0] * other[0] * self.waves[b][0][0]
            + (one[0] * other[1] + one[1] * other[0]) * self.moments[b][0][0]
            + one[1] * other[1] * self.squares[b]
    }

    /// Values and slopes of the baselines in the middle of a block.
    pub fn baselines(&self, b: usize) -> [[f32; 2]; DEGREE_MAX + 1] {
        let (values, slopes) = (legendre::<5>(self.middles[b]), slopes::<5>(self.middles[b]));
        core::array::from_fn(|k| [values[k], slopes[k]])
    }

    /// Products of two lines in a block: of cosine and sine of the one with those of the other.
    pub fn of_lines(&self, b: usize, one: usize, other: usize) -> [Wave; 2] {
        let difference = self.wave(b, one as isize - other as isize);
        let sum = self.wave(b, (one + other) as isize);
        [
            [
                0.5 * (difference[0] + sum[0]),
                0.5 * (sum[1] - difference[1]),
            ],
            [
                0.5 * (sum[1] + difference[1]),
                0.5 * (difference[0] - sum[0]),
            ],
        ]
    }

    /// Turns the unit line to another course.
    #[inline(never)]
    pub fn turn(&mut self, from: &Course, to: &Course) {
        for b in 0..self.count {
            let u = self.middles[b];
            let turns = 0.5 * (to.cycles - from.cycles) * u
                + 0.5 * FRAC_1_PI * (to.movement(u) - from.movement(u));
            self.turned[b] += turns / (0.5 * FRAC_1_PI);
            let (cos, sin) = cos_sin(from_turns(turns));
            let mut power = [1.0, 0.0];
            for m in 1..=self.most {
                let [c, s] = power;
                power = [c * cos - s * sin, s * cos + c * sin];
                rotate(&mut self.waves[b][m], power);
                rotate(&mut self.moments[b][m], power);
                if self.lines.has(m) {
                    let row = b * FUNCTIONS + 2 + 2 * self.lines.place(m);
                    let (first, second) = self.rows.split_at_mut(row + 1);
                    for (cos, sin) in first[row].iter_mut().zip(&mut second[0]) {
                        let mut wave = [*cos, *sin];
                        rotate(&mut wave, power);
                        [*cos, *sin] = wave;
                    }
                }
            }
        }
    }

    /// How far, in radians, neighbouring blocks have been turned against each other: what a block's
    /// own frames still lack.
    pub fn twist(&self) -> f32 {
        let turned = self.turned.get(..self.count).unwrap_or_default();
        turned
            .windows(2)
            .map(|pair| (pair[1] - pair[0]).abs())
            .fold(0.0, f32::max)
    }

    /// Adds a part of a function of the lines to the channels' products in a block: `change` has
    /// its coefficients for cosine and sine of each of `lines`.
    pub fn add(&mut self, b: usize, lines: Lines, change: &[Values; 2 * HARMONICS_MAX]) {
        for (j, line) in lines.iter().enumerate() {
            for one in self.lines.iter() {
                let products = self.of_lines(b, one, line);
                let row = b * FUNCTIONS + 2 + 2 * self.lines.place(one);
                for (i, products) in products.iter().enumerate() {
                    for (k, sum) in self.rows[row + i].iter_mut().enumerate() {
                        *sum += products[0] * change[2 * j][k] + products[1] * change[2 * j + 1][k];
                    }
                }
            }
            for (i, baseline) in [[1.0, 0.0], [0.0, 1.0]].into_iter().enumerate() {
                let products = self.with_baseline(b, line, baseline);
                for (k, sum) in self.rows[b * FUNCTIONS + i].iter_mut().enumerate() {
                    *sum += products[0] * change[2 * j][k] + products[1] * change[2 * j + 1][k];
                }
            }
        }
    }
}

/// Multiplies a complex number by another.
fn rotate(wave: &mut Wave, by: Wave) {
    let [c, s] = *wave;
    *wave = [c * by[0] - s * by[1], s * by[0] + c * by[1]];
}
