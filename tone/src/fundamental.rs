//! Whether the strongest line is the fundamental, or the second or third harmonic of one: an octave error is
//! the worst answer.

use crate::descent::{CYCLES_FOR_SLOPE, LINE_CLOSE, Problem};
use crate::frame_span::FrameSpan;
use crate::moments::HARMONICS_MAX;
use crate::nuisance::Curve;
use crate::search::{SpectralLine, Start};
use crate::significance::{ONE_IN_A_THOUSAND, significant_gain, significant_power};
use crate::solve::{Shape, Solution, gain};

/// Share of the tone's power that the lines in between must have for a tone an octave (or a
/// twelfth) below the strongest line.
pub(crate) const SUBHARMONIC_SHARE: f32 = 0.1;
/// Share from which such lines leave it open which of the two it is.
pub(crate) const AMBIGUOUS_SHARE: f32 = 0.04;
/// A harmonic is a line where the fundamental says it is, within this many cycles per window: real
/// combs in recordings keep to 0.01, the skirts of drifts and of other lines are off by 0.1 and more.
const LINE_OFFSET_MAX: f32 = 0.06;

/// As many of `harmonics` as stay clear of half the frame rate.
// Called from many places: one copy is enough.
#[inline(never)]
pub fn harmonics_below_nyquist(span: &FrameSpan, nu: f32, harmonics: usize) -> usize {
    let mut below = 1;
    while below < harmonics && (below + 1) as f32 * nu < 0.96 * span.nu_most() {
        below += 1;
    }
    below
}

/// Where to start: at the strongest line, or at the fundamental that it belongs to. None if frames were
/// overwritten.
pub fn fundamental(problem: &mut Problem, line: &SpectralLine, nuisances: usize) -> Option<Start> {
    let mut start = Start::at(line);
    let mut highest = AMBIGUOUS_SHARE;
    for (part, _) in [2usize, 3].into_iter().zip(line.suspects).filter(|(_, suspect)| *suspect) {
        let nu = line.nu / part as f32;
        let harmonics = harmonics_below_nyquist(problem.span, nu, (part + 2).min(HARMONICS_MAX));
        if 2.0 * nu < 1.0 || harmonics < part {
            continue;
        }
        let slope = 2.0 * nu >= CYCLES_FOR_SLOPE || line.curve != Curve::None;
        let shape = Shape { harmonics, slope, nuisances };
        // Most are seen not to be one at first sight.
        if !problem.descend(nu, shape, 1, LINE_CLOSE)?
            || share_between(problem.solution(), part) < 0.5 * highest
            || !problem.converge(problem.solution().nu, shape)?
        {
            continue;
        }
        let comb = problem.solution();
        if (comb.nu - nu).abs() > 0.25 {
            continue;
        }
        let (share, nu) = (share_between(comb, part), comb.nu);
        if share > highest
            && lines_hold(comb, part, significant_power(problem.levels, comb.shape.unknowns()))
            && better_than_overtones(problem, line)?
        {
            (highest, start.below) = (share, nu);
            start.ambiguous = share <= SUBHARMONIC_SHARE;
            if !start.ambiguous {
                (start.nu, start.slope) = (nu, slope);
            }
        }
    }
    Some(start)
}

/// Whether a comb, the latest solution, explains the window clearly better than the strongest line with
/// overtones of its own: across a gap in the window the lines of a comb can be large and cancel each other,
/// and they take up what those overtones leave.
fn better_than_overtones(problem: &mut Problem, line: &SpectralLine) -> Option<bool> {
    let (shape, residual_sum_of_squares) = (problem.solution().shape, problem.solution().residual_sum_of_squares);
    let harmonics = harmonics_below_nyquist(problem.span, line.nu, shape.harmonics);
    if !problem.converge(line.nu, Shape { harmonics, slope: line.slope, ..shape })? {
        return Some(true);
    }
    let more = 2 * (shape.harmonics - harmonics).max(1);
    let gained =
        gain(problem.levels, &problem.solution().residual_sum_of_squares, &residual_sum_of_squares, shape.unknowns());
    Some(gained > significant_gain(problem.levels, more, ONE_IN_A_THOUSAND))
}

/// Share of the power in harmonics that are no multiple of `part`.
#[inline(never)]
fn share_between(comb: &Solution, part: usize) -> f32 {
    let (mut between, mut all) = (0.0, 0.0);
    for (h, power) in comb.power.iter().enumerate().take(comb.shape.harmonics) {
        all += power;
        if !(h + 1).is_multiple_of(part) {
            between += power;
        }
    }
    if all > 0.0 { between / all } else { 0.0 }
}

/// Whether the lines of a comb below its strongest one, the `part`-th, are lines of their own: each
/// stands out of the noise, and the first is at its place, so that it is not the skirt of a drift or
/// of another line.
fn lines_hold(comb: &Solution, part: usize, by_chance: f32) -> bool {
    let off = comb.offset[0].abs();
    // Offsets are in `nu`, half of what they are in cycles per window.
    let at_its_place = off <= (0.5 * LINE_OFFSET_MAX).max(3.0 * comb.offset_sigma[0]).min(0.25);
    at_its_place && comb.power.iter().take(part - 1).all(|power| *power > by_chance)
}
