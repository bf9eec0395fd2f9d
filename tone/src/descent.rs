//! Gauss-Newton in the frequency: from a guess to the maximum of the likelihood.

use crate::frame_span::FrameSpan;
use crate::levels::Levels;
use crate::moments::Moments;
use crate::nuisance::Nuisances;
use crate::solve::{Shape, Solution, is_misfit, over_noise};
use core::f32::consts::PI;

/// Cycles in the window below which there is too little of a wave to tell its frequency
/// (a periodogram is off by more than 1 Hz there; the bound itself still holds at 0.73 cycles).
pub const CYCLES_MIN: f32 = 0.6;
/// Cycles in the window from which a slope can be told from the wave and is always fitted too.
pub const CYCLES_FOR_SLOPE: f32 = 2.0;
/// Gauss-Newton steps at the most; two do from a guess of the search.
const STEPS_MAX: usize = 16;
/// An error of the last step this small against the uncertainty is none.
const STEP_DONE: f32 = 0.05;
/// The same of a guess, in standard deviations: the fit goes on from there.
pub const LINE_CLOSE: f32 = 2.0;
/// Steps of the highest harmonic, in cycles per half window, from which on two of them tell how the likelihood bends.
const CREEP_MAX: f32 = 0.03;
/// Half a bin of a periodogram: further away the slope of the likelihood misleads.
const STEP_MAX: f32 = 0.25;

/// A stretch and all that is known of it but its tone.
pub struct Problem<'p, 'a> {
    /// The frames.
    pub span: &'p mut FrameSpan<'a>,
    /// Their levels.
    pub levels: &'p Levels,
    /// What else the channels hold.
    pub nuisances: &'p Nuisances,
    /// Sums and solution of the latest pass.
    pub work: &'p mut Work,
    /// Frequency of that pass.
    pub nu: f32,
}

/// What a pass gives, and the solution from it: too large to be handed around.
#[derive(Clone, Debug, Default)]
pub struct Work {
    /// Sums of the latest pass.
    pub sums: Moments,
    /// Solution, which has taken its step.
    pub solution: Solution,
}

impl Work {
    /// Nothing yet. A constant of zeros: in its place that is emptied, where what a function makes would be copied.
    pub const NONE: Self = Self { sums: Moments::new(), solution: Solution::NONE };
}

impl<'p, 'a> Problem<'p, 'a> {
    /// A problem of which no sums are known yet; they will be kept in `work`.
    pub fn new(span: &'p mut FrameSpan<'a>, levels: &'p Levels, nuisances: &'p Nuisances, work: &'p mut Work) -> Self {
        Self { span, levels, nuisances, work, nu: 0.0 }
    }

    /// One pass at `nu`. None if the frames were overwritten.
    pub fn pass(&mut self, nu: f32, harmonics: usize) -> Option<()> {
        self.nu = nu;
        self.work.sums.collect(self.span, self.levels, self.nuisances, nu, harmonics)
    }

    /// The latest solution.
    pub fn solution(&self) -> &Solution {
        &self.work.solution
    }

    /// Solves for `shape` with the sums of the latest pass and takes its step. None if the unknowns cannot be
    /// told apart.
    pub fn step(&mut self, shape: Shape) -> Option<()> {
        let Work { sums, solution } = &mut *self.work;
        solution.solve(sums, self.levels, self.nuisances, self.nu, shape)?;
        solution.nu = stepped(self.nu, solution.step, self.span.nu_most());
        Some(())
    }

    /// Gauss-Newton from `nu`, at most `steps` of them, until the error left is `close` standard deviations. False
    /// if the unknowns cannot be told apart. None if the frames were overwritten.
    #[inline(never)]
    pub fn descend(&mut self, nu: f32, shape: Shape, steps: usize, close: f32) -> Option<bool> {
        let (mut nu, mut before) = (nu, None);
        for left in (0..steps.clamp(1, STEPS_MAX)).rev() {
            self.pass(nu, shape.harmonics)?;
            if self.step(shape).is_none() {
                return Some(false);
            }
            let arrived = match close <= STEP_DONE && self.is_misfit() {
                true => self.creep(nu, close, &mut before),
                false => self.arrives(nu, close),
            };
            if left == 0 || arrived {
                break;
            }
            nu = self.solution().nu;
        }
        Some(true)
    }

    /// What the latest solution leaves over the channels' noise ([`over_noise`]), where its step leads.
    pub fn over_noise(&self) -> Option<f32> {
        let solution = self.solution();
        let unknowns = solution.shape.unknowns();
        let samples = self.levels.channels() * (self.levels.frames as f32 - unknowns as f32).max(1.0);
        let ahead = solution.step * solution.step * solution.information / samples;
        over_noise(self.levels, &solution.residual_sum_of_squares, unknowns).map(|over| over * (1.0 - ahead.min(1.0)))
    }

    /// Whether that is more than noise.
    fn is_misfit(&self) -> bool {
        is_misfit(self.over_noise())
    }

    /// Where the model is wrong a Gauss-Newton step is but a part of the way, down to a fiftieth of it: the
    /// likelihood bends less than the model would have it. How much less is known from two steps (a secant); that
    /// leads on, and is the information there really is. Whether it has arrived.
    fn creep(&mut self, nu: f32, close: f32, before: &mut Option<(f32, f32)>) -> bool {
        let most = self.span.nu_most();
        let solution = &mut self.work.solution;
        let step = solution.nu - nu;
        // Far from the maximum the likelihood is no parabola.
        if step.abs() * solution.shape.harmonics as f32 > CREEP_MAX {
            *before = None;
            return false;
        }
        let bend = before.replace((nu, step)).map(|(nu_before, step_before)| (step_before - step) / (nu - nu_before));
        let Some(bend) = bend.filter(|bend| *bend > 0.02 && *bend < 2.0) else { return step.abs() < 1e-6 * nu };
        let way = (step / bend).clamp(-STEP_MAX, STEP_MAX);
        solution.nu = stepped(nu, way, most);
        let arrived = way.abs() <= close / libm::sqrtf(solution.information) || way.abs() < 1e-6 * nu;
        if arrived {
            solution.information *= bend.min(1.0);
        }
        arrived
    }

    /// All the steps it takes.
    pub fn converge(&mut self, nu: f32, shape: Shape) -> Option<bool> {
        self.descend(nu, shape, STEPS_MAX, STEP_DONE)
    }

    /// Whether the latest step, of a pass that was made for another shape perhaps, leads to the maximum.
    pub fn has_arrived(&self) -> bool {
        !self.is_misfit() && self.arrives(self.nu, STEP_DONE)
    }

    /// Whether the step from `nu` leads to the maximum, so that nothing has to be solved again there.
    fn arrives(&self, nu: f32, close: f32) -> bool {
        let solution = self.solution();
        let step = (solution.nu - nu).abs();
        let done = close / libm::sqrtf(solution.information);
        // A step turns the ends of the window by `angle`; what a Gauss-Newton step is wrong by goes
        // with its cube (the waves' third-order terms).
        let angle = 2.0 * PI * solution.shape.harmonics as f32 * step;
        // Below two cycles the waves lean on offset and slope too, and as close to half the frame rate on their own
        // images: a step errs by more than that.
        let highest = solution.shape.harmonics as f32 * nu;
        if 2.0 * nu < CYCLES_FOR_SLOPE || 2.0 * (self.span.nu_most() - highest) < CYCLES_FOR_SLOPE {
            return step <= done || step < 1e-6 * nu;
        }
        // The weights follow the residuals: that moves the maximum by a step's share in the degrees of freedom.
        let freedom = self.levels.frames as f32 - solution.shape.unknowns() as f32;
        (0.1 * angle * angle * step <= done && 2.5 * step <= done * (freedom - 8.0)) || step < 1e-6 * nu
    }
}

/// Where a step from `nu` ends: below a quarter of a cycle per window there is nothing, and nothing above `most`.
fn stepped(nu: f32, step: f32, most: f32) -> f32 {
    // Not `clamp`: its assertion would bring all of float formatting into the image.
    (nu + step.clamp(-STEP_MAX, STEP_MAX)).min(most).max(0.15)
}
