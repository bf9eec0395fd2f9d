//! The likeliest candidates so far.

use crate::refine::Summit;

/// Candidates whose scores are this close are compared by all channels.
pub const CLOSE_SCORE: f32 = 25.0;
/// Candidates nearer than this to the end of another's refinement, cycles per half window, are the
/// same.
pub const SAME_NU: f32 = 0.08;
/// Cycles from which a model whose residuals are noise is not one of a drift.
const CYCLES_PLAIN: f32 = 3.0;
/// Residuals of more than this share of its power may hide more than noise: the noise is not known
/// where what is in the window is fast.
const REMAINDER_PLAIN: f32 = 0.125;

impl Summit {
    /// Whether it leaves nothing but noise.
    pub fn leaves_noise(&self) -> bool {
        self.explains_all && self.remainder < REMAINDER_PLAIN
    }

    /// Whether it leaves nothing but noise, and is none of a drift.
    pub fn is_plain(&self) -> bool {
        self.leaves_noise() && 2.0 * self.nu >= CYCLES_PLAIN
    }

    /// How much likelier it is than another, by score.
    pub fn lead(&self, over: &Self) -> f32 {
        let penalties = self.penalty - over.penalty;
        let frames = self.frames_of_one().min(over.frames_of_one());
        (self.model.score - over.model.score + penalties) / frames - penalties
    }

    /// Residuals far above the noise are no noise. They change little from frame to frame: this
    /// many frames say no more than one. The power is that of a few recordings of a ridged board,
    /// and of no theory.
    fn frames_of_one(&self) -> f32 {
        let ratio = self.noise_ratio.max(1.0);
        libm::sqrtf(ratio * libm::sqrtf(ratio))
    }

    fn is_near(&self, nu: f32) -> bool {
        (self.nu - nu).abs() < SAME_NU
    }
}

/// The likeliest candidates.
#[derive(Default)]
pub struct Found {
    pub best: Option<Summit>,
    /// One that is nearly as likely, at another frequency.
    pub other: Option<Summit>,
    /// Where there are lines that say that a candidate is an overtone.
    pub overtone: Option<f32>,
}

impl Found {
    /// Whether no other model says more than the best one.
    pub fn is_plain(&self) -> bool {
        self.best.as_ref().is_some_and(Summit::is_plain)
    }

    pub fn has(&self, nu: f32) -> bool {
        [&self.best, &self.other]
            .into_iter()
            .flatten()
            .any(|summit| summit.is_near(nu))
    }

    /// The score that a refinement must come to.
    pub fn least_score(&self) -> f32 {
        let least = |best: &Summit| best.model.score - CLOSE_SCORE * best.frames_of_one();
        self.best.as_ref().map_or(f32::NEG_INFINITY, least)
    }

    pub fn add(&mut self, summit: Summit) {
        let is_better = |than: &Option<Summit>| than.is_none_or(|than| summit.lead(&than) > 0.0);
        let is_same = self.best.is_some_and(|best| best.is_near(summit.nu));
        if is_better(&self.best) {
            if !is_same {
                self.other = self.best;
            }
            self.best = Some(summit);
        } else if !is_same && is_better(&self.other) {
            self.other = Some(summit);
        }
        let best = self.best;
        self.other = self
            .other
            .filter(|other| best.is_some_and(|best| other.lead(&best) > -CLOSE_SCORE));
    }
}
