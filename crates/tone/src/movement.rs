//! Estimates phase and amplitude modulation jointly with the noise next to the lines, adding
//! degrees until the next ones are not significant.

use crate::blocks::Blocks;
use crate::covariance::{Covariance, ROUNDING, Samples};
use crate::limits::{BAND, CHANNELS_MAX, DEGREES_MAX, HARMONICS_MAX, MOVES, MOVES_MAX};
use crate::lines::Lines;
use crate::matrix::{Factor, Square, invert};
use crate::noise_bins::{LineFrequencies, Member};
use crate::normal::{Degrees, MOVEMENT_MAX, degrees_max};
use crate::refine::{Known, Refinement, Steps};
use crate::residual::Motion;
use crate::significance::{Z_TEST, deviate};
use crate::solve::{Power, Shape, Solution};
use crate::source::Values;
use crate::trajectory::Trajectory;
use crate::workspace::Workspace;
use core::ops::Range;

/// Gauss-Newton steps per iteration.
const STEPS: usize = 6;
/// Maximum number of iterations.
const TURNS: usize = 7;
/// Minimum number of iterations. The first takes the noise next to a comb that is not yet at its
/// optimum. With a second, only a third as many outliers, from tones that start or end in the
/// window, are reported as good.
const TURNS_MIN: usize = 2;
/// Iterations after which the lines are chosen again.
const LINES_AGAIN: [usize; 2] = [2, 4];
/// Threshold for subtracting modulation from the noise; chance exceeds it once in twenty. Missing
/// real modulation costs more than subtracting spurious modulation.
const Z_TAKEN: f32 = 1.64;
/// Minimum number of noise-bin functions with all harmonics in the model; with fewer, the model has
/// only the tone's lines.
const NOISE_BINS_WHOLE: usize = 8;
/// Minimum number of noise-bin functions for a noise estimate.
const NOISE_BINS_MIN: usize = 3;
/// Noise samples required per degree.
const SAMPLES_PER_DEGREE: usize = 4;
/// Maximum rotation between adjacent blocks, radians of the highest line, before the blocks are
/// collected again.
pub const TWIST_MAX: f32 = 0.1;

/// A tone with its modulation and local noise; its solution, the modulation's covariance and the
/// noise weights are in the [`Workspace`].
#[derive(Clone, Debug)]
pub struct Followed {
    /// Phase of the fundamental.
    pub trajectory: Trajectory,
    pub shape: Shape,
    /// Variances of the residuals over all frames.
    pub variances: Values,
    /// Degrees that are fitted.
    pub fitted: Degrees,
    /// Degrees that are fitted or tested.
    pub degrees: Degrees,
    /// Phase and amplitude modulation relative to the trajectory.
    pub moved: [f32; MOVEMENT_MAX],
    /// Weight of each degree of the phase in the mean frequency.
    pub seen: [f32; MOVEMENT_MAX],
    /// The noise next to the lines.
    pub noise: Covariance,
    /// Power of the loudest noise bin next to each line, by line number, in units of the channels'
    /// noise variances.
    pub loudest: [f32; HARMONICS_MAX + 1],
    /// Weight of the noise bins of each line, by index.
    pub weights: [f32; HARMONICS_MAX],
    /// Number of noise-bin functions; in white noise, of frames less unknowns.
    pub count: f32,
    /// Effective number: equally weighted functions with the same information.
    pub effective: f32,
    /// True if residual modulation is subtracted from the noise: in the first iteration, then only
    /// if significant.
    pub moves: bool,
    /// Variance inflation for the degrees of freedom of the subtracted modulation.
    pub taken: f32,
}

impl Followed {
    /// A comb whose modulation is not estimated yet.
    pub fn at(trajectory: Trajectory, shape: Shape) -> Self {
        Self {
            trajectory,
            shape,
            variances: [0.0; CHANNELS_MAX],
            fitted: Degrees::STEADY,
            degrees: Degrees::STEADY,
            moved: [0.0; MOVEMENT_MAX],
            seen: [0.0; MOVEMENT_MAX],
            noise: Covariance::NONE,
            loudest: [0.0; HARMONICS_MAX + 1],
            weights: [0.0; HARMONICS_MAX],
            count: 0.0,
            effective: 0.0,
            moves: true,
            taken: 1.0,
        }
    }

    /// Estimates the modulation with the current noise weights.
    fn move_by_noise(&mut self, blocks: &Blocks, workspace: &mut Workspace) {
        let n = self.degrees.count().min(MOVEMENT_MAX);
        let normal = &mut workspace.normal;
        normal.degrees = self.degrees;
        let memory = workspace.memory.as_flattened_mut();
        normal.make(blocks, &workspace.solution, &workspace.weights, memory);
        let trace: f32 = (0..n).map(|i| normal.matrix[i][i]).sum();
        for (i, row) in normal.matrix.iter_mut().enumerate().take(n) {
            row[i] += 1e-7 * trace;
        }
        self.moved = normal.right;
        Factor::new(&mut normal.matrix, n).solve(&mut self.moved);
        // Phases come first, so their factor is the leading part of the whole factor.
        self.seen = core::array::from_fn(|i| if i % 2 == 0 { 1.0 } else { 0.0 });
        Factor::of(&normal.matrix, self.fitted.phase).solve(&mut self.seen);
        invert(&mut normal.matrix, n);
    }

    /// Phase and amplitude modulation relative to the trajectory.
    pub fn motion(&self) -> Motion {
        let mut motion = Motion::default();
        let Degrees { phase, amplitude } = self.degrees;
        motion.degrees = phase.max(amplitude);
        let phases = motion.phase.iter_mut().zip(&self.moved);
        phases.take(phase).for_each(|(to, from)| *to = *from);
        let behind = self.moved.iter().skip(phase);
        let amplitudes = motion.amplitude.iter_mut().zip(behind);
        amplitudes
            .take(amplitude)
            .for_each(|(to, from)| *to = *from);
        motion
    }

    /// Coefficients of the phase by degree from 1 on, relative to the frequency of the trajectory.
    pub fn phase(&self) -> [f32; DEGREES_MAX] {
        let mut phase = self.motion().phase;
        let in_trajectory = self.trajectory.moved.iter().skip(1);
        let pairs = phase.iter_mut().zip(in_trajectory).take(self.degrees.phase);
        pairs.for_each(|(phase, moved)| *phase += moved);
        phase
    }

    /// Adds `sign` times the modulation to the blocks.
    #[inline(never)]
    fn add_motion(&self, blocks: &mut Blocks, solution: &Solution, sign: f32) {
        let motion = self.motion();
        for b in 0..blocks.count() {
            let moved = motion.at(blocks.middle(b)).map(|x| sign * x);
            blocks.add(b, &solution.shape, solution.lines(), moved);
        }
    }

    /// Subtracts the modulation from the blocks and solves again.
    pub fn take_out_motion(&self, blocks: &mut Blocks, solution: &mut Solution) {
        self.add_motion(blocks, solution, -1.0);
        solution.project(blocks, self.shape);
        solution.solve();
    }

    /// Number of unknowns of the modulation that is subtracted from the noise.
    pub fn unknowns(&self) -> usize {
        if self.moves { self.degrees.count() } else { 0 }
    }

    /// Degrees of freedom of the noise.
    pub fn freedom(&self) -> f32 {
        self.effective * self.noise.channels
    }

    /// Joint normal deviate of some unknowns of the modulation.
    fn shows(&self, covariance: &Square<MOVEMENT_MAX>, unknowns: Range<usize>) -> f32 {
        let (first, n) = (unknowns.start, unknowns.len().min(MOVES));
        let mut block = [[0.0; MOVES]; MOVES];
        let mut moved = [0.0; MOVES];
        let known = covariance.iter().zip(&self.moved).skip(first).take(n);
        let places = block.iter_mut().zip(&mut moved);
        for ((row, moved), (known_row, known)) in places.zip(known) {
            *moved = *known;
            let columns = row.iter_mut().zip(known_row.iter().skip(first));
            columns.for_each(|(to, from)| *to = *from);
        }
        Factor::new(&mut block, n).forward(&mut moved);
        let square: f32 = moved.iter().map(|x| x * x).sum();
        deviate(square / n as f32, n as f32, self.freedom())
    }
}

/// Weight of each line's noise bins: the line's share of the information, divided by its number of
/// functions.
#[inline(never)]
fn noise_weights(
    solution: &Solution,
    inverse: &Square<CHANNELS_MAX>,
    counts: &[f32; HARMONICS_MAX],
) -> [f32; HARMONICS_MAX] {
    let factors = solution.line_factors();
    let mut weights = [0.0; HARMONICS_MAX];
    let (mut sum, mut count) = (0.0, 0.0);
    let lines = solution.shape.lines.iter().zip(&factors);
    for ((line, factors), (weight, own)) in lines.zip(weights.iter_mut().zip(counts)) {
        let power = Power::new(factors, inverse).all;
        *weight = (line * line) as f32 * power / own.max(1.0);
        sum += own * *weight;
        count += own;
    }
    weights.map(|weight| weight * count / sum.max(f32::MIN_POSITIVE))
}

impl Refinement<'_> {
    /// Estimates the modulation of a comb, to which the blocks must be rotated, and stores it in
    /// `followed`; `recollect` passes over the window again. Returns false if there are too few
    /// noise bins.
    #[inline(never)]
    pub fn follow(
        &self,
        blocks: &mut Blocks,
        workspace: &mut Workspace,
        followed: &mut Followed,
        recollect: &mut dyn FnMut(&mut Blocks, &Trajectory, Lines),
    ) -> bool {
        let (mut trajectory, mut shape) = (followed.trajectory, followed.shape);
        let mut fitted = followed.fitted;
        let (mut turn, mut collected) = (0, trajectory);
        loop {
            let steps = Steps {
                shape,
                max: STEPS,
                degrees: fitted.phase,
                last: 0.3,
                noise: Known::Weights,
            };
            for _ in 0..2 {
                self.refine(blocks, &mut trajectory, steps, workspace);
                if blocks.twist(&collected, &trajectory) * shape.lines.max() as f32 <= TWIST_MAX {
                    break;
                }
                recollect(
                    blocks,
                    &trajectory,
                    self.lines(trajectory.cycles).and(shape.lines),
                );
                collected = trajectory;
            }
            (followed.trajectory, followed.shape, followed.fitted) = (trajectory, shape, fitted);
            if !self.noise(blocks, workspace, followed) {
                return false;
            }
            let Degrees { phase, amplitude } = followed.degrees;
            let covariance = &workspace.normal.matrix;
            let of_phase = followed.shows(covariance, fitted.phase..phase);
            let beyond = phase + fitted.amplitude..phase + amplitude;
            let of_amplitude = followed.shows(covariance, beyond);
            let samples = followed.count as usize * self.width;
            let has_room = (phase + amplitude + 2 * (MOVES - 1)) * SAMPLES_PER_DEGREE < samples;
            let max = MOVES_MAX.min(degrees_max(blocks) + 1 - MOVES);
            let grows = has_room && of_phase > Z_TEST && fitted.phase < max;
            let fades = has_room && of_amplitude > Z_TEST && fitted.amplitude < max;
            turn += 1;
            let moves = of_phase.max(of_amplitude) > Z_TAKEN;
            let is_known = followed.moves || !moves;
            if turn == TURNS || !grows && !fades && turn >= TURNS_MIN && is_known {
                return true;
            }
            followed.moves = moves;
            if grows {
                fitted.phase = (fitted.phase + MOVES - 1).min(max);
            }
            if fades {
                fitted.amplitude = (fitted.amplitude + MOVES - 1).min(max);
            }
            // Choose the lines again, since modulation may have smeared some.
            if fitted.phase > 1 && LINES_AGAIN.contains(&turn) {
                recollect(blocks, &trajectory, self.lines(trajectory.cycles));
                let degrees = [1, shape.degree];
                let count = if shape.degree > 1 { 2 } else { 1 };
                workspace.score_of_best = f32::NEG_INFINITY;
                if let Some(comb) = self.best(blocks, workspace, trajectory, &degrees[..count]) {
                    (trajectory, shape) = (comb.trajectory, comb.shape);
                    workspace.restore_weights();
                }
                recollect(
                    blocks,
                    &trajectory,
                    self.lines(trajectory.cycles).and(shape.lines),
                );
                collected = trajectory;
            }
        }
    }

    /// Estimates the noise next to the lines and the residual modulation; returns false with too
    /// few bins.
    #[inline(never)]
    fn noise(
        &self,
        blocks: &mut Blocks,
        workspace: &mut Workspace,
        followed: &mut Followed,
    ) -> bool {
        let shape = followed.shape;
        workspace.solution.project(blocks, shape);
        let squares = workspace.solution.squares(self.all);
        let free = (self.frames - shape.unknowns() as f32).max(1.0);
        followed.variances = squares.map(|square| square / free + ROUNDING);
        let max = degrees_max(blocks);
        followed.degrees = Degrees {
            phase: (followed.fitted.phase + MOVES - 1).min(max),
            amplitude: (followed.fitted.amplitude + MOVES).min(max),
        };
        if self.is_white {
            (followed.noise, followed.count) = (self.weigh(workspace, free), free);
            (followed.effective, followed.weights) = (free, [1.0; HARMONICS_MAX]);
            workspace.noise_bins.clear();
            workspace.solution.solve();
            followed.move_by_noise(blocks, workspace);
            return true;
        }
        if followed.moves {
            workspace.solution.solve();
            followed.move_by_noise(blocks, workspace);
            self.collect_less_motion(blocks, workspace, followed);
        } else {
            self.collect_noise_bins(blocks, workspace, followed.trajectory.cycles);
        }
        workspace.solution.solve();
        let count = workspace.noise_bins.count();
        if count < NOISE_BINS_MIN {
            return false;
        }
        let mut counts = [0.0; HARMONICS_MAX];
        for member in workspace.noise_bins.members() {
            counts[shape.lines.index(usize::from(member.line)) % HARMONICS_MAX] += 1.0;
        }
        let of_lines = noise_weights(&workspace.solution, &workspace.weights, &counts);
        let squares: f32 = counts.iter().zip(&of_lines).map(|(n, w)| n * w * w).sum();
        let all = count as f32 * self.width as f32;
        followed.weights = of_lines;
        followed.count = count as f32;
        followed.effective = (count * count) as f32 / squares.max(f32::MIN_POSITIVE);
        followed.taken = all / (all - followed.unknowns() as f32).max(1.0);
        let weight = |member: &Member| {
            followed.taken * of_lines[shape.lines.index(usize::from(member.line)) % HARMONICS_MAX]
        };
        let noise_bins = &mut workspace.noise_bins;
        noise_bins.products(&workspace.memory, &weight, &mut workspace.weights);
        let samples = Samples {
            width: self.width,
            count: followed.count,
            effective: followed.effective,
            may_share: self.may_share,
        };
        followed.noise = samples.invert(&mut workspace.weights, Some(&followed.variances));
        noise_bins.measure(&workspace.memory, &workspace.weights, &followed.variances);
        followed.loudest = noise_bins.loudest(&workspace.memory, &followed.noise.variances);
        followed.move_by_noise(blocks, workspace);
        true
    }

    /// Collects the noise bins next to the lines after subtracting the modulation; the solution
    /// must be solved.
    #[inline(never)]
    fn collect_less_motion(
        &self,
        blocks: &mut Blocks,
        workspace: &mut Workspace,
        followed: &Followed,
    ) {
        let shape = workspace.solution.shape;
        // Save only the lines: a second solution would set the maximum stack depth.
        let mut lines = [[0.0; CHANNELS_MAX]; 2 * HARMONICS_MAX];
        let pairs = lines.iter_mut().zip(workspace.solution.lines());
        pairs.for_each(|(kept, row)| *kept = *row);
        followed.add_motion(blocks, &workspace.solution, -1.0);
        workspace.solution.project(blocks, shape);
        self.collect_noise_bins(blocks, workspace, followed.trajectory.cycles);
        let solution = &mut workspace.solution;
        let rows = solution.rows.iter_mut().skip(shape.first_line());
        rows.zip(lines).for_each(|(row, kept)| *row = kept);
        followed.add_motion(blocks, solution, 1.0);
        solution.project(blocks, shape);
    }

    /// Collects the noise bins of the projected solution.
    fn collect_noise_bins(&self, blocks: &Blocks, workspace: &mut Workspace, cycles: f32) {
        let shape = workspace.solution.shape;
        // Project out harmonics too weak to be kept, so that they do not count as noise, if enough
        // bins remain.
        let whole = Shape {
            lines: self.lines(cycles).and(shape.lines),
            ..shape
        };
        let place = LineFrequencies {
            lines: shape.lines,
            cycles,
            nyquist: self.nyquist,
            band: BAND,
        };
        let Workspace {
            noise_bins,
            memory,
            solution,
            ..
        } = workspace;
        if whole.lines != shape.lines {
            solution.project(blocks, whole);
            noise_bins.collect(blocks, solution.projected(), place, memory);
            solution.project(blocks, shape);
        }
        if whole.lines == shape.lines || noise_bins.count() < NOISE_BINS_WHOLE {
            noise_bins.collect(blocks, solution.projected(), place, memory);
        }
    }
}
