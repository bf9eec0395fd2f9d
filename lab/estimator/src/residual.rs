//! What a solution, and the movement that is fitted beside it, leave of the frames.

use crate::blocks::WAVES;
use crate::legendre::legendre;
use crate::limits::{CHANNELS_MAX, DEGREES_MAX, HARMONICS_MAX, UNKNOWNS_MAX};
use crate::phase::cos_sin;
use crate::phase_course::Course;
use crate::pieces::Piece;
use crate::solve::Shape;
use crate::source::Values;

/// How phase and amplitude go beside the fitted course: coefficients by degree, from 1 on.
#[derive(Clone, Copy, Debug)]
pub struct Motion {
    /// Radians of the unit line.
    pub phase: [f32; DEGREES_MAX],
    /// Shares of the amplitude.
    pub amplitude: [f32; DEGREES_MAX],
}

impl Motion {
    /// None.
    pub const NONE: Self = Self {
        phase: [0.0; DEGREES_MAX],
        amplitude: [0.0; DEGREES_MAX],
    };

    /// Phase and amplitude at `u`.
    pub fn at(&self, u: f32) -> [f32; 2] {
        let p = legendre::<{ DEGREES_MAX + 1 }>(u);
        [&self.phase, &self.amplitude]
            .map(|course| course.iter().zip(&p[1..]).map(|(c, p)| c * p).sum())
    }

    /// Coefficients of what it adds to the lines of a solution where phase and amplitude are
    /// `moved`.
    pub fn change(
        lines: &[Values; 2 * HARMONICS_MAX],
        shape: &Shape,
        moved: [f32; 2],
    ) -> [Values; 2 * HARMONICS_MAX] {
        let [phase, amplitude] = moved;
        let mut change = [[0.0; CHANNELS_MAX]; 2 * HARMONICS_MAX];
        for (i, line) in shape.lines.iter().enumerate() {
            let turn = phase * line as f32;
            for k in 0..CHANNELS_MAX {
                let (cos, sin) = (lines[2 * i][k], lines[2 * i + 1][k]);
                change[2 * i][k] = amplitude * cos + turn * sin;
                change[2 * i + 1][k] = amplitude * sin - turn * cos;
            }
        }
        change
    }
}

/// A model of the frames.
#[derive(Clone, Debug)]
pub struct Model {
    /// What was fitted.
    pub shape: Shape,
    /// Its coefficients.
    pub coefficients: [Values; UNKNOWNS_MAX + 1],
    /// What moves beside them.
    pub motion: Option<Motion>,
    /// Phase of the fundamental.
    pub course: Course,
}

/// Coefficients in groups of four.
pub fn padded(coefficients: &[Values; UNKNOWNS_MAX]) -> [Values; UNKNOWNS_MAX + 1] {
    let mut padded = [[0.0; CHANNELS_MAX]; UNKNOWNS_MAX + 1];
    padded[..UNKNOWNS_MAX].copy_from_slice(coefficients);
    padded
}

impl Model {
    /// What is left of a piece.
    pub fn residual(&self, frame: &Piece) -> Values {
        let (c, s) = cos_sin(self.course.at(frame.u, 1.0));
        let mut powers = [[1.0, 0.0]; WAVES];
        for m in 1..=self.shape.lines.most().min(WAVES - 1) {
            let [x, y] = powers[m - 1];
            powers[m] = [x * c - y * s, y * c + x * s];
        }
        let p = legendre::<5>(frame.u);
        let first = self.shape.first_line();
        let [phase, amplitude] = self
            .motion
            .as_ref()
            .map_or([0.0; 2], |motion| motion.at(frame.u));
        let mut weights = [0.0; UNKNOWNS_MAX + 1];
        weights[..first].copy_from_slice(&p[..first]);
        for (i, line) in self.shape.lines.iter().enumerate() {
            let [cos, sin] = powers[line.min(WAVES - 1)];
            let turn = phase * line as f32;
            weights[first + 2 * i] = (1.0 + amplitude) * cos - turn * sin;
            weights[first + 2 * i + 1] = (1.0 + amplitude) * sin + turn * cos;
        }
        let mut values = frame.values;
        let rows = self.coefficients.as_chunks::<4>().0;
        let weights = weights.as_chunks::<4>().0;
        let groups = self.shape.unknowns().div_ceil(4);
        for ([one, two, three, four], [a, b, c, d]) in rows.iter().zip(weights).take(groups) {
            for k in 0..CHANNELS_MAX {
                values[k] -= a * one[k] + b * two[k] + c * three[k] + d * four[k];
            }
        }
        values
    }
}
