//! Search for an interferer near its declared frequency.

use super::Hum;
use crate::blocks::{Blocks, Pass};
use crate::domain::Domain;
use crate::lines::Lines;
use crate::refine::{Known, Refinement, Steps};
use crate::scene::Band;
use crate::search::strongest;
use crate::solve::Shape;
use crate::trajectory::Trajectory;
use crate::window_frames::WindowFrames;
use crate::workspace::Workspace;

/// Maximum relative deviation from the declared frequency.
const OFF: f32 = 0.02;
/// Minimum half-width of the search around the declared frequency, cycles per window.
const OFF_CYCLES: f32 = 0.75;
/// Gauss-Newton steps.
const STEPS: usize = 8;

impl Hum {
    /// Finds the hum near `given` cycles per frame and subtracts it from the window.
    #[inline(never)]
    pub fn take_out(
        window: &mut WindowFrames,
        blocks: &mut Blocks,
        workspace: &mut Workspace,
        given: f32,
    ) {
        let time = Domain::time(window.count());
        let domain = core::mem::replace(&mut window.domain, time);
        window.hum = Self::find(window, blocks, workspace, given);
        window.domain = domain;
        if window.hum.is_some() {
            window.centre();
        }
    }

    fn find(
        window: &mut WindowFrames,
        blocks: &mut Blocks,
        workspace: &mut Workspace,
        given: f32,
    ) -> Option<Self> {
        let count = window.count() as f32;
        let turns = given - libm::floorf(given);
        let cycles = count * turns.min(1.0 - turns);
        let off = (OFF * given * count).max(OFF_CYCLES);
        let all = blocks.start(window, 1, true);
        // Frequencies above the transform's Nyquist limit are searched for at their aliases.
        let max = window.cycles_max() / window.frames_each() as f32;
        let centre = 2.0 * max * libm::roundf(0.5 * cycles / max);
        let folded = (cycles - centre).abs();
        let band = (folded - off).max(1.0)..(folded + off).min(max - 0.5);
        let found = strongest(window, workspace.sums(), blocks.scratch(), &all, band)?;
        let mut trajectory = Trajectory::steady(centre + found.copysign(cycles - centre));
        let lines = Lines::up_to(1);
        let shape = Shape { lines, degree: 1 };
        let refinement = Refinement {
            all: &all,
            width: window.width(),
            frames: all.count,
            harmonics: 1,
            may_share: true,
            is_white: false,
            nyquist: window.nyquist(),
            band: Band::default(),
        };
        for max in [STEPS, 1] {
            let pass = Pass {
                trajectory,
                scale: 1.0,
                lines,
                multiple_max: 2,
            };
            blocks.collect(window, &pass, None);
            let steps = Steps {
                shape,
                max,
                degrees: 1,
                last: 0.02,
                noise: Known::Residuals,
            };
            refinement.refine(blocks, &mut trajectory, steps, workspace);
        }
        workspace.solution.project(blocks, shape);
        workspace.solution.solve();
        Some(Self {
            cycles_per_frame: trajectory.cycles / count,
            middle: 0.5 * (count - 1.0),
            waves: *workspace.solution.lines().first_chunk()?,
        })
    }
}
