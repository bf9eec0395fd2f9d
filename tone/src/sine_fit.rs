//! Least squares over all channels with one common frequency: the paper's equation 7 for sixteen
//! channels, with harmonics and a slope.
//!
//! This room decides how many harmonics there are, and whether there is a tone at all. Where the
//! search starts comes from [`crate::search`], the solution from [`crate::solve`]; the uncertainty is
//! the inverse of the same normal equations.

use crate::descent::{CYCLES_MIN, Problem, Work};
use crate::frame_span::FrameSpan;
use crate::fundamental::harmonics_below_nyquist;
use crate::levels::Levels;
use crate::moments::HARMONICS_MAX;
use crate::nuisance::{CURVE, Curve, Nuisances};
use crate::residuals::residuals;
use crate::search::{Scratch, Start, is_bent, is_curved, levels_and_means, search, search_coarse};
use crate::significance::{significant_power, significant_search_gain};
use crate::solve;
use crate::solve::{Shape, Solution, gain, is_misfit, over_noise, quantization};
use crate::source::CHANNELS_MAX;
use crate::source::{Overwritten, Values};
use crate::status::Status;

/// Residuals below this share of a channel's sum of squares are taken anew, sample by sample.
const DROWNED: f32 = 1e-4;
/// A relative uncertainty above which a window holds too little to speak of a frequency.
const RELATIVE_SIGMA_MAX: f32 = 0.1;
/// Frames of a long window's middle: means of four of them are as many as there can be.
const MIDDLE_FRAMES: u32 = 256;
/// What f32 makes a frequency wrong by, as a share of it: its own last digit, and those of the sums, which
/// noise covers from about 60 dB down.
const ROUNDING: f32 = 2e-7;
/// Fewest frames that are worth a fit.
pub const FRAMES_MIN: u32 = 16;

/// One channel of a [`Fit`], in the units of its frames.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ChannelFit {
    /// Level at the window's centre.
    pub offset: f32,
    /// Amplitude of the fundamental.
    pub amplitude: f32,
    /// Phase of the fundamental at the window's centre, radians, -pi to pi: amplitude x cos(theta + phase).
    pub phase_rad: f32,
    /// Variance of that phase, radians squared; of a channel without any tone not finite.
    pub phase_variance: f32,
    /// Standard deviation of what the fit leaves.
    pub residual: f32,
}

/// The result of a fit.
#[derive(Clone, Debug)]
pub struct Fit {
    /// Whether to believe it.
    pub status: Status,
    /// Cycles per frame; zero where there is no tone.
    pub frequency: f32,
    /// Its standard deviation, cycles per frame.
    pub sigma: f32,
    /// Harmonics fitted.
    pub harmonics: u8,
    /// Frames that counted.
    pub frames: u32,
    /// Bit k: taxel k took part.
    pub usable: u16,
    /// One for each taxel; zeros where it took no part.
    pub channels: [ChannelFit; CHANNELS_MAX],
}

impl Fit {
    /// Of a window in which the finger rests: no path to fit along.
    pub fn at_rest(frames: u32) -> Self {
        let channels = [ChannelFit::default(); CHANNELS_MAX];
        Self { status: Status::TooShort, frequency: 0.0, sigma: 0.0, harmonics: 0, frames, usable: 0, channels }
    }

    fn without_tone(status: Status, levels: &Levels) -> Self {
        let mut channels = [ChannelFit::default(); CHANNELS_MAX];
        let spreads = levels.offset.iter().zip(&levels.about_line);
        for (c, (channel, (offset, about_line))) in channels.iter_mut().zip(spreads).enumerate() {
            if levels.usable & 1 << c != 0 {
                channel.offset = *offset;
                channel.residual = libm::sqrtf(about_line / (levels.frames as f32 - 2.0));
            }
        }
        let (frames, usable) = (levels.frames, levels.usable);
        Self { status, frequency: 0.0, sigma: 0.0, harmonics: 0, frames, usable, channels }
    }
}

/// Scratch and settings of the fit.
#[derive(Debug)]
pub struct Fitter {
    scratch: Scratch,
    harmonics: usize,
}

impl Fitter {
    /// A fitter of up to `harmonics` harmonics (1 to [`HARMONICS_MAX`]); `const`, so that its
    /// scratch memory can live in a static.
    pub const fn new(harmonics: u8) -> Self {
        let harmonics = if harmonics == 0 { 1 } else { harmonics as usize };
        Self { scratch: Scratch::new(), harmonics: if harmonics > HARMONICS_MAX { HARMONICS_MAX } else { harmonics } }
    }

    /// From now on up to so many harmonics are fitted, 1 to [`HARMONICS_MAX`].
    pub fn set_harmonics(&mut self, harmonics: u8) {
        self.harmonics = usize::from(harmonics).clamp(1, HARMONICS_MAX);
    }

    /// Fits all usable channels of a stretch.
    ///
    /// # Errors
    /// If its frames were overwritten meanwhile.
    pub fn fit(&mut self, span: &mut FrameSpan) -> Result<Fit, Overwritten> {
        self.try_fit(span).ok_or(Overwritten)
    }

    fn try_fit(&mut self, span: &mut FrameSpan) -> Option<Fit> {
        // On the stack, which has room for it: the statics are close to their limit.
        let mut work = Work::NONE;
        let work = &mut work;
        let (levels, coarse) = levels_and_means(span, &mut self.scratch)?;
        if levels.usable == 0 || levels.frames < FRAMES_MIN {
            let levels = Levels { usable: 0, ..levels };
            return Some(Fit::without_tone(Status::Nothing, &levels));
        }
        // What is left of a window with more holes than frames bends its frequency at will.
        if 2 * levels.frames < span.frames {
            return Some(Fit::without_tone(Status::TooShort, &levels));
        }
        if let Some(start) = search_coarse(span, &levels, &coarse, &mut self.scratch, work, self.harmonics)? {
            let fit = fit_from(span, &levels, work, self.harmonics, start)?;
            // A drift can hide a tone that is too fast for the means.
            if fit.status.has_tone() {
                return Some(fit);
            }
        }
        if let Some(start) = self.search_middle(span, work)? {
            let fit = fit_from(span, &levels, work, self.harmonics, start)?;
            if fit.status.has_tone() {
                return Some(fit);
            }
        }
        match search(span, &levels, &mut self.scratch, work, self.harmonics)? {
            Some(start) => fit_from(span, &levels, work, self.harmonics, start),
            None => Some(Fit::without_tone(Status::NoTone, &levels)),
        }
    }

    /// Where a long window has a tone too fast for its means: the means of its middle may be short enough.
    // Apart: its levels and means are off the stack when it is done.
    #[inline(never)]
    fn search_middle(&mut self, span: &mut FrameSpan, work: &mut Work) -> Option<Option<Start>> {
        let all = span.frames;
        if all <= MIDDLE_FRAMES || !span.is_in_time() {
            return Some(None);
        }
        let mut middle = span.part((all - MIDDLE_FRAMES) / 2, MIDDLE_FRAMES);
        let (levels, coarse) = levels_and_means(&mut middle, &mut self.scratch)?;
        if levels.usable == 0 || 2 * levels.frames < MIDDLE_FRAMES {
            return Some(None);
        }
        let start = search_coarse(&mut middle, &levels, &coarse, &mut self.scratch, work, self.harmonics)?;
        let scale = all as f32 / MIDDLE_FRAMES as f32;
        Some(start.map(|start| Start { nu: start.nu * scale, ..start }))
    }
}

/// The fit from a guess.
// Large and called from several places: one copy is enough.
#[inline(never)]
fn fit_from(span: &mut FrameSpan, levels: &Levels, work: &mut Work, most: usize, start: Start) -> Option<Fit> {
    let Start { nu, ambiguous, below, slope, curve, harmonics } = start;
    let nuisances = Nuisances::new(span, levels, curve)?;
    let mut problem = Problem::new(span, levels, &nuisances, work);
    // Where a window is too short to tell so many harmonics apart, fewer may do.
    let harmonics = if harmonics > 0 { harmonics } else { harmonics_below_nyquist(problem.span, nu, most) };
    let mut shape = Shape { harmonics, slope, nuisances: nuisances.count() };
    while !problem.converge(nu, shape)? {
        if shape.harmonics == 1 {
            return Some(Fit::without_tone(Status::TooShort, levels));
        }
        shape.harmonics -= 1;
    }
    if curve != Curve::None {
        keep_curve_if_there(&mut problem)?;
    } else if slope && start.harmonics == 0 && is_bent(&mut problem)? {
        let nu = problem.solution().nu;
        return fit_from(span, levels, work, most, Start { nu, curve: Curve::Bent, ..start });
    }
    // As many harmonics as the scene carries and no more.
    let shape = problem.solution().shape;
    let carried = carried(problem.solution(), levels);
    if carried < shape.harmonics {
        let (lean, nu) = (Shape { harmonics: carried, ..shape }, problem.nu);
        // Where the harmonics left out stood for something else, such as a tone's end, it may be a long way.
        let found =
            problem.step(lean).is_some() && (problem.has_arrived() || problem.converge(problem.solution().nu, lean)?);
        if !found {
            problem.converge(nu, shape)?;
        }
    }
    conclude(&mut problem, ambiguous, below > 0.0)
}

/// A search by means takes what it does not model of a clear tone for a curve too: all harmonics of all frames
/// tell for sure.
fn keep_curve_if_there(problem: &mut Problem) -> Option<()> {
    let (shape, nu) = (problem.solution().shape, problem.solution().nu);
    let straight = Shape { nuisances: shape.nuisances - CURVE, ..shape };
    if problem.step(straight).is_some() && !is_curved(problem) {
        problem.converge(nu, straight)?;
    } else {
        problem.step(shape);
    }
    Some(())
}

/// Residual, uncertainty and verdict of a converged fit.
fn conclude(problem: &mut Problem, ambiguous: bool, comb: bool) -> Option<Fit> {
    let Problem { span, levels, nuisances, work, .. } = problem;
    let best = &work.solution;
    let frames = levels.frames as f32;
    let unknowns = best.shape.unknowns() as f32;

    let (mut residual_sum_of_squares, mut information) = (best.residual_sum_of_squares, best.information);
    // A small difference of large sums is mostly rounding: then sample by sample.
    if is_drowned(&residual_sum_of_squares, levels) {
        residual_sum_of_squares = residuals(span, levels, nuisances, best)?;
        information *= regained(best, &residual_sum_of_squares, frames).max(1e-3);
    }
    information *= honest(best, levels);
    let rounding = ROUNDING * best.nu;
    let sigma_nu = libm::sqrtf(1.0 / information + rounding * rounding);

    let without = Shape { harmonics: 0, ..best.shape };
    let mut before =
        solve::residual_sum_of_squares(&work.sums, levels, nuisances, &without, false).unwrap_or(levels.about_mean);
    // Of a baseline that outweighs everything too, or it would seem to leave a tone's worth of rounding.
    if is_drowned(&before, levels) {
        before = residuals_of_baseline(span, levels, nuisances, work, without)?;
    }
    let gained = gain(levels, &before, &residual_sum_of_squares, best.shape.unknowns());
    let threshold = significant_search_gain(2.0 * best.shape.harmonics as f32 * levels.channels(), levels.frames);
    let status = if !(gained > threshold) {
        Status::NoTone
    } else if !(2.0 * best.nu >= CYCLES_MIN) || best.nu >= span.nu_most() || !(sigma_nu <= RELATIVE_SIGMA_MAX * best.nu)
    {
        Status::TooShort
        // What comes and goes, or a drift, has lines below its own too.
    } else if ambiguous || comb && is_misfit(over_noise(levels, &residual_sum_of_squares, best.shape.unknowns())) {
        Status::Ambiguous
    } else {
        Status::Good
    };
    if !status.has_tone() {
        return Some(Fit::without_tone(status, levels));
    }
    let mut fit = Fit {
        status,
        frequency: best.nu / span.half(),
        sigma: sigma_nu / span.half(),
        harmonics: best.shape.harmonics as u8,
        frames: levels.frames,
        usable: levels.usable,
        channels: [ChannelFit::default(); CHANNELS_MAX],
    };
    let (cos, sin) = best.harmonic(0);
    let [of_cos, of_sin, of_both] = best.fundamental_covariance()?;
    for c in 0..CHANNELS_MAX {
        if levels.usable & 1 << c == 0 {
            continue;
        }
        let power = cos[c] * cos[c] + sin[c] * sin[c];
        // Across the fundamental's phasor.
        let across = of_cos * sin[c] * sin[c] + of_sin * cos[c] * cos[c] - 2.0 * of_both * cos[c] * sin[c];
        let noise = residual_sum_of_squares[c] / (frames - unknowns).max(1.0);
        fit.channels[c] = ChannelFit {
            offset: levels.offset[c] + best.unknowns[0][c],
            amplitude: libm::sqrtf(power),
            phase_rad: libm::atan2f(-sin[c], cos[c]),
            phase_variance: noise * (across / power) / power,
            residual: libm::sqrtf(noise),
        };
    }
    Some(fit)
}

/// Whether what is left of a channel is mostly rounding of what was taken off.
#[inline(never)]
fn is_drowned(residual_sum_of_squares: &Values, levels: &Levels) -> bool {
    residual_sum_of_squares
        .iter()
        .zip(&levels.yy)
        .any(|(residual_sum_of_squares, yy)| *residual_sum_of_squares < DROWNED * yy)
}

/// What the baseline alone leaves, sample by sample.
#[inline(never)]
fn residuals_of_baseline(
    span: &mut FrameSpan,
    levels: &Levels,
    nuisances: &Nuisances,
    work: &Work,
    without: Shape,
) -> Option<Values> {
    let mut baseline = Solution::NONE;
    if baseline.solve(&work.sums, levels, nuisances, work.solution.nu, without).is_none() {
        return Some(levels.about_mean);
    }
    residuals(span, levels, nuisances, &baseline)
}

/// What share of the information that a solution believes to have is real. Its weights come from noise that was
/// measured with few degrees of freedom (their mean is too large by two, and what they vary costs two more), and
/// the noise in a harmonic's two amplitudes counts as its power.
fn honest(best: &Solution, levels: &Levels) -> f32 {
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

/// By what factor the information about the frequency grows when the residuals of `best` are in truth
/// `rest`: each channel counts by the inverse of what was taken for its own.
fn regained(best: &Solution, residual_sum_of_squares: &Values, frames: f32) -> f32 {
    let (mut weights, mut spread) = (0.0, 0.0);
    let (cos, sin) = best.harmonic(0);
    for c in 0..CHANNELS_MAX {
        if residual_sum_of_squares[c] > 0.0 {
            let power = cos[c] * cos[c] + sin[c] * sin[c];
            let weight = power / best.residual_sum_of_squares[c];
            weights += weight;
            spread += weight * (residual_sum_of_squares[c].max(quantization(frames)) / best.residual_sum_of_squares[c]);
        }
    }
    if spread > 0.0 { weights / spread } else { 1.0 }
}

/// Harmonics up to the last that stands out of the noise.
fn carried(best: &Solution, levels: &Levels) -> usize {
    let (mut harmonics, by_chance) = (1, significant_power(levels, best.shape.unknowns()));
    for (h, power) in best.power.iter().enumerate().take(best.shape.harmonics) {
        if *power > by_chance {
            harmonics = h + 1;
        }
    }
    harmonics
}
