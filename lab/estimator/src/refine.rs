//! Gauss-Newton steps to the optimum of the phase: its frequency, and where it moves more degrees.

use crate::blocks::Blocks;
use crate::covariance::Samples;
use crate::limits::{CHANNELS_MAX, MOVES_MAX};
use crate::lines::Lines;
use crate::matrix::{Factor, Square};
use crate::normal::{Degrees, Explained, MOVEMENT_MAX, Normal};
use crate::phase_course::Course;
use crate::solve::{Shape, Solution};
use crate::statistics::Products;

/// Added to the information, as a share of it.
const DAMPING: f32 = 1e-6;
/// Fewest cycles of the unit line.
const CYCLES_LEAST: f32 = 0.4;

/// What the steps need beside the blocks.
pub struct Refinement<'r> {
    /// Products of all channels.
    pub all: &'r Products,
    /// Number of channels.
    pub width: usize,
    /// Frames that count.
    pub frames: f32,
    /// Most harmonics.
    pub harmonics: usize,
    /// Whether channels may share noise.
    pub may_share: bool,
    /// Cycles a window of half the frame rate.
    pub cycles_max: f32,
}

/// What is refined.
#[derive(Clone, Copy, Debug)]
pub struct Steps<'w> {
    /// Lines and baseline.
    pub shape: Shape,
    /// Most steps.
    pub most: usize,
    /// Degrees of the phase.
    pub degrees: usize,
    /// A step of less than this many sigmas is the last.
    pub last: f32,
    /// Inverse covariance of the channels' noise; None is what each step's residuals say.
    pub weights: Option<&'w Square<CHANNELS_MAX>>,
}

impl Refinement<'_> {
    /// The harmonics of a fundamental that are clear of half the frame rate.
    pub fn lines(&self, cycles: f32) -> Lines {
        let is_clear = |line: &usize| *line as f32 * cycles < self.cycles_max - 0.5;
        let most = (1..=self.harmonics).take_while(is_clear).count();
        Lines::up_to(most.max(1))
    }

    /// Steps of `course`, to which the blocks are turned.
    #[inline(never)]
    pub fn refine(
        &self,
        blocks: &mut Blocks,
        course: &mut Course,
        steps: Steps,
        explained: &mut Explained,
    ) {
        let degrees = Degrees {
            phase: steps.degrees.min(MOVES_MAX),
            amplitude: 0,
        };
        let mut own = None;
        for _ in 0..steps.most {
            let solution = Solution::new(blocks, steps.shape);
            let weights = match steps.weights {
                Some(weights) => weights,
                None => &*own.get_or_insert_with(|| self.weights(&solution)),
            };
            let normal = Normal::new(blocks, &solution, weights, degrees, explained);
            let n = degrees.phase;
            let mut damped = normal.matrix;
            for (i, row) in damped.iter_mut().enumerate().take(n) {
                row[i] += DAMPING * row[i] + f32::MIN_POSITIVE;
            }
            let mut step: [f32; MOVEMENT_MAX] = normal.right;
            Factor::new(&damped, n).solve(&mut step);
            let largest = step[..n].iter().map(|x| x.abs()).fold(0.0, f32::max);
            if !largest.is_finite() {
                return;
            }
            let scale = 1.0 / largest.max(1.0);
            step.iter_mut().for_each(|x| *x *= scale);
            let before = *course;
            course.step(&step[..n]);
            course.cycles = course.cycles.clamp(CYCLES_LEAST, self.cycles_max);
            blocks.turn(&before, course);
            let is_last =
                |i: usize| step[i].abs() * libm::sqrtf(normal.matrix[i][i].max(0.0)) < steps.last;
            if (0..n).all(is_last) {
                return;
            }
        }
    }

    /// Inverse covariance of a solution's residuals.
    pub fn weights(&self, solution: &Solution) -> Square<CHANNELS_MAX> {
        let products = solution.residuals(self.all, self.width);
        let samples = Samples {
            products: &products,
            width: self.width,
            count: self.frames,
            effective: self.frames,
            may_share: self.may_share,
        };
        samples.covariance(None).inverse
    }
}
