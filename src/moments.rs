//! Sums over a window: all that the fit needs to know of the data, one pass each.
//!
//! The abscissa is `u`, the frame's place in the window: -1 at its start, 1 at its end. A frequency
//! is `nu`, cycles per unit of `u`, that is half the cycles in the window. Frames with a missing
//! conversion are left out of every sum.

use crate::levels::Levels;
use crate::settings::TAXELS;
use crate::waves::{Oscillator, Waves};
use crate::window::{FrameSource, Values};

/// Most harmonics, the fundamental included.
pub const HARMONICS_MAX: usize = 5;

/// Frames that share a lever in a long window.
pub(crate) const GROUP: usize = 8;
/// Of them in a block.
pub(crate) const GROUPS: usize = BLOCK / GROUP;
/// Frames read at a time: the time the ring is locked, and the stretch over which the rotation of
/// a phasor is taken from a table.
pub(crate) const BLOCK: usize = 16;

/// A stretch of frames and how to read it.
pub struct Stretch<'a, S> {
    source: &'a mut S,
    first: u32,
    /// Frames in it.
    pub(crate) frames: u32,
    /// Taxels that a frame must have valid values of to count; found by [`crate::levels::levels`].
    pub(crate) taxels: u16,
}

/// Some frames of a stretch, always as many as fit, so that loops over them have a fixed length.
pub(crate) struct Block<'a> {
    /// Number of its first frame in the stretch.
    pub at: u32,
    /// How many there are.
    pub frames: usize,
    /// The frames; where there are fewer, zeros behind them.
    pub values: &'a [Values; BLOCK],
    /// Mask of valid taxels per frame; 0 is a frame that is missing, not there, or does not count.
    pub valid: &'a [u16; BLOCK],
}

impl<'a, S: FrameSource> Stretch<'a, S> {
    /// The `frames` frames of `source` from frame number `first` on.
    pub fn new(source: &'a mut S, first: u32, frames: u32) -> Self {
        Self { source, first, frames, taxels: 0 }
    }

    /// Shows every frame block by block. None if the frames were overwritten meanwhile.
    pub(crate) fn blocks(&mut self, mut visit: impl FnMut(Block)) -> Option<()> {
        let (mut at, taxels) = (0, self.taxels);
        while at < self.frames {
            let most = (self.frames - at).min(BLOCK as u32) as usize;
            at += self.source.read(self.first.wrapping_add(at), most, |values, valid| {
                let frames = values.len().min(BLOCK);
                let mut mask = [0; BLOCK];
                for (mask, valid) in mask.iter_mut().zip(valid) {
                    *mask = if valid & taxels == taxels { *valid } else { 0 };
                }
                if let Ok(values) = values.try_into() {
                    visit(Block { at, frames, values, valid: &mask });
                } else {
                    // The last block, or the ring's end.
                    let mut some = [[0.0; TAXELS]; BLOCK];
                    some.iter_mut().zip(values).for_each(|(to, from)| *to = *from);
                    visit(Block { at, frames, values: &some, valid: &mask });
                }
                (frames as u32).max(1)
            })?;
        }
        Some(())
    }

    /// Half the window in frames: one unit of `u`.
    pub fn half(&self) -> f32 {
        0.5 * self.frames as f32
    }

    /// `u` of a frame of the stretch.
    pub(crate) fn u(&self, frame: u32) -> f32 {
        (frame as f32 - 0.5 * (self.frames as f32 - 1.0)) / self.half()
    }
}

/// Sums of the harmonics alone, over the frames that count: weight x cos(k theta) and
/// weight x sin(k theta) for every [`Weight`] and k = 0 ..= 2 x harmonics.
#[derive(Clone, Debug)]
pub struct Trigonometric {
    /// The lever is `u`: sums with it are those with `u`.
    exact: bool,
    cos: [[f32; ORDERS]; WEIGHTS],
    sin: [[f32; ORDERS]; WEIGHTS],
}

/// Orders of the sums: products of two harmonics have up to twice the order of either.
const ORDERS: usize = 2 * HARMONICS_MAX + 1;

/// What a sum is weighted with. `Lever` is `u` in the derivative by frequency, and in long windows the
/// same for eight frames at a time. That leaves the estimate without bias, since the residuals of the
/// true model have nothing in common with the waves under any lever, and costs it less than a 400th
/// of its information.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Weight {
    /// 1
    One,
    /// u
    U,
    /// u squared
    UU,
    /// lever
    Lever,
    /// lever x u
    LeverU,
    /// lever squared
    LeverLever,
}

const WEIGHTS: usize = 6;

/// One of the functions a channel is made of, but for a power of `u`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Wave {
    /// 1
    One,
    /// cos(h theta)
    Cos(usize),
    /// sin(h theta)
    Sin(usize),
}

impl Trigonometric {
    /// Sum of weight x a x b.
    pub fn product(&self, weight: Weight, a: Wave, b: Wave) -> f32 {
        let weight = match weight {
            Weight::Lever if self.exact => Weight::U,
            Weight::LeverU | Weight::LeverLever if self.exact => Weight::UU,
            weight => weight,
        };
        let (cos, sin) = (&self.cos[weight as usize], &self.sin[weight as usize]);
        let signed = |to: usize, from: usize| if to >= from { sin[to - from] } else { -sin[from - to] };
        match (a, b) {
            (Wave::One, Wave::One) => cos[0],
            (Wave::One, Wave::Cos(h)) | (Wave::Cos(h), Wave::One) => cos[h],
            (Wave::One, Wave::Sin(h)) | (Wave::Sin(h), Wave::One) => sin[h],
            (Wave::Cos(i), Wave::Cos(j)) => 0.5 * (cos[i.abs_diff(j)] + cos[i + j]),
            (Wave::Sin(i), Wave::Sin(j)) => 0.5 * (cos[i.abs_diff(j)] - cos[i + j]),
            (Wave::Cos(i), Wave::Sin(j)) | (Wave::Sin(j), Wave::Cos(i)) => 0.5 * (sin[i + j] + signed(j, i)),
        }
    }

    /// Adds to the sums of order `k`, in the order of [`Weight`].
    #[inline(always)]
    pub(crate) fn add<const N: usize>(&mut self, k: usize, cos: [f32; N], sin: [f32; N]) {
        for w in 0..N {
            self.cos[w][k] += cos[w];
            self.sin[w][k] += sin[w];
        }
    }
}

/// One channel against the harmonics; y is the channel less its [`Levels::offset`].
#[derive(Clone, Copy, Debug, Default)]
pub struct Correlation {
    /// Sums of y cos(h theta), h from 1.
    pub cos: [f32; HARMONICS_MAX],
    /// Sums of y sin(h theta).
    pub sin: [f32; HARMONICS_MAX],
    /// Sums of lever y cos(h theta).
    pub lever_cos: [f32; HARMONICS_MAX],
    /// Sums of lever y sin(h theta).
    pub lever_sin: [f32; HARMONICS_MAX],
}

impl Correlation {
    fn add(&mut self, h: usize, cos: f32, sin: f32, lever_cos: f32, lever_sin: f32) {
        self.cos[h] += cos;
        self.sin[h] += sin;
        self.lever_cos[h] += lever_cos;
        self.lever_sin[h] += lever_sin;
    }
}

/// What one pass at one frequency gives.
#[derive(Clone, Debug)]
pub struct Moments {
    /// Sums of the harmonics alone.
    pub trigonometric: Trigonometric,
    /// Each channel against them.
    pub channels: [Correlation; TAXELS],
}

/// Windows of at least so many frames take one lever for a group of frames.
const LONG_WINDOW: u32 = 160;

/// One pass at frequency `nu` with `harmonics` harmonics (1 to [`HARMONICS_MAX`]). None if the
/// frames were overwritten.
pub fn moments<S: FrameSource>(
    stretch: &mut Stretch<'_, S>,
    levels: &Levels,
    nu: f32,
    harmonics: usize,
) -> Option<Moments> {
    let oscillator = Oscillator::new(stretch, nu, harmonics.clamp(1, HARMONICS_MAX));
    let mut waves = Waves::new();
    let mut out = Moments {
        trigonometric: Trigonometric {
            exact: stretch.frames < LONG_WINDOW,
            cos: [[0.0; ORDERS]; WEIGHTS],
            sin: [[0.0; ORDERS]; WEIGHTS],
        },
        channels: [Correlation::default(); TAXELS],
    };
    stretch.blocks(|block| {
        oscillator.fill(&block, &mut waves);
        if out.trigonometric.exact {
            out.add_short(&block, &oscillator, &waves, levels);
        } else {
            out.add_long(&block, &oscillator, &waves, levels);
        }
    })?;
    Some(out)
}

impl Moments {
    /// A block of a long window. On its own, so that there is one copy of it for all kinds of sources;
    /// `add_short` likewise.
    #[inline(never)]
    fn add_long(&mut self, block: &Block, oscillator: &Oscillator, waves: &Waves, levels: &Levels) {
        let levers = oscillator.add_groups(block, waves, &mut self.trigonometric);
        for c in 0..TAXELS {
            if levels.usable & 1 << c == 0 {
                continue;
            }
            let (y, channel) = (column(block, c, levels.offset[c]), &mut self.channels[c]);
            for h in 0..oscillator.harmonics {
                let (wave_cos, wave_sin) = (&waves.cos[h], &waves.sin[h]);
                let (mut cos, mut sin, mut lever_cos, mut lever_sin) = (0.0, 0.0, 0.0, 0.0);
                for q in 0..GROUPS {
                    let (mut c, mut s) = (0.0, 0.0);
                    for i in GROUP * q..GROUP * (q + 1) {
                        c += y[i] * wave_cos[i];
                        s += y[i] * wave_sin[i];
                    }
                    cos += c;
                    sin += s;
                    lever_cos += levers[q] * c;
                    lever_sin += levers[q] * s;
                }
                channel.add(h, cos, sin, lever_cos, lever_sin);
            }
        }
    }

    /// A block of a short window: the lever is `u`.
    #[inline(never)]
    fn add_short(&mut self, block: &Block, oscillator: &Oscillator, waves: &Waves, levels: &Levels) {
        oscillator.add_frames(block, waves, &mut self.trigonometric);
        for c in 0..TAXELS {
            if levels.usable & 1 << c == 0 {
                continue;
            }
            let (y, channel) = (column(block, c, levels.offset[c]), &mut self.channels[c]);
            let mut uy = y;
            for i in 0..BLOCK {
                uy[i] *= waves.u[i];
            }
            for h in 0..oscillator.harmonics {
                let (wave_cos, wave_sin) = (&waves.cos[h], &waves.sin[h]);
                let (mut cos, mut sin, mut u_cos, mut u_sin) = (0.0, 0.0, 0.0, 0.0);
                for i in 0..BLOCK {
                    cos += y[i] * wave_cos[i];
                    sin += y[i] * wave_sin[i];
                    u_cos += uy[i] * wave_cos[i];
                    u_sin += uy[i] * wave_sin[i];
                }
                channel.add(h, cos, sin, u_cos, u_sin);
            }
        }
    }
}

/// One channel's values in a block, less its offset. What stands in missing frames meets waves of zero.
#[inline(always)]
fn column(block: &Block, taxel: usize, offset: f32) -> [f32; BLOCK] {
    let mut y = [0.0; BLOCK];
    for i in 0..BLOCK {
        y[i] = block.values[i][taxel] - offset;
    }
    y
}
