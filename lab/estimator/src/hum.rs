//! A known interferer, mains hum: its frequency is refined near where it is said to be, and its waves
//! are subtracted from the frames. It is in time, also along a path.

use crate::abscissa::Abscissa;
use crate::blocks::{Blocks, Pass};
use crate::comb::Work;
use crate::limits::CHANNELS_MAX;
use crate::lines::Lines;
use crate::phase::cos_sin;
use crate::phase_course::Course;
use crate::pieces::Data;
use crate::refine::{Refinement, Steps};
use crate::search::strongest;
use crate::solve::{Shape, Solution};
use crate::source::Values;

/// How far, as a share of it, its frequency may be from what was said.
const OFF: f32 = 0.02;
/// Cycles a window from where it is said to be in which it is looked for at least.
const OFF_CYCLES: f32 = 0.75;
/// Gauss-Newton steps.
const STEPS: usize = 8;

/// An interferer's wave.
#[derive(Clone, Copy, Debug)]
pub struct Hum {
    course: Course,
    /// Cosine and sine of each channel.
    waves: [Values; 2],
    /// Frames of the window.
    frames: f32,
}

impl Hum {
    /// Cycles per frame.
    pub fn cycles_per_frame(&self) -> f32 {
        self.course.cycles / self.frames
    }

    /// Finds it, where it is said to have `given` cycles per frame, and subtracts it.
    #[inline(never)]
    pub fn take_out(
        data: &mut Data,
        rounding: &Values,
        blocks: &mut Blocks,
        work: &mut Work,
        given: f32,
    ) -> Option<Self> {
        let count = data.pieces.count() as f32;
        let place = data.place;
        data.place = Abscissa::time(data.pieces.count() as u32 * data.each);
        let cycles_max = core::mem::replace(&mut data.cycles_max, 0.5 * count);
        let found = Self::find(data, rounding, blocks, work, given);
        if let Some(hum) = &found {
            data.change(&mut |piece| {
                let (cos, sin) = cos_sin(hum.course.at(piece.u, 1.0));
                for (k, value) in piece.values.iter_mut().enumerate() {
                    *value -= hum.waves[0][k] * cos + hum.waves[1][k] * sin;
                }
            });
        }
        (data.place, data.cycles_max) = (place, cycles_max);
        if found.is_some() {
            data.centre();
        }
        found
    }

    fn find(
        data: &Data,
        rounding: &Values,
        blocks: &mut Blocks,
        work: &mut Work,
        given: f32,
    ) -> Option<Self> {
        let count = data.pieces.count() as f32;
        let turns = given * data.each as f32;
        let turns = turns - libm::floorf(turns);
        let cycles = count * turns.min(1.0 - turns);
        let off = (OFF * given * count * data.each as f32).max(OFF_CYCLES);
        let all = data.products(rounding, true);
        let most = (cycles + off).min(data.cycles_max - 0.5);
        let least = (cycles - off).max(1.0);
        let found = strongest(data, blocks.scratch(), &all.matrix, least, most)?;
        blocks.start(data);
        let mut course = Course::steady(found);
        let lines = Lines::up_to(1);
        let shape = Shape { lines, degree: 1 };
        let refinement = Refinement {
            all: &all,
            width: data.width,
            frames: all.count,
            harmonics: 1,
            may_share: true,
            cycles_max: data.cycles_max,
        };
        for most in [STEPS, 1] {
            let pass = Pass {
                course,
                scale: 1.0,
                lines,
                most: 2,
            };
            blocks.collect(data, &pass);
            let steps = Steps {
                shape,
                most,
                degrees: 1,
                last: 0.02,
                weights: None,
            };
            refinement.refine(blocks, &mut course, steps, &mut work.explained);
        }
        let solution = Solution::new(blocks, shape);
        let first = shape.first_line();
        let mut waves = [[0.0; CHANNELS_MAX]; 2];
        waves.copy_from_slice(&solution.coefficients[first..first + 2]);
        Some(Self {
            course,
            waves,
            frames: count * data.each as f32,
        })
    }
}
