//! Candidates for the content of a window, and how much likelier one is than another.

use crate::equations::Shape;
use crate::levels::Levels;
use crate::likelihood::gain;
use crate::nuisance::Curve;
use crate::significance::ln;
use crate::source::Values;

/// A tone with its baseline, or a baseline alone.
#[derive(Clone, Copy, Debug)]
pub struct Model {
    /// Cycles per half span ([`crate::abscissa`]); 0 if there is no tone.
    pub nu: f32,
    /// Curve of the baseline.
    pub curve: Curve,
    /// What is fitted to each channel; no harmonics if there is no tone.
    pub shape: Shape,
    /// Residual sums of squares.
    pub residual_sum_of_squares: Values,
    /// Whether `nu` is at the maximum of its likelihood.
    pub refined: bool,
}

impl Model {
    /// Log-likelihood by which `other` is likelier than this one, less a penalty for each unknown (Schwarz's criterion).
    #[inline(never)]
    pub fn log_odds(&self, levels: &Levels, other: &Self) -> f32 {
        let (own, others) = (self.shape.unknowns(), other.shape.unknowns());
        let penalty = 0.5 * ln(levels.frames as f32) * (others as f32 - own as f32) * levels.channels();
        gain(levels, &self.residual_sum_of_squares, &other.residual_sum_of_squares, own.max(others)) - penalty
    }

    /// Replaces the model in `place` if `model` is likelier.
    #[inline(never)]
    pub fn replace_if_better(place: &mut Option<Self>, levels: &Levels, model: &Self) {
        if place.as_ref().is_none_or(|place| place.log_odds(levels, model) > 0.0) {
            *place = Some(*model);
        }
    }
}
