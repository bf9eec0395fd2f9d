//! The level and the slope of every channel in a stretch, and which channels can be used: the first pass.

use crate::frame_span::{BLOCK, Block, FrameSpan};
use crate::source::CHANNELS_MAX;
use crate::source::Values;
use crate::waves::legendre;

/// Frames that are added up before they meet `u`, and of which means are made.
pub const QUAD: usize = 4;

/// Level and slope of every channel, and which of them can be used.
#[derive(Clone, Debug)]
pub struct Levels {
    /// Offset of each channel, on its straight line at the centre; the passes that follow subtract it.
    pub offset: Values,
    /// Slope per unit of `u` of a straight line through each channel.
    pub slope: Values,
    /// Sum of squares about that straight line.
    pub about_line: Values,
    /// Sum of squares about the mean.
    pub about_mean: Values,
    /// Sum of y, each channel less its `offset`.
    pub y: Values,
    /// Sum of u y.
    pub uy: Values,
    /// Sum of y squared.
    pub yy: Values,
    /// Variance of a frame's noise by the third differences of frames in a row: a tone of less than a tenth of
    /// the frame rate adds next to nothing. 0 if no four frames in a row count.
    pub rough: Values,
    /// Sum of u.
    pub u: f32,
    /// Sum of u squared.
    pub uu: f32,
    /// Steps towards a bent baseline.
    pub bend: Bend,
    /// Taxels with valid values in nearly all frames, and not constant.
    pub usable: u16,
    /// Frames that count.
    pub frames: u32,
}

/// The second and third Legendre polynomial in steps, each block's centre for all of it, and their sums over the whole
/// blocks of a stretch in time. Where there are many blocks that is as good as a smooth bend, to see whether there is one.
#[derive(Clone, Debug, Default)]
pub struct Bend {
    /// Sums of y times each.
    pub y: [Values; 2],
    /// Sum of each.
    pub one: [f32; 2],
    /// Sum of u times each.
    pub u: [f32; 2],
    /// Sums of their products with each other.
    pub each: [[f32; 2]; 2],
}

impl Bend {
    /// Adds a whole block about `centre` with the channels' sums `y`.
    fn add(&mut self, centre: f32, y: &Values) {
        let steps = legendre(centre);
        for (k, step) in steps.into_iter().enumerate() {
            let frames = BLOCK as f32 * step;
            self.one[k] += frames;
            self.u[k] += frames * centre;
            for (l, other) in steps.into_iter().enumerate() {
                self.each[k][l] += frames * other;
            }
            for c in 0..CHANNELS_MAX {
                self.y[k][c] += step * y[c];
            }
        }
    }
}

/// A taxel without a valid value in more than this share of the frames is left out. Of the others
/// every frame must have one: all channels share one abscissa.
const INVALID_MAX: f32 = 0.1;

/// Taxels that have valid values in nearly all frames that have any. None if the frames were
/// overwritten.
fn reliable_taxels(span: &mut FrameSpan) -> Option<u16> {
    let (mut frames, mut invalid) = (0u32, [0u32; CHANNELS_MAX]);
    span.taxels = 0;
    span.blocks(&[0.0; CHANNELS_MAX], &mut |block| {
        if block.whole && block.valid.iter().all(|valid| *valid == u16::MAX) {
            frames += BLOCK as u32;
            return;
        }
        for valid in block.valid.iter().filter(|valid| **valid != 0) {
            frames += 1;
            if *valid != u16::MAX {
                for (c, invalid) in invalid.iter_mut().enumerate() {
                    *invalid += (valid & 1 << c == 0) as u32;
                }
            }
        }
    })?;
    let mut taxels = 0;
    for (c, invalid) in invalid.iter().enumerate() {
        taxels |= ((*invalid as f32 <= INVALID_MAX * frames as f32) as u16) << c;
    }
    Some(taxels)
}

/// Sums of the quads of a block.
type Quads = [Values; BLOCK / QUAD];

/// Over the quads of a block: their sum, that of their number (from 0) times each, and of their squares.
struct OfQuads {
    y: Values,
    along: Values,
    yy: Values,
}

const _: () = assert!(BLOCK / QUAD == 4, "a column is added in four quads");

/// Sums of one channel over a block, values less `zero`.
struct Column {
    zero: f32,
    sum: f32,
    /// Of the quads' numbers times their sums.
    along: f32,
    /// Of what the last frame of a quad has more than the first.
    outer: f32,
    /// Of what the third has more than the second.
    inner: f32,
    squares: f32,
    quad_squares: f32,
    /// Third differences squared.
    rough: f32,
}

impl Column {
    #[inline(always)]
    fn new(zero: f32) -> Self {
        let none = 0.0;
        Self { zero, sum: none, along: none, outer: none, inner: none, squares: none, quad_squares: none, rough: none }
    }

    /// Adds quad `q` of taxel `c`; gives its sum.
    #[inline(always)]
    fn add(&mut self, block: &Block, q: usize, c: usize) -> f32 {
        let [a, b, c, d] = [0, 1, 2, 3].map(|i| block.values[QUAD * q + i][c] - self.zero);
        let (outer, inner) = (d - a, c - b);
        let third = outer - 3.0 * inner;
        let quad = a + b + (c + d);
        self.squares += a * a;
        self.squares += b * b;
        self.squares += c * c;
        self.squares += d * d;
        self.outer += outer;
        self.inner += inner;
        self.rough += third * third;
        self.sum += quad;
        self.along += q as f32 * quad;
        self.quad_squares += quad * quad;
        quad
    }
}

/// Sums over a stretch, values less `zero`.
struct Sums {
    zero: Values,
    n: u32,
    u: f32,
    uu: f32,
    y: Values,
    uy: Values,
    yy: Values,
    bend: Bend,
    /// Third differences squared, and how many for each channel.
    rough: Values,
    quads: u32,
}

impl Sums {
    fn new(zero: Values) -> Self {
        let none = [0.0; CHANNELS_MAX];
        let bend = Bend::default();
        Self { zero, n: 0, u: 0.0, uu: 0.0, y: none, uy: none, yy: none, bend, rough: none, quads: 0 }
    }

    /// Adds a block whose frames have their `u` from `from` on, `step` apart; what `u` has to do with the values is
    /// left to [`Sums::add_along`] if the step is zero.
    #[inline(never)]
    fn add(&mut self, block: &Block, from: f32, step: f32, quads: &mut Quads, of_quads: &mut OfQuads) {
        let whole = if block.whole { 1.0 } else { 0.0 };
        self.quads += if block.whole { (BLOCK / QUAD) as u32 } else { 0 };
        for c in 0..CHANNELS_MAX {
            let mut column = Column::new(self.zero[c]);
            // One by one: the compiler would make a loop of a loop.
            quads[0][c] = column.add(block, 0, c);
            quads[1][c] = column.add(block, 1, c);
            quads[2][c] = column.add(block, 2, c);
            quads[3][c] = column.add(block, 3, c);
            let Column { sum, along, outer, inner, squares, quad_squares, rough, .. } = column;
            self.y[c] += sum;
            // Frames are half of one and of three from their quad's centre, which is one and a half from its first.
            self.uy[c] += (from + 1.5 * step) * sum + step * (QUAD as f32 * along + 1.5 * outer + 0.5 * inner);
            self.yy[c] += squares;
            self.rough[c] += whole * rough;
            (of_quads.y[c], of_quads.along[c], of_quads.yy[c]) = (sum, along, quad_squares);
        }
    }

    /// Adds what a whole block in time holds besides, of which [`Sums::add`] gave `of_quads`.
    fn add_block(&mut self, of_quads: &OfQuads, from: f32, step: f32) {
        let centre = from + 0.5 * (BLOCK - 1) as f32 * step;
        self.add_frames(BLOCK as u32, centre, step);
        self.bend.add(centre, &of_quads.y);
    }

    /// Adds frames that count: so many, in the middle of which lies `centre`, `step` apart.
    fn add_frames(&mut self, count: u32, centre: f32, step: f32) {
        let n = count as f32;
        self.n += count;
        self.u += n * centre;
        self.uu += n * (centre * centre + step * step * (n * n - 1.0) / 12.0);
    }

    /// Adds the frames of a block that count, one by one.
    #[inline(never)]
    fn add_each(&mut self, block: &Block, u: &[f32; BLOCK]) {
        for (u, _) in u.iter().zip(block.valid).filter(|(_, valid)| **valid != 0) {
            self.add_frames(1, *u, 0.0);
        }
    }

    /// Sums of u y along a path.
    fn add_along(&mut self, block: &Block, u: &[f32; BLOCK]) {
        for (values, u) in block.values.iter().zip(u) {
            for c in 0..CHANNELS_MAX {
                self.uy[c] += u * (values[c] - self.zero[c]);
            }
        }
    }

    /// Adds the quads of a block as if each were a frame; the first is at `from`.
    fn add_quads(&mut self, of_quads: &OfQuads, from: f32, step: f32) {
        const QUADS: u32 = (BLOCK / QUAD) as u32;
        self.add_frames(QUADS, from + 0.5 * (QUADS - 1) as f32 * step, step);
        for c in 0..CHANNELS_MAX {
            self.y[c] += of_quads.y[c];
            self.uy[c] += from * of_quads.y[c] + step * of_quads.along[c];
            self.yy[c] += of_quads.yy[c];
        }
    }

    /// Adds one frame.
    fn add_one(&mut self, y: &Values, u: f32) {
        self.add_frames(1, u, 0.0);
        for c in 0..CHANNELS_MAX {
            self.y[c] += y[c];
            self.uy[c] += u * y[c];
            self.yy[c] += y[c] * y[c];
        }
    }
}

/// Sums of groups of frames, relative to the first frame that counts: a stretch in a fraction of its frames. They are
/// means in another measure.
pub struct Means<'a> {
    /// Frames of a group, a multiple of [`QUAD`].
    by: u32,
    /// As many as there are whole groups.
    values: &'a mut [Values],
    /// Mask of valid taxels; 0 where no frame of a group counts.
    valid: &'a mut [u16],
    sums: Sums,
    /// Of the latest block.
    of_quads: OfQuads,
}

impl<'a> Means<'a> {
    /// Room for as many groups of `by` frames as go into both slices.
    pub fn new(by: u32, values: &'a mut [Values], valid: &'a mut [u16]) -> Self {
        let none = [0.0; CHANNELS_MAX];
        Self { by, values, valid, sums: Sums::new(none), of_quads: OfQuads { y: none, along: none, yy: none } }
    }

    /// `u` of a group, and from one to the next.
    fn place(&self, group: usize) -> (f32, f32) {
        let step = 2.0 / self.valid.len().max(1) as f32;
        ((group as f32 + 0.5) * step - 1.0, step)
    }

    /// Adds a block here and to the sums of all frames.
    fn add(&mut self, sums: &mut Sums, block: &Block, from: f32, step: f32, taxels: u16) {
        let first = block.at as usize / QUAD;
        let (u, u_step) = self.place(first);
        if block.whole
            && self.by == QUAD as u32
            && let Some(quads) = self.values.get_mut(first..).and_then(|values| values.first_chunk_mut())
            && let Some(valid) = self.valid.get_mut(first..first + BLOCK / QUAD)
        {
            valid.fill(taxels);
            sums.add(block, from, step, quads, &mut self.of_quads);
            sums.add_block(&self.of_quads, from, step);
            return self.sums.add_quads(&self.of_quads, u, u_step);
        }
        let mut quads = [[0.0; CHANNELS_MAX]; BLOCK / QUAD];
        sums.add(block, from, step, &mut quads, &mut self.of_quads);
        if block.whole && step > 0.0 {
            sums.add_block(&self.of_quads, from, step);
        }
        self.add_apart(block, &quads, taxels);
    }

    /// Adds quads that are less than a group, or of which frames are missing.
    #[inline(never)]
    fn add_apart(&mut self, block: &Block, quads: &Quads, taxels: u16) {
        for (q, quad) in quads.iter().enumerate() {
            let at = block.at + (QUAD * q) as u32;
            let group = (at / self.by) as usize;
            let (u, _) = self.place(group);
            let (Some(sum), Some(valid)) = (self.values.get_mut(group), self.valid.get_mut(group)) else { return };
            if at.is_multiple_of(self.by) {
                (*sum, *valid) = ([0.0; CHANNELS_MAX], 0);
            }
            // Frames are counted in the mask until all are there.
            *valid += block.valid[QUAD * q..QUAD * (q + 1)].iter().filter(|valid| **valid != 0).count() as u16;
            for c in 0..CHANNELS_MAX {
                sum[c] += quad[c];
            }
            if (at + QUAD as u32).is_multiple_of(self.by) && *valid > 0 {
                let share = self.by as f32 / *valid as f32;
                sum.iter_mut().for_each(|sum| *sum *= share);
                *valid = taxels;
                self.sums.add_one(sum, u);
            }
        }
    }

    /// Levels of the groups; `all` are those of the frames themselves, and tell their noise.
    pub fn levels(&self, all: &Levels, taxels: u16) -> Levels {
        let mut levels = self.sums.levels(taxels);
        for c in 0..CHANNELS_MAX {
            levels.rough[c] = all.rough[c] * self.by as f32;
        }
        levels
    }
}

/// First pass: levels, and which taxels and frames count; makes means on the way. None if the frames were
/// overwritten.
pub fn levels(span: &mut FrameSpan, means: Option<&mut Means>) -> Option<Levels> {
    span.taxels = reliable_taxels(span)?;
    let zero = span.first_counted()?.unwrap_or_default();
    let mut sums = Sums::new(zero);
    let (abscissa, frames, taxels) = (span.abscissa(), span.frames, span.taxels);
    let mut nowhere = Means::new(QUAD as u32, &mut [], &mut []);
    let means = means.unwrap_or(&mut nowhere);
    span.blocks(&zero, &mut |block| match abscissa.step() {
        Some(step) => {
            let from = abscissa.u(block.at);
            means.add(&mut sums, &block, from, step, taxels);
            if !block.whole {
                sums.add_each(&block, &abscissa.block(block.at, frames));
            }
        }
        None => {
            let u = abscissa.block(block.at, frames);
            means.add(&mut sums, &block, 0.0, 0.0, taxels);
            sums.add_each(&block, &u);
            sums.add_along(&block, &u);
        }
    })?;
    Some(sums.levels(taxels))
}

impl Levels {
    /// How many channels are usable.
    pub fn channels(&self) -> f32 {
        self.usable.count_ones() as f32
    }
}

impl Sums {
    fn levels(&self, taxels: u16) -> Levels {
        let empty = [0.0; CHANNELS_MAX];
        let mut result = Levels {
            offset: empty,
            slope: empty,
            about_line: empty,
            about_mean: empty,
            y: empty,
            uy: empty,
            yy: empty,
            rough: empty,
            bend: self.bend.clone(),
            u: self.u,
            uu: self.uu,
            usable: 0,
            frames: self.n,
        };
        if self.n < 4 {
            return result;
        }
        let count = self.n as f32;
        let spread = self.uu - self.u * self.u / count;
        for c in (0..CHANNELS_MAX).filter(|c| taxels & 1 << c != 0) {
            let mean = self.y[c] / count;
            let along = self.uy[c] - self.u * mean;
            let slope = along / spread;
            let about_mean = self.yy[c] - self.y[c] * mean;
            let about = about_mean - along * slope;
            // Below this the sum is what rounding left of it: the channel is constant, or a ramp. Nor is NaN above.
            if !(about > 1e-6 * self.yy[c] && about > 0.0 && about.is_finite()) {
                continue;
            }
            result.usable |= 1 << c;
            let offset = self.zero[c] + (mean - slope * self.u / count);
            // By how much the offset, as f32 holds it, is off the first value.
            let moved = offset - self.zero[c];
            result.offset[c] = offset;
            result.y[c] = self.y[c] - count * moved;
            result.uy[c] = self.uy[c] - self.u * moved;
            result.yy[c] = self.yy[c] - moved * (2.0 * self.y[c] - count * moved);
            for k in 0..2 {
                result.bend.y[k][c] -= self.bend.one[k] * moved;
            }
            result.slope[c] = slope;
            // 1 + 9 + 9 + 1: the squared factors of a third difference.
            result.rough[c] = self.rough[c] / (20 * self.quads).max(1) as f32;
            result.about_line[c] = about;
            result.about_mean[c] = about_mean;
        }
        result
    }
}
