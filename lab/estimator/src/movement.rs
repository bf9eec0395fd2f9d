//! How phase and amplitude move, and the noise next to the lines: each is estimated beside the
//! other, and degrees are added until none is missing.

use crate::blocks::Blocks;
use crate::comb::Work;
use crate::covariance::{Covariance, ROUNDING, Samples};
use crate::limits::{CHANNELS_MAX, DEGREES_MAX, HARMONICS_MAX, MOVES, MOVES_MAX};
use crate::lines::Lines;
use crate::matrix::{Factor, Square};
use crate::neighbours::{BAND, Member, Place};
use crate::normal::{Degrees, MOVEMENT_MAX, Normal};
use crate::phase_course::Course;
use crate::refine::{Refinement, Steps};
use crate::residual::Motion;
use crate::significance::deviate;
use crate::solve::{LineFactors, Power, Shape, Solution};
use crate::source::Values;
use crate::tests::Z_TEST;

/// Gauss-Newton steps of a turn.
const STEPS: usize = 6;
/// Most turns.
const TURNS: usize = 7;
/// Turns after which the lines are chosen again.
const LINES_AGAIN: [usize; 2] = [2, 4];
/// Fewest functions next to the lines that are enough beside all harmonics.
const NEIGHBOURS_WHOLE: usize = 8;
/// Fewest functions next to the lines that noise is known from.
const NEIGHBOURS_MIN: usize = 3;
/// Samples of noise that a degree needs.
const SAMPLES_PER_DEGREE: usize = 4;
/// Blocks that are turned against each other by more, in radians of the highest line, are collected
/// anew.
const TWIST_MAX: f32 = 0.1;

/// A tone before its movement is known.
#[derive(Clone, Copy, Debug)]
struct Tone {
    course: Course,
    shape: Shape,
    fitted: Degrees,
}

/// A tone with its movement and the noise next to it.
#[derive(Clone, Debug)]
pub struct Followed {
    /// Phase of the fundamental.
    pub course: Course,
    /// The model, and the residuals beside it.
    pub solution: Solution,
    /// The model and residuals with the movement projected out.
    pub still: Solution,
    /// Variances of the residuals over all frames.
    pub variances: Values,
    /// Degrees that are fitted.
    pub fitted: Degrees,
    /// Degrees that were looked at.
    pub degrees: Degrees,
    /// Movement beside the course.
    pub moved: [f32; MOVEMENT_MAX],
    /// How the fitted phase sees the mean frequency, by degree.
    pub seen: [f32; MOVEMENT_MAX],
    /// Covariance of the movement.
    pub covariance: Square<MOVEMENT_MAX>,
    /// The noise next to the lines.
    pub noise: Covariance,
    /// Weight of the neighbourhood of each line, by its place.
    pub weights: [f32; HARMONICS_MAX],
    /// Number of functions next to the lines, and of those of equal weight that tell as much.
    pub count: f32,
    /// Number of equal weight.
    pub effective: f32,
    /// What the movement takes out of the noise.
    pub taken: f32,
}

impl Followed {
    /// Nothing that is followed.
    pub fn none() -> Self {
        Self {
            course: Course::steady(0.0),
            solution: Solution::NONE,
            still: Solution::NONE,
            variances: [0.0; CHANNELS_MAX],
            fitted: Degrees {
                phase: 1,
                amplitude: 0,
            },
            degrees: Degrees {
                phase: 1,
                amplitude: 0,
            },
            moved: [0.0; MOVEMENT_MAX],
            seen: [0.0; MOVEMENT_MAX],
            covariance: [[0.0; MOVEMENT_MAX]; MOVEMENT_MAX],
            noise: Covariance::NONE,
            weights: [0.0; HARMONICS_MAX],
            count: 0.0,
            effective: 0.0,
            taken: 1.0,
        }
    }

    /// Estimates the movement by the noise that is known.
    fn move_by_noise(&mut self, blocks: &Blocks, work: &mut Work) {
        let Self {
            solution,
            noise,
            degrees,
            ..
        } = self;
        let normal = Normal::new(
            blocks,
            solution,
            &noise.inverse,
            *degrees,
            &mut work.explained,
        );
        let n = self.degrees.count();
        let mut information = normal.matrix;
        let trace: f32 = (0..n).map(|i| information[i][i]).sum();
        for (i, row) in information.iter_mut().enumerate().take(n) {
            row[i] += 1e-7 * trace;
        }
        let factor = Factor::new(&information, n);
        self.moved = normal.right;
        factor.solve(&mut self.moved);
        self.seen = core::array::from_fn(|i| if i % 2 == 0 { 1.0 } else { 0.0 });
        Factor::new(&information, self.fitted.phase).solve(&mut self.seen);
        self.covariance = factor.inverse();
    }

    /// The movement beside the course.
    pub fn motion(&self) -> Motion {
        let mut motion = Motion::NONE;
        let Degrees { phase, amplitude } = self.degrees;
        motion.phase[..phase].copy_from_slice(&self.moved[..phase]);
        motion.amplitude[..amplitude].copy_from_slice(&self.moved[phase..phase + amplitude]);
        motion
    }

    /// Adds the movement to the blocks, `sign` times.
    fn add_motion(&self, blocks: &mut Blocks, sign: f32) {
        let (lines, motion) = (self.solution.lines(), self.motion());
        for b in 0..blocks.count() {
            let moved = motion.at(blocks.middle(b)).map(|x| sign * x);
            let change = Motion::change(&lines, &self.solution.shape, moved);
            blocks.add(b, self.solution.shape.lines, &change);
        }
    }

    /// Degrees of freedom of the noise.
    pub fn freedom(&self) -> f32 {
        self.effective * self.noise.channels
    }

    /// Deviate of some unknowns of the movement together.
    fn shows(&self, from: usize, to: usize) -> f32 {
        let n = to - from;
        let mut block = [[0.0; DEGREES_MAX]; DEGREES_MAX];
        let mut moved = [0.0; DEGREES_MAX];
        for i in 0..n {
            moved[i] = self.moved[from + i];
            block[i][..n].copy_from_slice(&self.covariance[from + i][from..to]);
        }
        Factor::new(&block, n).forward(&mut moved);
        let square: f32 = moved[..n].iter().map(|x| x * x).sum();
        deviate(square / n as f32, n as f32, self.freedom())
    }
}

/// Weight of each line's neighbourhood: its share of the information, by its number of functions.
fn neighbour_weights(
    lines: Lines,
    factors: &[LineFactors; HARMONICS_MAX],
    inverse: &Square<CHANNELS_MAX>,
    counts: &[f32; HARMONICS_MAX],
) -> [f32; HARMONICS_MAX] {
    let mut weights = [0.0; HARMONICS_MAX];
    let (mut sum, mut count) = (0.0, 0.0);
    for (i, line) in lines.iter().enumerate() {
        let power = Power::new(&factors[i], inverse).all;
        weights[i] = (line * line) as f32 * power / counts[i].max(1.0);
        sum += counts[i] * weights[i];
        count += counts[i];
    }
    weights.map(|weight| weight * count / sum.max(f32::MIN_POSITIVE))
}

impl Refinement<'_> {
    /// Follows a comb, at which the blocks are, into `followed`; `recollect` passes over the window
    /// again. Whether enough noise is known.
    #[inline(never)]
    pub fn follow(
        &self,
        blocks: &mut Blocks,
        work: &mut Work,
        followed: &mut Followed,
        recollect: &mut dyn FnMut(&mut Blocks, &Course, Lines),
    ) -> bool {
        let (mut course, mut shape) = (followed.course, followed.solution.shape);
        let mut fitted = followed.fitted;
        let mut turn = 0;
        loop {
            let steps = Steps {
                shape,
                most: STEPS,
                degrees: fitted.phase,
                last: 0.02,
                weights: Some(&followed.noise.inverse),
            };
            for _ in 0..2 {
                self.refine(blocks, &mut course, steps, &mut work.explained);
                if blocks.twist() * shape.lines.most() as f32 <= TWIST_MAX {
                    break;
                }
                recollect(blocks, &course, self.lines(course.cycles).and(shape.lines));
            }
            let tone = Tone {
                course,
                shape,
                fitted,
            };
            if !self.noise(blocks, work, tone, followed) {
                return false;
            }
            let Degrees { phase, amplitude } = followed.degrees;
            let phase_shows = followed.shows(fitted.phase, phase) > Z_TEST;
            let amplitude_shows =
                followed.shows(phase + fitted.amplitude, phase + amplitude) > Z_TEST;
            let samples = followed.count as usize * self.width;
            let has_room = (phase + amplitude + 2 * (MOVES - 1)) * SAMPLES_PER_DEGREE < samples;
            let grows = has_room && phase_shows && fitted.phase < MOVES_MAX;
            let fades = has_room && amplitude_shows && fitted.amplitude < MOVES_MAX;
            turn += 1;
            if !grows && !fades || turn == TURNS {
                return true;
            }
            if grows {
                fitted.phase = (fitted.phase + MOVES - 1).min(MOVES_MAX);
            }
            if fades {
                fitted.amplitude = (fitted.amplitude + MOVES - 1).min(MOVES_MAX);
            }
            // Lines that the movement had smeared.
            if fitted.phase > 1 && LINES_AGAIN.contains(&turn) {
                recollect(blocks, &course, self.lines(course.cycles));
                let degrees = [1, shape.degree];
                let count = if shape.degree > 1 { 2 } else { 1 };
                if let Some(comb) = self.best(blocks, work, course, &degrees[..count]) {
                    (course, shape) = (comb.course, comb.shape);
                }
                recollect(blocks, &course, self.lines(course.cycles).and(shape.lines));
            }
        }
    }

    /// The noise next to the lines, and the movement beside the fitted one.
    #[inline(never)]
    fn noise(
        &self,
        blocks: &mut Blocks,
        work: &mut Work,
        tone: Tone,
        followed: &mut Followed,
    ) -> bool {
        let Tone {
            course,
            shape,
            fitted,
        } = tone;
        let solution = Solution::new(blocks, shape);
        let residuals = solution.residuals(self.all, self.width);
        let free = (self.frames - shape.unknowns() as f32).max(1.0);
        let variances: Values = core::array::from_fn(|k| residuals[k][k] / free + ROUNDING);
        let degrees = Degrees {
            phase: (fitted.phase + MOVES - 1).min(DEGREES_MAX),
            amplitude: (fitted.amplitude + MOVES).min(DEGREES_MAX),
        };
        followed.degrees = degrees;
        followed.fitted = fitted;
        followed.solution = solution;
        followed.move_by_noise(blocks, work);
        followed.course = course;
        followed.variances = variances;
        self.collect_beside(blocks, work, followed);
        let count = work.neighbours.count();
        if count < NEIGHBOURS_MIN {
            return false;
        }
        let mut counts = [0.0; HARMONICS_MAX];
        for (member, _) in work.neighbours.iter() {
            counts[shape.lines.place(usize::from(member.line))] += 1.0;
        }
        let factors = followed.solution.line_factors();
        let of_lines = neighbour_weights(shape.lines, &factors, &followed.noise.inverse, &counts);
        let squares: f32 = counts.iter().zip(&of_lines).map(|(n, w)| n * w * w).sum();
        let all = count as f32 * self.width as f32;
        followed.weights = of_lines;
        followed.count = count as f32;
        followed.effective = (count * count) as f32 / squares.max(f32::MIN_POSITIVE);
        followed.taken = all / (all - degrees.count() as f32).max(1.0);
        let weight = |member: &Member| {
            followed.taken * of_lines[shape.lines.place(usize::from(member.line)) % HARMONICS_MAX]
        };
        let products = work.neighbours.products(&weight);
        let samples = Samples {
            products: &products,
            width: self.width,
            count: followed.count,
            effective: followed.effective,
            may_share: self.may_share,
        };
        followed.noise = samples.covariance(Some(&variances));
        followed.move_by_noise(blocks, work);
        true
    }

    /// Collects the functions next to the lines, less the movement, and the model without it.
    fn collect_beside(&self, blocks: &mut Blocks, work: &mut Work, followed: &mut Followed) {
        let (shape, cycles) = (followed.solution.shape, followed.course.cycles);
        followed.add_motion(blocks, -1.0);
        followed.still = Solution::new(blocks, shape);
        // Harmonics that are too weak to be kept are no noise either, where there is room without.
        let whole = Shape {
            lines: self.lines(cycles).and(shape.lines),
            ..shape
        };
        let place = Place {
            cycles,
            most: self.cycles_max,
            band: BAND,
        };
        let neighbours = &mut work.neighbours;
        if whole.lines != shape.lines {
            let beside = Solution::new(blocks, whole);
            neighbours.collect(blocks, beside.beside(), shape.lines, place);
        }
        if whole.lines == shape.lines || neighbours.count() < NEIGHBOURS_WHOLE {
            neighbours.collect(blocks, followed.still.beside(), shape.lines, place);
        }
        followed.add_motion(blocks, 1.0);
    }
}
