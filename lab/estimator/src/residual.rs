//! What a solution, and the movement that is fitted beside it, leave of the frames.

use crate::blocks::WAVES;
use crate::data::Frame;
use crate::legendre::{legendre, legendre_after};
use crate::limits::{CHANNELS_MAX, DEGREES_MAX, HARMONICS_MAX};
use crate::phase::cos_sin;
use crate::phase_course::Course;
use crate::solve::{Rows, Solution};
use crate::source::Values;
use core::ops::Range;

/// How phase and amplitude go beside the fitted course: coefficients by degree, from 1 on.
#[derive(Clone, Copy, Debug)]
pub struct Motion {
    /// Radians of the unit line.
    pub phase: [f32; DEGREES_MAX],
    /// Shares of the amplitude.
    pub amplitude: [f32; DEGREES_MAX],
    /// Highest degree.
    pub degrees: usize,
}

impl Motion {
    /// None.
    pub const NONE: Self = Self {
        phase: [0.0; DEGREES_MAX],
        amplitude: [0.0; DEGREES_MAX],
        degrees: 0,
    };

    /// Phase and amplitude at `u`.
    pub fn at(&self, u: f32) -> [f32; 2] {
        let (mut before, mut p) = (0.0, 1.0);
        let [mut phase, mut amplitude] = [0.0; 2];
        let pairs = self.phase.iter().zip(&self.amplitude);
        for (k, (of_phase, of_amplitude)) in pairs.enumerate().take(self.degrees) {
            (before, p) = (p, legendre_after(k, u, [before, p]));
            phase += of_phase * p;
            amplitude += of_amplitude * p;
        }
        [phase, amplitude]
    }

    /// Coefficients of what is added to the lines of a solution where phase and amplitude are
    /// `moved`.
    pub fn change(solution: &Solution, moved: [f32; 2]) -> [Values; 2 * HARMONICS_MAX] {
        let [phase, amplitude] = moved;
        let mut change = [[0.0; CHANNELS_MAX]; 2 * HARMONICS_MAX];
        let pairs = solution.lines().as_chunks::<2>().0;
        for (i, ([cos, sin], line)) in pairs.iter().zip(solution.shape.lines.iter()).enumerate() {
            let turn = phase * line as f32;
            for k in 0..CHANNELS_MAX {
                change[2 * i][k] = amplitude * cos[k] + turn * sin[k];
                change[2 * i + 1][k] = amplitude * sin[k] - turn * cos[k];
            }
        }
        change
    }
}

/// A model of the frames.
#[derive(Clone, Debug)]
pub struct Model<'m> {
    /// What was fitted, solved.
    pub solution: &'m Solution,
    /// What moves beside them.
    pub motion: Option<Motion>,
    /// Phase of the fundamental.
    pub course: Course,
}

impl Model<'_> {
    /// What is left of some channels of a frame.
    pub fn residual(&self, frame: &Frame, channels: Range<usize>, values: &mut Values) {
        let (c, s) = cos_sin(self.course.at(frame.u, 1.0));
        let shape = &self.solution.shape;
        let mut powers = [[1.0, 0.0]; WAVES];
        for m in 1..=shape.lines.most().min(WAVES - 1) {
            let [x, y] = powers[m - 1];
            powers[m] = [x * c - y * s, y * c + x * s];
        }
        let p = legendre::<5>(frame.u);
        let first = shape.first_line();
        let [phase, amplitude] = self
            .motion
            .as_ref()
            .map_or([0.0; 2], |motion| motion.at(frame.u));
        let mut weights = [0.0; size_of::<Rows>() / size_of::<Values>()];
        weights[..first].copy_from_slice(&p[..first]);
        for (i, line) in shape.lines.iter().enumerate() {
            let [cos, sin] = powers[line.min(WAVES - 1)];
            let turn = phase * line as f32;
            weights[first + 2 * i] = (1.0 + amplitude) * cos - turn * sin;
            weights[first + 2 * i + 1] = (1.0 + amplitude) * sin + turn * cos;
        }
        values[channels.clone()].copy_from_slice(&frame.values[channels.clone()]);
        let rows = self.solution.rows.as_chunks::<4>().0;
        let weights = weights.as_chunks::<4>().0;
        let groups = shape.unknowns().div_ceil(4);
        for ([one, two, three, four], [a, b, c, d]) in rows.iter().zip(weights).take(groups) {
            for k in channels.clone() {
                values[k] -= a * one[k] + b * two[k] + c * three[k] + d * four[k];
            }
        }
    }
}
