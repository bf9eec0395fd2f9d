//! Gauss-Newton steps in the frequency: from a guess to the maximum of the likelihood.

use crate::equations::Shape;
use crate::likelihood::{is_misfit, noise_ratio};
use crate::nuisance::Nuisances;
use crate::solution::Solution;
use crate::source::Overwritten;
use crate::window::{Window, Work};
use core::f32::consts::PI;

/// Cycles in the window below which its frequency cannot be estimated (a periodogram is off by more than 1 Hz there; the
/// bound itself still holds at 0.73 cycles).
pub const CYCLES_MIN: f32 = 0.6;
/// Cycles in the window from which a slope can be separated from the wave and is always fitted too.
pub const CYCLES_FOR_SLOPE: f32 = 2.0;
/// Most Gauss-Newton steps; from a guess of the search two are enough.
const STEPS_MAX: usize = 16;
/// Error of the last step from which on the descent has converged, standard deviations.
const CONVERGED_SIGMAS: f32 = 0.05;
/// The same of a guess, which the fit refines.
pub const GUESS_SIGMAS: f32 = 2.0;
/// Longest step of the highest harmonic, in cycles per half window, from which a secant follows.
const SECANT_STEP_MAX: f32 = 0.03;
/// Longest step in `nu`, half a bin of a periodogram: further away the slope of the likelihood misleads.
const STEP_MAX: f32 = 0.25;
/// Smallest change of `nu` that f32 resolves well, as a share of it.
const STEP_SHARE_MIN: f32 = 1e-6;

/// A window whose content is known but for its tone.
pub struct Problem<'p, 'w> {
    /// The window; its work has sums and solution of the latest pass.
    pub window: &'p mut Window<'w>,
    /// Other components of the channels.
    pub nuisances: &'p Nuisances,
    /// Frequency of the latest pass.
    pub nu: f32,
}

impl<'p, 'w> Problem<'p, 'w> {
    /// A problem before its first pass.
    pub fn new(window: &'p mut Window<'w>, nuisances: &'p Nuisances) -> Self {
        Self { window, nuisances, nu: 0.0 }
    }

    /// One pass at `nu`.
    pub fn pass(&mut self, nu: f32, harmonics: usize) -> Result<(), Overwritten> {
        self.nu = nu;
        let Window { span, levels, work, .. } = &mut *self.window;
        work.sums.collect(span, levels, self.nuisances, nu, harmonics)
    }

    /// The latest solution.
    pub fn solution(&self) -> &Solution {
        &self.window.work.solution
    }

    /// Solves for `shape` with the sums of the latest pass, and takes the step. None if the equations are singular.
    pub fn step(&mut self, shape: Shape) -> Option<()> {
        let Work { sums, solution } = &mut *self.window.work;
        solution.solve(sums, self.window.levels, self.nuisances, self.nu, shape)?;
        solution.nu = stepped(self.nu, solution.step, self.window.span.nu_max());
        Some(())
    }

    /// Gauss-Newton from `nu`, at most `steps` of them, until the remaining error is within `sigmas` standard deviations.
    /// False if the equations are singular.
    #[inline(never)]
    pub fn descend(&mut self, nu: f32, shape: Shape, steps: usize, sigmas: f32) -> Result<bool, Overwritten> {
        let (mut nu, mut before) = (nu, None);
        for remaining in (0..steps.clamp(1, STEPS_MAX)).rev() {
            self.pass(nu, shape.harmonics)?;
            if self.step(shape).is_none() {
                return Ok(false);
            }
            let converged = match sigmas <= CONVERGED_SIGMAS && is_misfit(self.noise_ratio()) {
                true => self.secant_step(nu, sigmas, &mut before),
                false => self.converges(nu, sigmas),
            };
            if remaining == 0 || converged {
                break;
            }
            nu = self.solution().nu;
        }
        Ok(true)
    }

    /// Residuals of the latest solution over the noise ([`noise_ratio`]), where its step leads.
    pub fn noise_ratio(&self) -> Option<f32> {
        let (solution, levels) = (self.solution(), self.window.levels);
        let unknowns = solution.shape.unknowns();
        let samples = levels.channels() * (levels.frames as f32 - unknowns as f32).max(1.0);
        let removed = solution.step * solution.step * solution.information / samples;
        let ratio = noise_ratio(levels, &solution.residual_sum_of_squares, unknowns);
        ratio.map(|ratio| ratio * (1.0 - removed.min(1.0)))
    }

    /// Where the model is wrong, a Gauss-Newton step is too short, down to a fiftieth of what it should be: the likelihood
    /// curves less than the model's. Two steps give its curvature (a secant), which gives the next step and the real
    /// information. Returns whether the descent has converged.
    fn secant_step(&mut self, nu: f32, sigmas: f32, before: &mut Option<(f32, f32)>) -> bool {
        let most = self.window.span.nu_max();
        let solution = &mut self.window.work.solution;
        let step = solution.nu - nu;
        // Far from the maximum the likelihood is no parabola.
        if step.abs() * solution.shape.harmonics as f32 > SECANT_STEP_MAX {
            *before = None;
            return false;
        }
        let curvature = before.replace((nu, step)).map(|(nu_before, before)| (before - step) / (nu - nu_before));
        let Some(curvature) = curvature.filter(|curvature| *curvature > 0.02 && *curvature < 2.0) else {
            return step.abs() < STEP_SHARE_MIN * nu;
        };
        let step = (step / curvature).clamp(-STEP_MAX, STEP_MAX);
        solution.nu = stepped(nu, step, most);
        let converged = step.abs() <= sigmas / libm::sqrtf(solution.information) || step.abs() < STEP_SHARE_MIN * nu;
        if converged {
            solution.information *= curvature.min(1.0);
        }
        converged
    }

    /// As many steps as it takes.
    pub fn converge(&mut self, nu: f32, shape: Shape) -> Result<bool, Overwritten> {
        self.descend(nu, shape, STEPS_MAX, CONVERGED_SIGMAS)
    }

    /// Whether the latest step leads to the maximum; its pass may have been made for another shape.
    pub fn has_converged(&self) -> bool {
        !is_misfit(self.noise_ratio()) && self.converges(self.nu, CONVERGED_SIGMAS)
    }

    /// Whether the step from `nu` leads to the maximum, so that no further pass is needed there.
    fn converges(&self, nu: f32, sigmas: f32) -> bool {
        let solution = self.solution();
        let step = (solution.nu - nu).abs();
        let tolerance = sigmas / libm::sqrtf(solution.information);
        // A step turns the ends of the window by `angle`; the error of a Gauss-Newton step grows with its cube (the waves'
        // third-order terms).
        let angle = 2.0 * PI * solution.shape.harmonics as f32 * step;
        // Below two cycles the waves correlate with offset and slope too, and as close to half the frame rate with their
        // own images: a step errs by more than that.
        let highest = solution.shape.harmonics as f32 * nu;
        let is_tiny = step < STEP_SHARE_MIN * nu;
        if 2.0 * nu < CYCLES_FOR_SLOPE || 2.0 * (self.window.span.nu_max() - highest) < CYCLES_FOR_SLOPE {
            return step <= tolerance || is_tiny;
        }
        // The weights follow the residuals: that moves the maximum by a step's share in the degrees of freedom.
        let freedom = self.window.levels.frames as f32 - solution.shape.unknowns() as f32;
        (0.1 * angle * angle * step <= tolerance && 2.5 * step <= tolerance * (freedom - 8.0)) || is_tiny
    }
}

/// The end of a step from `nu`: at least 0.3 cycles in the window, at most `most`.
fn stepped(nu: f32, step: f32, most: f32) -> f32 {
    // Not `clamp`: its assertion would bring all of float formatting into the image.
    (nu + step.clamp(-STEP_MAX, STEP_MAX)).min(most).max(0.15)
}
