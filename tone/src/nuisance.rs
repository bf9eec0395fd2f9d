//! Components of a channel besides its level, its slope and the tone: a curved baseline, an interferer.
//!
//! Each is a function of the frame, known but for its factor in every channel, and so one more linear
//! unknown of the fit. A baseline that relaxes is curved: within a window the
//! second and third Legendre polynomials describe an exponential whose time constant is not much
//! shorter than the window. An interferer of known frequency is a cosine and a sine; sampled below twice
//! its frequency it is their alias, and needs no other treatment.

use crate::frame_span::{BLOCK, Block, FrameSpan};
use crate::groups::{GROUP, part, products};
use crate::levels::Levels;
use crate::limits::{CHANNELS_MAX, CURVE_FUNCTIONS, NUISANCES_MAX, UNKNOWNS_MAX};
use crate::normal::Normal;
use crate::phase::{TURN, cos_sin, from_turns};
use crate::source::{Overwritten, Values};

/// A baseline that is no straight line.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Curve {
    /// It is straight.
    #[default]
    None,
    /// Second and third Legendre polynomial of `u`.
    Bent,
    /// exp(-rate (u + 1)), rate > 0: the time constant is half the window over `rate`; and behind it its
    /// derivative by the rate. Both less a line, so that a slope must be fitted too.
    Relaxing(f32),
}

impl Curve {
    fn functions(self) -> usize {
        match self {
            Self::None => 0,
            Self::Bent | Self::Relaxing(_) => CURVE_FUNCTIONS,
        }
    }
}

/// An interferer of fewer cycles in a span than this, as sampling folds it, is a part of the baseline.
const ALIAS_CYCLES_MIN: f32 = 0.5;
/// A function whose mean square is less than this is zero but for rounding: folded onto half the frame rate, an
/// interferer is its cosine or its sine alone.
const MEAN_SQUARE_MIN: f32 = 1e-3;

/// Offset, slope, and factors of the functions, for every channel.
pub type Baseline = [Values; 2 + NUISANCES_MAX];

/// The functions of a span, and their sums over it.
#[derive(Clone, Debug, Default)]
pub struct Nuisances {
    /// Those of a curve; those of an interferer come first.
    pub curve: Curve,
    /// Whether the two of an interferer are among them.
    pub interferer: bool,
    /// Phase of the interferer per frame and in the first frame, and its turns from a block's first frame.
    step: u32,
    phase_0: u32,
    turn: [(f32, f32); BLOCK],
    /// Whether its cosine, and its sine, is zero but for rounding.
    zero: [bool; 2],
    /// Sums of y times the function, each channel less its [`Levels::offset`].
    pub y: [Values; NUISANCES_MAX],
    /// Sums of the function, of u times it, and of its products with each.
    pub one: [f32; NUISANCES_MAX],
    /// Sums of u times the function.
    pub u: [f32; NUISANCES_MAX],
    /// Sums of its products with each.
    pub each: [[f32; NUISANCES_MAX]; NUISANCES_MAX],
}

/// Values of the functions over a block, zero where a frame does not count.
pub type Columns = [[f32; NUISANCES_MAX]; BLOCK];

impl Nuisances {
    /// How many there are.
    pub fn count(&self) -> usize {
        self.curve.functions() + 2 * self.interferer as usize
    }

    /// Those of a span's interferer, and those of a curve. One pass, unless there are none.
    pub fn new(span: &mut FrameSpan, levels: &Levels, curve: Curve) -> Result<Self, Overwritten> {
        let step = from_turns(span.interferer.unwrap_or(0.0));
        let folded = step.min(step.wrapping_neg()) as f32 / TURN;
        let interferer = span.interferer.is_some() && folded * span.frames as f32 >= ALIAS_CYCLES_MIN;
        let mut out = Self { curve, interferer, ..Self::default() };
        let count = out.count();
        if count == 0 {
            return Ok(out);
        }
        let back = step as u64 * span.frames.saturating_sub(1) as u64 / 2;
        (out.step, out.phase_0) = (step, (back as u32).wrapping_neg());
        for (i, turn) in out.turn.iter_mut().enumerate() {
            *turn = cos_sin(step.wrapping_mul(i as u32));
        }
        let (abscissa, frames) = (span.abscissa(), span.frames);
        span.blocks(&levels.offset, &mut |block| {
            let u = abscissa.block(block.first, frames);
            let mut columns = [[0.0; NUISANCES_MAX]; BLOCK];
            out.fill(&block, &u, &mut columns);
            for (i, functions) in columns.iter().enumerate() {
                for k in 0..count {
                    out.one[k] += functions[k];
                    out.u[k] += functions[k] * u[i];
                    for l in 0..count {
                        out.each[k][l] += functions[k] * functions[l];
                    }
                }
            }
            for group in 0..CHANNELS_MAX / GROUP {
                let part = part(&block, &levels.offset, group);
                for k in 0..count {
                    let function = core::array::from_fn(|i| columns[i][k]);
                    let sums = products(&part, &function);
                    for c in 0..GROUP {
                        // A channel that is not used may hold NaN.
                        if levels.usable & 1 << (GROUP * group + c) != 0 {
                            out.y[k][GROUP * group + c] += sums[c];
                        }
                    }
                }
            }
        })?;
        if out.interferer {
            out.leave_out_zero(levels.frames);
        }
        Ok(out)
    }

    /// Takes a function that is nothing but rounding out of the interferer's: its factor is then zero.
    fn leave_out_zero(&mut self, frames: u32) {
        for k in 0..2 {
            if self.each[k][k] < MEAN_SQUARE_MIN * frames as f32 {
                self.zero[k] = true;
                (self.y[k], self.one[k], self.u[k]) = ([0.0; CHANNELS_MAX], 0.0, 0.0);
                self.each[k] = [0.0; NUISANCES_MAX];
                self.each.iter_mut().for_each(|products| products[k] = 0.0);
                self.each[k][k] = 1.0;
            }
        }
    }

    /// The functions over a block.
    pub fn fill(&self, block: &Block, u: &[f32; BLOCK], columns: &mut Columns) {
        if self.count() == 0 {
            return;
        }
        let first = 2 * self.interferer as usize;
        let (c, s) = cos_sin(self.phase_0.wrapping_add(self.step.wrapping_mul(block.first)));
        let centre = if let Curve::Relaxing(rate) = self.curve { libm::expf(-rate) } else { 0.0 };
        for (i, functions) in columns.iter_mut().enumerate() {
            let counts = (block.valid[i] != 0) as u8 as f32;
            if self.interferer {
                let (tc, ts) = self.turn[i];
                let [cos, sin] = self.zero.map(|zero| if zero { 0.0 } else { counts });
                (functions[0], functions[1]) = ((c * tc - s * ts) * cos, (s * tc + c * ts) * sin);
            }
            match self.curve {
                Curve::None => {}
                Curve::Bent => {
                    if let [second, third, ..] = &mut functions[first..] {
                        let uu = u[i] * u[i];
                        *second = (1.5 * uu - 0.5) * counts;
                        *third = (2.5 * uu - 1.5) * u[i] * counts;
                    }
                }
                // Less the line that each resembles where the rate is small: f32 could not separate them from the slope.
                Curve::Relaxing(rate) => {
                    if let [relaxing, change, ..] = &mut functions[first..] {
                        let beyond = libm::expf(-rate * (u[i] + 1.0)) - centre;
                        let bent = beyond + centre * rate * u[i];
                        *relaxing = bent * counts;
                        *change = (u[i] * beyond + 2.0 / rate * bent) * counts;
                    }
                }
            }
        }
    }

    /// Each channel's factors of all of them, behind its offset and its slope. None if the equations are singular.
    // Not inlined: its normal equations leave the stack when it is done.
    #[inline(never)]
    pub fn baseline(&self, levels: &Levels) -> Option<Baseline> {
        let size = 2 + self.count().min(NUISANCES_MAX);
        let (mut normal, mut right) = (Normal::new(size), [[0.0; CHANNELS_MAX]; UNKNOWNS_MAX]);
        normal.lower[0][0] = levels.frames as f32;
        (normal.lower[1][0], normal.lower[1][1]) = (levels.u, levels.uu);
        (right[0], right[1]) = (levels.y, levels.uy);
        for k in 0..size - 2 {
            let row = &mut normal.lower[2 + k];
            (row[0], row[1]) = (self.one[k], self.u[k]);
            row[2..2 + NUISANCES_MAX].copy_from_slice(&self.each[k]);
            right[2 + k] = self.y[k];
        }
        normal.factor()?;
        normal.forward_rows(&mut right);
        normal.backward_rows(&mut right);
        right.first_chunk().copied()
    }
}
