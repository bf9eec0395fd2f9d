//! What the channels share: disturbances that reach all of them, each with a gain of its own.
//!
//! Such a disturbance lives in one mixture of channels, or in two if its phases differ. Least squares that takes channels as
//! independent has all of it in its error. Mixtures at right angles to it are free of it. So the blocks' channels are turned
//! into mixtures that are independent and of equal noise (whitened), by the covariance of the residuals next to the main line,
//! and the last steps are taken from there.
//! Source: S. M. Kay, "Fundamentals of Statistical Signal Processing: Estimation Theory" (1993), section 4.5.

use crate::blocks::Blocks;
use crate::limits::CHANNELS_MAX;
use crate::neighbourhood::{Neighbourhood, neighbourhood};
use crate::normal::dot;
use crate::solve::{Equations, Shape, Solution};
use crate::source::Values;

/// Most directions that are shared: cosine and sine of a disturbance.
const DIRECTIONS: usize = 4;
/// Power in a direction, over the mean of those left, from which on it is shared and no chance: sixteen channels of white
/// noise have three to five in as few blocks.
const SHARED_MIN: f32 = 10.0;
/// Share of a direction's square that lies along the tone from which on it is the tone's own movement.
const OWN_SHARE: f32 = 0.7;
/// Least power of a channel's own, over the mean of all channels'.
const OWN_MIN: f32 = 0.5;
/// Blocks' worth of residuals that the solution has taken, and what they lack as few as they are: chosen so that intervals hold
/// on other seeds than those of docs/noise.md. Each direction takes one more.
const BLOCKS_TAKEN: f32 = 6.0;
/// Rounds in which shared and own power are parted.
const ROUNDS: usize = 2;
/// Fewer channels have no mixture to spare.
const CHANNELS_MIN: usize = 3;
/// Turns of the power iteration.
const TURNS: usize = 12;
/// Steps in a whitened window; from one to the next, standard deviations; and all together, `nu`.
const STEPS: usize = 8;
const SIGMAS: f32 = 0.02;
const MOVE_MAX: f32 = 0.25;

/// A covariance of channels, each in units of its own residuals: both triangles.
pub type Covariance = [Values; CHANNELS_MAX];

/// How channels are turned into independent ones.
#[derive(Clone, Copy, Debug)]
pub struct Mixture {
    /// Of each channel, one over the standard deviation of a mixture.
    factors: Values,
    /// Directions of unit length that are taken out; zeros are none.
    directions: [Values; DIRECTIONS],
}

impl Mixture {
    /// Of a covariance that adds up so many blocks, of residuals in units of one over `roots`. None if channels share nothing.
    #[inline(never)]
    pub fn new(covariance: &Covariance, roots: &Values, solution: &Solution, main: usize, blocks: f32) -> Option<Self> {
        let width = solution.width.min(CHANNELS_MAX);
        let (mut trace, mut squares) = (0.0, 0.0);
        for (c, row) in covariance.iter().enumerate().take(width) {
            (trace, squares) = (trace + row[c], squares + dot(row, row));
        }
        // No direction has more power than the root of all squares.
        let least = SHARED_MIN * trace / (width as f32 - 1.0 + SHARED_MIN);
        if width < CHANNELS_MIN || !(squares > least * least) {
            return None;
        }
        let (cos, sin) = solution.harmonic(main);
        let mut out = Self { factors: *roots, directions: [[0.0; CHANNELS_MAX]; DIRECTIONS] };
        let (mut own, mut of_one) = ([1.0; CHANNELS_MAX], 0.0);
        // What is a channel's own shows once the shared part is known.
        for _ in 0..ROUNDS {
            out.factors.iter_mut().zip(&own).for_each(|(factor, own)| *factor /= libm::sqrtf(*own));
            let units: Values = core::array::from_fn(|c| if roots[c] > 0.0 { out.factors[c] / roots[c] } else { 0.0 });
            let mut left: Covariance =
                core::array::from_fn(|c| core::array::from_fn(|d| units[c] * covariance[c][d] * units[d]));
            let wave = |wave: &Values| core::array::from_fn(|c| if c < width { wave[c] * out.factors[c] } else { 0.0 });
            (out.directions, of_one) = directions(&mut left, &at_right_angles([wave(cos), wave(sin)]), width);
            for (c, own) in own.iter_mut().enumerate().take(width) {
                // Its own noise has a part in the shared directions too.
                let within: f32 = out.directions.iter().map(|direction| direction[c] * direction[c]).sum();
                *own = (left[c][c] / of_one + within).max(OWN_MIN);
            }
        }
        let count = out.directions.iter().filter(|direction| direction.iter().any(|value| *value != 0.0)).count();
        let freedom = (blocks - BLOCKS_TAKEN - count as f32).max(1.0);
        let scale = libm::sqrtf(freedom * (1.0 - solution.shape.unknowns() as f32 / solution.frames) / of_one);
        out.factors.iter_mut().for_each(|factor| *factor *= scale);
        (count > 0 && scale.is_finite()).then_some(out)
    }

    /// Turns rows of channels into rows of mixtures.
    pub fn apply(&self, rows: &mut [Values]) {
        for row in rows {
            row.iter_mut().zip(&self.factors).for_each(|(value, factor)| *value *= factor);
            for direction in &self.directions {
                let along = dot(row, direction);
                row.iter_mut().zip(direction).for_each(|(value, direction)| *value -= along * direction);
            }
        }
    }
}

/// Takes the steps that are left from the latest solution with the noise that the channels share taken out, and turns the blocks'
/// channels into mixtures. The neighbourhood there; None if the steps lead away, and the equations' solution is then of no use.
#[inline(never)]
pub fn whiten(blocks: &mut Blocks, equations: &mut Equations, least: &Values) -> Option<Neighbourhood> {
    let start = equations.solution.nu;
    // Harmonics that noise has hidden may show.
    let shape = Shape { harmonics: blocks.lines.harmonics, ..equations.solution.shape };
    // Of each mixture the noise is known: its residuals are as many as its degrees of freedom.
    let known = [equations.frames - shape.unknowns() as f32; CHANNELS_MAX];
    let mut nu = start;
    for step in 1..=STEPS {
        // Residuals of a frequency that noise has moved look as if the noise had a part of the tone: they are taken anew.
        equations.collect(blocks, nu, shape.curves > 0);
        equations.solve(shape, least)?;
        let mixture = neighbourhood(blocks, &equations.solution).mixture?;
        equations.mix(&mixture);
        equations.solve(shape, &known)?;
        let solution = &mut equations.solution;
        nu += solution.step;
        solution.nu = nu;
        if !((nu - start).abs() < MOVE_MAX) {
            return None;
        }
        if step == STEPS || solution.step * solution.step * solution.information < SIGMAS * SIGMAS {
            let count = blocks.count;
            mixture.apply(blocks.rows.get_mut(..count)?.as_flattened_mut());
            return Some(neighbourhood(blocks, &equations.solution));
        }
    }
    None
}

/// Directions that are shared and not the tone's, and the mean power in the others; takes them out of the covariance.
fn directions(covariance: &mut Covariance, of_tone: &[Values; 2], width: usize) -> ([Values; DIRECTIONS], f32) {
    let mut trace = (0..width).map(|c| covariance[c][c]).sum::<f32>();
    let (mut found, mut left) = ([[0.0; CHANNELS_MAX]; DIRECTIONS], width as f32);
    for found in found.as_chunks_mut::<2>().0 {
        for (found, (direction, power)) in found.iter_mut().zip(strongest(covariance)) {
            if !(power * (left - 1.0) > SHARED_MIN * (trace - power)) {
                break;
            }
            (left, trace) = (left - 1.0, trace - power);
            for (row, along) in covariance.iter_mut().zip(&direction) {
                row.iter_mut().zip(&direction).for_each(|(value, other)| *value -= power * along * other);
            }
            let own: f32 = of_tone.iter().map(|wave| dot(wave, &direction)).map(|along| along * along).sum();
            if own < OWN_SHARE {
                *found = direction;
            }
        }
    }
    (found, trace / left)
}

/// The two directions of most power of a covariance, the stronger first, and their power.
fn strongest(covariance: &Covariance) -> [(Values, f32); 2] {
    let mut plane = [covariance[0], covariance[CHANNELS_MAX / 2]];
    let along = |direction: &Values| -> Values { core::array::from_fn(|c| dot(&covariance[c], direction)) };
    for _ in 0..TURNS {
        plane = at_right_angles(plane).map(|direction| along(&direction));
    }
    let [first, second] = at_right_angles(plane);
    let [with_first, with_second] = [along(&first), along(&second)];
    let [one, two, both] = [dot(&first, &with_first), dot(&second, &with_second), dot(&first, &with_second)];
    // Turned within their plane to where they share nothing.
    let angle = 0.5 * libm::atan2f(2.0 * both, one - two);
    let (sin, cos) = (libm::sinf(angle), libm::cosf(angle));
    let turned = |cos: f32, sin: f32| -> (Values, f32) {
        let direction = core::array::from_fn(|c| cos * first[c] + sin * second[c]);
        (direction, cos * cos * one + sin * sin * two + 2.0 * cos * sin * both)
    };
    [turned(cos, sin), turned(-sin, cos)]
}

/// Two vectors of unit length at right angles to each other in the plane of two others.
fn at_right_angles([first, mut second]: [Values; 2]) -> [Values; 2] {
    let unit = |vector: Values| {
        let length = libm::sqrtf(dot(&vector, &vector)).max(f32::MIN_POSITIVE);
        vector.map(|value| value / length)
    };
    let first = unit(first);
    let along = dot(&first, &second);
    second.iter_mut().zip(&first).for_each(|(value, other)| *value -= along * other);
    [first, unit(second)]
}
