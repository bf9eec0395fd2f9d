//! Sums of the frames over blocks of the window, at one frequency. Fits near that frequency need
//! nothing else.

use super::reference::Reference;
use crate::frame_span::{FrameSpan, READ_FRAMES};
use crate::limits::CHANNELS_MAX;
use crate::phase::{cos_sin, from_turns};
use crate::source::{Overwritten, Values};

/// Most blocks of a window.
pub const BLOCKS: usize = 16;
/// Fewest frames of a block.
const FRAMES_OF_BLOCK: usize = 3;
/// Fraction of sigma by which turned blocks may be off before the frames are read again.
const NEAR: f32 = 0.3;

/// Cosine and sine, or sums of them.
pub type Wave = [f32; 2];

/// Sums over a block; `d` is `u` less the block's middle.
#[derive(Clone, Copy, Debug)]
pub struct Block {
    /// `u` at its middle.
    pub middle: f32,
    /// Number of frames.
    pub frames: f32,
    /// Sum of `d`.
    pub d: f32,
    /// Cosine and sine of the phase.
    pub wave: Wave,
    /// Cosine and sine of twice the phase.
    pub double: Wave,
    /// Cosine and sine of the phase, times `d`.
    pub moment: Wave,
}

/// Sums of the channels over a block: of the values, and of the values times cosine and sine.
pub type Rows = [Values; 3];

/// Rows of memory for all blocks.
pub const LEAN_ROWS: usize = 3 * BLOCKS;

impl Block {
    const NONE: Self = Self {
        middle: 0.0,
        frames: 0.0,
        d: 0.0,
        wave: [0.0; 2],
        double: [0.0; 2],
        moment: [0.0; 2],
    };
}

/// Sums over all blocks of a window, of values less the reference, over its scale.
pub struct Blocks<'m> {
    blocks: [Block; BLOCKS],
    rows: &'m mut [Rows],
    count: usize,
    /// Number of frames, and sums of `u` and of its square.
    pub powers: [f32; 3],
    /// Sums of the values, of the values times `u`, and of their squares.
    pub sums: Rows,
    /// Cycles a window of the line.
    pub cycles: f32,
}

impl<'m> Blocks<'m> {
    /// Empty ones, with [`LEAN_ROWS`] rows of memory.
    pub fn new(memory: &'m mut [Values]) -> Self {
        Self {
            blocks: [Block::NONE; BLOCKS],
            rows: memory.as_chunks_mut().0,
            count: 0,
            powers: [0.0; 3],
            sums: [[0.0; CHANNELS_MAX]; 3],
            cycles: 0.0,
        }
    }

    /// Blocks with frames.
    pub fn iter(&self) -> impl Iterator<Item = (&Block, &Rows)> {
        let used = self.blocks.iter().zip(&*self.rows).take(self.count);
        used.filter(|(block, _)| block.frames > 0.0)
    }

    /// Number of frames.
    pub fn frames(&self) -> f32 {
        self.powers[0]
    }

    /// Distance in cycles up to which turned blocks are as good as new ones, for a frequency of
    /// `cycles` with a standard deviation of `sigma`. They err by a part of the turn: by more in the
    /// frequency where a block is a part of a cycle, and in the residuals of each block where the
    /// tone is loud.
    pub fn near(&self, sigma: f32, cycles: f32, width: usize) -> f32 {
        let blocks = self.count as f32;
        let parts = (0.25 * cycles * cycles).max(0.25);
        let residual = libm::sqrtf(0.5 * blocks * width as f32);
        NEAR * sigma * blocks * (blocks * parts).min(residual)
    }

    /// Sums up the frames of a span at a frequency of `cycles` a window.
    #[inline(never)]
    pub fn collect(
        &mut self,
        span: &mut FrameSpan,
        reference: &Reference,
        cycles: f32,
    ) -> Result<(), Overwritten> {
        let frames = span.frames as usize;
        self.count = (frames / FRAMES_OF_BLOCK).clamp(1, BLOCKS);
        self.cycles = cycles;
        self.sums = [[0.0; CHANNELS_MAX]; 3];
        self.powers = [0.0; 3];
        let place = *span.domain();
        // Phases are exact: a fraction of a turn for each frame, about the window's centre.
        let step = from_turns(cycles / frames as f32);
        let centre = from_turns(0.5 * cycles * (frames as f32 - 1.0) / frames as f32);
        let (cos, sin) = cos_sin(step);
        let mut from = 0;
        let blocks = self.blocks.iter_mut().zip(&mut *self.rows);
        for (b, (block, rows)) in blocks.enumerate().take(self.count) {
            *rows = [[0.0; CHANNELS_MAX]; 3];
            let end = (b + 1) * frames / self.count.max(1);
            *block = Block::NONE;
            let last = end.max(from + 1) - 1;
            block.middle = 0.5 * (place.u(from as u32) + place.u(last as u32));
            let mut chunk = Chunk::new(block.middle);
            span.visit_range(
                from as u32..end as u32,
                reference.wanted,
                &mut |n, values| {
                    let u = place.u(n);
                    if !chunk.follows(n) {
                        let (c, s) = cos_sin(step.wrapping_mul(n).wrapping_sub(centre));
                        chunk.wave = [c, s];
                    }
                    chunk.add(reference, u, values);
                    chunk.turn(n, [cos, sin]);
                    if chunk.count == READ_FRAMES {
                        chunk.flush(block, rows, &mut self.sums);
                    }
                },
            )?;
            chunk.flush(block, rows, &mut self.sums);
            let (n, middle) = (block.frames, block.middle);
            self.powers[0] += n;
            self.powers[1] += n * middle + block.d;
            self.powers[2] += n * middle * middle + 2.0 * middle * block.d + chunk.dd;
            from = end;
        }
        Ok(())
    }
}

/// Some frames of a block, that are multiplied together.
struct Chunk {
    values: [Values; READ_FRAMES],
    waves: [Wave; READ_FRAMES],
    u: [f32; READ_FRAMES],
    count: usize,
    middle: f32,
    /// Sum of the squares of `d`, of all frames.
    dd: f32,
    wave: Wave,
    next: u32,
}

impl Chunk {
    fn new(middle: f32) -> Self {
        Self {
            values: [[0.0; CHANNELS_MAX]; READ_FRAMES],
            waves: [[0.0; 2]; READ_FRAMES],
            u: [0.0; READ_FRAMES],
            count: 0,
            middle,
            dd: 0.0,
            wave: [0.0; 2],
            next: u32::MAX,
        }
    }

    /// True if the wave was turned to this frame.
    fn follows(&self, number: u32) -> bool {
        number == self.next && self.count > 0
    }

    /// Adds a frame, centred and scaled.
    #[inline(always)]
    fn add(&mut self, reference: &Reference, u: f32, values: &Values) {
        let mut memory = [0.0; CHANNELS_MAX];
        let values = reference.clean(values, &mut memory);
        let place = self.count % READ_FRAMES;
        self.u[place] = u;
        self.waves[place] = self.wave;
        let to = &mut self.values[place];
        for c in 0..CHANNELS_MAX {
            let value = values[c] - (reference.level[c] + reference.slope[c] * u);
            to[c] = value * reference.inverse[c];
        }
        self.count += 1;
    }

    /// Turns the wave to the frame after `number`.
    #[inline(always)]
    fn turn(&mut self, number: u32, [cos, sin]: Wave) {
        let [c, s] = self.wave;
        self.wave = [c * cos - s * sin, s * cos + c * sin];
        self.next = number + 1;
    }

    /// Adds what is there to the sums, and starts anew.
    fn flush(&mut self, block: &mut Block, rows: &mut Rows, sums: &mut Rows) {
        let count = self.count.min(READ_FRAMES);
        self.count = 0;
        let (frames, waves, places) = (
            self.values.get(..count).unwrap_or_default(),
            self.waves.get(..count).unwrap_or_default(),
            self.u.get(..count).unwrap_or_default(),
        );
        for (u, [c, s]) in places.iter().zip(waves) {
            let d = u - self.middle;
            block.frames += 1.0;
            block.d += d;
            self.dd += d * d;
            block.wave = [block.wave[0] + c, block.wave[1] + s];
            block.moment = [block.moment[0] + d * c, block.moment[1] + d * s];
            block.double = [
                block.double[0] + c * c - s * s,
                block.double[1] + 2.0 * c * s,
            ];
        }
        let [level, cosines, sines] = rows;
        let [values_sum, moments, squares] = sums;
        for group in 0..CHANNELS_MAX / 4 {
            // Sums of a few values first: rounding then grows with the number of sums.
            let (mut sum, mut moment, mut square) = ([0.0; 4], [0.0; 4], [0.0; 4]);
            for (values, u) in frames.iter().zip(places) {
                let values = &values.as_chunks::<4>().0[group];
                for k in 0..4 {
                    sum[k] += values[k];
                    moment[k] += u * values[k];
                    square[k] += values[k] * values[k];
                }
            }
            let add = |to: &mut Values, from: [f32; 4]| {
                let to = &mut to.as_chunks_mut::<4>().0[group];
                to.iter_mut().zip(from).for_each(|(to, x)| *to += x);
            };
            add(level, sum);
            add(values_sum, sum);
            add(moments, moment);
            add(squares, square);
        }
        for half in 0..2 {
            let eight = |values: &Values| values.as_chunks::<8>().0[half];
            let (mut cos, mut sin) = (eight(cosines), eight(sines));
            for (values, [c, s]) in frames.iter().zip(waves) {
                let values = &values.as_chunks::<8>().0[half];
                for k in 0..8 {
                    cos[k] += c * values[k];
                    sin[k] += s * values[k];
                }
            }
            cosines.as_chunks_mut::<8>().0[half] = cos;
            sines.as_chunks_mut::<8>().0[half] = sin;
        }
    }
}
