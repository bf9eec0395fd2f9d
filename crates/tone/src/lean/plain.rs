//! Tests of a lean fit in a scene that may contain more: do the frames contain only what was
//! fitted?
//!
//! [`declaration`](super::declaration) tests the blocks; these tests read the frames once more.
//! Noise of a different colour correlates adjacent residuals. Noise that channels share scatters
//! the score of the phase more than the channels' variances predict. A tone that moves or fades
//! leaves a trend along the window. A false alarm costs instructions but no accuracy: the window is
//! then fitted with all that the scene may contain.

use super::blocks::{LINES, add_line};
use super::declaration::{PARTS, Tested};
use super::reference::Reference;
use super::solve::Solution;
use crate::fit::Movement;
use crate::frame_span::{FrameSpan, READ_FRAMES};
use crate::impulses::Z_IMPULSE;
use crate::legendre::legendre;
use crate::limits::CHANNELS_MAX;
use crate::phase::{Wave, cos_sin, from_turns, times};
use crate::significance::{deviate, square_root};
use crate::source::{Overwritten, Values};
use core::f32::consts::{FRAC_1_PI, PI};

/// Threshold of each test: one in a hundred by chance.
const Z: f32 = 2.33;
/// Threshold for each of some seven tests of one kind: one in a hundred by chance for all of them.
pub const Z_OF_SEVEN: f32 = 2.98;
/// Highest degree of a trend of phase or amplitude.
const DEGREE: usize = 4;

/// A lean fit whose frames are tested.
pub struct Fitted<'f> {
    pub reference: &'f Reference,
    pub tested: Tested<'f>,
    /// Cycles per window.
    pub cycles: f32,
}

/// Outcome of the tests.
pub struct Plain {
    /// Largest deviate, and that of the [`PARTS`].
    worst: f32,
    part: f32,
    has_impulse: bool,
    /// Step from the fit to the optimum over the frames, cycles per window.
    pub step: f32,
    /// Coefficients of the phase's trend by degree, radians.
    phase: [f32; DEGREE + 1],
    /// Information on the phase, one over radians squared.
    information: f32,
}

impl Plain {
    /// True if the frames contain only what was fitted.
    pub fn is_met(&self) -> bool {
        self.worst <= Z && self.part <= Z_OF_SEVEN && !self.has_impulse
    }

    /// Movement of a tone of `cycles` cycles per window. `per_unit` converts a slope by `u`.
    pub fn movement(&self, cycles: f32, per_unit: f32) -> Movement {
        let variance = 1.0 / self.information;
        let [_, _, second, third, fourth] = self.phase;
        // Mean squares of the derivatives of the Legendre polynomials.
        let squares = [second * second, third * third, fourth * fourth];
        let square = dot(&squares, &[3.0, 6.0, 10.0]) + 6.0 * second * fourth;
        let noise = variance * dot(&[5.0, 7.0, 9.0], &[3.0, 6.0, 10.0]);
        let unit = PI * cycles;
        Movement {
            wander: crate::sqrt((square - noise).max(0.0)) / unit,
            wander_sigma: crate::sqrt(noise) / unit,
            // Least-squares slope of the frequency.
            chirp: 3.0 * FRAC_1_PI * (second + fourth) * per_unit,
            chirp_sigma: 3.0 * FRAC_1_PI * crate::sqrt(14.0 * variance) * per_unit,
        }
    }
}

fn dot<const N: usize>(a: &[f32; N], b: &[f32; N]) -> f32 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Reads the frames and tests the residuals of a fit. `memory` has [`READ_FRAMES`] rows, and two
/// more for each of [`PARTS`].
#[inline(never)]
pub fn test(
    span: &mut FrameSpan,
    fitted: &Fitted,
    memory: &mut [Values],
) -> Result<Plain, Overwritten> {
    let mut sums = Sums::new(span.frames, fitted, memory);
    span.visit(fitted.reference.wanted, &mut |number, values| {
        sums.add(number, values, fitted);
    })?;
    Ok(sums.outcome(fitted))
}

/// Sums over the frames.
struct Sums<'m> {
    /// Phase step per frame, and phase at the window's centre.
    step: u32,
    centre: u32,
    /// Step of `u` per frame.
    u_step: f32,
    frames: f32,
    /// Number of the next frame, and residuals of the latest one.
    next: u32,
    latest: Values,
    /// Largest squared residual, relative to the channel's variance.
    square_max: f32,
    /// Products of adjacent residuals, and their number.
    adjacent: f32,
    pairs: f32,
    /// Scores of phase and amplitude, by degree of a trend.
    phase: [f32; DEGREE + 1],
    fading: [f32; DEGREE + 1],
    /// Sums of the phase's squared scores, of its information, and of the squared information.
    squares: f32,
    information: f32,
    information_squares: f32,
    /// Information on the amplitude.
    power: f32,
    /// Phase steps per frame of lines of lower fundamentals, and the residuals' products with their
    /// cosines and sines.
    parts: [u32; PARTS.len()],
    part_count: usize,
    of_parts: &'m mut [[Values; 2]],
    /// Residuals of consecutive frames that are not in these products yet, and their number.
    waiting: &'m mut [Values],
    waiting_count: usize,
}

impl<'m> Sums<'m> {
    #[inline(always)]
    fn new(count: u32, fitted: &Fitted, memory: &'m mut [Values]) -> Self {
        let (waiting, rows) = memory.split_at_mut(READ_FRAMES.min(memory.len()));
        let of_parts = rows.as_chunks_mut().0;
        let places = of_parts.iter_mut().take(PARTS.len());
        places.for_each(|place| *place = [[0.0; CHANNELS_MAX]; 2]);
        let frames = count as f32;
        let cycles = fitted.cycles;
        let mut sums = Self {
            step: from_turns(cycles / frames),
            centre: from_turns(0.5 * cycles * (frames - 1.0) / frames),
            u_step: 2.0 / frames,
            frames: 0.0,
            next: u32::MAX,
            latest: [0.0; CHANNELS_MAX],
            square_max: 0.0,
            adjacent: 0.0,
            pairs: 0.0,
            phase: [0.0; DEGREE + 1],
            fading: [0.0; DEGREE + 1],
            squares: 0.0,
            information: 0.0,
            information_squares: 0.0,
            power: 0.0,
            parts: [0; PARTS.len()],
            part_count: 0,
            of_parts,
            waiting,
            waiting_count: 0,
        };
        let Tested {
            solution,
            place,
            harmonics,
        } = fitted.tested;
        let tested = solution
            .orders()
            .get(place)
            .map_or(1.0, |order| *order as f32)
            * cycles;
        for (part, needed) in PARTS {
            if needed <= harmonics
                && part * tested < 0.5 * frames
                && let Some(place) = sums.parts.get_mut(sums.part_count)
            {
                *place = from_turns(part * tested / frames);
                sums.part_count += 1;
            }
        }
        sums
    }

    #[inline(always)]
    fn add(&mut self, number: u32, values: &Values, fitted: &Fitted) {
        let Solution {
            coefficients,
            weights,
            ..
        } = fitted.tested.solution;
        let u = (number as f32 + 0.5) * self.u_step - 1.0;
        let phase = self.step.wrapping_mul(number).wrapping_sub(self.centre);
        let orders = fitted.tested.solution.orders();
        let waves = multiples(phase);
        let [mut score, mut information, mut fading, mut power] = [0.0f32; 4];
        let (mut adjacent, mut square_max) = (0.0, self.square_max);
        let mut rest = [0.0; CHANNELS_MAX];
        for (c, rest) in rest.iter_mut().enumerate() {
            *rest = values[c] - fitted.reference.level[c];
        }
        fitted.reference.clear(&mut rest);
        for group in 0..CHANNELS_MAX / 4 {
            let part = |values: &Values| values.as_chunks::<4>().0[group];
            let (levels, slopes) = (part(&coefficients[0]), part(&coefficients[1]));
            let (mut tone, mut slope) = ([0.0; 4], [0.0; 4]);
            let pairs = coefficients[2..].as_chunks::<2>().0;
            for ([cosines, sines], order) in pairs.iter().zip(orders) {
                let [c, s] = waves[order % waves.len()];
                let times = *order as f32;
                let (cosines, sines) = (part(cosines), part(sines));
                for k in 0..4 {
                    tone[k] += c * cosines[k] + s * sines[k];
                    slope[k] += times * (c * sines[k] - s * cosines[k]);
                }
            }
            let (weights, latest) = (part(weights), part(&self.latest));
            let rest = &mut rest.as_chunks_mut::<4>().0[group];
            for k in 0..4 {
                let left = rest[k] - levels[k] - u * slopes[k] - tone[k];
                let weighted = weights[k] * left;
                score += weighted * slope[k];
                information += weights[k] * (slope[k] * slope[k]);
                fading += weighted * tone[k];
                power += weights[k] * (tone[k] * tone[k]);
                adjacent += weighted * latest[k];
                let square = weighted * left;
                if square > square_max {
                    square_max = square;
                }
                rest[k] = left;
            }
        }
        if number == self.next {
            self.adjacent += adjacent;
            self.pairs += 1.0;
        } else {
            self.add_parts();
        }
        (self.next, self.latest, self.square_max) = (number + 1, rest, square_max);
        let polynomials = legendre::<{ DEGREE + 1 }>(u);
        for (d, value) in polynomials.iter().enumerate() {
            self.phase[d] += score * value;
            self.fading[d] += fading * value;
        }
        self.squares += score * score;
        self.information += information;
        self.information_squares += information * information;
        self.power += power;
        self.frames += 1.0;
        if let Some(place) = self.waiting.get_mut(self.waiting_count) {
            *place = rest;
            self.waiting_count += 1;
        }
        if self.waiting_count == READ_FRAMES {
            self.add_parts();
        }
    }

    /// Adds the waiting residuals to the products with the lines of lower fundamentals.
    #[inline(never)]
    fn add_parts(&mut self) {
        let waiting = self.waiting.get(..self.waiting_count).unwrap_or_default();
        let first = self.next.wrapping_sub(self.waiting_count as u32);
        let steps = self.parts.iter().take(self.part_count);
        for (step, rows) in steps.zip(&mut *self.of_parts) {
            let (turn_cos, turn_sin) = cos_sin(*step);
            let (c, s) = cos_sin(step.wrapping_mul(first));
            let (mut wave, mut waves) = ([c, s], [[0.0; 2]; READ_FRAMES]);
            for place in &mut waves {
                *place = wave;
                wave = times(wave, [turn_cos, turn_sin]);
            }
            add_line(waiting, &waves, rows);
        }
        self.waiting_count = 0;
    }

    fn outcome(&mut self, fitted: &Fitted) -> Plain {
        self.add_parts();
        let solution = fitted.tested.solution;
        let width = fitted.reference.width as f32;
        let freedom = width * solution.freedom;
        // Each fitted function lowers the residuals' correlation by its own: add that back.
        let orders = solution.orders().iter();
        let cosines = orders.map(|order| cos_sin(self.step.wrapping_mul(*order as u32)).0);
        let taken = 2.0 * cosines.sum::<f32>();
        let adjacent = self.adjacent + width * (2.0 + taken);
        let colour = f32::abs(adjacent) / square_root((width * self.pairs).max(1.0));
        let shared = deviate(
            self.squares / self.information,
            self.information * self.information / self.information_squares,
            freedom,
        );
        let degrees = [1.0, 3.0, 5.0, 7.0, 9.0];
        let trend = |scores: &[f32; DEGREE + 1], first: usize, information: f32| {
            let terms = scores.iter().zip(&degrees).skip(first);
            let square: f32 = terms.map(|(score, degree)| score * score * degree).sum();
            let count = (DEGREE + 1 - first) as f32;
            deviate(square / (information * count), count, freedom)
        };
        let worst = colour
            .max(shared)
            .max(trend(&self.phase, 2, self.information))
            .max(trend(&self.fading, 1, self.power));
        let mut part = 0.0f32;
        for [cosines, sines] in self.of_parts.iter().take(self.part_count) {
            let pairs = cosines.iter().zip(sines).zip(&solution.weights);
            let power: f32 = pairs.map(|((c, s), weight)| weight * (c * c + s * s)).sum();
            let ratio = power / (width * self.frames);
            part = part.max(deviate(ratio, 2.0 * width, freedom));
        }
        let mut phase = self.phase;
        for (score, degree) in phase.iter_mut().zip(degrees) {
            *score *= degree / self.information;
        }
        let turn = self.phase[1] * solution.turn_sigma * solution.turn_sigma;
        Plain {
            worst,
            part,
            has_impulse: self.square_max > Z_IMPULSE * Z_IMPULSE,
            step: turn * FRAC_1_PI,
            phase,
            information: self.information,
        }
    }
}

/// Cosine and sine of the multiples 0 to 4 of a phase.
fn multiples(phase: u32) -> [Wave; LINES + 1] {
    let (c, s) = cos_sin(phase);
    let mut waves = [[1.0, 0.0]; LINES + 1];
    for m in 1..waves.len() {
        waves[m] = times(waves[m - 1], [c, s]);
    }
    waves
}
