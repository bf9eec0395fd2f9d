//! A pass over the frames: for each of a few blocks the products of every channel with level,
//! slope and the lines, and the sums of the lines themselves. All that follows works on these.
//!
//! Within a block what modulates a line is taken to be constant, and baselines to be straight.

use crate::data::Data;
use crate::legendre::{legendre, slopes};
use crate::limits::{
    BLOCKS_MAX, CHANNELS_MAX, DEGREE_MAX, HARMONICS_MAX, POINTS_MAX, UNKNOWNS_MAX,
};
use crate::lines::Lines;
use crate::phase::{cos_sin, from_turns};
use crate::phase_course::Course;
use crate::residual::Model;
use crate::solve::Shape;
use crate::source::Values;
use core::f32::consts::FRAC_1_PI;

/// Functions of a block: cosine and sine of each line.
const FUNCTIONS: usize = 2 * HARMONICS_MAX;
/// Rows of memory that blocks need.
const ROWS_BLOCKS: usize = BLOCKS_MAX * FUNCTIONS;
const ROWS: usize = rows(POINTS_MAX);

/// Rows of memory: what blocks need, or a transform.
pub const fn rows(points: usize) -> usize {
    let transform = points.div_ceil(CHANNELS_MAX);
    if ROWS_BLOCKS > transform {
        ROWS_BLOCKS
    } else {
        transform
    }
}

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
    /// Sums of cosine and sine of each line times the distance from the block's middle.
    moments: [[Wave; HARMONICS_MAX]; BLOCKS_MAX],
    /// Ends and middles of the blocks.
    ends: [f32; BLOCKS_MAX],
    /// Middles of the blocks.
    middles: [f32; BLOCKS_MAX],
    /// How far blocks have been turned since the pass, radians of the unit line.
    turned: [f32; BLOCKS_MAX],
    /// Values and slopes of the baselines in the middles of the blocks.
    baselines: [[[f32; 2]; DEGREE_MAX + 1]; BLOCKS_MAX],
    /// Products of the baselines with the channels.
    levels: [Values; DEGREE_MAX + 1],
    /// Products of the baselines with each other.
    gram: [[f32; DEGREE_MAX + 1]; DEGREE_MAX + 1],
    count: usize,
    lines: Lines,
    most: usize,
}

/// What is passed over.
pub struct Pass {
    /// The unit line's phase.
    pub course: Course,
    /// The unit is this part of the course's phase: 1, or a half.
    pub scale: f32,
    /// Lines whose products with the channels are wanted.
    pub lines: Lines,
    /// Highest multiple of the unit whose sums are wanted.
    pub most: usize,
}

impl Blocks {
    /// Empty ones; all zeros.
    pub const fn new() -> Self {
        Self {
            rows: [[0.0; CHANNELS_MAX]; ROWS],
            waves: [[[0.0; 2]; WAVES]; BLOCKS_MAX],
            moments: [[[0.0; 2]; HARMONICS_MAX]; BLOCKS_MAX],
            ends: [0.0; BLOCKS_MAX],
            middles: [0.0; BLOCKS_MAX],
            turned: [0.0; BLOCKS_MAX],
            baselines: [[[0.0; 2]; DEGREE_MAX + 1]; BLOCKS_MAX],
            levels: [[0.0; CHANNELS_MAX]; DEGREE_MAX + 1],
            gram: [[0.0; DEGREE_MAX + 1]; DEGREE_MAX + 1],
            count: 0,
            lines: Lines::NONE,
            most: 0,
        }
    }

    /// Memory that holds nothing between passes.
    pub fn scratch(&mut self) -> &mut [f32] {
        self.rows.as_flattened_mut()
    }

    /// Divides a window, and passes over it for what baselines have.
    #[inline(never)]
    pub fn start(&mut self, data: &mut Data) {
        self.divide(data.count());
        self.levels = [[0.0; CHANNELS_MAX]; DEGREE_MAX + 1];
        self.gram = [[0.0; DEGREE_MAX + 1]; DEGREE_MAX + 1];
        let (mut b, mut sums) = (0, [[0.0; CHANNELS_MAX]; 2]);
        let mut moments = [0.0; 3];
        data.visit(|frame| {
            if !self.is_in(b, frame.u) {
                self.add_levels(b, &sums, &moments);
                (sums, moments) = ([[0.0; CHANNELS_MAX]; 2], [0.0; 3]);
                b = self.block(frame.u);
            }
            let from_middle = frame.u - self.middles[b];
            moments[0] += 1.0;
            moments[1] += from_middle;
            moments[2] += from_middle * from_middle;
            for (k, value) in frame.values.iter().enumerate() {
                sums[0][k] += value;
                sums[1][k] += from_middle * value;
            }
        });
        self.add_levels(b, &sums, &moments);
    }

    /// Adds what baselines have of a block.
    fn add_levels(&mut self, b: usize, sums: &[Values; 2], moments: &[f32; 3]) {
        let [count, first, second] = moments;
        for (i, one) in self.baselines[b].iter().enumerate() {
            for (j, other) in self.baselines[b].iter().enumerate() {
                self.gram[i][j] += one[0] * other[0] * count
                    + (one[0] * other[1] + one[1] * other[0]) * first
                    + one[1] * other[1] * second;
            }
            for (k, sum) in self.levels[i].iter_mut().enumerate() {
                *sum += one[0] * sums[0][k] + one[1] * sums[1][k];
            }
        }
    }

    /// Whether a place is in a block.
    fn is_in(&self, b: usize, u: f32) -> bool {
        u < self.ends[b] && (b == 0 || u >= self.ends[b - 1])
    }

    /// Block of a place.
    fn block(&self, u: f32) -> usize {
        let ends = self.ends.get(..self.count).unwrap_or_default();
        let b = ends.partition_point(|end| *end <= u);
        b.min(self.count.saturating_sub(1))
    }

    /// Passes over the window, or over what a model leaves of it.
    #[inline(never)]
    pub fn collect(&mut self, data: &mut Data, pass: &Pass, model: Option<&Model>) {
        self.lines = pass.lines;
        self.most = pass.most.min(WAVES - 1);
        self.rows[..ROWS_BLOCKS].fill([0.0; CHANNELS_MAX]);
        self.waves = [[[0.0; 2]; WAVES]; BLOCKS_MAX];
        self.moments = [[[0.0; 2]; HARMONICS_MAX]; BLOCKS_MAX];
        self.turned = [0.0; BLOCKS_MAX];
        let (mut b, mut powers) = (0, [[1.0, 0.0]; WAVES]);
        let mut batch = Batch::NONE;
        data.visit_beside(model, |frame| {
            if !self.is_in(b, frame.u) {
                batch.add_to(&mut self.rows[b * FUNCTIONS..][..FUNCTIONS]);
                b = self.block(frame.u);
            }
            let from_middle = frame.u - self.middles[b];
            let (cos, sin) = cos_sin(pass.course.at(frame.u, pass.scale));
            for m in 1..=self.most {
                let [c, s] = powers[m - 1];
                powers[m] = [c * cos - s * sin, s * cos + c * sin];
            }
            for (wave, power) in self.waves[b].iter_mut().zip(&powers).take(self.most + 1) {
                wave[0] += power[0];
                wave[1] += power[1];
            }
            for (moment, line) in self.moments[b].iter_mut().zip(pass.lines.iter()) {
                let [cos, sin] = powers[line % WAVES];
                moment[0] += from_middle * cos;
                moment[1] += from_middle * sin;
            }
            batch.push(&frame.values, pass.lines, &powers);
            if batch.count == BATCH {
                batch.add_to(&mut self.rows[b * FUNCTIONS..][..FUNCTIONS]);
            }
        });
        batch.add_to(&mut self.rows[b * FUNCTIONS..][..FUNCTIONS]);
    }

    /// Divides the window into blocks of whole frames. They are shortest at the ends, where Legendre
    /// polynomials change fastest.
    fn divide(&mut self, frames: u32) {
        let (mut first, half) = (0, 0.5 * frames as f32);
        self.count = 0;
        for i in 1..=BLOCKS_MAX {
            let (cos, _) = cos_sin(from_turns(0.5 * i as f32 / BLOCKS_MAX as f32));
            let end = (half * (1.0 - cos) + 0.5) as u32;
            if end > first {
                self.middles[self.count] = 0.5 * (first + end) as f32 / half - 1.0;
                self.ends[self.count] = end as f32 / half - 1.0;
                let u = self.middles[self.count];
                let (values, slopes) = (legendre::<5>(u), slopes::<5>(u));
                self.baselines[self.count] = core::array::from_fn(|k| [values[k], slopes[k]]);
                self.count += 1;
                first = end;
            }
        }
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
        let row = b * FUNCTIONS + 2 * self.lines.place(line);
        [&self.rows[row], &self.rows[row + 1]]
    }

    /// Sums of a multiple of the phase in a block.
    pub fn wave(&self, b: usize, multiple: usize) -> Wave {
        self.waves[b][multiple.min(WAVES - 1)]
    }

    /// Products of the baselines with the channels.
    pub fn levels(&self) -> &[Values; DEGREE_MAX + 1] {
        &self.levels
    }

    /// Products of the baselines with each other.
    pub fn of_baselines(&self) -> &[[f32; DEGREE_MAX + 1]; DEGREE_MAX + 1] {
        &self.gram
    }

    /// Products of cosine and sine of a line with the baseline of a degree in a block.
    pub fn with_baseline(&self, b: usize, line: usize, degree: usize) -> Wave {
        let wave = self.wave(b, line);
        let moment = self.moments[b][self.lines.place(line) % HARMONICS_MAX];
        let [value, slope] = self.baselines[b][degree];
        [0, 1].map(|i| value * wave[i] + slope * moment[i])
    }

    /// Sums over all blocks, each with its weight: of the multiples of the phase up to `most`, and
    /// of the lines' products with the baselines of a shape.
    pub fn totals(&self, shape: &Shape, weights: &[f32; BLOCKS_MAX]) -> Totals {
        let most = (2 * shape.lines.most()).min(self.most);
        let mut totals = Totals::NONE;
        for b in 0..self.count {
            let weight = weights[b];
            let waves = totals.waves.iter_mut().zip(&self.waves[b]);
            for (sum, wave) in waves.take(most + 1) {
                sum[0] += weight * wave[0];
                sum[1] += weight * wave[1];
            }
            let baselines = &self.baselines[b][..=shape.degree.min(DEGREE_MAX)];
            for (sums, line) in totals.baselines.iter_mut().zip(shape.lines.iter()) {
                let wave = self.wave(b, line);
                let moment = self.moments[b][self.lines.place(line) % HARMONICS_MAX];
                for (sum, [value, slope]) in sums.iter_mut().zip(baselines) {
                    sum[0] += weight * (value * wave[0] + slope * moment[0]);
                    sum[1] += weight * (value * wave[1] + slope * moment[1]);
                }
            }
        }
        totals
    }

    /// Products of the lines of a shape with the channels, each block with its weight, into rows.
    pub fn products(&self, shape: &Shape, weights: &[f32; BLOCKS_MAX], rows: &mut [Values]) {
        let pairs = rows.chunks_exact_mut(2);
        for (sums, line) in pairs.zip(shape.lines.iter()) {
            let place = 2 * self.lines.place(line);
            for (r, sums) in sums.iter_mut().enumerate() {
                *sums = [0.0; CHANNELS_MAX];
                for b in 0..self.count {
                    let row = &self.rows[b * FUNCTIONS + place + r];
                    for (sum, value) in sums.iter_mut().zip(row) {
                        *sum += weights[b] * value;
                    }
                }
            }
        }
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
                if self.lines.has(m) {
                    let place = self.lines.place(m) % HARMONICS_MAX;
                    rotate(&mut self.moments[b][place], power);
                    let row = b * FUNCTIONS + 2 * self.lines.place(m);
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
    pub fn add(&mut self, b: usize, lines: Lines, change: &[Values]) {
        for (j, line) in lines.iter().enumerate() {
            for one in self.lines.iter() {
                let products = self.of_lines(b, one, line);
                let row = b * FUNCTIONS + 2 * self.lines.place(one);
                for (i, products) in products.iter().enumerate() {
                    for (k, sum) in self.rows[row + i].iter_mut().enumerate() {
                        *sum += products[0] * change[2 * j][k] + products[1] * change[2 * j + 1][k];
                    }
                }
            }
            for degree in 0..self.levels.len() {
                let products = self.with_baseline(b, line, degree);
                for (k, sum) in self.levels[degree].iter_mut().enumerate() {
                    *sum += products[0] * change[2 * j][k] + products[1] * change[2 * j + 1][k];
                }
            }
        }
    }

    /// Products of two lines in a block.
    fn of_lines(&self, b: usize, one: usize, other: usize) -> [Wave; 2] {
        of_lines(&self.waves[b], one, other)
    }
}

/// Products of two lines: of cosine and sine of the one with those of the other.
fn of_lines(waves: &[Wave; WAVES], one: usize, other: usize) -> [Wave; 2] {
    let [cos, sin] = waves[one.abs_diff(other) % WAVES];
    let difference = [cos, if one < other { -sin } else { sin }];
    let sum = waves[(one + other) % WAVES];
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

/// Sums over all blocks.
#[derive(Clone, Debug)]
pub struct Totals {
    waves: [Wave; WAVES],
    baselines: [[Wave; DEGREE_MAX + 1]; HARMONICS_MAX],
}

impl Totals {
    const NONE: Self = Self {
        waves: [[0.0; 2]; WAVES],
        baselines: [[[0.0; 2]; DEGREE_MAX + 1]; HARMONICS_MAX],
    };

    /// Products of the lines of a shape with its unknowns' functions, into rows.
    pub fn of_shape(&self, shape: &Shape, products: &mut [[f32; UNKNOWNS_MAX]]) {
        let first = shape.first_line();
        for (i, line) in shape.lines.iter().enumerate() {
            for (j, wave) in self.baselines[i].iter().enumerate().take(first) {
                (products[2 * i][j], products[2 * i + 1][j]) = (wave[0], wave[1]);
            }
            for (j, other) in shape.lines.iter().enumerate() {
                let product = of_lines(&self.waves, line, other);
                for r in 0..2 {
                    products[2 * i + r][first + 2 * j] = product[r][0];
                    products[2 * i + r][first + 2 * j + 1] = product[r][1];
                }
            }
        }
    }
}

/// Frames that are added to a block at a time: a sum is then read and written once for all.
const BATCH: usize = 4;

/// A few frames, and the lines' cosines and sines there.
struct Batch {
    values: [Values; BATCH],
    weights: [[f32; BATCH]; FUNCTIONS],
    count: usize,
    functions: usize,
}

impl Batch {
    const NONE: Self = Self {
        values: [[0.0; CHANNELS_MAX]; BATCH],
        weights: [[0.0; BATCH]; FUNCTIONS],
        count: 0,
        functions: 0,
    };

    fn push(&mut self, values: &Values, lines: Lines, powers: &[Wave; WAVES]) {
        let place = self.count % BATCH;
        self.values[place] = *values;
        self.functions = 0;
        for (i, line) in lines.iter().enumerate().take(HARMONICS_MAX) {
            let [cos, sin] = powers[line % WAVES];
            self.weights[2 * i][place] = cos;
            self.weights[2 * i + 1][place] = sin;
            self.functions += 2;
        }
        self.count += 1;
    }

    /// Adds them to the rows of a block, and forgets them.
    #[inline(never)]
    fn add_to(&mut self, rows: &mut [Values]) {
        let [one, two, three, four] = &self.values;
        for (row, weights) in rows.iter_mut().zip(&mut self.weights).take(self.functions) {
            let [a, b, c, d] = *weights;
            for k in 0..CHANNELS_MAX {
                row[k] += a * one[k] + b * two[k] + c * three[k] + d * four[k];
            }
            *weights = [0.0; BATCH];
        }
        self.count = 0;
    }
}

/// Multiplies a complex number by another.
fn rotate(wave: &mut Wave, by: Wave) {
    let [c, s] = *wave;
    *wave = [c * by[0] - s * by[1], s * by[0] + c * by[1]];
}
