//! Search for an interferer near its declared frequency.

use super::Hum;
use crate::blocks::{Blocks, Pass};
use crate::data::Data;
use crate::domain::Domain;
use crate::lines::Lines;
use crate::refine::{Known, Refinement, Steps};
use crate::scene::Band;
use crate::search::strongest;
use crate::solve::Shape;
use crate::trajectory::Trajectory;
use crate::work::Work;

/// Maximum deviation of the frequency from the declared one, as a fraction of it.
const OFF: f32 = 0.02;
/// Minimum half-width of the search around the declared frequency, cycles per window.
const OFF_CYCLES: f32 = 0.75;
/// Gauss-Newton steps.
const STEPS: usize = 8;

impl Hum {
    /// Finds it, where it is said to have `given` cycles per frame, and takes it out of the window.
    #[inline(never)]
    pub fn take_out(data: &mut Data, blocks: &mut Blocks, work: &mut Work, given: f32) {
        let time = Domain::time(data.count());
        let domain = core::mem::replace(&mut data.domain, time);
        data.hum = Self::find(data, blocks, work, given);
        data.domain = domain;
        if data.hum.is_some() {
            data.centre();
        }
    }

    fn find(data: &mut Data, blocks: &mut Blocks, work: &mut Work, given: f32) -> Option<Self> {
        let count = data.count() as f32;
        let turns = given - libm::floorf(given);
        let cycles = count * turns.min(1.0 - turns);
        let off = (OFF * given * count).max(OFF_CYCLES);
        let all = blocks.start(data, 1, true);
        // Frequencies that the transform does not reach are where it folds them to.
        let most = data.cycles_max() / data.frames_each() as f32;
        let centre = 2.0 * most * libm::roundf(0.5 * cycles / most);
        let folded = (cycles - centre).abs();
        let band = (folded - off).max(1.0)..(folded + off).min(most - 0.5);
        let found = strongest(data, work.sums(), blocks.scratch(), &all, band)?;
        let mut trajectory = Trajectory::steady(centre + found.copysign(cycles - centre));
        let lines = Lines::up_to(1);
        let shape = Shape { lines, degree: 1 };
        let refinement = Refinement {
            all: &all,
            width: data.width(),
            frames: all.count,
            harmonics: 1,
            may_share: true,
            is_white: false,
            nyquist: data.nyquist(),
            band: Band::default(),
        };
        for most in [STEPS, 1] {
            let pass = Pass {
                trajectory,
                scale: 1.0,
                lines,
                most: 2,
            };
            blocks.collect(data, &pass, None);
            let steps = Steps {
                shape,
                most,
                degrees: 1,
                last: 0.02,
                noise: Known::Residuals,
            };
            refinement.refine(blocks, &mut trajectory, steps, work);
        }
        work.solution.project(blocks, shape);
        work.solution.solve();
        Some(Self {
            cycles_per_frame: trajectory.cycles / count,
            middle: 0.5 * (count - 1.0),
            waves: *work.solution.lines().first_chunk()?,
        })
    }
}
