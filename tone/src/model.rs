//! What a window may hold, and how much likelier one is than another.

use crate::levels::Levels;
use crate::nuisance::Curve;
use crate::significance::ln;
use crate::solve::{Shape, Solution, gain};
use crate::source::Values;

/// A step takes no more than this share of the squares: 60 dB.
const ALL_BUT: f32 = 1.0 - 1e-6;

/// A tone with its baseline, or a baseline alone.
#[derive(Clone, Copy, Debug)]
pub struct Model {
    /// Cycles per half window ([`crate::frame_span`]); 0 if there is no tone.
    pub nu: f32,
    /// Curve of the baseline.
    pub curve: Curve,
    /// What each channel holds; no harmonics if there is no tone.
    pub shape: Shape,
    /// Residual sums of squares.
    pub residual_sum_of_squares: Values,
    /// Whether `nu` is where its likelihood is highest.
    pub refined: bool,
}

impl Model {
    /// Log-likelihood by which `other` is likelier than this one, where each unknown has to pay for itself (Schwarz's
    /// criterion).
    #[inline(never)]
    pub fn odds(&self, levels: &Levels, other: &Self) -> f32 {
        let (own, others) = (self.shape.unknowns(), other.shape.unknowns());
        let paid = 0.5 * ln(levels.frames as f32) * (others as f32 - own as f32) * levels.channels();
        gain(levels, &self.residual_sum_of_squares, &other.residual_sum_of_squares, own.max(others)) - paid
    }

    /// Puts it in its place if it is likelier than what is there.
    #[inline(never)]
    pub fn keep(place: &mut Option<Self>, levels: &Levels, model: &Self) {
        if place.as_ref().is_none_or(|place| place.odds(levels, model) > 0.0) {
            *place = Some(*model);
        }
    }
}

/// Log-likelihood that a solution's step promises: what it takes off the squares, and not measured by the noise as it
/// seems before.
#[inline(never)]
pub fn expected_gain(levels: &Levels, solution: &Solution) -> f32 {
    let samples = levels.frames as f32 * levels.channels();
    let taken = solution.step * solution.step * solution.information / samples;
    -0.5 * samples * ln(1.0 - taken.min(ALL_BUT))
}
