//! A known interferer, mains hum: its frequency is refined near where it is said to be, and its waves
//! are subtracted from the frames. It is in time, also along a path.

use crate::blocks::{Blocks, Pass};
use crate::comb::Work;
use crate::frame_span::FrameSpan;
use crate::impulses::Impulses;
use crate::limits::CHANNELS_MAX;
use crate::lines::Lines;
use crate::phase::cos_sin;
use crate::phase_course::Course;
use crate::refine::{Refinement, Steps};
use crate::search::strongest;
use crate::solve::{Shape, Solution};
use crate::source::{Overwritten, Values};
use crate::statistics::{Data, Frame, Statistics};

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

    /// Subtracts it from a frame.
    pub fn subtract(&self, frame: &mut Frame) {
        let u = (2 * frame.number + 1) as f32 / self.frames - 1.0;
        let (cos, sin) = cos_sin(self.course.at(u, 1.0));
        for (k, value) in frame.values.iter_mut().enumerate() {
            *value -= self.waves[0][k] * cos + self.waves[1][k] * sin;
        }
    }

    /// Finds it in a window.
    #[inline(never)]
    pub fn find(
        span: &mut FrameSpan,
        statistics: &Statistics,
        blocks: &mut Blocks,
        work: &mut Work,
    ) -> Result<Option<Self>, Overwritten> {
        let Some(given) = span.interferer else {
            return Ok(None);
        };
        let abscissa = span.swap_abscissa(None);
        let found = Self::search(span, statistics, blocks, work, given);
        span.swap_abscissa(Some(abscissa));
        found
    }

    fn search(
        span: &mut FrameSpan,
        statistics: &Statistics,
        blocks: &mut Blocks,
        work: &mut Work,
        given: f32,
    ) -> Result<Option<Self>, Overwritten> {
        let frames = span.frames as f32;
        let turns = given - libm::floorf(given);
        let cycles = frames * turns.min(1.0 - turns);
        let off = (OFF * given * frames).max(OFF_CYCLES);
        let all = statistics.products(span, &Impulses::NONE)?;
        let mut data = Data {
            span,
            statistics,
            impulses: &Impulses::NONE,
        };
        let most = (cycles + off).min(data.cycles_max() - 0.5);
        let least = (cycles - off).max(1.0);
        let memory = blocks.scratch();
        let Some(found) = strongest(&mut data, memory, &all.matrix, least, most)? else {
            return Ok(None);
        };
        let mut course = Course::steady(found);
        let lines = Lines::up_to(1);
        let shape = Shape { lines, degree: 1 };
        let refinement = Refinement {
            all: &all,
            width: statistics.width,
            frames: statistics.frames as f32,
            harmonics: 1,
            may_share: true,
            cycles_max: data.cycles_max(),
        };
        for most in [STEPS, 1] {
            let pass = Pass {
                course,
                scale: 1.0,
                lines,
                most: 2,
                model: None,
            };
            blocks.collect(&mut data, &pass)?;
            let steps = Steps {
                shape,
                most,
                degrees: 1,
                weights: None,
            };
            refinement.refine(blocks, &mut course, steps, &mut work.explained);
        }
        let solution = Solution::new(blocks, shape);
        let first = shape.first_line();
        let mut waves = [[0.0; CHANNELS_MAX]; 2];
        waves.copy_from_slice(&solution.coefficients[first..first + 2]);
        Ok(Some(Self {
            course,
            waves,
            frames,
        }))
    }
}
