//! From a guess to the maximum of the likelihood, with the baseline and the harmonics that the window needs.

use crate::curvature::{is_bent, is_curved};
use crate::descent::Problem;
use crate::equations::Shape;
use crate::guess::InitialGuess;
use crate::levels::Levels;
use crate::limits::CURVE_FUNCTIONS;
use crate::nuisance::{Curve, Nuisances};
use crate::significance::significant_power;
use crate::solution::Solution;
use crate::source::Overwritten;
use crate::window::Window;

/// Leaves the solution in the window, and returns its nuisances; None if not even one harmonic can be fitted.
pub fn refine(window: &mut Window, guess: InitialGuess) -> Result<Option<Nuisances>, Overwritten> {
    let InitialGuess { nu, slope, curve, harmonics, .. } = guess;
    let nuisances = window.nuisances(curve)?;
    let mut problem = Problem::new(window, &nuisances);
    // Where a window is too short to separate all harmonics, fewer may do.
    let harmonics = if harmonics > 0 { harmonics } else { problem.window.harmonics(nu) };
    let mut shape = Shape { harmonics, slope, nuisances: nuisances.count() };
    while !problem.converge(nu, shape)? {
        if shape.harmonics == 1 {
            return Ok(None);
        }
        shape.harmonics -= 1;
    }
    if curve != Curve::None {
        remove_needless_curve(&mut problem)?;
    } else if slope && guess.harmonics == 0 && is_bent(&mut problem)? {
        let nu = problem.solution().nu;
        return refine(window, InitialGuess { nu, curve: Curve::Bent, ..guess });
    }
    let shape = problem.solution().shape;
    let significant = significant_harmonics(problem.solution(), problem.window.levels);
    if significant < shape.harmonics {
        let (fewer, nu) = (Shape { harmonics: significant, ..shape }, problem.nu);
        // Where the harmonics left out described something else, such as a tone's end, the maximum may be far away.
        let found = problem.step(fewer).is_some()
            && (problem.has_converged() || problem.converge(problem.solution().nu, fewer)?);
        if !found {
            problem.converge(nu, shape)?;
        }
    }
    Ok(Some(nuisances))
}

/// A search by means also takes for a curve what its few harmonics do not describe of a clear tone; all harmonics of all
/// frames decide.
fn remove_needless_curve(problem: &mut Problem) -> Result<(), Overwritten> {
    let (shape, nu) = (problem.solution().shape, problem.solution().nu);
    let straight = Shape { nuisances: shape.nuisances - CURVE_FUNCTIONS, ..shape };
    if problem.step(straight).is_some() && !is_curved(problem) {
        problem.converge(nu, straight)?;
    } else {
        problem.step(shape);
    }
    Ok(())
}

/// Harmonics up to the last whose power is significant.
fn significant_harmonics(best: &Solution, levels: &Levels) -> usize {
    let (mut harmonics, least) = (1, significant_power(levels, best.shape.unknowns()));
    for (h, power) in best.power.iter().enumerate().take(best.shape.harmonics) {
        if *power > least {
            harmonics = h + 1;
        }
    }
    harmonics
}
