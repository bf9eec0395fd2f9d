//! Harmonic combs: lines and likelihood of a candidate.

use crate::blocks::Blocks;
use crate::covariance::Samples;
use crate::limits::{BAND, HARMONICS_MAX};
use crate::lines::Lines;
use crate::matrix::{Factor, PIVOT_MIN};
use crate::noise_bins::LineFrequencies;
use crate::refine::{Known, Refinement, Steps};
use crate::solve::{Power, Shape, Solution};
use crate::trajectory::Trajectory;
use crate::workspace::Workspace;

/// Minimum number of noise-bin functions (cosines and sines) for a covariance.
const NOISE_BINS_MIN: usize = 4;

/// A refined candidate.
#[derive(Clone, Copy, Debug)]
pub struct Comb {
    /// Log likelihood less the penalty of the Bayesian information criterion.
    pub score: f32,
    /// Phase of the fundamental.
    pub trajectory: Trajectory,
    pub shape: Shape,
    /// Refined phase of the candidate's unit line.
    pub unit: Trajectory,
    /// Lines that stand out of the local noise, as multiples of `unit`.
    pub kept: Lines,
    /// Best-scoring comb at a different frequency.
    pub competing: CompetingComb,
}

/// A comb at a different frequency.
#[derive(Clone, Copy, Debug)]
pub struct CompetingComb {
    /// Score; in the end, relative to the likeliest comb's.
    pub score: f32,
    /// Cycles per window.
    pub cycles: f32,
}

impl CompetingComb {
    pub const NONE: Self = Self {
        score: f32::NEG_INFINITY,
        cycles: 0.0,
    };
}

impl Refinement<'_> {
    /// Fits the comb at a `trajectory`, to which the blocks are already rotated, with a baseline of
    /// `degree`. Leaves the blocks rotated to the refined unit line.
    #[inline(never)]
    pub fn comb(
        &self,
        blocks: &mut Blocks,
        workspace: &mut Workspace,
        trajectory: &mut Trajectory,
        degree: usize,
    ) -> Comb {
        let all = Shape {
            lines: blocks.lines(),
            degree,
        };
        let steps = Steps {
            noise: Known::Residuals,
            ..Steps::of_comb(all)
        };
        self.refine(blocks, trajectory, steps, workspace);
        workspace.solution.project(blocks, all);
        if self.is_white {
            self.weigh(workspace, self.frames);
        } else {
            self.weigh_by_noise_bins(blocks, workspace, trajectory.cycles);
        }
        workspace.solution.solve();
        let kept = Shape {
            lines: self.lines_there(workspace, trajectory.cycles),
            degree,
        };
        let steps = Steps {
            max: 1,
            ..Steps::of_comb(kept)
        };
        self.refine(blocks, trajectory, steps, workspace);
        workspace.solution.project(blocks, kept);
        let divisor = kept.lines.divisor();
        Comb {
            score: self.score(&workspace.solution),
            trajectory: trajectory.times(divisor as f32),
            shape: Shape {
                lines: kept.lines.over(divisor),
                degree,
            },
            unit: *trajectory,
            kept: kept.lines,
            competing: CompetingComb::NONE,
        }
    }

    /// Selects the lines whose power over the local noise exceeds the Bayesian penalty plus the
    /// power that rounding may add. Of these, returns the line whose multiples have the most power,
    /// with these multiples, or line 1 if no line passes. Aliased lines cannot be the unit line.
    #[inline(never)]
    fn lines_there(&self, workspace: &Workspace, cycles: f32) -> Lines {
        let rounding = self.all.rounding(&workspace.weights, self.width);
        let min = 2.0 * self.width as f32 * libm::logf(self.frames) + rounding;
        let factors = workspace.solution.line_factors();
        let lines = workspace.solution.shape.lines;
        let mut powers = [0.0; HARMONICS_MAX + 1];
        for (line, factors) in lines.iter().zip(&factors) {
            let power = Power::new(factors, &workspace.weights).all;
            if let Some(place) = powers.get_mut(line) {
                *place = if power > min { power } else { 0.0 };
            }
        }
        let own = |line: usize| powers.get(line).copied().unwrap_or_default();
        let there = || lines.iter().filter(|line| own(*line) > 0.0);
        let multiples = |unit: usize| there().filter(move |line| line.is_multiple_of(unit));
        let power = |unit: usize| multiples(unit).map(own).sum::<f32>();
        let mut units = there().filter(|line| *line as f32 * cycles < self.nyquist.max);
        let first = units.next().unwrap_or(1);
        let unit = units.fold(first, |best, unit| {
            if power(unit) > power(best) {
                unit
            } else {
                best
            }
        });
        multiples(unit).fold(Lines::NONE.with(unit), Lines::with)
    }

    /// Finds the likeliest comb at a `trajectory`, with a baseline of one of the `degrees`, whose
    /// fundamental is in the band. Rotates the blocks to its unit line, and keeps its weights if it
    /// is the best comb of the window so far.
    pub fn best(
        &self,
        blocks: &mut Blocks,
        workspace: &mut Workspace,
        trajectory: Trajectory,
        degrees: &[usize],
    ) -> Option<Comb> {
        let (mut at, mut best) = (trajectory, None::<Comb>);
        for degree in degrees {
            // Skip a baseline that does not raise the score at the best trajectory so far.
            if let Some(best) = &best {
                let shape = Shape {
                    lines: best.kept,
                    degree: *degree,
                };
                workspace.solution.project(blocks, shape);
                if self.score(&workspace.solution) <= best.score {
                    continue;
                }
            }
            blocks.turn(&at, &trajectory);
            at = trajectory;
            let comb = self.comb(blocks, workspace, &mut at, *degree);
            if !self.band.has(comb.trajectory.cycles) {
                continue;
            }
            if best.is_none_or(|best| comb.score > best.score) {
                if comb.score > workspace.score_of_best {
                    workspace.score_of_best = comb.score;
                    workspace.keep_weights();
                }
                best = Some(comb);
            }
        }
        if let Some(best) = &best {
            blocks.turn(&at, &best.unit);
        }
        best
    }

    /// Upper bound on the score of any comb at the blocks' trajectory with a baseline of up to
    /// `degree` and at least as many unknowns as `min`: the likelihood of all lines less the
    /// penalty for `min`.
    pub fn bound(
        &self,
        blocks: &Blocks,
        workspace: &mut Workspace,
        degree: usize,
        min: &Shape,
    ) -> f32 {
        let all = Shape {
            lines: blocks.lines(),
            degree,
        };
        workspace.solution.project(blocks, all);
        self.likelihood(&workspace.solution) - self.price(min)
    }

    /// Weights the channels by the noise next to the lines of the projected solution.
    #[inline(never)]
    fn weigh_by_noise_bins(&self, blocks: &Blocks, workspace: &mut Workspace, cycles: f32) {
        let shape = workspace.solution.shape;
        let place = LineFrequencies {
            lines: shape.lines,
            cycles,
            nyquist: self.nyquist,
            band: if shape.lines.count() > 2 {
                BAND / 2
            } else {
                BAND
            },
        };
        let (noise_bins, memory) = (&mut workspace.noise_bins, &mut workspace.memory);
        noise_bins.collect(blocks, workspace.solution.projected(), place, memory);
        if noise_bins.count() < NOISE_BINS_MIN {
            self.weigh(workspace, self.frames);
            return;
        }
        let count = noise_bins.count() as f32;
        noise_bins.products(memory, &|_| 1.0, &mut workspace.weights);
        let samples = Samples {
            width: self.width,
            count,
            effective: count,
            may_share: self.may_share,
        };
        let squares = workspace.solution.squares(self.all);
        let variances = squares.map(|square| (square / self.frames).max(f32::MIN_POSITIVE));
        samples.invert(&mut workspace.weights, Some(&variances));
    }

    /// Log likelihood less the penalty for the unknowns.
    pub fn score(&self, solution: &Solution) -> f32 {
        self.likelihood(solution) - self.price(&solution.shape)
    }

    /// Log likelihood, from the determinant of the residuals' covariance.
    fn likelihood(&self, solution: &Solution) -> f32 {
        let log_det = if self.may_share {
            let mut residuals = solution.residuals(self.all);
            // The part of a channel that the others do not explain is at least its rounding.
            let min =
                core::array::from_fn(|k| self.all.squares_min[k].max(PIVOT_MIN * residuals[k][k]));
            Factor::new(&mut residuals, self.width).log_det_above(&min)
        } else {
            let squares = solution.squares(self.all);
            squares
                .iter()
                .take(self.width)
                .map(|x| libm::logf(*x))
                .sum()
        };
        -0.5 * self.bartlett() * log_det
    }

    /// Penalty for a shape's unknowns, by the Bayesian information criterion.
    fn price(&self, shape: &Shape) -> f32 {
        let unknowns = self.width as f32 * shape.unknowns() as f32 + 1.0;
        0.5 * unknowns * libm::logf(self.frames)
    }

    /// Degrees of freedom of the determinant, after Bartlett.
    fn bartlett(&self) -> f32 {
        let max = crate::limits::UNKNOWNS_MAX as f32 - 2.0;
        (self.frames - max - 0.5 * (self.width as f32 + 1.0)).max(4.0)
    }
}
