//! Sums of the frames over blocks of the window, at one frequency and its multiples. Fits near this
//! frequency need nothing else.

use super::reference::Reference;
use crate::frame_span::{FrameSpan, READ_FRAMES};
use crate::limits::CHANNELS_MAX;
use crate::phase::{Wave, cos_sin, from_turns, times};
use crate::source::{Overwritten, Values};

/// Maximum number of blocks of a window.
pub const BLOCKS: usize = 16;
/// Maximum number of blocks of a window with several lines or few frames: 1 / 64 of the information
/// is lost.
pub const BLOCKS_FEWER: usize = 8;
/// Number of frames below which a window has fewer blocks.
const FRAMES_FEW: usize = 128;
/// Maximum number of lines.
pub const LINES: usize = 4;
/// Number of multiples of the phase for which sums are kept; products of two lines need up to twice
/// the highest line.
pub const WAVES: usize = 2 * LINES;
/// Minimum number of frames of a block.
const FRAMES_OF_BLOCK: usize = 3;
/// Maximum error of rotated blocks before the frames are read again, as a fraction of sigma.
const NEAR: f32 = 0.3;

/// Rows of memory for all blocks.
pub const LEAN_ROWS: usize = {
    let (one, several) = (rows(1) * BLOCKS, rows(LINES) * BLOCKS_FEWER);
    if one > several { one } else { several }
};

/// Rows of a block: products of the channels with cosine and sine of each line.
const fn rows(lines: usize) -> usize {
    let rows = 2 * lines;
    if rows > 2 { rows } else { 2 }
}

/// Sums over a block; `d` is `u` less the block's middle.
#[derive(Clone, Copy, Debug, Default)]
pub struct Block {
    /// `u` at the block's middle.
    pub middle: f32,
    /// Number of frames.
    pub frames: f32,
    /// Sum of `d`.
    pub d: f32,
    /// Sums of cosine and sine of each multiple of the phase, from 1 on.
    pub waves: [Wave; WAVES],
    /// Sums of cosine and sine of each line, times `d`.
    pub moments: [Wave; LINES],
    /// Sums of the channels' values.
    pub level: Values,
}

/// Sums over all blocks of a window, of values less the reference.
pub struct Blocks<'m> {
    blocks: [Block; BLOCKS],
    rows: &'m mut [Values],
    count: usize,
    /// Number of lines.
    pub lines: usize,
    /// Number of frames, and sums of `u` and of its square.
    pub powers: [f32; 3],
    /// Sums of the values, of the values times `u`, and of their squares.
    pub sums: [Values; 3],
    /// Frequency of the first line, cycles per window.
    pub cycles: f32,
    run: Run,
}

#[derive(Clone, Copy, Debug)]
pub struct Pass {
    /// Frequency of the first line, cycles per window.
    pub cycles: f32,
    /// Number of lines.
    pub lines: usize,
    /// Maximum number of blocks.
    pub blocks: usize,
}

impl<'m> Blocks<'m> {
    /// Empty blocks, with [`LEAN_ROWS`] rows of memory.
    #[inline(always)]
    pub fn new(rows: &'m mut [Values]) -> Self {
        Self {
            blocks: [Block::default(); BLOCKS],
            rows,
            count: 0,
            lines: 1,
            powers: [0.0; 3],
            sums: [[0.0; CHANNELS_MAX]; 3],
            cycles: 0.0,
            run: Run::default(),
        }
    }

    /// Iterates over the blocks, with the rows of each.
    pub fn iter(&self) -> impl Iterator<Item = (&Block, &[Values])> {
        let rows = self.rows.chunks_exact(rows(self.lines));
        self.blocks.iter().zip(rows).take(self.count)
    }

    /// Number of blocks.
    pub fn count(&self) -> usize {
        self.count
    }

    /// Number of frames.
    pub fn frames(&self) -> f32 {
        self.powers[0]
    }

    /// Distance in cycles up to which rotated blocks are as good as new ones, for a frequency of
    /// `cycles` with a standard deviation of `sigma`. Their error grows with the rotation: in the
    /// frequency if a block is shorter than a cycle, and in the residuals of each block if the tone
    /// is loud.
    pub fn near(&self, sigma: f32, cycles: f32, width: usize) -> f32 {
        let blocks = self.count as f32;
        let parts = (0.25 * cycles * cycles).max(0.25);
        let residual = crate::sqrt(0.5 * blocks * width as f32);
        NEAR * sigma * blocks * (blocks * parts).min(residual)
    }

    /// Maximum number of blocks for a number of frames and lines.
    pub fn max(frames: u32, lines: usize) -> usize {
        if lines > 1 || frames < FRAMES_FEW as u32 {
            BLOCKS_FEWER
        } else {
            BLOCKS
        }
    }

    /// Sums up the frames of a span; `kept` is scratch memory for some frames.
    #[inline(never)]
    pub fn collect(
        &mut self,
        span: &mut FrameSpan,
        reference: &Reference,
        pass: Pass,
        kept: &mut [Values],
    ) -> Result<(), Overwritten> {
        let Pass { cycles, lines, .. } = pass;
        let frames = span.frames as usize;
        self.count = (frames / FRAMES_OF_BLOCK).min(pass.blocks).max(1);
        (self.cycles, self.lines) = (cycles, lines);
        self.sums = [[0.0; CHANNELS_MAX]; 3];
        self.powers = [0.0; 3];
        let run = &mut self.run;
        run.start(frames, cycles, lines);
        let mut from = 0;
        let blocks = self.blocks.iter_mut();
        let blocks = blocks.zip(self.rows.chunks_exact_mut(rows(lines)));
        for (b, (block, rows)) in blocks.enumerate().take(self.count) {
            let end = (b + 1) * frames / self.count.max(1);
            rows.fill([0.0; CHANNELS_MAX]);
            *block = Block::default();
            block.middle = run.u(0.5 * (from + end - 1) as f32);
            run.dd = 0.0;
            let part = from as u32..end as u32;
            span.visit_runs(part, reference.wanted, &mut |first, values| {
                let sums = Sums {
                    block,
                    rows,
                    total: &mut self.sums,
                    kept,
                };
                run.add(first, values, reference, sums);
            })?;
            let (n, middle) = (block.frames, block.middle);
            self.powers[0] += n;
            self.powers[1] += n * middle + block.d;
            self.powers[2] += n * middle * middle + 2.0 * middle * block.d + run.dd;
            from = end;
        }
        if reference.width < CHANNELS_MAX {
            let levels = self.blocks.iter_mut().map(|block| &mut block.level);
            levels.for_each(|row| reference.clear(row));
            self.rows.iter_mut().for_each(|row| reference.clear(row));
            self.sums.iter_mut().for_each(|row| reference.clear(row));
        }
        Ok(())
    }
}

/// Sums that frames are added to.
struct Sums<'b> {
    block: &'b mut Block,
    rows: &'b mut [Values],
    /// Sums over the window.
    total: &'b mut [Values; 3],
    /// Values less the reference; filled in only if there are several lines.
    kept: &'b mut [Values],
}

/// Rows to which the first line's sums are added: the block's values, cosine and sine products,
/// then the window's three sums.
struct FirstLine<'s> {
    sums: [&'s mut Values; 6],
    kept: &'s mut [Values],
}

/// Waves for some consecutive frames.
#[derive(Default)]
struct Run {
    lines: usize,
    /// Phase step per frame, and phase at the window's centre.
    step: u32,
    centre: u32,
    /// Cosine and sine of the phase step.
    turn: Wave,
    /// Step of `u` per frame.
    u_step: f32,
    /// Sum of the squares of `d` over all frames of a block.
    dd: f32,
    /// Cosine and sine of each line at each frame.
    waves: [[Wave; READ_FRAMES]; LINES],
}

impl Run {
    fn start(&mut self, frames: usize, cycles: f32, lines: usize) {
        let frames = frames as f32;
        self.lines = lines;
        // Phases are exact: a fraction of a turn for each frame, about the window's centre.
        self.step = from_turns(cycles / frames);
        self.centre = from_turns(0.5 * cycles * (frames - 1.0) / frames);
        let (cos, sin) = cos_sin(self.step);
        self.turn = [cos, sin];
        self.u_step = 2.0 / frames;
    }

    fn u(&self, frame: f32) -> f32 {
        (frame + 0.5) * self.u_step - 1.0
    }

    /// Adds frames to the sums of a block and of the window.
    fn add(&mut self, first: u32, values: &[Values], reference: &Reference, sums: Sums) {
        let Sums {
            block,
            rows,
            total,
            kept,
        } = sums;
        let [[cos, sin], others @ ..] = rows.as_chunks_mut::<2>().0 else {
            return;
        };
        if self.lines == 1 {
            self.turn_lines::<1, 2>(first, values.len(), block);
            let [total, moments, squares] = total;
            let sums = [&mut block.level, cos, sin, total, moments, squares];
            self.add_first::<false>(first, values, reference, FirstLine { sums, kept });
            return;
        }
        self.turn_lines::<LINES, WAVES>(first, values.len(), block);
        let [total, moments, squares] = total;
        let sums = [&mut block.level, cos, sin, total, moments, squares];
        let line = FirstLine {
            sums,
            kept: &mut *kept,
        };
        self.add_first::<true>(first, values, reference, line);
        let values = kept.get(..values.len()).unwrap_or_default();
        for (waves, rows) in self.waves.iter().skip(1).zip(others) {
            add_line(values, waves, rows);
        }
    }

    /// Computes the waves of some frames and adds them to a block's sums; `M` is twice `L`.
    #[inline(never)]
    fn turn_lines<const L: usize, const M: usize>(
        &mut self,
        first: u32,
        count: usize,
        block: &mut Block,
    ) {
        let (mut waves, mut moments) = ([[0.0; 2]; M], [[0.0; 2]; L]);
        let (mut sum, mut squares) = (0.0, 0.0);
        let phase = self.step.wrapping_mul(first).wrapping_sub(self.centre);
        let (c, s) = cos_sin(phase);
        let (mut wave, turn) = ([c, s], self.turn);
        let mut d = self.u(first as f32) - block.middle;
        for i in 0..count.min(READ_FRAMES) {
            let double = 2.0 * wave[0];
            let (mut before, mut at) = ([1.0, 0.0], wave);
            for m in 0..M {
                if m < L {
                    self.waves[m][i] = at;
                    moments[m] = [moments[m][0] + d * at[0], moments[m][1] + d * at[1]];
                }
                waves[m] = [waves[m][0] + at[0], waves[m][1] + at[1]];
                // Chebyshev's recurrence.
                (before, at) = (at, [double * at[0] - before[0], double * at[1] - before[1]]);
            }
            sum += d;
            squares += d * d;
            d += self.u_step;
            wave = times(wave, turn);
        }
        let add = |to: &mut Wave, x: &Wave| *to = [to[0] + x[0], to[1] + x[1]];
        let pairs = block.waves.iter_mut().zip(&waves);
        pairs.for_each(|(to, x)| add(to, x));
        let pairs = block.moments.iter_mut().zip(&moments);
        pairs.for_each(|(to, x)| add(to, x));
        block.frames += count as f32;
        block.d += sum;
        self.dd += squares;
    }

    /// Subtracts the reference, and adds the sums that the first line needs: in the block, of the
    /// values and of their products with cosine and sine; in the window, of the values, of the
    /// values times `u`, and of the squares. The hot loop: four channels at a time, with their sums
    /// in registers.
    #[inline(never)]
    fn add_first<const KEEP: bool>(
        &mut self,
        first: u32,
        values: &[Values],
        reference: &Reference,
        line: FirstLine,
    ) {
        let FirstLine { sums, kept } = line;
        let (u, count) = (self.u(first as f32), values.len() as f32);
        let sums = sums.map(|row| row.as_chunks_mut::<4>().0);
        for (group, level) in reference.level.as_chunks::<4>().0.iter().enumerate() {
            let [mut sum, mut double, mut square] = [[0.0; 4]; 3];
            let [mut cos, mut sin] = [[0.0; 4]; 2];
            let kept = kept.iter_mut();
            for ((frame, [c, s]), kept) in values.iter().zip(&self.waves[0]).zip(kept) {
                let frame = &frame.as_chunks::<4>().0[group];
                for k in 0..4 {
                    let y = frame[k] - level[k];
                    sum[k] += y;
                    double[k] += sum[k];
                    square[k] += y * y;
                    cos[k] += c * y;
                    sin[k] += s * y;
                    if KEEP {
                        kept.as_chunks_mut::<4>().0[group][k] = y;
                    }
                }
            }
            for k in 0..4 {
                sums[0][group][k] += sum[k];
                sums[1][group][k] += cos[k];
                sums[2][group][k] += sin[k];
                sums[3][group][k] += sum[k];
                // `double`, the sum of the running sums, weights value i by `count` - i, so this is
                // the sum of the values times i.
                sums[4][group][k] += u * sum[k] + self.u_step * (count * sum[k] - double[k]);
                sums[5][group][k] += square[k];
            }
        }
    }
}

/// Adds the products of frames with the waves of a line.
#[inline(never)]
pub fn add_line(
    values: &[Values],
    waves: &[Wave; READ_FRAMES],
    [cosines, sines]: &mut [Values; 2],
) {
    for half in 0..2 {
        let [mut cos, mut sin] = [[0.0; 8]; 2];
        for (values, [c, s]) in values.iter().zip(waves) {
            let values = &values.as_chunks::<8>().0[half];
            for k in 0..8 {
                cos[k] += c * values[k];
                sin[k] += s * values[k];
            }
        }
        for k in 0..8 {
            cosines.as_chunks_mut::<8>().0[half][k] += cos[k];
            sines.as_chunks_mut::<8>().0[half][k] += sin[k];
        }
    }
}
