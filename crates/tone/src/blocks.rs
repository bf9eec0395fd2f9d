//! Sums over blocks of frames. One pass over the frames adds up, for each block, the lines and the
//! products of every channel with level, slope and lines. All later steps work on these sums.
//!
//! Within a block, modulation is assumed constant and baselines straight.

use crate::lean::LEAN_ROWS;
use crate::legendre::baselines;
use crate::limits::{BLOCK_LINES, BLOCKS_MAX, CHANNELS_MAX, DEGREE_MAX, HARMONICS_MAX, POINTS_MAX};
use crate::lines::Lines;
use crate::matrix::Factor;
use crate::phase::{self, Wave, cos_sin, from_turns, line_products, times};
use crate::residual::Model;
use crate::rows::add_all;
use crate::solve::{Shape, Solution};
use crate::source::Values;
use crate::statistics::Products;
use crate::totals::{Totals, WAVES};
use crate::trajectory::Trajectory;
use crate::window_frames::WindowFrames;
use core::f32::consts::{FRAC_1_PI, PI};

/// Maximum number of functions in a block: cosine and sine of each line.
const FUNCTIONS: usize = 2 * HARMONICS_MAX;
const ROWS: usize = rows(BLOCK_LINES, POINTS_MAX);

/// Number of rows for cosine and sine of `lines` lines in all blocks, or for a transform of
/// `points` points.
pub const fn rows(lines: usize, points: usize) -> usize {
    let transform = points.div_ceil(CHANNELS_MAX) + LEAN_ROWS;
    if 2 * lines > transform {
        2 * lines
    } else {
        transform
    }
}

/// Minimum fraction of a function's energy that remains after projecting out the earlier ones.
/// Below this, errors of rotated blocks dominate.
const LEFT_MIN: f32 = 1e-3;

/// Sums over the frames of each block of a window.
#[derive(Debug)]
pub struct Blocks {
    rows: [Values; ROWS],
    /// Sums of cosine and sine of each multiple of the phase.
    waves: [[Wave; WAVES]; BLOCKS_MAX],
    /// Sums of each line's cosine and sine, times the distance from the block's middle.
    moments: [Wave; BLOCK_LINES],
    /// End of each block, as `u`.
    ends: [f32; BLOCKS_MAX],
    /// Products of the baselines with the channels.
    levels: [Values; DEGREE_MAX + 1],
    /// Products of the baselines with each other.
    gram: [[f32; DEGREE_MAX + 1]; DEGREE_MAX + 1],
    count: usize,
    /// Number of groups of four channels in use.
    groups: usize,
    lines: Lines,
    multiple_max: usize,
}

/// Parameters of a pass over the frames.
pub struct Pass {
    /// Phase of the unit line, divided by `scale`.
    pub trajectory: Trajectory,
    /// Ratio of the unit line's phase to the trajectory's: 1, or a half.
    pub scale: f32,
    /// Lines for which products with the channels are needed.
    pub lines: Lines,
    /// Highest multiple of the unit line for which sums are needed.
    pub multiple_max: usize,
}

impl Blocks {
    pub const fn new() -> Self {
        Self {
            rows: [[0.0; CHANNELS_MAX]; ROWS],
            waves: [[[0.0; 2]; WAVES]; BLOCKS_MAX],
            moments: [[0.0; 2]; BLOCK_LINES],
            ends: [0.0; BLOCKS_MAX],
            levels: [[0.0; CHANNELS_MAX]; DEGREE_MAX + 1],
            gram: [[0.0; DEGREE_MAX + 1]; DEGREE_MAX + 1],
            count: 0,
            groups: 0,
            lines: Lines::NONE,
            multiple_max: 0,
        }
    }

    /// Scratch memory, free between passes.
    pub fn scratch(&mut self) -> &mut [f32] {
        self.rows().as_flattened_mut()
    }

    /// Scratch memory in rows.
    pub fn rows(&mut self) -> &mut [Values] {
        &mut self.rows
    }

    /// Divides a window into blocks for passes with up to `lines` lines. Sums the products of the
    /// baselines with the channels, and of the channels with each other.
    #[inline(never)]
    pub fn start(&mut self, window: &mut WindowFrames, lines: usize, may_share: bool) -> Products {
        self.divide(window.count(), BLOCKS_MAX.min(BLOCK_LINES / lines.max(1)));
        self.groups = window.width().div_ceil(4);
        self.levels = [[0.0; CHANNELS_MAX]; DEGREE_MAX + 1];
        self.gram = [[0.0; DEGREE_MAX + 1]; DEGREE_MAX + 1];
        let (mut b, mut sums) = (0, [[0.0; CHANNELS_MAX]; 2]);
        let mut moments = [0.0; 3];
        let step = window.span.quantization_step;
        let mut products = Products::new(&window.statistics, step, may_share);
        let width = window.width();
        window.visit(|frame| {
            products.add(&frame.values, width);
            if !self.is_in(b, frame.u) {
                self.add_levels(b, &sums, &moments);
                (sums, moments) = ([[0.0; CHANNELS_MAX]; 2], [0.0; 3]);
                b = self.block(frame.u);
            }
            let from_middle = frame.u - self.middle(b);
            moments[0] += 1.0;
            moments[1] += from_middle;
            moments[2] += from_middle * from_middle;
            let [levels, slopes] = sums.each_mut().map(|sums| sums.as_chunks_mut::<4>().0);
            let groups = levels.iter_mut().zip(slopes);
            for ((levels, slopes), values) in groups
                .zip(frame.values.as_chunks::<4>().0)
                .take(self.groups)
            {
                for k in 0..4 {
                    levels[k] += values[k];
                    slopes[k] += from_middle * values[k];
                }
            }
        });
        self.add_levels(b, &sums, &moments);
        products.finish()
    }

    /// Adds a block's contribution to `gram` and `levels`.
    fn add_levels(&mut self, b: usize, sums: &[Values; 2], moments: &[f32; 3]) {
        let [count, first, second] = moments;
        let baselines = baselines(self.middle(b));
        for (i, one) in baselines.iter().enumerate() {
            for (j, other) in baselines.iter().enumerate() {
                self.gram[i][j] += one[0] * other[0] * count
                    + (one[0] * other[1] + one[1] * other[0]) * first
                    + one[1] * other[1] * second;
            }
            for (k, sum) in self.levels[i].iter_mut().enumerate() {
                *sum += one[0] * sums[0][k] + one[1] * sums[1][k];
            }
        }
    }

    fn end(&self, b: usize) -> f32 {
        self.ends[b % BLOCKS_MAX]
    }

    fn is_in(&self, b: usize, u: f32) -> bool {
        u < self.end(b) && (b == 0 || u >= self.end(b - 1))
    }

    fn block(&self, u: f32) -> usize {
        let ends = self.ends.get(..self.count).unwrap_or_default();
        let b = ends.partition_point(|end| *end <= u);
        b.min(self.count.saturating_sub(1))
    }

    /// Sums over the frames of the window, or over their residuals after subtracting a model.
    #[inline(never)]
    pub fn collect(&mut self, window: &mut WindowFrames, pass: &Pass, model: Option<&Model>) {
        self.lines = pass.lines;
        let max = pass.multiple_max.min(WAVES - 1);
        self.multiple_max = max;
        let lines = pass.lines.count().min(HARMONICS_MAX);
        let used = (2 * lines * self.count).min(2 * BLOCK_LINES);
        self.rows[..used].fill([0.0; CHANNELS_MAX]);
        self.waves = [[[0.0; 2]; WAVES]; BLOCKS_MAX];
        self.moments = [[0.0; 2]; BLOCK_LINES];
        let (mut b, mut middle, mut powers) = (0, self.middle(0), [[1.0, 0.0]; WAVES]);
        let groups = self.groups;
        let mut numbers = [0; HARMONICS_MAX];
        let places = numbers.iter_mut().zip(pass.lines.iter());
        places.for_each(|(place, line)| *place = line % WAVES);
        let mut batch = Batch::NONE;
        window.visit_residuals(model, |frame| {
            if !self.is_in(b, frame.u) {
                batch.add_to(self.rows_of(b, lines), groups);
                b = self.block(frame.u);
                middle = self.middle(b);
            }
            let places = powers.iter_mut().zip(&mut self.waves[b % BLOCKS_MAX]);
            let multiples = phase::powers(pass.trajectory.at(frame.u, pass.scale));
            for ((place, wave), power) in places.zip(multiples).take(max + 1) {
                *place = power;
                wave[0] += power[0];
                wave[1] += power[1];
            }
            let moments = self.moments.get_mut(b * lines..).unwrap_or_default();
            let weights = batch.push(&frame.values).as_chunks_mut::<2>().0.iter_mut();
            let places = moments.iter_mut().zip(weights);
            for ((moment, pair), number) in places.zip(&numbers).take(lines) {
                let [cos, sin] = powers[(*number).min(WAVES - 1)];
                moment[0] += (frame.u - middle) * cos;
                moment[1] += (frame.u - middle) * sin;
                *pair = [cos, sin];
            }
            if batch.count == BATCH {
                batch.add_to(self.rows_of(b, lines), groups);
            }
        });
        batch.add_to(self.rows_of(b, lines), groups);
    }

    /// Divides the window into up to `max` blocks of whole frames. They are shortest at the ends,
    /// where Legendre polynomials change fastest.
    fn divide(&mut self, frames: u32, max: usize) {
        let (mut first, half) = (0, 0.5 * frames as f32);
        self.count = 0;
        for i in 1..=max {
            let (cos, _) = cos_sin(from_turns(0.5 * i as f32 / max as f32));
            let end = (half * (1.0 - cos) + 0.5) as u32;
            if end > first
                && let Some(place) = self.ends.get_mut(self.count)
            {
                *place = end as f32 / half - 1.0;
                self.count += 1;
                first = end;
            }
        }
    }

    pub fn count(&self) -> usize {
        self.count.min(BLOCKS_MAX)
    }

    pub fn middle(&self, b: usize) -> f32 {
        let start = b.checked_sub(1).map_or(-1.0, |before| self.end(before));
        0.5 * (start + self.end(b))
    }

    pub fn lines(&self) -> Lines {
        self.lines
    }

    fn rows_of(&mut self, b: usize, lines: usize) -> &mut [Values] {
        let first = 2 * b * lines;
        self.rows
            .get_mut(first..first + 2 * lines)
            .unwrap_or_default()
    }

    /// Index of a block's line in `moments`, and of its pair in `rows`.
    fn index(&self, b: usize, line: usize) -> usize {
        (b * self.lines.count() + self.lines.index(line)) % BLOCK_LINES
    }

    /// Products of a line's cosine and sine with the channels in a block.
    pub fn line(&self, b: usize, line: usize) -> [&Values; 2] {
        let row = 2 * self.index(b, line);
        [&self.rows[row], &self.rows[row + 1]]
    }

    /// Sums of cosine and sine of a multiple of the phase over a block.
    pub fn wave(&self, b: usize, multiple: usize) -> Wave {
        self.waves[b % BLOCKS_MAX][multiple.min(WAVES - 1)]
    }

    /// Products of cosine and sine of a line with the baselines in a block.
    pub fn with_baselines(&self, b: usize, line: usize) -> [Wave; DEGREE_MAX + 1] {
        let (wave, moment) = (self.wave(b, line), self.moments[self.index(b, line)]);
        baselines(self.middle(b))
            .map(|[value, slope]| [0, 1].map(|i| value * wave[i] + slope * moment[i]))
    }

    /// Sums over all blocks, weighted by block: the multiples of the phase, and the products of a
    /// shape's lines with its baselines.
    pub fn totals(&self, shape: &Shape, weights: &[f32; BLOCKS_MAX]) -> Totals {
        let max = (2 * shape.lines.max()).min(self.multiple_max);
        let mut totals = Totals::default();
        for b in 0..self.count() {
            let weight = weights[b];
            let waves = totals.waves.iter_mut().zip(&self.waves[b]);
            for (sum, wave) in waves.take(max + 1) {
                sum[0] += weight * wave[0];
                sum[1] += weight * wave[1];
            }
            let baselines = baselines(self.middle(b));
            for (sums, line) in totals.baselines.iter_mut().zip(shape.lines.iter()) {
                let (wave, moment) = (self.wave(b, line), self.moments[self.index(b, line)]);
                let pairs = sums.iter_mut().zip(&baselines);
                for (sum, [value, slope]) in pairs.take(shape.degree + 1) {
                    sum[0] += weight * (value * wave[0] + slope * moment[0]);
                    sum[1] += weight * (value * wave[1] + slope * moment[1]);
                }
            }
        }
        totals
    }

    /// Writes the products of a shape's lines with the channels into rows.
    fn products(&self, shape: &Shape, rows: &mut [Values]) {
        let pairs = rows.as_chunks_mut::<2>().0.iter_mut();
        for (pair, line) in pairs.zip(shape.lines.iter()) {
            for (i, sums) in pair.iter_mut().enumerate() {
                *sums = [0.0; CHANNELS_MAX];
                let groups = sums.as_chunks_mut::<4>().0.iter_mut().enumerate();
                // Keep a group's sums in registers.
                for (g, sums) in groups.take(self.groups) {
                    let [mut a, mut b, mut c, mut d] = [0.0; 4];
                    for pair in self.pairs(line) {
                        let row = pair.get(i).and_then(|row| row.as_chunks::<4>().0.get(g));
                        let Some(values) = row else { break };
                        a += values[0];
                        b += values[1];
                        c += values[2];
                        d += values[3];
                    }
                    *sums = [a, b, c, d];
                }
            }
        }
    }

    /// Products of a line's cosine and sine with the channels, block by block.
    pub fn pairs(&self, line: usize) -> impl Iterator<Item = &[Values; 2]> {
        let pairs = self.rows.as_chunks::<2>().0.iter();
        let each = self.lines.count().max(1);
        pairs
            .skip(self.lines.index(line))
            .step_by(each)
            .take(self.count())
    }

    pub fn groups(&self) -> usize {
        self.groups
    }

    /// Rotates the blocks from one phase trajectory of the unit line to another.
    #[inline(never)]
    pub fn turn(&mut self, from: &Trajectory, to: &Trajectory) {
        for b in 0..self.count() {
            let u = self.middle(b);
            let turns = 0.5 * (to.cycles - from.cycles) * u
                + 0.5 * FRAC_1_PI * (to.movement(u) - from.movement(u));
            let (cos, sin) = cos_sin(from_turns(turns));
            let mut power = [1.0, 0.0];
            for m in 1..=self.multiple_max.min(WAVES - 1) {
                power = times(power, [cos, sin]);
                let rotate = |wave: &mut Wave| *wave = times(*wave, power);
                rotate(&mut self.waves[b][m]);
                if self.lines.has(m) {
                    let place = self.index(b, m);
                    rotate(&mut self.moments[place]);
                    let [first, second] = &mut self.rows.as_chunks_mut::<2>().0[place];
                    for (cos, sin) in first.iter_mut().zip(second).take(4 * self.groups) {
                        let mut wave = [*cos, *sin];
                        rotate(&mut wave);
                        [*cos, *sin] = wave;
                    }
                }
            }
        }
    }

    /// Largest difference in rotation between adjacent blocks from one trajectory to another, in
    /// radians of the unit line: a measure of the error within rotated blocks.
    pub fn twist(&self, from: &Trajectory, to: &Trajectory) -> f32 {
        let turned = |b: usize| {
            let u = self.middle(b);
            PI * (to.cycles - from.cycles) * u + to.movement(u) - from.movement(u)
        };
        (1..self.count)
            .map(|b| (turned(b) - turned(b - 1)).abs())
            .fold(0.0, f32::max)
    }

    /// Modulates a shape's lines in block `b` by `moved` (phase, relative amplitude): adds the
    /// effect to the channels' products with the lines and with the shape's baselines.
    pub fn add(&mut self, b: usize, shape: &Shape, coefficients: &[Values], moved: [f32; 2]) {
        let [phase, amplitude] = moved;
        // Apply the modulation to the products rather than to the coefficients.
        let gain = |line: usize, [cos, sin]: Wave| {
            let turn = phase * line as f32;
            [amplitude * cos - turn * sin, amplitude * sin + turn * cos]
        };
        let lines = || shape.lines.iter().enumerate().take(HARMONICS_MAX);
        for one in self.lines.iter() {
            let mut factors = [[0.0; FUNCTIONS]; 2];
            for (j, line) in lines() {
                for (row, product) in
                    factors
                        .iter_mut()
                        .zip(line_products(&self.waves[b % BLOCKS_MAX], one, line))
                {
                    row.as_chunks_mut::<2>().0[j] = gain(line, product);
                }
            }
            let place = self.index(b, one);
            let sums = &mut self.rows.as_chunks_mut::<2>().0[place];
            for (sums, factors) in sums.iter_mut().zip(&factors) {
                add_all(sums, self.groups, coefficients, factors);
            }
        }
        let mut factors = [[0.0; FUNCTIONS]; DEGREE_MAX + 1];
        for (j, line) in lines() {
            for (row, product) in factors.iter_mut().zip(self.with_baselines(b, line)) {
                row.as_chunks_mut::<2>().0[j] = gain(line, product);
            }
        }
        let levels = self.levels.iter_mut().zip(&factors);
        for (level, factors) in levels.take(shape.degree + 1) {
            add_all(level, self.groups, coefficients, factors);
        }
    }
}

impl Solution {
    /// Projects the channels onto a shape's functions.
    #[inline(never)]
    pub fn project(&mut self, blocks: &Blocks, shape: Shape) {
        let first = shape.first_line();
        self.shape = shape;
        for (row, known) in self.lower.iter_mut().zip(&blocks.gram).take(first) {
            row[..=DEGREE_MAX].copy_from_slice(known);
        }
        self.rows[..first].copy_from_slice(&blocks.levels[..first]);
        let totals = blocks.totals(&shape, &[1.0; BLOCKS_MAX]);
        totals.of_shape(&shape, &mut self.lower[first..]);
        blocks.products(&shape, &mut self.rows[first..]);
        // Clear what an earlier solution left in the last group.
        self.rows[shape.unknowns()..].fill([0.0; CHANNELS_MAX]);
        let factor = Factor::with_pivots(&mut self.lower, shape.unknowns(), LEFT_MIN);
        factor.forward_rows(&mut self.rows);
    }
}

/// Frames added to a block at a time, so that each sum is read and written once for all of them.
const BATCH: usize = 4;

/// A few frames, with cosine and sine of each line.
struct Batch {
    values: [Values; BATCH],
    weights: [[f32; FUNCTIONS]; BATCH],
    count: usize,
}

impl Batch {
    const NONE: Self = Self {
        values: [[0.0; CHANNELS_MAX]; BATCH],
        weights: [[0.0; FUNCTIONS]; BATCH],
        count: 0,
    };

    /// Adds a frame; the caller fills in its cosines and sines.
    fn push(&mut self, values: &Values) -> &mut [f32; FUNCTIONS] {
        let place = self.count % BATCH;
        self.values[place] = *values;
        self.count += 1;
        &mut self.weights[place]
    }

    /// Adds the frames to the rows of a block and empties the batch; `groups` is the number of
    /// groups of four channels in use.
    #[inline(never)]
    fn add_to(&mut self, rows: &mut [Values], groups: usize) {
        // Clear the weights of an earlier batch.
        self.weights[self.count.min(BATCH)..].fill([0.0; FUNCTIONS]);
        let [one, two, three, four] = self
            .values
            .each_ref()
            .map(|values| values.as_chunks::<4>().0);
        for (i, [cosine, sine]) in rows.as_chunks_mut::<2>().0.iter_mut().enumerate() {
            let place = 2 * i.min(HARMONICS_MAX - 1);
            let cos = self.weights.map(|weights| weights[place]);
            let sin = self.weights.map(|weights| weights[place + 1]);
            let frames = one.iter().zip(two).zip(three.iter().zip(four));
            let cosine = cosine.as_chunks_mut::<4>().0.iter_mut();
            let sine = sine.as_chunks_mut::<4>().0.iter_mut();
            for ((cosine, sine), ((one, two), (three, four))) in
                cosine.zip(sine).zip(frames).take(groups)
            {
                for k in 0..4 {
                    let (a, b, c, d) = (one[k], two[k], three[k], four[k]);
                    cosine[k] += cos[0] * a + cos[1] * b + cos[2] * c + cos[3] * d;
                    sine[k] += sin[0] * a + sin[1] * b + sin[2] * c + sin[3] * d;
                }
            }
        }
        self.count = 0;
    }
}
