//! The second pass: the window in at most [`BLOCKS_MAX`] blocks, each as the sums of its frames
//! times a local basis: 1, `v` (`u` from the block's centre), and cosine and sine of each line with
//! their phases at the block's centre.
//!
//! Whatever follows needs the frames no more: lines that are off by a small part of a cycle a
//! window, baselines that are smooth, and how amplitude and phase move from block to block.

use crate::frame_span::{BLOCK, Block, FrameSpan};
use crate::limits::{BLOCKS_MAX, CHANNELS_MAX, LINES_MAX, PIECES_MAX, POINTS_MAX};
use crate::phase::{cos_sin, from_turns};
use crate::source::{Overwritten, Values};
use crate::statistics::{Channels, Statistics};
use core::ops::Range;

/// Functions of the local basis.
pub const LOCAL: usize = 2 + 2 * LINES_MAX;
/// Their products with each other: the lower triangle, row by row.
pub const PRODUCTS: usize = LOCAL * (LOCAL + 1) / 2;

/// Index of a product, `row` not less than `column`; never beyond the last, which spares a check.
#[inline(always)]
pub const fn product(row: usize, column: usize) -> usize {
    let index = row * (row + 1) / 2 + column;
    if index < PRODUCTS {
        index
    } else {
        PRODUCTS - 1
    }
}

/// The lines of a pass.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lines {
    /// The fundamental's cycles per half window.
    pub nu: f32,
    pub harmonics: usize,
    /// An interferer's, behind the harmonics.
    pub interferer: Option<f32>,
}

impl Lines {
    /// Cycles per half window of each line, and how many there are; with `half_line` that at half
    /// the fundamental in an interferer's place, where there is none.
    pub fn all(&self, half_line: bool) -> ([f32; LINES_MAX], usize) {
        let mut all = [0.0; LINES_MAX];
        let harmonics = self
            .harmonics
            .min(LINES_MAX - self.interferer.is_some() as usize);
        for (h, nu) in all.iter_mut().enumerate().take(harmonics) {
            *nu = (h + 1) as f32 * self.nu;
        }
        let last = self.interferer.or(half_line.then_some(0.5 * self.nu));
        match (last, all.get_mut(harmonics)) {
            (Some(last), Some(nu)) => {
                *nu = last;
                (all, harmonics + 1)
            }
            _ => (all, harmonics),
        }
    }
}

/// The blocks of a window.
#[derive(Clone, Debug)]
pub struct Blocks {
    /// `u` of each block's centre.
    pub u: [f32; BLOCKS_MAX],
    /// Products of the basis with itself.
    products: [[f32; PRODUCTS]; BLOCKS_MAX],
    /// How many blocks, from the first one on, have the products of the first one.
    alike: u8,
    /// With the channels, which are in the order of the pass and in units of their scale, less
    /// their lines. Before there are blocks, other steps have their memory here.
    pub rows: [[Values; LOCAL]; BLOCKS_MAX],
    /// How many there are.
    pub count: usize,
    /// Whether they are as they were collected: no other step has had their memory since.
    pub are_intact: bool,
    /// Channels of the pass, and their number.
    pub order: [u8; CHANNELS_MAX],
    pub width: usize,
    /// Sums of squares of the channels.
    pub squares: Values,
    pub lines: Lines,
    /// Whether the line at half the fundamental is among them; it is no part of a solution.
    pub half_line: bool,
    #[cfg(feature = "long-windows")]
    long: [f32; POINTS_MAX + POINTS_MAX / 2],
}

/// Most frames on one side of a chunk's centre.
const HALF_MAX: usize = 8;

/// Frames about a chunk's centre: cosine and sine of each line at half of them, the other half is
/// their mirror image.
struct Centred {
    distance: [f32; HALF_MAX],
    cos: [[f32; HALF_MAX]; LINES_MAX],
    sin: [[f32; HALF_MAX]; LINES_MAX],
    products: [f32; PRODUCTS],
    /// Products of each line's cosine with 1, and of its sine with the distance.
    lines: [[f32; 2]; LINES_MAX],
}

impl Centred {
    /// None; a constant is written in its place.
    const NONE: Self = Self {
        distance: [0.0; HALF_MAX],
        cos: [[0.0; HALF_MAX]; LINES_MAX],
        sin: [[0.0; HALF_MAX]; LINES_MAX],
        products: [0.0; PRODUCTS],
        lines: [[0.0; 2]; LINES_MAX],
    };

    /// For `half` frames on either side. What is behind them stays zero.
    // One for chunks of all sizes: each of its own would take 700 bytes of flash.
    #[inline(never)]
    fn fill(&mut self, nu: &[f32; LINES_MAX], lines: usize, step: f32, half: usize) {
        let out = self;
        for (i, distance) in out.distance.iter_mut().enumerate().take(half) {
            *distance = (i as f32 + 0.5) * step;
        }
        for l in 0..lines.min(LINES_MAX) {
            let waves = out.cos[l].iter_mut().zip(&mut out.sin[l]);
            for ((cos, sin), distance) in waves.zip(&out.distance).take(half) {
                (*cos, *sin) = cos_sin(from_turns(nu[l] * distance));
            }
        }
        out.products[product(0, 0)] = 2.0 * half as f32;
        out.products[product(1, 1)] = twice(&out.distance, &out.distance, half);
        for l in 0..lines.min(LINES_MAX) {
            let row = 2 + 2 * l;
            out.lines[l] = [
                twice(&[1.0; HALF_MAX], &out.cos[l], half),
                twice(&out.distance, &out.sin[l], half),
            ];
            [
                out.products[product(row, 0)],
                out.products[product(row + 1, 1)],
            ] = out.lines[l];
            for m in 0..=l {
                out.products[product(row, 2 + 2 * m)] = twice(&out.cos[l], &out.cos[m], half);
                out.products[product(row + 1, 3 + 2 * m)] = twice(&out.sin[l], &out.sin[m], half);
            }
        }
    }
}

/// The product of two series over both sides of a centre.
#[inline(never)]
fn twice(a: &[f32; HALF_MAX], b: &[f32; HALF_MAX], half: usize) -> f32 {
    a.iter().zip(b).take(half).map(|(a, b)| 2.0 * a * b).sum()
}

/// How a chunk's centre lies to its block's: its distance, and cosine and sine of each line there.
#[derive(Clone, Copy)]
struct Shift {
    distance: f32,
    turns: [(f32, f32); LINES_MAX],
}

impl Shift {
    fn new(nu: &[f32; LINES_MAX], distance: f32) -> Self {
        Self {
            distance,
            turns: nu.map(|nu| cos_sin(from_turns(nu * distance))),
        }
    }

    /// That of the next chunk, where `step` is from one to the next.
    fn next(&self, step: &Self) -> Self {
        let mut next = Self {
            distance: self.distance + step.distance,
            turns: self.turns,
        };
        for ((cos, sin), (by_cos, by_sin)) in next.turns.iter_mut().zip(&step.turns) {
            (*cos, *sin) = (*cos * by_cos - *sin * by_sin, *sin * by_cos + *cos * by_sin);
        }
        next
    }
}

/// The block of a place along a path.
fn neighbours(u: f32, count: usize) -> usize {
    ((0.5 * (u + 1.0) * count as f32) as usize).min(count.saturating_sub(1))
}

/// What a pass knows of its window.
struct Pass<'p> {
    statistics: &'p Statistics,
    nu: [f32; LINES_MAX],
    lines: usize,
    step: f32,
    frames_per_block: u32,
    /// Frame by frame: along a path, and in windows that are too short for chunks.
    is_by_frame: bool,
    /// Of chunks: those blocks of which all frames are there.
    whole_blocks: usize,
    /// `u` of frame 0.
    start: f32,
}

impl Blocks {
    /// No blocks yet; `const`, so that they can live in a static.
    pub const fn new() -> Self {
        Self {
            u: [0.0; BLOCKS_MAX],
            products: [[0.0; PRODUCTS]; BLOCKS_MAX],
            alike: 0,
            rows: [[[0.0; CHANNELS_MAX]; LOCAL]; BLOCKS_MAX],
            count: 0,
            are_intact: false,
            order: [0; CHANNELS_MAX],
            width: 0,
            squares: [0.0; CHANNELS_MAX],
            lines: Lines {
                nu: 0.0,
                harmonics: 0,
                interferer: None,
            },
            half_line: false,
            #[cfg(feature = "long-windows")]
            long: [0.0; POINTS_MAX + POINTS_MAX / 2],
        }
    }

    /// Products of the basis of block `b` with itself.
    pub fn products(&self, b: usize) -> &[f32; PRODUCTS] {
        &self.products[if b < self.alike as usize {
            0
        } else {
            b % BLOCKS_MAX
        }]
    }

    /// The pieces' memory, before there are blocks: behind that of a periodogram.
    pub fn pieces_mut(&mut self) -> &mut [Values] {
        self.are_intact = false;
        self.rows
            .as_flattened_mut()
            .split_at_mut(BLOCKS_MAX * LOCAL - PIECES_MAX)
            .1
    }

    /// The first pieces, and memory for a grid: of each of its series a sum and a difference.
    pub fn grid_memory<const SERIES: usize>(
        &mut self,
        count: usize,
    ) -> (&[Values], &mut [[[f32; SERIES]; 2]]) {
        self.are_intact = false;
        let rows = self.rows.as_flattened();
        let pieces = rows
            .get(rows.len() - PIECES_MAX..)
            .and_then(|pieces| pieces.get(..count))
            .unwrap_or_default();
        let folded = self
            .products
            .as_flattened_mut()
            .as_chunks_mut()
            .0
            .as_chunks_mut()
            .0;
        (pieces, folded.get_mut(..PIECES_MAX / 2).unwrap_or_default())
    }

    /// Memory for a periodogram: its powers, and a transform. It leaves the pieces as they are.
    pub fn transform_memory(&mut self) -> (&mut [f32], &mut [f32]) {
        self.scratch().split_at_mut(POINTS_MAX / 2)
    }

    /// The memory of transforms, one and a half times as many values as their points.
    pub fn scratch(&mut self) -> &mut [f32] {
        self.are_intact = false;
        #[cfg(feature = "long-windows")]
        let memory = &mut self.long[..];
        #[cfg(not(feature = "long-windows"))]
        let memory = self.rows.as_flattened_mut().as_flattened_mut();
        memory
            .get_mut(..POINTS_MAX + POINTS_MAX / 2)
            .unwrap_or_default()
    }

    /// Collects at most `most` blocks of some channels and lines.
    #[inline(never)]
    pub fn collect(
        &mut self,
        span: &mut FrameSpan,
        statistics: &Statistics,
        channels: &Channels,
        lines: Lines,
        most: usize,
    ) -> Result<(), Overwritten> {
        (self.order, self.width) = (channels.order, channels.width.min(CHANNELS_MAX));
        (self.lines, self.squares, self.are_intact) = (lines, [0.0; CHANNELS_MAX], true);
        let (nu, line_count) = lines.all(self.half_line);
        let mut chunk = 2;
        let most = most.clamp(1, BLOCKS_MAX);
        while chunk < BLOCK && chunk * most < span.frames as usize {
            chunk *= 2;
        }
        let frames_per_block =
            (chunk as u32 * span.frames.div_ceil(((most * chunk) as u32).max(1))).max(1);
        let abscissa = span.abscissa();
        // Along a path, which may turn back, a block is not of frames that follow each other but of
        // neighbours.
        self.count = if span.is_in_time() {
            span.frames.div_ceil(frames_per_block) as usize
        } else {
            most
        };
        let is_by_frame = !span.is_in_time() || chunk == 2;
        let whole_blocks = if is_by_frame {
            0
        } else {
            (span.frames / frames_per_block) as usize
        };
        let pass = Pass {
            statistics,
            nu,
            lines: line_count,
            step: abscissa.step().unwrap_or(0.0),
            frames_per_block,
            is_by_frame,
            whole_blocks,
            start: abscissa.u(0),
        };
        let mut sums = [(0.0, 0.0); BLOCKS_MAX];
        if !span.is_in_time() {
            for frame in 0..span.frames {
                let u = abscissa.u(frame);
                if let Some((count, sum)) = sums.get_mut(neighbours(u, self.count)) {
                    (*count, *sum) = (*count + 1.0, *sum + u);
                }
            }
        }
        self.alike = pass.whole_blocks as u8;
        for b in 0..self.count.min(BLOCKS_MAX) {
            if b == 0 || b >= self.alike as usize {
                self.products[b] = [0.0; PRODUCTS];
            }
            let used = self.rows[b]
                .as_flattened_mut()
                .get_mut(..(2 + 2 * line_count) * CHANNELS_MAX);
            used.unwrap_or_default().fill(0.0);
            let first = b as u32 * frames_per_block;
            self.u[b] = match (abscissa.step(), sums[b]) {
                (Some(step), _) => {
                    pass.start + step * (first as f32 + 0.5 * (frames_per_block - 1) as f32)
                }
                (None, (count, sum)) => sum / f32::max(count, 1.0),
            };
        }
        match chunk {
            2 | 4 => self.pass::<2>(span, &pass),
            8 => self.pass::<4>(span, &pass),
            _ => self.pass::<HALF_MAX>(span, &pass),
        }
    }

    fn pass<const HALF: usize>(
        &mut self,
        span: &mut FrameSpan,
        pass: &Pass,
    ) -> Result<(), Overwritten> {
        let mut centred = Centred::NONE;
        centred.fill(&pass.nu, pass.lines, pass.step, HALF);
        let (abscissa, frames) = (span.abscissa(), span.frames);
        let chunk = 2 * HALF as u32;
        let step = Shift::new(&pass.nu, pass.step * chunk as f32);
        let first = Shift::new(
            &pass.nu,
            -0.5 * pass.step * pass.frames_per_block.saturating_sub(chunk) as f32,
        );
        let mut shift = first;
        // Of a block whose frames are all there the products are those of any other.
        let chunks_of_first = if self.alike > 0 {
            pass.frames_per_block / chunk
        } else {
            0
        };
        for _ in 0..chunks_of_first {
            add_products(&mut self.products[0], &centred.products, &shift, pass.lines);
            shift = shift.next(&step);
        }
        span.blocks(&pass.statistics.offset, &mut |block| {
            if pass.is_by_frame {
                return self.add_by_frame(&block, &abscissa.block(block.first, frames), pass);
            }
            let chunks = block.values.as_chunks::<HALF>().0.as_chunks::<2>().0;
            for (start, halves) in (0..BLOCK).step_by(2 * HALF).zip(chunks) {
                let first_frame = block.first + start as u32;
                let number = (first_frame / pass.frames_per_block.max(1)) as usize;
                if number >= BLOCKS_MAX {
                    continue;
                }
                let frame = first_frame % pass.frames_per_block.max(1);
                shift = if frame == 0 { first } else { shift.next(&step) };
                let is_whole = number < pass.whole_blocks;
                let valid = block
                    .valid
                    .get(start..start + chunk as usize)
                    .unwrap_or_default();
                let missing = if block.complete {
                    0
                } else {
                    valid.iter().filter(|valid| **valid == 0).count()
                };
                // Where most are missing, frame by frame; else a frame that is missing has a value
                // as any other, and is taken out again.
                let is_sparse = !is_whole && missing > HALF;
                if is_sparse || missing > 0 {
                    let u = abscissa.block(block.first, frames);
                    self.add_frames(
                        &block,
                        start..start + chunk as usize,
                        number,
                        (&u, is_sparse),
                        pass,
                    );
                }
                if is_sparse {
                    continue;
                }
                if !is_whole {
                    add_products(
                        &mut self.products[number],
                        &centred.products,
                        &shift,
                        pass.lines,
                    );
                }
                let u = self.u[number] + shift.distance;
                let rows = &mut self.rows[number];
                for (k, (channel, squares)) in self
                    .order
                    .iter()
                    .zip(&mut self.squares)
                    .enumerate()
                    .take(self.width)
                {
                    *squares += add_channel(rows, halves, k, *channel, u, &shift, &centred, pass);
                }
            }
        })
    }

    /// Adds each frame to the block of its place: those that follow each other are mostly in the
    /// same one.
    #[inline(never)]
    fn add_by_frame(&mut self, block: &Block, u: &[f32; BLOCK], pass: &Pass) {
        let count = self.count;
        // Only along a path there is no step.
        let (in_time, first, by) = (pass.step > 0.0, block.first, pass.frames_per_block.max(1));
        let number = |i: usize| {
            if in_time {
                ((first + i as u32) / by) as usize
            } else {
                neighbours(u[i % BLOCK], count)
            }
        };
        let mut from = 0;
        while from < BLOCK {
            let (own, mut to) = (number(from), from + 1);
            while to < BLOCK && number(to) == own {
                to += 1;
            }
            self.add_frames(block, from..to, own, (u, true), pass);
            from = to;
        }
    }

    /// Adds those of some frames to block `number` that are there, or takes those out that are not
    /// there: by fours, as far as these have any.
    #[inline(never)]
    fn add_frames(
        &mut self,
        block: &Block,
        frames: Range<usize>,
        number: usize,
        (u, are_there): (&[f32; BLOCK], bool),
        pass: &Pass,
    ) {
        let (number, pairs) = (number % BLOCKS_MAX, 1 + pass.lines);
        let weight = if are_there { 1.0 } else { -1.0 };
        if number < self.alike as usize {
            // Without a frame it is no longer as the others.
            let like = self.products[0];
            self.products
                .iter_mut()
                .take(self.alike as usize)
                .for_each(|products| *products = like);
            self.alike = 0;
        }
        let Statistics {
            offset,
            slope,
            scale,
            ..
        } = pass.statistics;
        let fours = block
            .values
            .as_chunks::<FOUR>()
            .0
            .iter()
            .zip(u.as_chunks::<FOUR>().0);
        for (((values, u), valid), first) in fours
            .zip(block.valid.as_chunks::<FOUR>().0)
            .zip((0..).step_by(FOUR))
        {
            let is_in =
                |i: &usize| frames.contains(&(first + i)) && (valid[i % FOUR] != 0) == are_there;
            if !(0..FOUR).any(|i| is_in(&i)) {
                continue;
            }
            // Zeros where a frame is not one of them.
            let mut basis = [[[0.0; FOUR]; 2]; LOCAL / 2];
            for i in (0..FOUR).filter(is_in).map(|i| i % FOUR) {
                let distance = u[i] - self.u[number];
                let [[ones, distances], waves @ ..] = &mut basis;
                (ones[i], distances[i]) = (1.0, distance);
                for ([cos, sin], nu) in waves.iter_mut().zip(&pass.nu).take(pass.lines) {
                    (cos[i], sin[i]) = cos_sin(from_turns(nu * distance));
                }
            }
            let weights = basis[0][0].map(|one| weight * one);
            let mut products = &mut self.products[number][..];
            for (row, factors) in basis.as_flattened().iter().enumerate().take(2 * pairs) {
                let (own, others) = products.split_at_mut((row + 1).min(products.len()));
                let factors = factors.map(|factor| weight * factor);
                own.iter_mut()
                    .zip(basis.as_flattened())
                    .for_each(|(product, with)| add_four(product, with, &factors));
                products = others;
            }
            let rows = &mut self.rows[number].as_chunks_mut::<2>().0;
            for (k, (channel, squares)) in self
                .order
                .iter()
                .zip(&mut self.squares)
                .enumerate()
                .take(self.width)
            {
                let (c, k) = (*channel as usize % CHANNELS_MAX, k % CHANNELS_MAX);
                let (offset, slope, scale) = (offset[c], slope[c], scale[c]);
                let values: [f32; FOUR] =
                    core::array::from_fn(|i| (values[i][c] - offset - slope * u[i]) * scale);
                let weighted: [f32; FOUR] = core::array::from_fn(|i| weights[i] * values[i]);
                add_four(squares, &values, &weighted);
                for ([one, other], [with_one, with_other]) in
                    rows.iter_mut().zip(&basis).take(pairs)
                {
                    add_four(&mut one[k], with_one, &weighted);
                    add_four(&mut other[k], with_other, &weighted);
                }
            }
        }
    }
}

/// Frames whose values stay in registers.
const FOUR: usize = 4;

/// Adds the product of two series.
#[inline(always)]
fn add_four(to: &mut f32, a: &[f32; FOUR], b: &[f32; FOUR]) {
    *to += (a[0] * b[0] + a[1] * b[1]) + (a[2] * b[2] + a[3] * b[3]);
}

/// Adds the products of a complete chunk.
#[inline(never)]
fn add_products(to: &mut [f32; PRODUCTS], of: &[f32; PRODUCTS], shift: &Shift, lines: usize) {
    let (at, du) = (product, shift.distance);
    let n = of[at(0, 0)];
    to[at(0, 0)] += n;
    to[at(1, 0)] += n * du;
    to[at(1, 1)] += of[at(1, 1)] + n * du * du;
    for l in 0..lines.min(LINES_MAX) {
        let (row, (cos, sin)) = (2 + 2 * l, shift.turns[l]);
        let (even, odd) = (of[at(row, 0)], of[at(row + 1, 1)]);
        to[at(row, 0)] += cos * even;
        to[at(row + 1, 0)] += sin * even;
        to[at(row, 1)] += du * cos * even - sin * odd;
        to[at(row + 1, 1)] += du * sin * even + cos * odd;
        for m in 0..=l {
            let (column, (other_cos, other_sin)) = (2 + 2 * m, shift.turns[m]);
            let (cosines, sines) = (of[at(row, column)], of[at(row + 1, column + 1)]);
            to[at(row, column)] += cos * other_cos * cosines + sin * other_sin * sines;
            to[at(row + 1, column)] += sin * other_cos * cosines - cos * other_sin * sines;
            to[at(row + 1, column + 1)] += sin * other_sin * cosines + cos * other_cos * sines;
            if m < l {
                to[at(row, column + 1)] += cos * other_sin * cosines - sin * other_cos * sines;
            }
        }
    }
}

/// Adds one channel of a complete chunk; returns its sum of squares.
#[inline(always)]
#[allow(clippy::too_many_arguments, reason = "the innermost loop")]
fn add_channel<const HALF: usize>(
    rows: &mut [Values; LOCAL],
    [before, after]: &[[Values; HALF]; 2],
    k: usize,
    channel: u8,
    u: f32,
    shift: &Shift,
    centred: &Centred,
    pass: &Pass,
) -> f32 {
    let c = channel as usize % CHANNELS_MAX;
    let Statistics {
        offset,
        slope,
        scale,
        ..
    } = pass.statistics;
    let (offset, scale) = (offset[c], scale[c]);
    // The line at the chunk's centre as f32 holds it is subtracted frame by frame, and what it
    // lacks from the sums.
    let zero = offset + slope[c] * u;
    let (rest, slope) = ((slope[c] * u - (zero - offset)) * scale, slope[c] * scale);
    let (mut even, mut odd) = ([0.0; HALF], [0.0; HALF]);
    let (mut sum, mut along, mut squares, mut odd_squares) = (0.0, 0.0, 0.0, 0.0);
    for i in 0..HALF {
        let (after, before) = (
            (after[i][c] - zero) * scale,
            (before[HALF - 1 - i][c] - zero) * scale,
        );
        (even[i], odd[i]) = (after + before, after - before);
    }
    // A loop of its own: the compiler unrolls short ones only, and without that nothing stays in
    // registers.
    for i in 0..HALF {
        sum += even[i];
        along += odd[i] * centred.distance[i % HALF_MAX];
        // Of the sum and the difference, which are in registers anyway: twice those of both values.
        squares += even[i] * even[i];
        odd_squares += odd[i] * odd[i];
    }
    squares = 0.5 * (squares + odd_squares);
    let (count, spread) = (2.0 * HALF as f32, centred.products[product(1, 1)]);
    squares += rest * (count * rest - 2.0 * sum) + slope * (slope * spread - 2.0 * along);
    (sum, along) = (sum - count * rest, along - slope * spread);
    rows[0][k] += sum;
    rows[1][k] += along + shift.distance * sum;
    for l in 0..pass.lines.min(LINES_MAX) {
        let (row, (cos, sin)) = (2 + 2 * l, shift.turns[l]);
        let [with_ones, with_distances] = centred.lines[l];
        let (mut with_cos, mut with_sin) = (-rest * with_ones, -slope * with_distances);
        for i in 0..HALF {
            with_cos += even[i] * centred.cos[l][i % HALF_MAX];
            with_sin += odd[i] * centred.sin[l][i % HALF_MAX];
        }
        rows[row][k] += cos * with_cos - sin * with_sin;
        rows[row + 1][k] += sin * with_cos + cos * with_sin;
    }
    squares
}
