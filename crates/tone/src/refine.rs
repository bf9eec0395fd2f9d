//! Refines a candidate: Gauss-Newton steps lead to the maximum of its likelihood, which also
//! chooses the shape of the model (the number of harmonics, and whether the baseline is curved).

use crate::blocks::{Blocks, Lines};
use crate::frame_span::FrameSpan;
use crate::limits::{BLOCKS_MAX, CHANNELS_MAX, CURVES_MAX, LINES_MAX};
use crate::other_lines::HALF_CYCLES;
use crate::significance::ln;
use crate::solve::{Equations, Shape, Solution};
use crate::source::{Overwritten, Values};
use crate::statistics::{Channels, Statistics};
use core::f32::consts::PI;

/// Longest step in `nu`, half a bin of a periodogram: further away the slope of the likelihood
/// misleads.
const STEP_MAX: f32 = 0.25;
/// The blocks' sums hold near the frequency at which they were collected. Greatest share of the
/// residuals that may come from the distance to it.
const MOVED_SHARE: f32 = 0.005;
/// The shape is chosen again after a step that moves the highest harmonic by more than this, in
/// `nu`.
const LONG_STEP: f32 = 0.1;
/// The same in windows of fewer than [`CYCLES_FEW`] cycles, where a curve can stand for a harmonic
/// and the shape changes often.
const LONG_STEP_FEW: f32 = 0.004;
const CYCLES_FEW: f32 = 3.0;
/// Steps in such windows whose expected gain is not used yet: the shape still changes.
const STEPS_FEW: usize = 2;
/// With at least this number of cycles a step's error grows with its cube. With fewer, the waves
/// correlate with the baseline.
const CYCLES_CUBIC: f32 = 2.0;
/// Cycles that each curve of the baseline adds to it.
const CYCLES_CURVE: f32 = 0.5;
/// Normal deviate within which residuals are noise alone.
const NOISE_DEVIATE: f32 = 3.5;
/// A step removes at most this share of the residuals: 60 dB.
const TAKEN_MAX: f32 = 1.0 - 1e-6;
/// A refinement gains at most this multiple of the gain that a step expects, and this score more.
const SURE_GAINS: f32 = 2.0;
const SURE_SCORE: f32 = 30.0;
/// Bounds of the secant's slope: the change of the solution's step from one frequency to the next,
/// over the distance between them, with the sign reversed. It is 1 where the steps converge at
/// once.
const SLOPE_MIN: f32 = 0.25;
const SLOPE_MAX: f32 = 3.0;
/// Smallest change of `nu` that f32 resolves well, as a share of it.
const STEP_SHARE_MIN: f32 = 1e-6;

/// A model of a window's content.
#[derive(Clone, Copy, Debug)]
pub struct Model {
    pub shape: Shape,
    /// Log-likelihood less a penalty for each unknown (Schwarz's criterion).
    pub score: f32,
}

/// Smallest sums of squares of residuals: a rounding's, by channel of the pass.
pub fn least_squares(statistics: &Statistics, channels: &Channels) -> Values {
    let step = statistics.quantization_step;
    let mut least = [0.0; CHANNELS_MAX];
    for (least, c) in least.iter_mut().zip(channels.list()) {
        let step = step * statistics.scale[*c as usize % CHANNELS_MAX];
        *least = step * step / 12.0 * statistics.frames as f32;
    }
    least
}

/// The log-likelihood of `width` channels, by the product of their residuals' shares of the
/// squares, less the penalty for the unknowns of each; `frames` and their logarithm.
pub fn likelihood(
    (frames, ln_frames): (f32, f32),
    width: usize,
    product: f32,
    unknowns: usize,
) -> f32 {
    -0.5 * (frames - unknowns as f32).max(0.0) * ln(product)
        - 0.5 * ln_frames * unknowns as f32 * width as f32
}

/// The same of residuals.
fn score(
    equations: &Equations,
    ln_frames: f32,
    residuals: &Values,
    least: &Values,
    unknowns: usize,
) -> f32 {
    let (frames, width) = ((equations.frames, ln_frames), equations.width());
    let mut sum = 0.0;
    // One logarithm for four: a residual is no less than a millionth of its squares, so f32 holds
    // their product.
    for first in (0..width).step_by(4) {
        let last = (first + 4).min(width);
        let mut product = 1.0;
        for c in first..last {
            let residual = if residuals[c] > least[c] {
                residuals[c]
            } else {
                least[c]
            };
            product *= residual / equations.squares()[c];
        }
        sum += likelihood(frames, last - first, product, unknowns);
    }
    sum
}

/// The likeliest model at a frequency, and the likeliest without a tone.
#[inline(never)]
fn choose(
    equations: &mut Equations,
    least: &Values,
    lines: &Lines,
    curved: bool,
) -> (Option<Model>, Model) {
    let none = Model {
        shape: Shape::default(),
        score: f32::NEG_INFINITY,
    };
    let (mut best, mut baseline) = (None, none);
    let curves = if curved { CURVES_MAX } else { 0 };
    let ln_frames = ln(equations.frames);
    let shape = Shape {
        harmonics: lines.harmonics,
        curves,
        interferer: lines.interferer.is_some(),
    };
    equations.residuals(shape, &mut |equations, shape, residuals| {
        let model = Model {
            shape,
            score: score(equations, ln_frames, residuals, least, shape.unknowns()),
        };
        if shape.harmonics == 0 {
            if model.score > baseline.score {
                baseline = model;
            }
        } else if best.is_none_or(|best: Model| model.score > best.score) {
            best = Some(model);
        }
    });
    (best, baseline)
}

/// Where a refinement ends.
#[derive(Clone, Copy, Debug)]
pub struct Summit {
    pub nu: f32,
    pub model: Model,
    /// The likeliest model without a tone.
    pub baseline: Model,
    /// The strongest harmonic, 1 the fundamental.
    pub strongest: usize,
    /// The part of its score that its unknowns take.
    pub penalty: f32,
    /// Power of the residuals over the noise of the frames' third differences, in most channels.
    pub noise_ratio: f32,
    /// The residuals are no more than that noise.
    pub explains_all: bool,
    /// Power of the residuals over the tone's.
    pub remainder: f32,
}

/// Share of the residuals that the solution's step takes.
fn taken(solution: &Solution) -> f32 {
    let samples = solution.frames * solution.width as f32;
    (solution.step * solution.step * solution.information / samples).min(TAKEN_MAX)
}

/// Power of the residuals over the noise in most channels, and whether they are noise alone in all.
fn noise_ratio(statistics: &Statistics, channels: &Channels, solution: &Solution) -> (f32, bool) {
    let (ratio, of_most, known) = solution.noise_ratio(statistics, channels);
    // Of the residuals and of third differences, a quarter as many but each of four frames.
    let sigma = libm::sqrtf(4.0 / (solution.frames * known));
    (
        of_most,
        known > 0.0 && ratio * (1.0 - taken(solution)) < 1.0 + NOISE_DEVIATE * sigma,
    )
}

/// How far to refine.
#[derive(Clone, Copy, Debug)]
pub struct Limits {
    /// Most blocks.
    pub blocks: usize,
    /// Gauss-Newton steps.
    pub steps: usize,
    /// Error that may be left, standard deviations.
    pub sigmas: f32,
    /// A refinement that will not come to this score is given up.
    pub score: f32,
    /// Without curves.
    pub is_straight: bool,
    /// With harmonics above half the frame rate, by their images.
    pub images: bool,
}

impl Limits {
    /// For a candidate. Eight blocks leave the memory of the window's pieces untouched.
    pub const CANDIDATE: Self = Self {
        blocks: 8,
        steps: 5,
        sigmas: 0.5,
        score: f32::NEG_INFINITY,
        is_straight: false,
        images: false,
    };
    /// For the result.
    pub const RESULT: Self = Self {
        blocks: BLOCKS_MAX,
        steps: 8,
        sigmas: 0.02,
        score: f32::NEG_INFINITY,
        is_straight: false,
        images: true,
    };
}

/// The error of a step. It grows with the cube of the angle by which the step turns the ends of the
/// window (the waves' third-order terms); that of a secant grows with the slope's distance from 1.
/// The weights follow the residuals: that moves the maximum by the step's share in the degrees of
/// freedom.
fn remainder(solution: &Solution, step: f32, slope: Option<f32>, nu_max: f32) -> f32 {
    let harmonics = solution.shape.harmonics as f32;
    let angle = 2.0 * PI * harmonics * step;
    let few = CYCLES_CUBIC + CYCLES_CURVE * solution.shape.curves as f32;
    // As close to half the frame rate the waves correlate with their own images.
    let below = harmonics.min((nu_max / solution.nu) as u32 as f32);
    let is_close = 2.0 * solution.nu < few || 2.0 * (nu_max - below * solution.nu) < CYCLES_CUBIC;
    if is_close || angle.abs() > 1.0 {
        return match slope {
            Some(slope) => step.abs() * (0.1 + (1.0 - slope).abs()),
            None => step.abs(),
        };
    }
    let freedom = (solution.frames - solution.shape.unknowns() as f32 - 8.0).max(1.0);
    step.abs() * (0.1 * angle * angle + 2.5 / freedom)
}

/// How far the highest harmonic may move from the frequency at which its blocks were collected, in
/// `nu`. The phase at a block's ends is then off by this distance times half the block's length. A
/// third of that phase's square, times the tone's power, is left in the residuals.
fn move_max(solution: &Solution, blocks: usize) -> f32 {
    let samples = solution.frames * solution.width as f32;
    let power = solution.power.iter().sum::<f32>() / samples;
    blocks as f32 / (2.0 * PI) * libm::sqrtf(3.0 * MOVED_SHARE / power.max(1.0))
}

/// A window, and memory.
pub struct Refinement<'c, 's> {
    pub span: &'c mut FrameSpan<'s>,
    pub statistics: &'c Statistics,
    pub blocks: &'c mut Blocks,
    pub equations: &'c mut Equations,
}

impl Refinement<'_, '_> {
    fn collect(
        &mut self,
        channels: &Channels,
        lines: &Lines,
        nu: f32,
        limits: &Limits,
    ) -> Result<(), Overwritten> {
        // An interferer takes the place of a harmonic.
        let most = lines
            .harmonics
            .min(LINES_MAX - lines.interferer.is_some() as usize);
        let harmonics = self.span.harmonics_apart(nu, most, limits.images);
        // Only a result's blocks have it.
        self.blocks.half_line = limits.blocks == BLOCKS_MAX
            && lines.harmonics > 1
            && nu >= HALF_CYCLES
            && self.span.is_in_time();
        let lines = Lines {
            nu,
            harmonics,
            ..*lines
        };
        self.blocks
            .collect(self.span, self.statistics, channels, lines, limits.blocks)
    }

    /// The solution at the end of the latest refinement: it is one step behind.
    pub fn solve_again(&mut self, channels: &Channels, summit: &Summit) {
        let shape = summit.model.shape;
        self.equations
            .collect(self.blocks, summit.nu, shape.curves > 0);
        // It had one a small step before.
        let _ = self
            .equations
            .solve(shape, &least_squares(self.statistics, channels));
    }

    /// Gauss-Newton steps from the fundamental of `lines`. Leaves the solution. None if there is no
    /// tone that can be separated from the baseline, or none that is likely enough.
    #[inline(never)]
    pub fn refine(
        &mut self,
        channels: &Channels,
        lines: &Lines,
        limits: &Limits,
    ) -> Result<Option<Summit>, Overwritten> {
        let least = least_squares(self.statistics, channels);
        let nu_max = self.span.nu_max();
        let mut nu = lines.nu;
        self.collect(channels, lines, nu, limits)?;
        let mut chosen: Option<(Shape, Model)> = None;
        let (mut most, mut last) = (0.0, None);
        for step in 0..limits.steps {
            if (nu - self.blocks.lines.nu).abs() * self.blocks.lines.harmonics as f32 > most {
                self.collect(channels, lines, nu, limits)?;
                // On the way an image may have come too close to another line.
                chosen = chosen.filter(|(shape, _)| shape.harmonics <= self.blocks.lines.harmonics);
            }
            // The shape is chosen where the refinement begins, and anew behind a long step.
            let curved = !limits.is_straight
                && self.span.is_in_time()
                && chosen.is_none_or(|(shape, _)| shape.curves > 0);
            let equations = &mut *self.equations;
            equations.collect(self.blocks, nu, curved);
            let (shape, baseline) = match chosen {
                Some(chosen) => chosen,
                None => match choose(equations, &least, &self.blocks.lines, curved) {
                    (Some(model), baseline) => (model.shape, baseline),
                    (None, _) => return Ok(None),
                },
            };
            if equations.solve(shape, &least).is_none() {
                return Ok(None);
            }
            let (solution, ln_frames) = (&equations.solution, ln(equations.frames));
            let score = score(
                equations,
                ln_frames,
                &solution.residual_squares,
                &least,
                shape.unknowns(),
            );
            let expected =
                -0.5 * solution.frames * solution.width as f32 * ln(1.0 - taken(solution));
            // Where the shape changes on the way, the first steps promise too little.
            let is_known = 2.0 * nu >= CYCLES_FEW || step >= STEPS_FEW;
            if is_known && score + SURE_GAINS * expected + SURE_SCORE < limits.score {
                return Ok(None);
            }
            // Along a path a block's frames are not spread evenly about its centre; the last step
            // is that of the frames then.
            most = move_max(solution, self.blocks.count);
            // A step should take itself back: where it does less, as in few cycles, the secant
            // leads further.
            let slope = match last {
                Some((at, step, of)) if of == shape => Some((step - solution.step) / (nu - at)),
                _ => None,
            };
            let slope = slope.map(|slope: f32| slope.clamp(SLOPE_MIN, SLOPE_MAX));
            last = Some((nu, solution.step, shape));
            let change = (solution.step / slope.unwrap_or(1.0)).clamp(-STEP_MAX, STEP_MAX);
            let next = (nu + change).min(nu_max).max(0.15);
            let tolerance = limits.sigmas / libm::sqrtf(solution.information);
            let is_tiny = change.abs() < STEP_SHARE_MIN * nu;
            if step + 1 < limits.steps
                && !is_tiny
                && remainder(solution, change, slope, nu_max) > tolerance
            {
                let long = if 2.0 * nu < CYCLES_FEW {
                    LONG_STEP_FEW
                } else {
                    LONG_STEP
                };
                let is_long = change.abs() * shape.harmonics as f32 > long;
                chosen = if is_long {
                    None
                } else {
                    Some((shape, baseline))
                };
                nu = next;
                continue;
            }
            // What remains is less than the tolerance: the solution is that at `nu`, its frequency
            // one step ahead.
            equations.solution.nu = next;
            let power = &equations.solution.power;
            let strongest = (0..power.len())
                .fold(0, |most, h| if power[h] > power[most] { h } else { most })
                + 1;
            let (noise_ratio, explains_all) =
                noise_ratio(self.statistics, channels, &equations.solution);
            let unknowns = shape.unknowns() as f32 * equations.width() as f32;
            return Ok(Some(Summit {
                nu: next,
                model: Model {
                    shape,
                    score: score + expected,
                },
                baseline,
                strongest,
                penalty: 0.5 * ln_frames * unknowns,
                noise_ratio,
                explains_all,
                remainder: equations.solution.remainder(),
            }));
        }
        Ok(None)
    }
}
