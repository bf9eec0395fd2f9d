//! Gauss-Newton steps to the optimum of the phase: its frequency, and higher degrees if modulated.

use crate::blocks::Blocks;
use crate::covariance::{Covariance, Samples};
use crate::limits::MOVES_MAX;
use crate::lines::Lines;
use crate::matrix::Factor;
use crate::noise_bins::APART;
use crate::normal::Degrees;
use crate::nyquist::Nyquist;
use crate::scene::Band;
use crate::solve::Shape;
use crate::statistics::Products;
use crate::trajectory::Trajectory;
use crate::workspace::Workspace;

/// Maximum number of steps per refinement of a comb.
const STEPS: usize = 2;
/// Damping, as a fraction of the information.
const DAMPING: f32 = 1e-6;
/// Minimum number of cycles of the unit line.
const CYCLES_MIN: f32 = 0.4;

/// Inputs of the steps, apart from the blocks.
pub struct Refinement<'r> {
    pub all: &'r Products,
    /// Number of channels.
    pub width: usize,
    /// Number of valid frames.
    pub frames: f32,
    pub harmonics: usize,
    /// True if channels may share noise.
    pub may_share: bool,
    pub is_white: bool,
    pub nyquist: Nyquist,
    /// Allowed band of the fundamental, cycles per window.
    pub band: Band,
}

/// Model to refine, and when to stop.
#[derive(Clone, Copy, Debug)]
pub struct Steps {
    pub shape: Shape,
    pub max: usize,
    /// Degrees of the phase.
    pub degrees: usize,
    /// Stops after a step of less than this many sigmas.
    pub last: f32,
    /// Source of the channels' noise covariance.
    pub noise: Known,
}

impl Steps {
    /// Steps of a comb's frequency with known weights.
    pub fn of_comb(shape: Shape) -> Self {
        Self {
            shape,
            max: STEPS,
            degrees: 1,
            last: 1.0,
            noise: Known::Weights,
        }
    }
}

/// Source of the channels' noise covariance.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Known {
    /// Covariance of the residuals at the first step.
    Residuals,
    /// The existing inverse covariance.
    Weights,
}

impl Refinement<'_> {
    /// Harmonics of a fundamental whose apparent frequencies are clear of zero, of half the frame
    /// rate and, if aliased, of each other.
    pub fn lines(&self, cycles: f32) -> Lines {
        let seen = |line: usize| self.nyquist.seen(line as f32 * cycles);
        (2..=self.harmonics).fold(Lines::up_to(1), |lines, line| {
            let at = line as f32 * cycles;
            let is_apart = |other: usize| (seen(other) - seen(line)).abs() > APART;
            let is_below = at < self.nyquist.max;
            if self.nyquist.is_clear(at) && (is_below || lines.iter().all(is_apart)) {
                lines.with(line)
            } else {
                lines
            }
        })
    }

    /// Refines a `trajectory`, to which the blocks are rotated before and after.
    #[inline(never)]
    pub fn refine(
        &self,
        blocks: &mut Blocks,
        trajectory: &mut Trajectory,
        steps: Steps,
        workspace: &mut Workspace,
    ) {
        let n = steps.degrees.min(MOVES_MAX);
        for number in 0..steps.max {
            workspace.solution.project(blocks, steps.shape);
            if number == 0 && steps.noise == Known::Residuals {
                self.weigh(workspace, self.frames);
            }
            workspace.solution.solve();
            let normal = &mut workspace.normal;
            normal.degrees = Degrees {
                phase: n,
                amplitude: 0,
            };
            let memory = workspace.memory.as_flattened_mut();
            normal.make(blocks, &workspace.solution, &workspace.weights, memory);
            let mut information = [0.0; MOVES_MAX];
            for i in 0..n {
                information[i] = normal.matrix[i][i];
                normal.matrix[i][i] += DAMPING * information[i] + f32::MIN_POSITIVE;
            }
            Factor::new(&mut normal.matrix, n).solve(&mut normal.right);
            let step = &mut normal.right[..n];
            let largest = step.iter().map(|x| x.abs()).fold(0.0, f32::max);
            if !largest.is_finite() {
                return;
            }
            let scale = 1.0 / largest.max(1.0);
            step.iter_mut().for_each(|x| *x *= scale);
            let before = *trajectory;
            trajectory.step(step);
            // Not `clamp`, which may panic.
            trajectory.cycles = trajectory.cycles.max(CYCLES_MIN).min(self.nyquist.max);
            blocks.turn(&before, trajectory);
            let mut sizes = step.iter().zip(&information);
            if sizes.all(|(step, x)| step.abs() * crate::sqrt(x.max(0.0)) < steps.last) {
                return;
            }
        }
    }

    /// Weights the channels by the inverse covariance of the projected solution's residuals,
    /// estimated from `count` samples.
    #[inline(never)]
    pub fn weigh(&self, workspace: &mut Workspace, count: f32) -> Covariance {
        workspace.weights = workspace.solution.residuals(self.all);
        let samples = Samples {
            width: self.width,
            count,
            effective: count,
            may_share: self.may_share,
        };
        samples.invert(&mut workspace.weights, None)
    }
}
