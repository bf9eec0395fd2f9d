//! A comb: which of a candidate's harmonics are there, and how likely it is.

use crate::blocks::Blocks;
use crate::covariance::Samples;
use crate::limits::CHANNELS_MAX;
use crate::lines::Lines;
use crate::matrix::{Factor, Square};
use crate::neighbours::{BAND, Neighbours, Place};
use crate::normal::Explained;
use crate::phase_course::Course;
use crate::refine::{Refinement, Steps};
use crate::solve::{Power, Shape, Solution};

/// Gauss-Newton steps before and after the harmonics are chosen.
const STEPS: usize = 2;
/// Fewest functions next to the lines that a covariance is taken from.
const NEIGHBOURS_MIN: usize = 4;

/// A candidate after its refinement.
#[derive(Clone, Debug)]
pub struct Comb {
    /// Logarithm of its likelihood, less the Bayesian criterion's price.
    pub score: f32,
    /// Phase of the fundamental.
    pub course: Course,
    /// Its lines, and the baseline.
    pub shape: Shape,
    /// Cycles a window of the unit that was tried, after its refinement.
    pub tried: f32,
    /// Those of the lines that were tried that are there.
    pub kept: Lines,
    /// Inverse covariance of the noise next to its lines.
    pub weights: Square<CHANNELS_MAX>,
}

/// Memory of the steps.
#[derive(Debug)]
pub struct Work {
    /// Functions next to the lines.
    pub neighbours: Neighbours,
    /// What the model explains of the movement's.
    pub explained: Explained,
}

impl Work {
    /// All zeros.
    pub const fn new() -> Self {
        Self {
            neighbours: Neighbours::new(),
            explained: Explained::new(),
        }
    }
}

impl Refinement<'_> {
    /// The comb at `course`, to which the blocks are turned, with a baseline of `degree`. The
    /// blocks stay at the refined unit line.
    #[inline(never)]
    pub fn comb(
        &self,
        blocks: &mut Blocks,
        work: &mut Work,
        course: &mut Course,
        degree: usize,
    ) -> Comb {
        let all = Shape {
            lines: blocks.lines(),
            degree,
        };
        let steps = Steps {
            shape: all,
            most: STEPS,
            degrees: 1,
            last: 0.1,
            weights: None,
        };
        self.refine(blocks, course, steps, &mut work.explained);
        let solution = Solution::new(blocks, all);
        let weights = self.local(blocks, &mut work.neighbours, &solution, course.cycles);
        let least = 2.0 * self.width as f32 * libm::logf(self.frames);
        let is_there = |(_, factors): &(usize, &_)| Power::new(factors, &weights).all > least;
        let factors = solution.line_factors();
        let mut lines = all
            .lines
            .iter()
            .zip(&factors)
            .filter(is_there)
            .fold(Lines::NONE, |lines, (line, _)| lines.with(line));
        if lines == Lines::NONE {
            lines = lines.with(1);
        }
        let kept = Shape { lines, degree };
        let steps = Steps {
            shape: kept,
            most: 1,
            weights: Some(&weights),
            ..steps
        };
        self.refine(blocks, course, steps, &mut work.explained);
        let divisor = lines.divisor();
        Comb {
            score: self.score(&Solution::new(blocks, kept)),
            course: course.times(divisor as f32),
            shape: Shape {
                lines: lines.over(divisor),
                degree,
            },
            tried: course.cycles,
            kept: lines,
            weights,
        }
    }

    /// The likeliest of a comb that is known and of those at `course` with baselines of some degrees.
    pub fn best(
        &self,
        blocks: &mut Blocks,
        work: &mut Work,
        course: Course,
        degrees: &[usize],
    ) -> Option<Comb> {
        let (mut at, mut best) = (course, None::<Comb>);
        for degree in degrees {
            // A baseline that explains nothing at the best course so far explains nothing at all.
            if let Some(best) = &best {
                let shape = Shape {
                    lines: best.kept,
                    degree: *degree,
                };
                if self.score(&Solution::new(blocks, shape)) <= best.score {
                    continue;
                }
            }
            blocks.turn(&at, &course);
            at = course;
            let comb = self.comb(blocks, work, &mut at, *degree);
            if best.as_ref().is_none_or(|best| comb.score > best.score) {
                best = Some(comb);
            }
        }
        best
    }

    /// A bound of the scores of all combs at the blocks' course with a baseline of up to `degree`: what
    /// all lines explain, at the price of two.
    pub fn bound(&self, blocks: &Blocks, degree: usize) -> f32 {
        let all = Shape {
            lines: blocks.lines(),
            degree,
        };
        let two = Shape {
            lines: Lines::up_to(2),
            degree: 1,
        };
        self.likelihood(&Solution::new(blocks, all)) - self.price(&two)
    }

    /// Inverse covariance of the noise next to the lines.
    fn local(
        &self,
        blocks: &Blocks,
        neighbours: &mut Neighbours,
        solution: &Solution,
        cycles: f32,
    ) -> Square<CHANNELS_MAX> {
        let shape = &solution.shape;
        let place = Place {
            cycles,
            most: self.cycles_max,
            band: if shape.lines.count() > 2 {
                BAND / 2
            } else {
                BAND
            },
        };
        neighbours.collect(blocks, solution.beside(), shape.lines, place);
        if neighbours.count() < NEIGHBOURS_MIN {
            return self.weights(solution);
        }
        let products = neighbours.products(&|_| 1.0);
        let count = neighbours.count() as f32;
        let samples = Samples {
            products: &products,
            width: self.width,
            count,
            effective: count,
            may_share: self.may_share,
        };
        let residuals = solution.residuals(self.all, self.width);
        let variances =
            core::array::from_fn(|k| (residuals[k][k] / self.frames).max(f32::MIN_POSITIVE));
        samples.covariance(Some(&variances)).inverse
    }

    /// Logarithm of the likelihood, less the price of the unknowns.
    pub fn score(&self, solution: &Solution) -> f32 {
        self.likelihood(solution) - self.price(&solution.shape)
    }

    /// Logarithm of the likelihood, by the determinant of the residuals' covariance.
    fn likelihood(&self, solution: &Solution) -> f32 {
        let residuals = solution.residuals(self.all, self.width);
        let log_det = if self.may_share {
            Factor::new(&residuals, self.width).log_det()
        } else {
            (0..self.width).map(|k| libm::logf(residuals[k][k])).sum()
        };
        -0.5 * self.bartlett() * log_det
    }

    /// Price of the unknowns by the Bayesian criterion.
    fn price(&self, shape: &Shape) -> f32 {
        let unknowns = self.width as f32 * shape.unknowns() as f32 + 1.0;
        0.5 * unknowns * libm::logf(self.frames)
    }

    /// Degrees of freedom of the determinant, after Bartlett.
    fn bartlett(&self) -> f32 {
        let most = crate::limits::UNKNOWNS_MAX as f32 - 2.0;
        (self.frames - most - 0.5 * (self.width as f32 + 1.0)).max(4.0)
    }
}
