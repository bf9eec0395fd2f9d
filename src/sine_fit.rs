//! Least squares over all channels with one common frequency: the paper's equation 7 for sixteen
//! channels, with harmonics and a slope.
//!
//! For a fixed frequency every other unknown is linear, so they are solved for exactly (variable
//! projection) and a Gauss-Newton step moves the frequency alone. Channels count by the inverse of
//! their own residual variance, which makes this the maximum of the likelihood with unknown noise
//! in each channel. The uncertainty is the inverse of the same normal equations.

use crate::moments::{Correlation, HARMONICS_MAX, Levels, Model, Moments, Stretch, Wave, levels, moments, residuals};
use crate::normal::{Cholesky, UNKNOWNS, Vector};
use crate::settings::TAXELS;
use crate::spectrum::{Scratch, strongest};
use crate::telemetry::Status;
use crate::window::{FrameSource, Values};
use core::f32::consts::PI;

/// Cycles in the window below which there is too little of a wave to tell its frequency
/// (a periodogram is off by more than 1 Hz there; the bound itself still holds at 0.73 cycles).
const CYCLES_MIN: f32 = 0.6;
/// Cycles in the window from which a slope can be told from the wave and is fitted too.
const CYCLES_FOR_SLOPE: f32 = 2.0;
/// Gauss-Newton steps at the most; three do from a periodogram's peak.
const STEPS_MAX: usize = 8;
/// A step this small against the uncertainty ends the search.
const STEP_DONE: f32 = 0.02;
/// A relative uncertainty above which a window holds too little to speak of a frequency.
const RELATIVE_SIGMA_MAX: f32 = 0.1;
/// Share of the tone's power that the lines in between must have for a tone an octave (or a
/// twelfth) below the strongest line.
const SUBHARMONIC_SHARE: f32 = 0.1;
/// Share from which such lines leave it open which of the two it is.
const AMBIGUOUS_SHARE: f32 = 0.04;
/// A harmonic is a line where the fundamental says it is, within this many cycles per window: real
/// combs in recordings keep to 0.01, the skirts of drifts and of other lines are off by 0.1 and more.
const LINE_OFFSET_MAX: f32 = 0.06;
/// One channel of a [`Fit`], in the units of its frames.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ChannelFit {
    /// Level at the window's centre.
    pub offset: f32,
    /// Amplitude of the fundamental.
    pub amplitude: f32,
    /// Phase of the fundamental at the window's centre, radians, -pi to pi: amplitude x cos(theta + phase).
    pub phase_rad: f32,
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
    pub channels: [ChannelFit; TAXELS],
}

impl Fit {
    fn without_tone(status: Status, levels: &Levels) -> Self {
        let mut channels = [ChannelFit::default(); TAXELS];
        for (c, channel) in channels.iter_mut().enumerate() {
            if levels.usable & 1 << c != 0 {
                channel.offset = levels.offset[c];
                channel.residual = libm::sqrtf(levels.about_line[c] / (levels.frames as f32 - 2.0));
            }
        }
        let (frames, usable) = (levels.frames, levels.usable);
        Self { status, frequency: 0.0, sigma: 0.0, harmonics: 0, frames, usable, channels }
    }
}

/// What is fitted at one frequency.
#[derive(Clone, Copy, Debug)]
struct Shape {
    harmonics: usize,
    slope: bool,
}

impl Shape {
    /// Unknowns of a channel.
    fn unknowns(&self) -> usize {
        1 + self.slope as usize + 2 * self.harmonics
    }

    /// The functions of a channel: wave and power of `u`.
    fn function(&self, index: usize) -> (Wave, usize) {
        let first = 1 + self.slope as usize;
        match index {
            0 => (Wave::One, 0),
            1 if self.slope => (Wave::One, 1),
            _ if (index - first).is_multiple_of(2) => (Wave::Cos((index - first) / 2 + 1), 0),
            _ => (Wave::Sin((index - first) / 2 + 1), 0),
        }
    }
}

/// The least-squares solution at one frequency and the step towards a better one.
#[derive(Clone, Debug)]
struct Solution {
    nu: f32,
    shape: Shape,
    models: [Model; TAXELS],
    /// Residual sums of squares.
    rest: Values,
    /// Gauss-Newton step in `nu`.
    step: f32,
    /// Information about `nu`: the inverse of its variance.
    information: f32,
    /// Weighted power of each harmonic.
    power: [f32; HARMONICS_MAX],
    /// Where each harmonic alone would rather be, in `nu` from its place.
    offset: [f32; HARMONICS_MAX],
    /// Standard deviation of that.
    offset_sigma: [f32; HARMONICS_MAX],
}

/// Smallest residual sum of squares that f32 sums can tell from rounding.
fn floor(correlation: &Correlation, frames: f32) -> f32 {
    // Quantization alone leaves 1/12 of a code squared per sample.
    (1e-6 * correlation.yy).max(frames / 12.0)
}

/// Solves at `moments`' frequency. None if the unknowns cannot be told apart there.
fn solve(moments: &Moments, levels: &Levels, nu: f32, shape: Shape) -> Option<Solution> {
    let sums = &moments.trigonometric;
    let size = shape.unknowns();
    let mut normal = [[0.0; UNKNOWNS]; UNKNOWNS];
    for i in 0..size {
        for j in 0..=i {
            let ((a, p), (b, q)) = (shape.function(i), shape.function(j));
            normal[i][j] = sums.product(p + q, a, b);
        }
    }
    let normal = Cholesky::new(&normal, size)?;

    // d model / d nu is a mixture of u cos(h theta) and u sin(h theta); `across[d]` is what each of
    // those has in common with the model's own functions, `spread` what it has beside them.
    let waves = 2 * shape.harmonics;
    let wave = |index: usize| if index.is_multiple_of(2) { Wave::Cos(index / 2 + 1) } else { Wave::Sin(index / 2 + 1) };
    let mut across = [[0.0; UNKNOWNS]; 2 * HARMONICS_MAX];
    let mut spread = [[0.0; 2 * HARMONICS_MAX]; 2 * HARMONICS_MAX];
    for (d, across) in across.iter_mut().enumerate().take(waves) {
        for (i, across) in across.iter_mut().enumerate().take(size) {
            let (b, p) = shape.function(i);
            *across = sums.product(1 + p, wave(d), b);
        }
    }
    for d in 0..waves {
        let solved = normal.solve(&across[d]);
        for e in 0..waves {
            let common: f32 = (0..size).map(|i| solved[i] * across[e][i]).sum();
            spread[d][e] = sums.product(2, wave(d), wave(e)) - common;
        }
    }

    let frames = levels.frames as f32;
    let mut out = Solution {
        nu,
        shape,
        models: [Model::default(); TAXELS],
        rest: [0.0; TAXELS],
        step: 0.0,
        information: 0.0,
        power: [0.0; HARMONICS_MAX],
        offset: [0.0; HARMONICS_MAX],
        offset_sigma: [0.0; HARMONICS_MAX],
    };
    let mut pull = 0.0;
    let (mut line_pull, mut line_information) = ([0.0; HARMONICS_MAX], [0.0; HARMONICS_MAX]);
    for c in 0..TAXELS {
        if levels.usable & 1 << c == 0 {
            continue;
        }
        let channel = &moments.channels[c];
        let right = right_side(channel, &shape);
        let beta = normal.solve(&right);
        let explained: f32 = (0..size).map(|i| beta[i] * right[i]).sum();
        let rest = (channel.yy - explained).max(floor(channel, frames));
        let weight = (frames - size as f32).max(1.0) / rest;
        out.rest[c] = rest;
        out.models[c] = model(&beta, &shape);

        let mut along = [0.0; 2 * HARMONICS_MAX];
        let mut left = [0.0; 2 * HARMONICS_MAX];
        for d in 0..waves {
            let h = d / 2;
            let turn = 2.0 * PI * (h + 1) as f32;
            let (cos, sin) = (out.models[c].cos[h], out.models[c].sin[h]);
            let (sum, factor) =
                if d % 2 == 0 { (channel.u_cos[h], turn * sin) } else { (channel.u_sin[h], -turn * cos) };
            along[d] = factor;
            left[d] = sum - (0..size).map(|i| across[d][i] * beta[i]).sum::<f32>();
        }
        for d in 0..waves {
            pull += weight * along[d] * left[d];
            line_pull[d / 2] += weight * along[d] * left[d];
            for e in 0..waves {
                let part = weight * along[d] * spread[d][e] * along[e];
                out.information += part;
                if d / 2 == e / 2 {
                    line_information[d / 2] += part;
                }
            }
        }
        for h in 0..shape.harmonics {
            let (cos, sin) = (out.models[c].cos[h], out.models[c].sin[h]);
            out.power[h] += weight * 0.5 * frames * (cos * cos + sin * sin);
        }
    }
    if !(out.information > 0.0) {
        return None;
    }
    out.step = pull / out.information;
    for h in 0..shape.harmonics {
        if line_information[h] > 0.0 {
            out.offset[h] = (h + 1) as f32 * line_pull[h] / line_information[h];
            out.offset_sigma[h] = (h + 1) as f32 / libm::sqrtf(line_information[h]);
        }
    }
    Some(out)
}

/// Right-hand side of a channel's normal equations.
fn right_side(channel: &Correlation, shape: &Shape) -> Vector {
    let mut right = [0.0; UNKNOWNS];
    for (i, right) in right.iter_mut().enumerate().take(shape.unknowns()) {
        *right = match shape.function(i) {
            (Wave::One, 0) => channel.y,
            (Wave::One, _) => channel.uy,
            (Wave::Cos(h), _) => channel.cos[h - 1],
            (Wave::Sin(h), _) => channel.sin[h - 1],
        };
    }
    right
}

/// A channel's model from its unknowns.
fn model(beta: &Vector, shape: &Shape) -> Model {
    let mut model = Model::default();
    for (i, beta) in beta.iter().enumerate().take(shape.unknowns()) {
        match shape.function(i) {
            (Wave::One, 0) => model.offset = *beta,
            (Wave::One, _) => model.slope = *beta,
            (Wave::Cos(h), _) => model.cos[h - 1] = *beta,
            (Wave::Sin(h), _) => model.sin[h - 1] = *beta,
        }
    }
    model
}

/// Log-likelihood gained over straight lines (with a slope) or constants (without).
fn gain(levels: &Levels, rest: &Values, shape: &Shape) -> f32 {
    let before = if shape.slope { &levels.about_line } else { &levels.about_mean };
    // Bartlett's factor: the logarithm of few frames overstates what so many unknowns explain.
    let factor = (levels.frames as f32 - shape.unknowns() as f32).max(0.0);
    let mut sum = 0.0;
    for c in 0..TAXELS {
        if levels.usable & 1 << c != 0 && rest[c] > 0.0 && before[c] > rest[c] {
            sum += libm::logf(before[c] / rest[c]);
        }
    }
    0.5 * factor * sum
}

/// Gain that noise alone reaches in one search out of a hundred: the chi-square point of
/// `unknowns` degrees of freedom at one hundredth over the number of tries (Wilson and Hilferty's
/// cube), halved. A search between the frequencies of a transform counts for twice as many of them,
/// and the number of harmonics and the place of the fundamental are chosen too: four tries a frame.
fn gain_by_chance(unknowns: f32, frames: f32) -> f32 {
    // Normal deviate of the tail, by Mills' ratio.
    let tail = 0.01 / (4.0 * frames);
    let z2 = -2.0 * libm::logf(tail * 2.5);
    let z = libm::sqrtf((z2 - libm::logf(z2)).max(1.0));
    let cube = 1.0 - 2.0 / (9.0 * unknowns) + z * libm::sqrtf(2.0 / (9.0 * unknowns));
    0.5 * unknowns * cube * cube * cube
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

    /// Fits all usable channels of a stretch. None if its frames were overwritten meanwhile.
    pub fn fit<S: FrameSource>(&mut self, stretch: &mut Stretch<'_, S>) -> Option<Fit> {
        let levels = levels(stretch)?;
        if levels.usable == 0 || levels.frames < 16 {
            let levels = Levels { usable: 0, ..levels };
            return Some(Fit::without_tone(Status::Nothing, &levels));
        }
        let Some(nu) = self.first_guess(stretch, &levels)? else {
            return Some(Fit::without_tone(Status::Nothing, &levels));
        };
        let Some((nu, ambiguous)) = self.fundamental(stretch, &levels, nu)? else {
            return Some(Fit::without_tone(Status::TooShort, &levels));
        };
        // Where a window is too short to tell so many harmonics apart, fewer may do.
        let mut harmonics = self.harmonics_below_nyquist(stretch, nu);
        let mut best = converge(stretch, &levels, nu, harmonics)?;
        while best.is_none() && harmonics > 1 {
            harmonics -= 1;
            best = converge(stretch, &levels, nu, harmonics)?;
        }
        let Some(mut best) = best else {
            return Some(Fit::without_tone(Status::TooShort, &levels));
        };
        // As many harmonics as the scene carries and no more.
        let carried = carried(&best, power_by_chance(&levels));
        if carried < best.shape.harmonics {
            if let Some(leaner) = converge(stretch, &levels, best.nu, carried)? {
                best = leaner;
            }
        }
        self.conclude(stretch, &levels, best, ambiguous)
    }

    /// The strongest line, by the periodogram; where it lies low, by exact likelihoods, because a
    /// line of few cycles leans on its own mirror image. The inner None says that there is none.
    fn first_guess<S: FrameSource>(&mut self, stretch: &mut Stretch<'_, S>, levels: &Levels) -> Option<Option<f32>> {
        let Some(peak) = strongest(stretch, levels, &mut self.scratch) else {
            return Some(None);
        };
        if peak > 1.75 {
            return Some(Some(peak));
        }
        let (mut best, mut most) = (peak, f32::MIN);
        let mut cycles = CYCLES_MIN;
        while cycles < 4.0 {
            let nu = 0.5 * cycles;
            let shape = Shape { harmonics: 1, slope: cycles >= CYCLES_FOR_SLOPE };
            let moments = moments(stretch, levels, nu, 1)?;
            if let Some(solution) = solve(&moments, levels, nu, shape) {
                // All against constants; the slopes' own gain has to pay for their unknowns.
                let constants = Shape { slope: false, ..shape };
                let paid = if shape.slope { 8.0 * libm::logf(levels.frames as f32) } else { 0.0 };
                let gain = gain(levels, &solution.rest, &constants) - paid;
                if gain > most {
                    (best, most) = (nu, gain);
                }
            }
            cycles += 0.2 + 0.1 * cycles;
        }
        Some(Some(best))
    }

    fn harmonics_below_nyquist<S: FrameSource>(&self, stretch: &Stretch<'_, S>, nu: f32) -> usize {
        let mut harmonics = 1;
        while harmonics < self.harmonics && (harmonics + 1) as f32 * nu < 0.48 * stretch.half() {
            harmonics += 1;
        }
        harmonics
    }

    /// Whether the strongest line is the fundamental, or the second or third harmonic of one; and
    /// whether that is open. The inner None says that the window is too short to tell anything.
    fn fundamental<S: FrameSource>(
        &self,
        stretch: &mut Stretch<'_, S>,
        levels: &Levels,
        strongest: f32,
    ) -> Option<Option<(f32, bool)>> {
        let Some(line) = converge(stretch, levels, strongest, 1)? else { return Some(None) };
        let (mut found, mut ambiguous) = (line.nu, false);
        if self.harmonics < 2 {
            return Some(Some((found, ambiguous)));
        }
        let mut highest = AMBIGUOUS_SHARE;
        for part in [2usize, 3] {
            let nu = line.nu / part as f32;
            let harmonics = (part + 2).min(HARMONICS_MAX);
            if 2.0 * nu < 1.0 || harmonics as f32 * nu > 0.48 * stretch.half() {
                continue;
            }
            let Some(comb) = converge(stretch, levels, nu, harmonics)? else { continue };
            if (comb.nu - nu).abs() > 0.25 {
                continue;
            }
            let share = share_between(&comb, part);
            if share > highest && lines_hold(&comb, part, power_by_chance(levels)) {
                highest = share;
                if share > SUBHARMONIC_SHARE {
                    (found, ambiguous) = (comb.nu, false);
                } else {
                    ambiguous = true;
                }
            }
        }
        Some(Some((found, ambiguous)))
    }

    /// Residual, uncertainty and verdict of a converged fit.
    fn conclude<S: FrameSource>(
        &self,
        stretch: &mut Stretch<'_, S>,
        levels: &Levels,
        best: Solution,
        ambiguous: bool,
    ) -> Option<Fit> {
        let rest = residuals(stretch, levels, best.nu, best.shape.harmonics, &best.models)?;
        let frames = levels.frames as f32;
        let channels_used = levels.usable.count_ones() as f32;
        let unknowns = best.shape.unknowns() as f32;

        // The moments' residual may have been at its floor; the information goes with its inverse.
        let mut refined = 0.0;
        let mut weights = 0.0;
        for c in 0..TAXELS {
            if levels.usable & 1 << c != 0 && rest[c] > 0.0 {
                let amplitude2 =
                    best.models[c].cos[0] * best.models[c].cos[0] + best.models[c].sin[0] * best.models[c].sin[0];
                refined += amplitude2 / rest[c].max(frames / 12.0);
                weights += amplitude2 / best.rest[c];
            }
        }
        let correction = if weights > 0.0 { refined / weights } else { 1.0 };
        let sigma_nu = 1.0 / libm::sqrtf(best.information * correction.max(1e-3));

        let gained = gain(levels, &rest, &best.shape);
        let chance = gain_by_chance(2.0 * best.shape.harmonics as f32 * channels_used, frames);
        let status = if !(gained > chance) {
            Status::NoTone
        } else if !(2.0 * best.nu >= CYCLES_MIN) || !(sigma_nu <= RELATIVE_SIGMA_MAX * best.nu) {
            Status::TooShort
        } else if ambiguous {
            Status::Ambiguous
        } else {
            Status::Good
        };
        if !matches!(status, Status::Good | Status::Ambiguous) {
            return Some(Fit::without_tone(status, levels));
        }
        let mut fit = Fit {
            status,
            frequency: best.nu / stretch.half(),
            sigma: sigma_nu / stretch.half(),
            harmonics: best.shape.harmonics as u8,
            frames: levels.frames,
            usable: levels.usable,
            channels: [ChannelFit::default(); TAXELS],
        };
        for c in 0..TAXELS {
            if levels.usable & 1 << c == 0 {
                continue;
            }
            let model = &best.models[c];
            let (cos, sin) = (model.cos[0], model.sin[0]);
            fit.channels[c] = ChannelFit {
                offset: levels.offset[c] + model.offset,
                amplitude: libm::sqrtf(cos * cos + sin * sin),
                phase_rad: libm::atan2f(-sin, cos),
                residual: libm::sqrtf(rest[c] / (frames - unknowns).max(1.0)),
            };
        }
        Some(fit)
    }
}

/// Gauss-Newton from `nu`. The inner None says that the unknowns cannot be told apart, or that the
/// search ran out of the window's reach.
fn converge<S: FrameSource>(
    stretch: &mut Stretch<'_, S>,
    levels: &Levels,
    nu: f32,
    harmonics: usize,
) -> Option<Option<Solution>> {
    let (least, greatest) = (0.25 * CYCLES_MIN, 0.4999 * 2.0 * stretch.half());
    let shape = Shape { harmonics, slope: 2.0 * nu >= CYCLES_FOR_SLOPE };
    let mut at = nu;
    let mut best = None;
    for _ in 0..STEPS_MAX {
        let moments = moments(stretch, levels, at, harmonics)?;
        let Some(solution) = solve(&moments, levels, at, shape) else { return Some(None) };
        // A quarter of a cycle per half window is half a bin: further away the slope misleads.
        let step = solution.step.clamp(-0.25, 0.25);
        let sigma = 1.0 / libm::sqrtf(solution.information);
        let done = solution.step.abs() <= STEP_DONE * sigma || solution.step.abs() < 1e-6 * at;
        best = Some(solution);
        if done {
            break;
        }
        at = (at + step).clamp(least, greatest);
    }
    Some(best)
}

/// Share of the power in harmonics that are no multiple of `part`.
fn share_between(comb: &Solution, part: usize) -> f32 {
    let (mut between, mut all) = (0.0, 0.0);
    for (h, power) in comb.power.iter().enumerate().take(comb.shape.harmonics) {
        all += power;
        if (h + 1) % part != 0 {
            between += power;
        }
    }
    if all > 0.0 { between / all } else { 0.0 }
}

/// Power of one line over all channels, in units of their noise, that noise alone reaches once in a
/// thousand times: the chi-square point of two degrees of freedom for each channel (Wilson and
/// Hilferty's cube, normal deviate 3.09).
fn power_by_chance(levels: &Levels) -> f32 {
    let degrees = 2.0 * levels.usable.count_ones() as f32;
    let cube = 1.0 - 2.0 / (9.0 * degrees) + 3.09 * libm::sqrtf(2.0 / (9.0 * degrees));
    degrees * cube * cube * cube
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

/// Harmonics up to the last that stands out of the noise.
fn carried(best: &Solution, by_chance: f32) -> usize {
    let mut harmonics = 1;
    for (h, power) in best.power.iter().enumerate().take(best.shape.harmonics) {
        if *power > by_chance {
            harmonics = h + 1;
        }
    }
    harmonics
}
