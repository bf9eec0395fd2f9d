//! Whether a converged solution is a tone, and with what uncertainty.

use crate::descent::CYCLES_MIN;
use crate::equations::{Shape, quantization_squares, residual_sums_without_solution};
use crate::fit::{ChannelFit, Fit, Status};
use crate::guess::InitialGuess;
use crate::levels::Levels;
use crate::likelihood::{gain, is_misfit, noise_ratio};
use crate::limits::{CHANNELS_MAX, HARMONICS_MAX};
use crate::nuisance::Nuisances;
use crate::residuals::residual_sums_of_squares;
use crate::significance::significant_search_gain;
use crate::solution::Solution;
use crate::source::{Overwritten, Values};
use crate::window::Window;

/// Share of a channel's sum of squares below which its residuals are taken sample by sample.
const CANCELLED_SHARE: f32 = 1e-4;
/// Relative uncertainty above which a window is too short for a frequency.
const RELATIVE_SIGMA_MAX: f32 = 0.1;
/// Error of a frequency by f32, as a share of it: of its own last digit, and of the sums', below the noise's at signal to
/// noise ratios up to about 60 dB.
const ROUNDING_SHARE: f32 = 2e-7;

/// The result of the window's solution.
pub fn conclude(window: &mut Window, nuisances: &Nuisances, guess: &InitialGuess) -> Result<Fit, Overwritten> {
    let Window { span, levels, work, .. } = window;
    let (best, levels) = (&work.solution, *levels);
    let unknowns = best.shape.unknowns();

    let (mut residual_sum_of_squares, mut information) = (best.residual_sum_of_squares, best.information);
    // A small difference of large sums is mostly rounding.
    if is_cancelled(&residual_sum_of_squares, levels) {
        residual_sum_of_squares = residual_sums_of_squares(span, levels, nuisances, best)?;
        information *= information_ratio(best, &residual_sum_of_squares, levels).max(1e-3);
    }
    information *= real_information_share(best, levels);
    let rounding = ROUNDING_SHARE * best.nu;
    let sigma_nu = libm::sqrtf(1.0 / information + rounding * rounding);

    let baseline = Shape { harmonics: 0, ..best.shape };
    let without = residual_sums_without_solution(&work.sums, levels, nuisances, &baseline, false);
    let mut before = without.unwrap_or(levels.about_mean);
    // Also of a baseline that is much larger than everything else, or rounding would pass for a tone.
    if is_cancelled(&before, levels) {
        before = residuals_of_baseline(window, nuisances, baseline)?;
    }
    let Window { span, work, .. } = window;
    let best = &work.solution;
    let gained = gain(levels, &before, &residual_sum_of_squares, unknowns);
    let threshold = significant_search_gain(2.0 * best.shape.harmonics as f32 * levels.channels(), levels.frames);
    let is_too_short =
        !(2.0 * best.nu >= CYCLES_MIN) || best.nu >= span.nu_max() || !(sigma_nu <= RELATIVE_SIGMA_MAX * best.nu);
    // A tone that is not there all the time, or a drift, has lines below its own too.
    let is_ambiguous =
        guess.ambiguous || guess.below > 0.0 && is_misfit(noise_ratio(levels, &residual_sum_of_squares, unknowns));
    let covariance = best.fundamental_covariance();
    let status = match () {
        () if !(gained > threshold) || covariance.is_none() => Status::NoTone,
        () if is_too_short => Status::TooShort,
        () if is_ambiguous => Status::Ambiguous,
        () => Status::Good,
    };
    let Some(covariance) = covariance.filter(|_| status.has_tone()) else {
        return Ok(Fit::without_tone(status, levels));
    };
    Ok(Fit {
        status,
        frequency: span.frequency(best.nu),
        sigma: span.frequency(sigma_nu),
        harmonics: best.shape.harmonics as u8,
        frames: levels.frames,
        usable: levels.usable,
        channels: channels(best, levels, covariance, &residual_sum_of_squares),
    })
}

/// The channels' part of the result; `covariance` is [`Solution::fundamental_covariance`].
fn channels(
    best: &Solution,
    levels: &Levels,
    [of_cos, of_sin, of_both]: [f32; 3],
    residual_sum_of_squares: &Values,
) -> [ChannelFit; CHANNELS_MAX] {
    let (cos, sin) = best.harmonic(0);
    let freedom = (levels.frames as f32 - best.shape.unknowns() as f32).max(1.0);
    let mut channels = [ChannelFit::default(); CHANNELS_MAX];
    for (c, channel) in channels.iter_mut().enumerate().filter(|(c, _)| levels.usable & 1 << c != 0) {
        let power = cos[c] * cos[c] + sin[c] * sin[c];
        // Across the fundamental's phasor.
        let across = of_cos * sin[c] * sin[c] + of_sin * cos[c] * cos[c] - 2.0 * of_both * cos[c] * sin[c];
        let noise = residual_sum_of_squares[c] / freedom;
        *channel = ChannelFit {
            offset: levels.offset[c] + best.unknowns[0][c],
            amplitude: libm::sqrtf(power),
            phase_rad: libm::atan2f(-sin[c], cos[c]),
            phase_variance: noise * (across / power) / power,
            residual: libm::sqrtf(noise),
        };
    }
    channels
}

/// Whether the residuals of a channel are mostly rounding of the sums whose difference they are.
#[inline(never)]
fn is_cancelled(residual_sum_of_squares: &Values, levels: &Levels) -> bool {
    residual_sum_of_squares.iter().zip(&levels.yy).any(|(residual, yy)| *residual < CANCELLED_SHARE * yy)
}

/// Residual sums of squares of the baseline alone, sample by sample.
#[inline(never)]
fn residuals_of_baseline(window: &mut Window, nuisances: &Nuisances, shape: Shape) -> Result<Values, Overwritten> {
    let Window { span, levels, work, .. } = window;
    let mut baseline = Solution::NONE;
    if baseline.solve(&work.sums, levels, nuisances, work.solution.nu, shape).is_none() {
        return Ok(levels.about_mean);
    }
    residual_sums_of_squares(span, levels, nuisances, &baseline)
}

/// The share of a solution's information that is real. Its weights are estimates with few degrees of freedom (their mean
/// is too large by two, and their variance costs two more), and the noise in a harmonic's two amplitudes counts as its
/// power.
fn real_information_share(best: &Solution, levels: &Levels) -> f32 {
    let freedom = (levels.frames as f32 - best.shape.unknowns() as f32).max(5.0);
    let mut real = best.information;
    for h in 0..best.shape.harmonics.min(HARMONICS_MAX) {
        if best.power[h] > 0.0 && best.offset_sigma[h] > 0.0 {
            let own = (h + 1) as f32 / best.offset_sigma[h];
            real -= own * own * (2.0 * levels.channels() / best.power[h]).min(1.0);
        }
    }
    (real / best.information).max(0.1) * (freedom - 4.0) / freedom
}

/// Information about the frequency with these residual sums of squares in place of the solution's own, as a ratio. Each
/// channel counts by the inverse of its own.
fn information_ratio(best: &Solution, residual_sum_of_squares: &Values, levels: &Levels) -> f32 {
    let (mut weights, mut spread) = (0.0, 0.0);
    let (cos, sin) = best.harmonic(0);
    for c in 0..CHANNELS_MAX {
        if residual_sum_of_squares[c] > 0.0 {
            let power = cos[c] * cos[c] + sin[c] * sin[c];
            let weight = power / best.residual_sum_of_squares[c];
            let least = quantization_squares(levels);
            weights += weight;
            spread += weight * (residual_sum_of_squares[c].max(least) / best.residual_sum_of_squares[c]);
        }
    }
    if spread > 0.0 { weights / spread } else { 1.0 }
}
