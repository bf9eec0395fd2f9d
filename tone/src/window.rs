//! What the steps of a fit share: the window's frames, what the first pass found in them, and memory to work in.

use crate::frame_span::FrameSpan;
use crate::levels::Levels;
use crate::moments::Moments;
use crate::nuisance::{Curve, Nuisances};
use crate::solution::Solution;
use crate::source::Overwritten;

/// Sums of the latest pass, and the latest solution from them: too large to be copied.
#[derive(Clone, Debug)]
pub struct Work {
    /// Sums of the latest pass.
    pub sums: Moments,
    /// Solution, whose `nu` is that behind its step.
    pub solution: Solution,
}

impl Work {
    /// Nothing yet. A constant of zeros is written in its place; the result of a function would be copied.
    pub const NONE: Self = Self { sums: Moments::new(), solution: Solution::NONE };
}

/// A window as each step hands it to the next.
pub struct Window<'w> {
    /// The frames.
    pub span: FrameSpan<'w>,
    /// Their levels.
    pub levels: &'w Levels,
    /// Memory to work in.
    pub work: &'w mut Work,
    /// Most harmonics to fit.
    pub harmonics_max: usize,
}

impl Window<'_> {
    /// The interferer's functions, and those of a curve.
    pub fn nuisances(&mut self, curve: Curve) -> Result<Nuisances, Overwritten> {
        Nuisances::new(&mut self.span, self.levels, curve)
    }

    /// Harmonics to fit to a tone of `nu`: those that stay clear of half the frame rate.
    pub fn harmonics(&self, nu: f32) -> usize {
        self.span.harmonics_below_nyquist(nu, self.harmonics_max)
    }
}
