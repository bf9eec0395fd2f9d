//! The last pass: residuals and the Gauss-Newton step from the frames themselves.
//!
//! The blocks take a wave's place for that of its block: that is as good as the frames but for a
//! small share of the information. And the difference of two sums of squares loses a small residual
//! in rounding.

use crate::abscissa::Abscissa;
use crate::found::SAME_NU;
use crate::frame_span::{BLOCK, FrameSpan};
use crate::limits::CHANNELS_MAX;
use crate::solve::Solution;
use crate::source::{Overwritten, Values};
use crate::statistics::{Channels, Statistics};
use crate::waves::Waves;
use core::f32::consts::PI;

/// Where so much of a path's range is gone back, lateness is left where it is, in the residuals: it
/// moves the ways there and back apart by more than a first-order step describes.
const TURNED_SHARE: f32 = 0.1;

/// Takes the step that the frames ask for from `nu`, at which the solution's unknowns are, and
/// replaces its residuals.
#[inline(never)]
pub fn polish(
    span: &mut FrameSpan,
    statistics: &Statistics,
    channels: &Channels,
    least: &Values,
    (nu, interferer): (f32, Option<f32>),
    solution: &mut Solution,
) -> Result<(), Overwritten> {
    let (mut squares, mut scores) = ([0.0; CHANNELS_MAX], [0.0; CHANNELS_MAX]);
    let (abscissa, frames) = (span.abscissa(), span.frames);
    // `u` from one frame to the next, the mean of all.
    let (later, mean) = match (span.later, abscissa) {
        (Some(later), Abscissa::Path { place, half, .. }) if !abscissa.turns(TURNED_SHARE) => {
            let last = frames.saturating_sub(1);
            (Some(later), (place(last) - place(0)) / (half * last as f32))
        }
        _ => (None, 0.0),
    };
    let mut before = 0.0;
    let mut waves = Waves::new(span, statistics, solution, (nu, interferer));
    span.blocks(&statistics.offset, &mut |block| {
        waves.go(abscissa.block(block.first, frames));
        // The angle by which a whole frame's lateness moves the fundamental, where the path is not
        // at its mean speed.
        let mut faster = [0.0; BLOCK];
        if block.first == 0 {
            before = waves.u[0] - mean;
        }
        for (faster, u) in faster.iter_mut().zip(&waves.u) {
            *faster = 2.0 * PI * nu * (u - before - mean);
            before = *u;
        }
        let there = block.valid.map(|valid| (valid != 0) as u8 as f32);
        for ((k, c), (squares, scores)) in channels
            .list()
            .iter()
            .enumerate()
            .zip(squares.iter_mut().zip(&mut scores))
        {
            let (residuals, derivatives) = (
                waves.residuals(block.values, *c as usize, k),
                waves.derivatives(k),
            );
            let later = later.map_or(0.0, |later| later[*c as usize % CHANNELS_MAX]);
            let (mut square, mut score) = (0.0, 0.0);
            for i in 0..BLOCK {
                let residual = there[i] * (residuals[i] - later * faster[i] * derivatives[i]);
                square += residual * residual;
                score += residual * (derivatives[i] * waves.u[i]);
            }
            (*squares, *scores) = (*squares + square, *scores + score);
        }
    })?;
    let freedom = (solution.frames - solution.shape.unknowns() as f32).max(1.0);
    let (mut score, mut before, mut after) = (0.0, 0.0, 0.0);
    let (cos, sin) = solution.harmonic(0);
    let (cos, sin) = (*cos, *sin);
    for k in 0..solution.width.min(CHANNELS_MAX) {
        let square: f32 = squares[k];
        let residual = square.max(least[k]);
        if !(residual > 0.0) || !(solution.weights[k] > 0.0) {
            continue;
        }
        let power = cos[k] * cos[k] + sin[k] * sin[k];
        before += power * solution.weights[k];
        (solution.residual_squares[k], solution.weights[k]) = (residual, freedom / residual);
        after += power * solution.weights[k];
        score += 2.0 * PI * solution.weights[k] * scores[k];
    }
    if before > 0.0 && after > 0.0 {
        solution.information *= after / before;
        let step = score / solution.information;
        // A longer one leads to another line, as from half a cycle of a drift to two: the
        // refinement's end stands.
        if step * step < (SAME_NU * SAME_NU).max(1.0 / solution.information) {
            (solution.step, solution.nu) = (step, nu + step);
        }
    }
    Ok(())
}
