//! Sums over a window: all that the fit needs to know of the data, one pass each.
//!
//! The abscissa is `u`, the frame's place in the window: -1 at its start, 1 at its end. A frequency
//! is `nu`, cycles per unit of `u`, that is half the cycles in the window. Frames with a missing
//! conversion are left out of every sum.

use crate::levels::Levels;
use crate::phase::{cos_sin, from_turns};
use crate::settings::TAXELS;
use crate::window::{FrameSource, Values};

/// Most harmonics, the fundamental included.
pub const HARMONICS_MAX: usize = 5;

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

/// Sums of the harmonics alone, over the frames that count: sums of u^w cos(k theta) and
/// u^w sin(k theta) for w = 0, 1, 2 and k = 0 ..= 2 x harmonics.
#[derive(Clone, Debug)]
pub struct Trigonometric {
    cos: [[f32; 2 * HARMONICS_MAX + 1]; 3],
    sin: [[f32; 2 * HARMONICS_MAX + 1]; 3],
}

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
    /// Sum of u^power x a x b, power 0 to 2.
    pub fn product(&self, power: usize, a: Wave, b: Wave) -> f32 {
        let (cos, sin) = (&self.cos[power], &self.sin[power]);
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
}

/// One channel against the harmonics; y is the channel less its [`Levels::offset`].
#[derive(Clone, Copy, Debug, Default)]
pub struct Correlation {
    /// Sums of y cos(h theta), h from 1.
    pub cos: [f32; HARMONICS_MAX],
    /// Sums of y sin(h theta).
    pub sin: [f32; HARMONICS_MAX],
    /// Sums of u y cos(h theta).
    pub u_cos: [f32; HARMONICS_MAX],
    /// Sums of u y sin(h theta).
    pub u_sin: [f32; HARMONICS_MAX],
}

/// What one pass at one frequency gives.
#[derive(Clone, Debug)]
pub struct Moments {
    /// Sums of the harmonics alone.
    pub trigonometric: Trigonometric,
    /// Each channel against them.
    pub channels: [Correlation; TAXELS],
}

/// The harmonics over one block of frames, zero where a frame is missing.
struct Waves {
    u: [f32; BLOCK],
    cos: [[f32; BLOCK]; HARMONICS_MAX],
    sin: [[f32; BLOCK]; HARMONICS_MAX],
}

impl Waves {
    const fn new() -> Self {
        Self { u: [0.0; BLOCK], cos: [[0.0; BLOCK]; HARMONICS_MAX], sin: [[0.0; BLOCK]; HARMONICS_MAX] }
    }
}

/// Makes the harmonics of a frequency block after block, without drifting: each block starts from
/// the exact phase and is turned by a table.
struct Oscillator {
    turn: [(f32, f32); BLOCK],
    phase_0: u32,
    step: u32,
    u_0: f32,
    u_step: f32,
}

impl Oscillator {
    fn new<S: FrameSource>(stretch: &Stretch<'_, S>, nu: f32) -> Self {
        let step = from_turns(nu / stretch.half());
        let mut turn = [(1.0, 0.0); BLOCK];
        for (i, turn) in turn.iter_mut().enumerate() {
            *turn = cos_sin(step.wrapping_mul(i as u32));
        }
        // Phase zero at the centre, which lies half way between two frames if their number is even.
        let back = step as u64 * stretch.frames.saturating_sub(1) as u64 / 2;
        let phase_0 = (back as u32).wrapping_neg();
        Self { turn, phase_0, step, u_0: stretch.u(0), u_step: 1.0 / stretch.half() }
    }

    fn fill<const H: usize>(&self, block: &Block, waves: &mut Waves) {
        let (c, s) = cos_sin(self.phase_0.wrapping_add(self.step.wrapping_mul(block.at)));
        for i in 0..BLOCK {
            let (tc, ts) = self.turn[i];
            let (mut c1, mut s1) = (c * tc - s * ts, s * tc + c * ts);
            if block.valid[i] == 0 {
                (c1, s1) = (0.0, 0.0);
            }
            waves.u[i] = self.u_0 + self.u_step * (block.at + i as u32) as f32;
            let (mut ch, mut sh) = (c1, s1);
            for h in 0..H {
                waves.cos[h][i] = ch;
                waves.sin[h][i] = sh;
                (ch, sh) = (ch * c1 - sh * s1, sh * c1 + ch * s1);
            }
        }
    }
}

/// One pass at frequency `nu` with `harmonics` harmonics (1 to [`HARMONICS_MAX`]). None if the
/// frames were overwritten.
pub fn moments<S: FrameSource>(
    stretch: &mut Stretch<'_, S>,
    levels: &Levels,
    nu: f32,
    harmonics: usize,
) -> Option<Moments> {
    match harmonics {
        0 | 1 => pass::<S, 1>(stretch, levels, nu),
        2 => pass::<S, 2>(stretch, levels, nu),
        3 => pass::<S, 3>(stretch, levels, nu),
        4 => pass::<S, 4>(stretch, levels, nu),
        _ => pass::<S, HARMONICS_MAX>(stretch, levels, nu),
    }
}

fn pass<S: FrameSource, const H: usize>(stretch: &mut Stretch<'_, S>, levels: &Levels, nu: f32) -> Option<Moments> {
    let oscillator = Oscillator::new(stretch, nu);
    let mut waves = Waves::new();
    let mut out = Moments {
        trigonometric: Trigonometric { cos: [[0.0; 11]; 3], sin: [[0.0; 11]; 3] },
        channels: [Correlation::default(); TAXELS],
    };
    stretch.blocks(|block| out.add::<H>(&block, &oscillator, &mut waves, levels))?;
    Some(out)
}

impl Moments {
    /// One block further. On its own, so that there is one copy of it for all kinds of sources.
    #[inline(never)]
    fn add<const H: usize>(&mut self, block: &Block, oscillator: &Oscillator, waves: &mut Waves, levels: &Levels) {
        oscillator.fill::<H>(block, waves);
        for i in 0..BLOCK {
            if block.valid[i] != 0 {
                self.trigonometric.add::<H>(waves, i);
            }
        }
        for c in 0..TAXELS {
            if levels.usable & 1 << c != 0 {
                self.channels[c].add::<H>(waves, block.values, c, levels.offset[c]);
            }
        }
    }
}

impl Trigonometric {
    fn add<const H: usize>(&mut self, waves: &Waves, i: usize) {
        let (u, c1, s1) = (waves.u[i], waves.cos[0][i], waves.sin[0][i]);
        let (mut c, mut s) = (1.0, 0.0);
        for k in 0..=2 * H {
            let (uc, us) = (u * c, u * s);
            self.cos[0][k] += c;
            self.sin[0][k] += s;
            self.cos[1][k] += uc;
            self.sin[1][k] += us;
            self.cos[2][k] += u * uc;
            self.sin[2][k] += u * us;
            (c, s) = (c * c1 - s * s1, s * c1 + c * s1);
        }
    }
}

impl Correlation {
    #[inline(always)]
    fn add<const H: usize>(&mut self, waves: &Waves, values: &[Values; BLOCK], taxel: usize, offset: f32) {
        let (mut cos, mut sin, mut u_cos, mut u_sin) = ([0.0; H], [0.0; H], [0.0; H], [0.0; H]);
        for i in 0..BLOCK {
            let y = values[i][taxel] - offset;
            let t = waves.u[i] * y;
            for h in 0..H {
                let (c, s) = (waves.cos[h][i], waves.sin[h][i]);
                cos[h] += y * c;
                sin[h] += y * s;
                u_cos[h] += t * c;
                u_sin[h] += t * s;
            }
        }
        for h in 0..H {
            self.cos[h] += cos[h];
            self.sin[h] += sin[h];
            self.u_cos[h] += u_cos[h];
            self.u_sin[h] += u_sin[h];
        }
    }
}

/// What a channel's model is made of: offset, slope, and per harmonic the factors of cosine and sine.
#[derive(Clone, Copy, Debug, Default)]
pub struct Model {
    /// Offset beyond [`Levels::offset`].
    pub offset: f32,
    /// Slope per unit of `u`.
    pub slope: f32,
    /// Factors of cos(h theta).
    pub cos: [f32; HARMONICS_MAX],
    /// Factors of sin(h theta).
    pub sin: [f32; HARMONICS_MAX],
}

/// Sums of squares of what models leave of each channel, taken sample by sample: the difference of
/// two sums of squares would drown a small residual in rounding. None if the frames were overwritten.
pub fn residuals<S: FrameSource>(
    stretch: &mut Stretch<'_, S>,
    levels: &Levels,
    nu: f32,
    harmonics: usize,
    models: &[Model; TAXELS],
) -> Option<Values> {
    let oscillator = Oscillator::new(stretch, nu);
    let mut waves = Waves::new();
    let mut sums = [0f32; TAXELS];
    let harmonics = harmonics.min(HARMONICS_MAX);
    stretch.blocks(|block| {
        oscillator.fill::<HARMONICS_MAX>(&block, &mut waves);
        add_residuals(&block, &waves, levels, harmonics, models, &mut sums);
    })?;
    Some(sums)
}

/// One block further; on its own like [`Moments::add`].
#[inline(never)]
fn add_residuals(
    block: &Block,
    waves: &Waves,
    levels: &Levels,
    harmonics: usize,
    models: &[Model; TAXELS],
    sums: &mut Values,
) {
    for (c, model) in models.iter().enumerate() {
        if levels.usable & 1 << c == 0 {
            continue;
        }
        let zero = levels.offset[c] + model.offset;
        let mut rest = [0.0; BLOCK];
        for i in 0..BLOCK {
            rest[i] = block.values[i][c] - zero - model.slope * waves.u[i];
        }
        for h in 0..harmonics {
            let (cos, sin) = (model.cos[h], model.sin[h]);
            for i in 0..BLOCK {
                rest[i] -= cos * waves.cos[h][i] + sin * waves.sin[h][i];
            }
        }
        let mut part = 0.0;
        for i in 0..BLOCK {
            if block.valid[i] != 0 {
                part += rest[i] * rest[i];
            }
        }
        sums[c] += part;
    }
}
