//! Whether the baseline of the channels is curved.

use crate::descent::Problem;
use crate::equations::{Shape, residual_sums_without_solution};
use crate::frame_span::BLOCK;
use crate::likelihood::gain;
use crate::limits::CURVE_FUNCTIONS;
use crate::nuisance::Curve;
use crate::significance::significant_gain;
use crate::solution::Solution;
use crate::source::Overwritten;
use crate::window::Window;

/// Frames from which steps from block to block, a dozen, show a bend.
const FRAMES_FOR_STEPS: u32 = 12 * BLOCK as u32;
/// Normal deviate from which a baseline counts as curved: a needless curve costs little.
const CURVE_DEVIATE: f32 = 3.0;

/// Whether the residuals of a converged solution without a curve have one: by steps from block to block where there are
/// many of them, else by another pass.
pub fn is_bent(problem: &mut Problem) -> Result<bool, Overwritten> {
    let Problem { window, nuisances, .. } = problem;
    let Window { span, levels, work, .. } = &**window;
    let (shape, nu) = (work.solution.shape, work.solution.nu);
    if span.is_in_time() && span.frames >= FRAMES_FOR_STEPS {
        let straight = &work.solution.residual_sum_of_squares;
        let bent = residual_sums_without_solution(&work.sums, levels, nuisances, &shape, true);
        let gained = bent.map_or(0.0, |bent| gain(levels, straight, &bent, shape.unknowns() + CURVE_FUNCTIONS));
        return Ok(gained > significant_gain(levels, CURVE_FUNCTIONS, CURVE_DEVIATE));
    }
    let nuisances = window.nuisances(Curve::Bent)?;
    let mut bent = Problem::new(window, &nuisances);
    bent.pass(nu, shape.harmonics)?;
    Ok(bent.step(shape).is_some() && is_curved(&bent))
}

/// Whether a curve in addition removes more of the latest solution's residuals than of noise. Both are compared where
/// their steps lead.
#[inline(never)]
pub fn is_curved(problem: &Problem) -> bool {
    let Problem { window, nuisances, nu } = problem;
    let Window { levels, work, .. } = &**window;
    let (straight, mut curved) = (&work.solution, Solution::NONE);
    let shape = Shape { nuisances: nuisances.count(), ..straight.shape };
    if curved.solve(&work.sums, levels, nuisances, *nu, shape).is_none() {
        return false;
    }
    let of_step = |solution: &Solution| 0.5 * solution.step * solution.step * solution.information;
    let gained = gain(levels, &straight.residual_sum_of_squares, &curved.residual_sum_of_squares, shape.unknowns());
    gained + of_step(&curved) - of_step(straight) > significant_gain(levels, CURVE_FUNCTIONS, CURVE_DEVIATE)
}
