//! How phase and amplitude move, and the noise next to the lines: each is estimated beside the
//! other, and degrees are added until none is missing.

use crate::blocks::Blocks;
use crate::comb::{Comb, Work};
use crate::covariance::{Covariance, ROUNDING, Samples, inverse_of};
use crate::limits::{CHANNELS_MAX, DEGREES_MAX, HARMONICS_MAX, MOVES, MOVES_MAX};
use crate::lines::Lines;
use crate::matrix::{Factor, Square};
use crate::neighbours::{Member, Place};
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
    /// Information of the movement.
    pub information: Square<MOVEMENT_MAX>,
    /// Inverse of the information.
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
    /// The movement beside the course.
    pub fn motion(&self) -> Motion {
        let mut motion = Motion::NONE;
        let Degrees { phase, amplitude } = self.degrees;
        motion.phase[..phase].copy_from_slice(&self.moved[..phase]);
        motion.amplitude[..amplitude].copy_from_slice(&self.moved[phase..phase + amplitude]);
        motion
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
    /// Follows a comb; `recollect` passes over the frames again. None if too little noise is known.
    #[inline(never)]
    pub fn follow(
        &self,
        blocks: &mut Blocks,
        work: &mut Work,
        comb: &Comb,
        recollect: &mut dyn FnMut(&mut Blocks, &Course, Lines),
    ) -> Option<Followed> {
        let (mut course, mut shape) = (comb.course, comb.shape);
        let mut fitted = Degrees {
            phase: 1,
            amplitude: 0,
        };
        let mut inverse: Option<Square<CHANNELS_MAX>> = None;
        let mut turn = 0;
        recollect(blocks, &course, self.lines(course.cycles).and(shape.lines));
        loop {
            let steps = Steps {
                shape,
                most: STEPS,
                degrees: fitted.phase,
                weights: inverse.as_ref(),
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
            let followed = self.noise(blocks, work, tone, inverse)?;
            inverse = Some(followed.noise.inverse);
            let Degrees { phase, amplitude } = followed.degrees;
            let phase_shows = followed.shows(fitted.phase, phase) > Z_TEST;
            let amplitude_shows =
                followed.shows(phase + fitted.amplitude, phase + amplitude) > Z_TEST;
            let samples = followed.count as usize * self.width;
            let has_room = (phase + amplitude + 2 * (MOVES - 1)) * SAMPLES_PER_DEGREE < samples;
            let grows = has_room && phase_shows && fitted.phase < MOVES_MAX;
            let fades = has_room && amplitude_shows && fitted.amplitude < MOVES_MAX;
            turn += 1;
            if turn > 1 && !grows && !fades || turn == TURNS {
                return Some(followed);
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
                let comb = self.best(blocks, work, course, &[1, shape.degree]);
                (course, shape) = (comb.course, comb.shape);
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
        inverse: Option<Square<CHANNELS_MAX>>,
    ) -> Option<Followed> {
        let Tone {
            course,
            shape,
            fitted,
        } = tone;
        let solution = Solution::new(blocks, shape);
        let residuals = solution.residuals(self.all, self.width);
        let free = (self.frames - shape.unknowns() as f32).max(1.0);
        let variances: Values = core::array::from_fn(|k| residuals[k][k] / free + ROUNDING);
        let place = Place {
            cycles: course.cycles,
            most: self.cycles_max,
        };
        // Harmonics that are too weak to be kept are no noise either, where there is room without.
        let whole = Shape {
            lines: self.lines(course.cycles).and(shape.lines),
            ..shape
        };
        let mut beside = Solution::new(blocks, whole);
        let neighbours = &mut work.neighbours;
        neighbours.collect(blocks, beside.beside(), shape.lines, place);
        if neighbours.count() < NEIGHBOURS_WHOLE {
            neighbours.collect(blocks, solution.beside(), shape.lines, place);
            beside = solution.clone();
        }
        let count = neighbours.count();
        if count < NEIGHBOURS_MIN {
            return None;
        }
        let degrees = Degrees {
            phase: (fitted.phase + MOVES - 1).min(DEGREES_MAX),
            amplitude: (fitted.amplitude + MOVES).min(DEGREES_MAX),
        };
        let mut counts = [0.0; HARMONICS_MAX];
        for (member, _) in work.neighbours.iter() {
            counts[shape.lines.place(usize::from(member.line))] += 1.0;
        }
        let factors = solution.line_factors();
        let rounds = if inverse.is_some() { 1 } else { 2 };
        let all = count as f32 * self.width as f32;
        let taken = all / (all - degrees.count() as f32).max(1.0);
        let mut weights = inverse.unwrap_or_else(|| inverse_of(&variances, self.width));
        let mut found: Option<Followed> = None;
        for _ in 0..rounds {
            let of_lines = neighbour_weights(shape.lines, &factors, &weights, &counts);
            let normal = Normal::new(blocks, &solution, &weights, degrees, &mut work.explained);
            let n = degrees.count();
            let mut information = normal.matrix;
            let trace: f32 = (0..n).map(|i| information[i][i]).sum();
            for (i, row) in information.iter_mut().enumerate().take(n) {
                row[i] += 1e-7 * trace;
            }
            let factor = Factor::new(&information, n);
            let mut moved = normal.right;
            factor.solve(&mut moved);
            let squares: f32 = counts.iter().zip(&of_lines).map(|(n, w)| n * w * w).sum();
            let effective = (count * count) as f32 / squares.max(f32::MIN_POSITIVE);
            let mut followed = Followed {
                course,
                solution: solution.clone(),
                still: solution.clone(),
                variances,
                fitted,
                degrees,
                moved,
                information,
                covariance: factor.inverse(),
                noise: Covariance {
                    matrix: weights,
                    inverse: weights,
                    shrinkage: 1.0,
                    channels: 1.0,
                },
                weights: of_lines,
                count: count as f32,
                effective,
                taken,
            };
            followed.still = self.without_movement(blocks, work, &followed, &beside.shape);
            let weight = |member: &Member| {
                taken * of_lines[shape.lines.place(usize::from(member.line)) % HARMONICS_MAX]
            };
            let products = work.neighbours.products(&weight);
            let samples = Samples {
                products: &products,
                width: self.width,
                count: count as f32,
                effective,
                may_share: self.may_share,
            };
            followed.noise = samples.covariance(Some(&variances));
            weights = followed.noise.inverse;
            found = Some(followed);
        }
        found
    }

    /// Multiplies the functions next to the lines with the residuals, less the movement.
    fn without_movement(
        &self,
        blocks: &mut Blocks,
        work: &mut Work,
        followed: &Followed,
        beside: &Shape,
    ) -> Solution {
        let (solution, motion) = (&followed.solution, followed.motion());
        let lines = solution.lines();
        let add = |blocks: &mut Blocks, sign: f32| {
            for b in 0..blocks.count() {
                let moved = motion.at(blocks.middle(b)).map(|x| sign * x);
                let change = Motion::change(&lines, &solution.shape, moved);
                blocks.add(b, solution.shape.lines, &change);
            }
        };
        add(blocks, -1.0);
        let still = Solution::new(blocks, solution.shape);
        let beside = Solution::new(blocks, *beside);
        work.neighbours.multiply(blocks, Some(&beside));
        add(blocks, 1.0);
        still
    }
}
