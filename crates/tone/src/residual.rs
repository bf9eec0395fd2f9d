//! Residuals of the frames after subtracting a solution and its modulation.

use crate::frame::Frame;
use crate::legendre::{baselines, legendre_after};
use crate::limits::{DEGREES_MAX, UNKNOWNS_MAX};
use crate::phase;
use crate::rows::add_rows;
use crate::solve::Solution;
use crate::source::Values;
use crate::trajectory::Trajectory;
use core::ops::Range;

/// Residual phase and amplitude modulation: coefficients by degree, from 1 on.
#[derive(Clone, Copy, Debug, Default)]
pub struct Motion {
    /// Phase of the unit line, radians.
    pub phase: [f32; DEGREES_MAX],
    /// Relative amplitude.
    pub amplitude: [f32; DEGREES_MAX],
    pub degrees: usize,
}

impl Motion {
    /// Phase and relative amplitude at `u`.
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
}

#[derive(Clone, Debug)]
pub struct Model<'m> {
    /// The solved fit.
    pub solution: &'m Solution,
    /// Modulation on top of the solution.
    pub motion: Option<Motion>,
    /// Phase of the fundamental.
    pub trajectory: Trajectory,
}

/// Values of a model's functions, in groups of four.
pub type Functions = [[f32; 4]; UNKNOWNS_MAX.div_ceil(4)];

impl Model<'_> {
    pub fn functions(&self, u: f32) -> Functions {
        let shape = &self.solution.shape;
        let mut multiples = phase::powers(self.trajectory.at(u, 1.0));
        let moved = self.motion.as_ref().map(|motion| motion.at(u));
        let mut functions = [[0.0; 4]; UNKNOWNS_MAX.div_ceil(4)];
        let (levels, lines) = functions
            .as_flattened_mut()
            .split_at_mut(shape.first_line());
        let values = levels.iter_mut().zip(baselines(u));
        values.for_each(|(place, [value, _])| *place = value);
        let pairs = lines.as_chunks_mut::<2>().0.iter_mut();
        let mut next = 0;
        for (pair, line) in pairs.zip(shape.lines.iter()) {
            let [cos, sin] = multiples.nth(line - next).unwrap_or_default();
            next = line + 1;
            *pair = match moved {
                Some([phase, amplitude]) => {
                    let turn = phase * line as f32;
                    [
                        cos + amplitude * cos - turn * sin,
                        sin + amplitude * sin + turn * cos,
                    ]
                }
                None => [cos, sin],
            };
        }
        functions
    }

    /// Residuals of some channels of a frame.
    pub fn residual(&self, frame: &Frame, channels: Range<usize>) -> Values {
        let (functions, mut values) = (self.functions(frame.u), frame.values);
        let groups = channels.start / 4..channels.end.div_ceil(4);
        let rows = self.solution.rows.as_chunks::<4>().0.iter().zip(functions);
        for (rows, [a, b, c, d]) in rows.take(self.solution.shape.unknowns().div_ceil(4)) {
            add_rows(&mut values, groups.clone(), rows, &[[-a, -b], [-c, -d]]);
        }
        values
    }
}
