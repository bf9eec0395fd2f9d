//! Whether the strongest line is the fundamental, or the second or third harmonic of one: an octave error is the worst
//! answer.

use crate::descent::{CYCLES_FOR_SLOPE, GUESS_SIGMAS, Problem};
use crate::equations::Shape;
use crate::guess::{InitialGuess, SpectralLine};
use crate::likelihood::gain;
use crate::limits::HARMONICS_MAX;
use crate::nuisance::Curve;
use crate::significance::{ONE_IN_A_THOUSAND, significant_gain, significant_power};
use crate::solution::Solution;
use crate::source::Overwritten;

/// Share of the tone's power that the lines in between must have for a tone an octave (or a twelfth) below the strongest
/// line.
const SUBHARMONIC_POWER_SHARE: f32 = 0.1;
/// Share from which such lines leave it open which of the two it is.
pub const AMBIGUOUS_POWER_SHARE: f32 = 0.04;
/// Largest offset of a line from its harmonic's place, cycles per window: real harmonic series in recordings keep to 0.01,
/// the skirts of drifts and of other lines are off by 0.1 and more.
const LINE_OFFSET_MAX: f32 = 0.06;

/// Where to start: at the strongest line, or at the fundamental that it belongs to.
pub fn fundamental(problem: &mut Problem, line: &SpectralLine, nuisances: usize) -> Result<InitialGuess, Overwritten> {
    let mut guess = InitialGuess::at(line);
    let mut highest = AMBIGUOUS_POWER_SHARE;
    for (part, _) in [2usize, 3].into_iter().zip(line.suspects).filter(|(_, suspect)| *suspect) {
        let nu = line.nu / part as f32;
        let harmonics = problem.window.span.harmonics_below_nyquist(nu, (part + 2).min(HARMONICS_MAX));
        if 2.0 * nu < 1.0 || harmonics < part {
            continue;
        }
        let slope = 2.0 * nu >= CYCLES_FOR_SLOPE || line.curve != Curve::None;
        let shape = Shape { harmonics, slope, nuisances };
        // One step excludes most of them.
        if !problem.descend(nu, shape, 1, GUESS_SIGMAS)?
            || share_between(problem.solution(), part) < 0.5 * highest
            || !problem.converge(problem.solution().nu, shape)?
        {
            continue;
        }
        let series = problem.solution();
        if (series.nu - nu).abs() > 0.25 {
            continue;
        }
        let (share, nu) = (share_between(series, part), series.nu);
        if share > highest
            && has_own_lines(series, part, significant_power(problem.window.levels, series.shape.unknowns()))
            && better_than_overtones(problem, line)?
        {
            (highest, guess.below) = (share, nu);
            guess.ambiguous = share <= SUBHARMONIC_POWER_SHARE;
            if !guess.ambiguous {
                (guess.nu, guess.slope) = (nu, slope);
            }
        }
    }
    Ok(guess)
}

/// Whether the latest solution, a harmonic series below the strongest line, explains the window clearly better than that
/// line with overtones of its own. Across a gap in the window the lines of a series can be large and cancel each other,
/// and they explain what those overtones do not.
fn better_than_overtones(problem: &mut Problem, line: &SpectralLine) -> Result<bool, Overwritten> {
    let (shape, residual_sum_of_squares) = (problem.solution().shape, problem.solution().residual_sum_of_squares);
    let harmonics = problem.window.span.harmonics_below_nyquist(line.nu, shape.harmonics);
    if !problem.converge(line.nu, Shape { harmonics, slope: line.slope, ..shape })? {
        return Ok(true);
    }
    let (levels, more) = (problem.window.levels, 2 * (shape.harmonics - harmonics).max(1));
    let before = &problem.solution().residual_sum_of_squares;
    let gained = gain(levels, before, &residual_sum_of_squares, shape.unknowns());
    Ok(gained > significant_gain(levels, more, ONE_IN_A_THOUSAND))
}

/// Share of the power in harmonics that are no multiple of `part`.
#[inline(never)]
fn share_between(series: &Solution, part: usize) -> f32 {
    let (mut between, mut all) = (0.0, 0.0);
    for (h, power) in series.power.iter().enumerate().take(series.shape.harmonics) {
        all += power;
        if !(h + 1).is_multiple_of(part) {
            between += power;
        }
    }
    if all > 0.0 { between / all } else { 0.0 }
}

/// Whether the lines of a series below its strongest one, the `part`-th, are lines of their own: each has more than the
/// noise's power, and the first is at its place, so that it is not the skirt of a drift or of another line.
fn has_own_lines(series: &Solution, part: usize, noise_power: f32) -> bool {
    let offset = series.offset[0].abs();
    // Offsets are in `nu`, half of what they are in cycles per window.
    let at_its_place = offset <= (0.5 * LINE_OFFSET_MAX).max(3.0 * series.offset_sigma[0]).min(0.25);
    at_its_place && series.power.iter().take(part - 1).all(|power| *power > noise_power)
}
