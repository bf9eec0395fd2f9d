//! The least-squares solution at one frequency, and the search for the best one.
//!
//! For a fixed frequency every other unknown is linear, so they are solved for exactly (variable
//! projection) and a Gauss-Newton step moves the frequency alone. Channels count by the inverse of
//! their own residual variance, which makes this the maximum of the likelihood with unknown noise
//! in each channel.

use crate::levels::Levels;
use crate::moments::{Correlation, HARMONICS_MAX, Moments, Stretch, Wave, Weight, moments};
use crate::normal::{Cholesky, UNKNOWNS, Vector, dot};
use crate::residuals::Model;
use crate::settings::TAXELS;
use crate::window::{FrameSource, Values};
use core::f32::consts::PI;

/// Cycles in the window below which there is too little of a wave to tell its frequency
/// (a periodogram is off by more than 1 Hz there; the bound itself still holds at 0.73 cycles).
pub const CYCLES_MIN: f32 = 0.6;
/// Cycles in the window from which a slope can be told from the wave and is fitted too.
pub const CYCLES_FOR_SLOPE: f32 = 2.0;
/// Gauss-Newton steps at the most; three do from a periodogram's peak.
const STEPS_MAX: usize = 8;
/// An error of the last step this small against the uncertainty is none.
const STEP_DONE: f32 = 0.02;
/// Share of the residuals that the last step may still take off them.
const RESIDUAL_EXCESS: f32 = 0.01;

/// What is fitted at one frequency.
#[derive(Clone, Copy, Debug)]
pub struct Shape {
    /// Harmonics, the fundamental included.
    pub harmonics: usize,
    /// Whether each channel has a slope besides its offset.
    pub slope: bool,
}

impl Shape {
    /// Unknowns of a channel.
    pub fn unknowns(&self) -> usize {
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
pub struct Solution {
    /// Cycles per half window ([`crate::moments`]).
    pub nu: f32,
    /// What was fitted.
    pub shape: Shape,
    /// Frames that counted.
    frames: f32,
    /// Each channel's model.
    pub models: [Model; TAXELS],
    /// Residual sums of squares.
    pub rest: Values,
    /// Gauss-Newton step in `nu`.
    pub step: f32,
    /// Information about `nu`: the inverse of its variance.
    pub information: f32,
    /// Weighted power of each harmonic.
    pub power: [f32; HARMONICS_MAX],
    /// Where each harmonic alone would rather be, in `nu` from its place.
    pub offset: [f32; HARMONICS_MAX],
    /// Standard deviation of that.
    pub offset_sigma: [f32; HARMONICS_MAX],
}

impl Solution {
    /// Whether the step leads to the maximum, so that nothing has to be solved again there.
    fn arrives(&self) -> bool {
        let step = self.step.abs();
        let done = STEP_DONE / libm::sqrtf(self.information);
        // A step turns the ends of the window by `angle`; what a Gauss-Newton step is wrong by goes
        // with its cube (the waves' third-order terms), and what the residuals are too large by with
        // its square.
        let angle = 2.0 * PI * self.shape.harmonics as f32 * step;
        // Below two cycles the waves lean on offset and slope too, and a step errs by more than that.
        if 2.0 * self.nu < CYCLES_FOR_SLOPE {
            return step <= done || step < 1e-6 * self.nu;
        }
        let samples = self.rest.iter().filter(|rest| **rest > 0.0).count() as f32 * self.frames;
        (0.1 * angle * angle * step <= done && step * step * self.information <= RESIDUAL_EXCESS * samples)
            || step < 1e-6 * self.nu
    }
}

/// Sum of squares that quantization alone leaves in so many frames: 1/12 of a code squared in each.
pub fn quantization(frames: f32) -> f32 {
    frames / 12.0
}

/// Smallest residual sum of squares that f32 sums can tell from rounding.
fn floor(squares: f32, frames: f32) -> f32 {
    (1e-6 * squares).max(quantization(frames))
}

/// Solves at `moments`' frequency. None if the unknowns cannot be told apart there.
pub fn solve(moments: &Moments, levels: &Levels, nu: f32, shape: Shape) -> Option<Solution> {
    let sums = &moments.trigonometric;
    let size = shape.unknowns();
    let mut normal = [[0.0; UNKNOWNS]; UNKNOWNS];
    for i in 0..size {
        for j in 0..=i {
            let ((a, p), (b, q)) = (shape.function(i), shape.function(j));
            let weight = [Weight::One, Weight::U, Weight::UU][p + q];
            normal[i][j] = sums.product(weight, a, b);
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
            let weight = if p == 0 { Weight::Lever } else { Weight::LeverU };
            *across = sums.product(weight, wave(d), b);
        }
    }
    for d in 0..waves {
        let solved = normal.solve(&across[d]);
        for e in 0..=d {
            let common = dot(&solved[..size], &across[e]);
            spread[d][e] = sums.product(Weight::LeverLever, wave(d), wave(e)) - common;
        }
    }

    let frames = levels.frames as f32;
    let mut out = Solution {
        nu,
        shape,
        frames,
        models: [Model::default(); TAXELS],
        rest: [0.0; TAXELS],
        step: 0.0,
        information: 0.0,
        power: [0.0; HARMONICS_MAX],
        offset: [0.0; HARMONICS_MAX],
        offset_sigma: [0.0; HARMONICS_MAX],
    };
    let mut line_pull = [0.0; HARMONICS_MAX];
    // Weighted sums over the channels of the products of the derivatives' factors, lower triangle.
    let mut factors = [[0.0; 2 * HARMONICS_MAX]; 2 * HARMONICS_MAX];
    for c in 0..TAXELS {
        if levels.usable & 1 << c == 0 {
            continue;
        }
        let channel = &moments.channels[c];
        let right = right_side(channel, levels, c, &shape);
        let beta = normal.solve(&right);
        let explained = dot(&beta[..size], &right);
        let rest = (levels.yy[c] - explained).max(floor(levels.yy[c], frames));
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
                if d % 2 == 0 { (channel.lever_cos[h], turn * sin) } else { (channel.lever_sin[h], -turn * cos) };
            along[d] = factor;
            left[d] = sum - dot(&across[d][..size], &beta);
        }
        for d in 0..waves {
            let weighted = weight * along[d];
            line_pull[d / 2] += weighted * left[d];
            for (factor, along) in factors[d].iter_mut().zip(&along[..=d]) {
                *factor += weighted * along;
            }
        }
        for h in 0..shape.harmonics {
            let (cos, sin) = (out.models[c].cos[h], out.models[c].sin[h]);
            out.power[h] += weight * 0.5 * frames * (cos * cos + sin * sin);
        }
    }
    let mut line_information = [0.0; HARMONICS_MAX];
    for d in 0..waves {
        for e in 0..=d {
            let part = if e < d { 2.0 } else { 1.0 } * factors[d][e] * spread[d][e];
            out.information += part;
            if d / 2 == e / 2 {
                line_information[d / 2] += part;
            }
        }
    }
    if !(out.information > 0.0) {
        return None;
    }
    out.step = line_pull.iter().sum::<f32>() / out.information;
    for h in 0..shape.harmonics {
        if line_information[h] > 0.0 {
            out.offset[h] = (h + 1) as f32 * line_pull[h] / line_information[h];
            out.offset_sigma[h] = (h + 1) as f32 / libm::sqrtf(line_information[h]);
        }
    }
    Some(out)
}

/// Right-hand side of a channel's normal equations.
fn right_side(channel: &Correlation, levels: &Levels, taxel: usize, shape: &Shape) -> Vector {
    let mut right = [0.0; UNKNOWNS];
    for (i, right) in right.iter_mut().enumerate().take(shape.unknowns()) {
        *right = match shape.function(i) {
            (Wave::One, 0) => levels.y[taxel],
            (Wave::One, _) => levels.uy[taxel],
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

/// Gauss-Newton from `nu`. The inner None says that the unknowns cannot be told apart, or that the
/// search ran out of the window's reach.
// Large and called from several places: one copy is enough.
#[inline(never)]
pub fn converge<S: FrameSource>(
    stretch: &mut Stretch<'_, S>,
    levels: &Levels,
    nu: f32,
    harmonics: usize,
) -> Option<Option<Solution>> {
    let (least, greatest) = (0.25 * CYCLES_MIN, 0.4999 * stretch.half());
    let shape = Shape { harmonics, slope: 2.0 * nu >= CYCLES_FOR_SLOPE };
    let mut at = nu;
    let mut best = None;
    for _ in 0..STEPS_MAX {
        let moments = moments(stretch, levels, at, harmonics)?;
        let Some(solution) = solve(&moments, levels, at, shape) else { return Some(None) };
        // A quarter of a cycle per half window is half a bin: further away the slope misleads.
        let step = solution.step.clamp(-0.25, 0.25);
        at = (at + step).clamp(least, greatest);
        let done = solution.arrives();
        best = Some(Solution { nu: at, ..solution });
        if done {
            break;
        }
    }
    Some(best)
}

/// Log-likelihood gained by what leaves the sums of squares `rest` with `shape`, over what left `before`.
pub fn gain(levels: &Levels, before: &Values, rest: &Values, shape: &Shape) -> f32 {
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

/// Whether sums of squares `a` are likelier than `b`, left by as many unknowns.
pub fn likelier(levels: &Levels, a: &Values, b: &Values) -> bool {
    let mut sum = 0.0;
    for c in 0..TAXELS {
        if levels.usable & 1 << c != 0 && a[c] > 0.0 && b[c] > 0.0 {
            sum += libm::logf(b[c] / a[c]);
        }
    }
    sum > 0.0
}
