//! The level and the slope of every channel in a stretch, and which channels can be used: the first pass.

use crate::settings::TAXELS;
use crate::stretch::{BLOCK, Block, Stretch};
use crate::window::Values;

/// Frames that are added up before they meet `u`, and of which means are made.
pub(crate) const QUAD: usize = 4;

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
    /// Taxels with valid values in nearly all frames, and not constant.
    pub usable: u16,
    /// Frames that count.
    pub frames: u32,
}

/// A taxel without a valid value in more than this share of the frames is left out. Of the others
/// every frame must have one: all channels share one abscissa.
const INVALID_MAX: f32 = 0.1;

/// Taxels that have valid values in nearly all frames that have any. None if the frames were
/// overwritten.
fn reliable_taxels(stretch: &mut Stretch) -> Option<u16> {
    let (mut frames, mut invalid) = (0u32, [0u32; TAXELS]);
    stretch.taxels = 0;
    stretch.blocks(&[0.0; TAXELS], &mut |block| {
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

/// Sums over a stretch, values less `zero`.
struct Sums {
    zero: Values,
    n: u32,
    u: f32,
    uu: f32,
    y: Values,
    uy: Values,
    yy: Values,
    /// Third differences squared, and how many for each channel.
    rough: Values,
    quads: u32,
}

impl Sums {
    #[inline(never)]
    fn add(&mut self, block: &Block, u: &[f32; BLOCK], in_time: bool, quads: &mut Quads) {
        for i in 0..BLOCK {
            if block.valid[i] != 0 {
                self.n += 1;
                self.u += u[i];
                self.uu += u[i] * u[i];
            }
        }
        self.quads += if block.whole { (BLOCK / QUAD) as u32 } else { 0 };
        let step = u[1] - u[0];
        for c in 0..TAXELS {
            let zero = self.zero[c];
            let (mut sum, mut u_sum, mut within, mut squares, mut rough) = (0.0, 0.0, 0.0, 0.0, 0.0);
            for q in 0..BLOCK / QUAD {
                let y: [f32; QUAD] = core::array::from_fn(|i| block.values[QUAD * q + i][c] - zero);
                let quad = y[0] + y[1] + y[2] + y[3];
                // From the quad's second frame.
                u_sum += u[QUAD * q + 1] * quad;
                within += y[2] - y[0] + y[3] + y[3];
                for y in y {
                    squares += y * y;
                }
                let third = y[3] - y[0] + 3.0 * (y[1] - y[2]);
                rough += third * third;
                quads[q][c] = quad;
                sum += quad;
            }
            self.y[c] += sum;
            if in_time {
                self.uy[c] += u_sum + step * within;
            }
            self.yy[c] += squares;
            if block.whole {
                self.rough[c] += rough;
            }
        }
    }

    /// Sums of u y along a path instead.
    fn add_along(&mut self, block: &Block, u: &[f32; BLOCK]) {
        for (values, u) in block.values.iter().zip(u) {
            for c in 0..TAXELS {
                self.uy[c] += u * (values[c] - self.zero[c]);
            }
        }
    }
}

/// Means of groups of frames, relative to the first frame that counts: a stretch in a fraction of its frames.
pub(crate) struct Means<'a> {
    /// Frames of a group, a multiple of [`QUAD`].
    pub by: u32,
    /// The means; as many as there are whole groups.
    pub values: &'a mut [Values],
    /// Mask of valid taxels; 0 where no frame of a group counts.
    pub valid: &'a mut [u16],
}

impl Means<'_> {
    fn add(&mut self, block: &Block, quads: &Quads, taxels: u16) {
        for (q, quad) in quads.iter().enumerate() {
            let group = ((block.at + (QUAD * q) as u32) / self.by) as usize;
            let (Some(sum), Some(valid)) = (self.values.get_mut(group), self.valid.get_mut(group)) else { return };
            if self.by == QUAD as u32 && block.whole {
                for c in 0..TAXELS {
                    sum[c] = quad[c] * (1.0 / QUAD as f32);
                }
                *valid = taxels;
                continue;
            }
            // Frames are counted in the mask until all are there.
            let counted = block.valid[QUAD * q..QUAD * (q + 1)].iter().filter(|valid| **valid != 0).count();
            *valid += counted as u16;
            for c in 0..TAXELS {
                sum[c] += quad[c];
            }
            let last = (block.at + (QUAD * (q + 1)) as u32).is_multiple_of(self.by);
            if last && *valid > 0 {
                let share = 1.0 / *valid as f32;
                sum.iter_mut().for_each(|sum| *sum *= share);
                *valid = taxels;
            }
        }
    }
}

/// First pass: levels, and which taxels and frames count; makes means on the way. None if the frames were
/// overwritten.
pub(crate) fn levels(stretch: &mut Stretch, mut means: Option<Means>) -> Option<Levels> {
    stretch.taxels = reliable_taxels(stretch)?;
    let zero = stretch.first_counted()?.unwrap_or_default();
    let empty = [0.0; TAXELS];
    let mut sums = Sums { zero, n: 0, u: 0.0, uu: 0.0, y: empty, uy: empty, yy: empty, rough: empty, quads: 0 };
    if let Some(means) = &mut means {
        means.values.fill(empty);
        means.valid.fill(0);
    }
    let (abscissa, frames, taxels, in_time) =
        (stretch.abscissa(), stretch.frames, stretch.taxels, stretch.is_in_time());
    let mut quads = [empty; BLOCK / QUAD];
    stretch.blocks(&zero, &mut |block| {
        let u = abscissa.block(block.at, frames);
        sums.add(&block, &u, in_time, &mut quads);
        if !in_time {
            sums.add_along(&block, &u);
        }
        if let Some(means) = &mut means {
            means.add(&block, &quads, taxels);
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
        let empty = [0.0; TAXELS];
        let mut result = Levels {
            offset: empty,
            slope: empty,
            about_line: empty,
            about_mean: empty,
            y: empty,
            uy: empty,
            yy: empty,
            rough: empty,
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
        for c in (0..TAXELS).filter(|c| taxels & 1 << c != 0) {
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
            result.slope[c] = slope;
            // 1 + 9 + 9 + 1: the squared factors of a third difference.
            result.rough[c] = self.rough[c] / (20 * self.quads).max(1) as f32;
            result.about_line[c] = about;
            result.about_mean[c] = about_mean;
        }
        result
    }
}
