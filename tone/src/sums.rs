//! Sums of the first pass over a span, values less those of its first frame.

use crate::frame_span::{BLOCK, Block};
use crate::limits::CHANNELS_MAX;
use crate::source::Values;
use crate::waves::legendre;

/// Frames that are added up before they meet `u`, and of which means are made.
pub const QUAD: usize = 4;

/// Sums over the complete blocks of a span in time with the second and third Legendre polynomial, each taken at its
/// block's centre. Where there are many blocks that is as good as a smooth bend to decide whether there is one.
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
    /// Adds a complete block about `centre` with the channels' sums `y`.
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

/// Sums of the quads of a block.
pub type Quads = [Values; BLOCK / QUAD];

/// Sums over the quads of a block: of each, of its number (from 0) times each, and of its square.
#[derive(Clone, Copy, Default)]
pub struct OfQuads {
    pub y: Values,
    pub along: Values,
    pub yy: Values,
}

const _: () = assert!(BLOCK / QUAD == 4, "a column is added in four quads");

/// Sums of one channel over a block, values less `zero`.
struct Column {
    zero: f32,
    sum: f32,
    /// Of each quad's number times its sum.
    along: f32,
    /// Of the last frame of each quad less the first.
    outer: f32,
    /// Of the third less the second.
    inner: f32,
    squares: f32,
    quad_squares: f32,
    /// Of squared third differences.
    third_squares: f32,
}

impl Column {
    #[inline(always)]
    fn new(zero: f32) -> Self {
        let (sum, along, outer, inner) = (0.0, 0.0, 0.0, 0.0);
        Self { zero, sum, along, outer, inner, squares: 0.0, quad_squares: 0.0, third_squares: 0.0 }
    }

    /// Adds quad `q` of channel `c`; gives its sum.
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
        self.third_squares += third * third;
        self.sum += quad;
        self.along += q as f32 * quad;
        self.quad_squares += quad * quad;
        quad
    }
}

/// Sums over a span, values less `zero`.
pub struct Sums {
    pub zero: Values,
    /// Frames.
    pub n: u32,
    pub u: f32,
    pub uu: f32,
    pub y: Values,
    pub uy: Values,
    pub yy: Values,
    pub bend: Bend,
    /// Of squared third differences, and how many for each channel.
    pub third_squares: Values,
    pub quads: u32,
}

impl Sums {
    pub fn new(zero: Values) -> Self {
        let none = [0.0; CHANNELS_MAX];
        let bend = Bend::default();
        Self { zero, n: 0, u: 0.0, uu: 0.0, y: none, uy: none, yy: none, bend, third_squares: none, quads: 0 }
    }

    /// Adds the values of a block whose frames have their `u` from `from` on, `step` apart. If the step is zero, `uy` is
    /// left to [`Sums::add_along`].
    #[inline(never)]
    pub fn add(&mut self, block: &Block, from: f32, step: f32, quads: &mut Quads, of_quads: &mut OfQuads) {
        let complete = if block.complete { 1.0 } else { 0.0 };
        self.quads += if block.complete { (BLOCK / QUAD) as u32 } else { 0 };
        for c in 0..CHANNELS_MAX {
            let mut column = Column::new(self.zero[c]);
            // One by one: the compiler would make a loop of a loop.
            quads[0][c] = column.add(block, 0, c);
            quads[1][c] = column.add(block, 1, c);
            quads[2][c] = column.add(block, 2, c);
            quads[3][c] = column.add(block, 3, c);
            let Column { sum, along, outer, inner, squares, quad_squares, third_squares, .. } = column;
            self.y[c] += sum;
            // Frames are half of one and of three from their quad's centre, which is one and a half from its first.
            self.uy[c] += (from + 1.5 * step) * sum + step * (QUAD as f32 * along + 1.5 * outer + 0.5 * inner);
            self.yy[c] += squares;
            self.third_squares[c] += complete * third_squares;
            (of_quads.y[c], of_quads.along[c], of_quads.yy[c]) = (sum, along, quad_squares);
        }
    }

    /// Adds the frames and the bend of a complete block in time, of which [`Sums::add`] gave `of_quads`.
    pub fn add_block(&mut self, of_quads: &OfQuads, from: f32, step: f32) {
        let centre = from + 0.5 * (BLOCK - 1) as f32 * step;
        self.add_frames(BLOCK as u32, centre, step);
        self.bend.add(centre, &of_quads.y);
    }

    /// Adds `count` frames that count, `step` apart about `centre`.
    fn add_frames(&mut self, count: u32, centre: f32, step: f32) {
        let n = count as f32;
        self.n += count;
        self.u += n * centre;
        self.uu += n * (centre * centre + step * step * (n * n - 1.0) / 12.0);
    }

    /// Adds the frames of a block that count, one by one.
    #[inline(never)]
    pub fn add_each(&mut self, block: &Block, u: &[f32; BLOCK]) {
        for (u, _) in u.iter().zip(block.valid).filter(|(_, valid)| **valid != 0) {
            self.add_frames(1, *u, 0.0);
        }
    }

    /// Sums of u y along a path.
    pub fn add_along(&mut self, block: &Block, u: &[f32; BLOCK]) {
        for (values, u) in block.values.iter().zip(u) {
            for c in 0..CHANNELS_MAX {
                self.uy[c] += u * (values[c] - self.zero[c]);
            }
        }
    }

    /// Adds the quads of a block as if each were a frame; the first is at `from`.
    pub fn add_quads(&mut self, of_quads: &OfQuads, from: f32, step: f32) {
        const QUADS: u32 = (BLOCK / QUAD) as u32;
        self.add_frames(QUADS, from + 0.5 * (QUADS - 1) as f32 * step, step);
        for c in 0..CHANNELS_MAX {
            self.y[c] += of_quads.y[c];
            self.uy[c] += from * of_quads.y[c] + step * of_quads.along[c];
            self.yy[c] += of_quads.yy[c];
        }
    }

    /// Adds one frame.
    pub fn add_one(&mut self, y: &Values, u: f32) {
        self.add_frames(1, u, 0.0);
        for c in 0..CHANNELS_MAX {
            self.y[c] += y[c];
            self.uy[c] += u * y[c];
            self.yy[c] += y[c] * y[c];
        }
    }
}
