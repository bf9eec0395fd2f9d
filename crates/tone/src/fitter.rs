//! The order of the steps.

use crate::blocks::{Blocks, Pass};
use crate::comb::{Comb, CompetingComb};
use crate::conclude::{self, Figures};
use crate::fit::{Fit, OtherTone, Status, Tests};
use crate::frame_span::FrameSpan;
use crate::hum::Hum;
use crate::hypotheses::{Noise, Other, Tested, Z_LINE};
use crate::impulses::{self, Impulses};
use crate::late::{Delays, Late};
use crate::lean::follow::{Loop, ROWS, Tracked};
use crate::lean::{self, Lean};
use crate::legendre::legendre;
use crate::limits::{CHANNELS_MAX, DEGREE_MAX, FRAMES_MIN};
use crate::lines::Lines;
use crate::movement::{Followed, TWIST_MAX};
use crate::refine::{Refinement, Steps};
use crate::scene::Scene;
use crate::search::{PEAKS, candidates};
use crate::solve::Shape;
use crate::source::{Overwritten, Values};
use crate::spectrum::Sums;
use crate::statistics::{Products, Statistics};
use crate::trajectory::Trajectory;
use crate::window_frames::WindowFrames;
use crate::workspace::Workspace;

/// Fits of a window whose impulses are replaced, the last included.
const ATTEMPTS: usize = 3;
/// Fits after which the multiplexing delay is corrected again.
const LATE_FITS: usize = 3;
/// Parts of a peak's frequency that are tried, where there are as many harmonics.
const DIVISORS: usize = 3;
/// Minimum number of cycles of a candidate.
const CYCLES_MIN: f32 = 0.45;
/// Candidates nearer than this, in cycles, are one.
const CANDIDATES_APART: f32 = 0.1;
/// A tone this close to hum is subtracted with it, cycles per window.
const HUM_CYCLES: f32 = 1.5;
/// Below this many cycles a curved baseline is tried for every candidate.
const CYCLES_CURVED: f32 = 5.0;

/// The estimator: memory of its steps.
#[derive(Debug)]
pub struct Fitter {
    impulses: Impulses,
    blocks: Blocks,
    workspace: Workspace,
}

impl Default for Fitter {
    fn default() -> Self {
        Self::new()
    }
}

impl Fitter {
    /// A fitter; all zeros, so that a static of it takes no flash.
    pub const fn new() -> Self {
        Self {
            impulses: Impulses::new(),
            blocks: Blocks::new(),
            workspace: Workspace::new(),
        }
    }

    /// Fits all usable channels of a span.
    ///
    /// # Errors
    /// If its frames were overwritten meanwhile.
    #[inline(never)]
    pub fn fit(&mut self, span: &mut FrameSpan, scene: &Scene) -> Result<Fit, Overwritten> {
        if Lean::takes(span, scene) {
            return self.fit_lean(span, scene);
        }
        let fit = self.fit_all(span, scene, None);
        self.end_loop();
        fit
    }

    /// Follows the line of the latest fit through the frames behind its window, one after the other:
    /// the span begins where the fit's window or the latest span ended. A fit takes as many
    /// instructions as two hundred frames.
    ///
    /// None where only a fit can tell: after a fit that was not good, or not of a single line in a
    /// scene in white noise at a steady speed; and from the frame on whose residuals disagree with
    /// the fit's noise.
    ///
    /// # Errors
    /// If its frames were overwritten meanwhile.
    pub fn follow(&mut self, span: &mut FrameSpan) -> Result<Option<Tracked>, Overwritten> {
        Loop::new(self.loop_rows()).follow(span)
    }

    /// Memory of the loop, which a fit writes over.
    fn loop_rows(&mut self) -> &mut [Values; ROWS] {
        &mut self.workspace.memory.as_chunks_mut().0[0]
    }

    /// Ends the loop after a fit that leaves no line to follow.
    fn end_loop(&mut self) {
        Loop::new(self.loop_rows()).end();
    }

    /// Fits a lean scene. It is not inlined: its memory on the stack is not that of other scenes.
    #[inline(never)]
    fn fit_lean(&mut self, span: &mut FrameSpan, scene: &Scene) -> Result<Fit, Overwritten> {
        let mut solution = lean::Solution::NONE;
        self.fit_lean_in(span, scene, &mut solution)
    }

    /// Fits a lean scene in the memory of a solution, so that no stack frame is larger than 4 KiB.
    #[inline(never)]
    fn fit_lean_in(
        &mut self,
        span: &mut FrameSpan,
        scene: &Scene,
        solution: &mut lean::Solution,
    ) -> Result<Fit, Overwritten> {
        let power = self.workspace.memory.as_flattened_mut();
        let fit = Lean::new(self.blocks.rows(), power, solution).fit(span, scene);
        match &fit {
            Ok(fit) => Loop::new(self.loop_rows()).start(span, solution, fit),
            Err(_) => self.end_loop(),
        }
        fit
    }

    /// Fits all usable channels of a span along a path, each channel at a position of its own.
    ///
    /// # Errors
    /// If its frames were overwritten meanwhile.
    pub fn fit_delayed(
        &mut self,
        span: &mut FrameSpan,
        scene: &Scene,
        delays: &Delays,
    ) -> Result<Fit, Overwritten> {
        let correct: Correct =
            |window, memory, scene, comb, delays| window.has_late(memory, scene, comb, delays);
        // Opaque: the compiler would else call the only such function directly.
        let correct = core::hint::black_box(correct);
        let correction = Correction { delays, correct };
        let fit = self.fit_all(span, scene, Some(correction));
        self.end_loop();
        fit
    }

    #[inline(never)]
    fn fit_all(
        &mut self,
        span: &mut FrameSpan,
        scene: &Scene,
        correction: Option<Correction>,
    ) -> Result<Fit, Overwritten> {
        let statistics = Statistics::collect(span)?;
        let mut fit = Fit::without_tone(Status::Nothing, statistics.frames);
        if statistics.width == 0 {
            return Ok(fit);
        }
        // More gaps than frames leave the frequency open.
        if statistics.frames < FRAMES_MIN || 2 * statistics.frames < span.frames {
            fit.status = Status::TooShort;
            return Ok(fit);
        }
        let Self {
            impulses,
            blocks,
            workspace,
        } = self;
        impulses.clear();
        let mut window = WindowFrames {
            domain: *span.domain(),
            span,
            statistics,
            impulses,
            hum: None,
            late: None,
            is_lost: false,
        };
        let mut memory = Memory {
            blocks,
            workspace,
            correction,
        };
        window.fit(&mut memory, scene, &mut fit);
        if window.is_lost {
            Err(Overwritten)
        } else {
            Ok(fit)
        }
    }
}

impl<'d, 's> WindowFrames<'d, 's> {
    /// Fits what is there.
    fn fit(&mut self, memory: &mut Memory, scene: &Scene, fit: &mut Fit) {
        if let Some(given) = self.span.interferer {
            Hum::take_out(self, memory.blocks, memory.workspace, given);
        }
        fit.interferer = self.hum.map(|hum| hum.cycles_per_frame);
        if let Some(expected) = self.span.expected {
            let cycles = expected / self.span.frequency(1.0);
            self.look(memory, scene, fit, Some(cycles));
            if fit.status == Status::Good {
                return;
            }
            self.impulses.clear();
            self.late = None;
            let interferer = fit.interferer;
            *fit = Fit::without_tone(Status::NoTone, fit.frames);
            fit.interferer = interferer;
        }
        self.look(memory, scene, fit, None);
    }

    /// Looks for a tone near an expected number of cycles per window alone, or anywhere.
    #[inline(never)]
    fn look(&mut self, memory: &mut Memory, scene: &Scene, fit: &mut Fit, expected: Option<f32>) {
        let (mut known, is_expected) = (expected, expected.is_some());
        for attempt in 1..=ATTEMPTS {
            let all = self.start(memory, scene);
            let mut window = self.window(scene, &all, is_expected);
            let Some(comb) = window.best(memory, known) else {
                fit.status = Status::NoTone;
                return;
            };
            if attempt == 1
                && let Some(Correction { delays, correct }) = memory.correction
                && correct(self, memory, scene, &comb, delays)
            {
                known = Some(comb.trajectory.cycles);
                continue;
            }
            let mut window = self.window(scene, &all, is_expected);
            if !scene.impulses || attempt == ATTEMPTS || !window.has_impulses(memory, &comb) {
                window.conclude_with_competing(memory, &comb, fit);
                return;
            }
            self.centre();
        }
    }

    fn window<'w>(
        &'w mut self,
        scene: &'w Scene,
        all: &'w Products,
        is_expected: bool,
    ) -> Window<'w, 'd, 's> {
        Window {
            frames: self,
            scene,
            all,
            is_expected,
            is_scored: false,
        }
    }

    /// The products of the channels, and the blocks' of the baselines.
    fn start(&mut self, memory: &mut Memory, scene: &Scene) -> Products {
        let lines = usize::from(scene.harmonics());
        memory.blocks.start(self, lines, scene.may_share())
    }

    /// Takes the lateness of channels and the low-pass out of the frames, by a comb; false if they
    /// are less than the noise.
    #[inline(never)]
    fn has_late(
        &mut self,
        memory: &mut Memory,
        scene: &Scene,
        comb: &Comb,
        delays: &Delays,
    ) -> bool {
        let mut trajectory = comb.trajectory;
        memory.workspace.restore_weights();
        for number in 0..LATE_FITS {
            let all = self.start(memory, scene);
            let mut window = self.window(scene, &all, false);
            if number > 0 {
                window.collect(memory.blocks, &trajectory, comb.shape.lines);
                let steps = Steps::of_comb(comb.shape);
                let refinement = window.refinement();
                refinement.refine(memory.blocks, &mut trajectory, steps, memory.workspace);
            }
            memory.workspace.solution.project(memory.blocks, comb.shape);
            memory.workspace.solution.solve();
            if !Late::take_out(self, memory.workspace, &trajectory, delays) {
                return number > 0;
            }
            self.centre();
        }
        true
    }
}

/// Memory of the steps, and what they correct.
struct Memory<'m> {
    blocks: &'m mut Blocks,
    workspace: &'m mut Workspace,
    correction: Option<Correction<'m>>,
}

/// Correction for delays. The function comes with them, so that an image without delays is without
/// the function.
#[derive(Clone, Copy)]
struct Correction<'c> {
    delays: &'c Delays,
    correct: Correct,
}

/// Takes delays out of the frames, by a comb; true if there were some.
type Correct = fn(&mut WindowFrames, &mut Memory, &Scene, &Comb, &Delays) -> bool;

/// A window that is fitted.
struct Window<'w, 'd, 's> {
    frames: &'w mut WindowFrames<'d, 's>,
    scene: &'w Scene,
    all: &'w Products,
    /// True if the tone is looked for where it is expected alone.
    is_expected: bool,
    /// True if a tone is scored whatever its strongest line is.
    is_scored: bool,
}

impl<'w> Window<'w, '_, '_> {
    /// The likeliest comb near a known frequency, or anywhere; the blocks are at it.
    #[inline(never)]
    fn best(&mut self, memory: &mut Memory, known: Option<f32>) -> Option<Comb> {
        memory.workspace.score_of_best = f32::NEG_INFINITY;
        let near = known.and_then(|cycles| Some((self.near(memory, cycles)?, cycles)));
        let (mut best, collected) = match near {
            Some((comb, cycles)) => (comb, Some(Trajectory::steady(cycles))),
            None if self.is_expected => return None,
            None => (self.search(memory)?, None),
        };
        self.choose_degree(memory, &mut best, collected);
        Some(best)
    }

    /// The comb near a frequency, with the blocks at its unit. `None` if the likeliest one there
    /// has another frequency.
    fn near(&mut self, memory: &mut Memory, cycles: f32) -> Option<Comb> {
        let Memory {
            blocks, workspace, ..
        } = memory;
        let refinement = self.refinement();
        let trajectory = Trajectory::steady(cycles);
        self.collect(blocks, &trajectory, refinement.lines(cycles));
        let comb = refinement.best(blocks, workspace, trajectory, self.degrees(cycles))?;
        let is_near = f32::abs(comb.trajectory.cycles - cycles) < CYCLES_MIN;
        is_near.then_some(comb)
    }

    /// Degrees of the baseline to try with a candidate.
    fn degrees(&self, cycles: f32) -> &'static [usize] {
        if cycles < CYCLES_CURVED && self.scene.degree_max() > 1 {
            &[1, DEGREE_MAX]
        } else {
            &[1]
        }
    }

    /// The likeliest comb of those at the peaks, and at half and at a third of each.
    #[inline(never)]
    fn search(&mut self, memory: &mut Memory) -> Option<Comb> {
        let Memory {
            blocks, workspace, ..
        } = memory;
        let refinement = self.refinement();
        let mut peaks = candidates(self.frames, blocks, workspace, self.all, self.scene);
        let mut tried = [0.0f32; PEAKS * DIVISORS];
        let mut others_tried = [CompetingComb::NONE; PEAKS * DIVISORS];
        let (mut best, mut count, mut first) = (None::<Comb>, 0, Lines::NONE);
        for divisor in 1..=DIVISORS.min(refinement.harmonics) {
            for (i, peak) in peaks.iter_mut().enumerate() {
                let cycles = *peak / divisor as f32;
                // A harmonic of the strongest peak is a line of its comb already.
                let times = libm::roundf(*peak / tried[0].max(CYCLES_MIN));
                let is_harmonic = f32::abs(*peak - times * tried[0]) < CANDIDATES_APART
                    && first.has(times as usize);
                let is_known = i > 0 && is_harmonic
                    || tried
                        .iter()
                        .take(count)
                        .any(|other| f32::abs(other - cycles) < CANDIDATES_APART);
                if cycles < CYCLES_MIN || is_known || !refinement.band.has(cycles) {
                    continue;
                }
                let trajectory = Trajectory::steady(cycles);
                self.collect(blocks, &trajectory, refinement.lines(cycles));
                let degrees = self.degrees(cycles);
                let max = degrees.last().copied().unwrap_or(1);
                // A part of a peak's frequency needs a line next to the peak's own.
                let fewest = if divisor > 1 { 2 } else { 1 };
                let min = Shape {
                    lines: Lines::up_to(fewest),
                    degree: 1,
                };
                if let Some(best) = &best
                    && refinement.bound(blocks, workspace, max, &min) < best.score
                {
                    continue;
                }
                let (Some(place), Some(competing)) =
                    (tried.get_mut(count), others_tried.get_mut(count))
                else {
                    break;
                };
                *place = cycles;
                count += 1;
                let Some(comb) = refinement.best(blocks, workspace, trajectory, degrees) else {
                    continue;
                };
                if divisor == 1 {
                    *peak = comb.unit.cycles;
                    *place = comb.unit.cycles;
                    if i == 0 {
                        first = comb.kept;
                    }
                }
                *competing = CompetingComb {
                    score: comb.score,
                    cycles: comb.trajectory.cycles,
                };
                if best.is_none_or(|best| comb.score > best.score) {
                    best = Some(comb);
                }
            }
        }
        let mut best = best?;
        let cycles = best.trajectory.cycles;
        let others = others_tried
            .iter()
            .filter(|competing| f32::abs(competing.cycles - cycles) > CYCLES_MIN);
        best.competing = others.fold(CompetingComb::NONE, |max, competing| {
            if competing.score > max.score {
                *competing
            } else {
                max
            }
        });
        best.competing.score -= best.score;
        Some(best)
    }

    /// Fits a comb with each degree of the baseline, by blocks that are at it: they were `collected`
    /// near it, or are collected anew.
    #[inline(never)]
    fn choose_degree(
        &mut self,
        memory: &mut Memory,
        best: &mut Comb,
        collected: Option<Trajectory>,
    ) {
        let Memory {
            blocks, workspace, ..
        } = memory;
        let refinement = self.refinement();
        let cycles = best.trajectory.cycles;
        let lines = refinement.lines(cycles).and(best.shape.lines);
        let twist =
            collected.map(|from| blocks.twist(&from, &best.trajectory) * lines.max() as f32);
        if twist.is_none_or(|twist| twist > TWIST_MAX) || blocks.lines() != lines {
            self.collect(blocks, &best.trajectory, lines);
        }
        // Blocks that were turned gave the scores so far; these are exact. The least and the highest
        // degree were compared each at its own frequency; those between are at that of the better one.
        let (mut at, degree) = (best.trajectory, best.shape.degree);
        best.score = f32::NEG_INFINITY;
        workspace.restore_weights();
        let max = self.scene.degree_max();
        let others = (1..=max).filter(|other| *other != degree);
        let mut are_bounded = false;
        for other in core::iter::once(degree).chain(others) {
            let mut steps = Steps::of_comb(best.shape);
            steps.shape.degree = other;
            if other != degree {
                // The first of the others is the least. Below, lines may be left out beside a baseline.
                if !are_bounded
                    && cycles >= CYCLES_CURVED
                    && refinement.bound(blocks, workspace, max, &steps.shape) <= best.score
                {
                    break;
                }
                are_bounded = true;
                workspace.solution.project(blocks, steps.shape);
                if refinement.score(&workspace.solution) <= best.score {
                    continue;
                }
            }
            let from = at;
            refinement.refine(blocks, &mut at, steps, workspace);
            workspace.solution.project(blocks, steps.shape);
            let score = refinement.score(&workspace.solution);
            if score > best.score {
                (best.score, best.shape, best.trajectory) = (score, steps.shape, at);
            } else {
                blocks.turn(&at, &from);
                at = from;
            }
        }
    }

    /// Replaces what a comb leaves of single values; whether there are some.
    #[inline(never)]
    fn has_impulses(&mut self, memory: &mut Memory, comb: &Comb) -> bool {
        let Workspace {
            solution,
            memory: found,
            ..
        } = &mut *memory.workspace;
        solution.project(memory.blocks, comb.shape);
        solution.solve();
        let found = found.as_flattened_mut();
        impulses::replace(self.frames, solution, &comb.trajectory, found) > 0
    }

    /// The verdict on a comb, or on the strongest of its lines where that is likelier: lines next to
    /// a tone whose amplitude moves look like those of a comb.
    #[inline(never)]
    fn conclude_with_competing(&mut self, memory: &mut Memory, comb: &Comb, fit: &mut Fit) {
        let found = self.conclude(memory, comb, fit);
        if found.strongest < 2 || !fit.status.has_tone() {
            return;
        }
        let cycles = found.strongest as f32 * comb.trajectory.cycles;
        memory.workspace.score_of_best = f32::NEG_INFINITY;
        let Some(mut line) = self.near(memory, cycles) else {
            return;
        };
        self.choose_degree(memory, &mut line, Some(Trajectory::steady(cycles)));
        let mut other = Fit {
            interferer: fit.interferer,
            ..Fit::without_tone(Status::NoTone, fit.frames)
        };
        self.is_scored = true;
        let lead = found.score - self.conclude(memory, &line, &mut other).score;
        if lead.is_nan() || !other.status.has_tone() {
            return;
        }
        // More lines than the window has room for explain anything: they are no likelier reading.
        if lead >= 0.0 && !found.is_crowded {
            fit.tests.margin = fit.tests.margin.min(lead);
            return;
        }
        core::mem::swap(fit, &mut other);
        fit.tests.margin = fit.tests.margin.min(-lead);
        if fit.status == Status::Good {
            fit.status = Status::Ambiguous;
            fit.other_tone = Some(OtherTone {
                frequency: other.frequency,
                share: 1.0,
            });
        }
    }

    /// The verdict on a comb, whose phase is followed and tested.
    #[inline(never)]
    fn conclude(&mut self, memory: &mut Memory, comb: &Comb, fit: &mut Fit) -> Concluded {
        let Memory {
            blocks, workspace, ..
        } = memory;
        let refinement = self.refinement();
        let mut followed = Followed::at(comb.trajectory, comb.shape);
        workspace.restore_weights();
        let mut recollect = |blocks: &mut Blocks, trajectory: &Trajectory, lines: Lines| {
            self.collect(blocks, trajectory, lines);
        };
        let is_known = refinement.follow(blocks, workspace, &mut followed, &mut recollect);
        let judged = is_known.then(|| self.judge(memory, &followed, &comb.competing, fit));
        judged.flatten().unwrap_or_else(|| {
            let frequency = |cycles| self.frames.span.frequency(cycles);
            let competing = if comb.competing.cycles > 0.0 {
                comb.competing.cycles
            } else {
                0.5 * comb.trajectory.cycles
            };
            fit.status = Status::Ambiguous;
            fit.frequency = frequency(comb.trajectory.cycles);
            fit.sigma = fit.frequency;
            fit.other_tone = Some(OtherTone {
                frequency: frequency(competing),
                share: 1.0,
            });
            Concluded::UNKNOWN
        })
    }

    /// The verdict on a tone that is followed; none where f32 cannot tell its mean.
    #[inline(never)]
    fn judge(
        &mut self,
        memory: &mut Memory,
        followed: &Followed,
        competing: &CompetingComb,
        fit: &mut Fit,
    ) -> Option<Concluded> {
        let workspace = &*memory.workspace;
        let (nyquist, width) = (self.frames.nyquist(), self.frames.width());
        let tested = Tested::new(followed, workspace, nyquist, width);
        let clipped = &self.frames.statistics.clipped;
        let mean = conclude::mean(&tested, workspace, memory.blocks, self.scene, clipped);
        if !(mean.cycles > 0.0 && (mean.cycles + mean.sigma).is_finite()) {
            return None;
        }
        let mut tests = Tests::default();
        tested.near(&workspace.noise_bins, &mut tests);
        let nearest = workspace.noise_bins.strongest_near();
        let shape = tested.shape;
        let [strongest, second] = strongest(&tested);
        let span = &*self.frames.span;
        let movement = conclude::movement(followed, &workspace.normal.matrix, &mean, span);
        let overtones = conclude::overtones(&workspace.solution, &followed.variances, width);
        let statistics = &self.frames.statistics;
        tests.cycles = followed.trajectory.cycles;
        tests.margin = -competing.score;
        tests.unfollowed = crate::sqrt(mean.phase.unfollowed);
        tests.fading = fading(followed);
        tests.steady = mean.phase.steady;
        tests.degree = shape.degree as u8;
        tests.degrees = followed.fitted.phase as u8;
        tests.lines = shape.lines.iter().fold(0, |mask, line| mask | 1 << line);
        // Up to each line: a baseline of degree four has two cycles itself.
        let unknowns = |line: usize| 2 * shape.lines.iter().filter(|other| *other <= line).count();
        let room = |line: usize| 2.0 * line as f32 * tests.cycles + 1.0;
        let is_crowded = |line: usize| room(line) < (unknowns(line) + shape.degree) as f32;
        let is_crowded = shape.degree > 1 && shape.lines.iter().any(is_crowded);
        let mut figures = Figures {
            tests: &tests,
            mean: &mean,
            other: &Other::default(),
            competing,
            image: Some(tested.loudest as f32 * tests.cycles)
                .filter(|cycles| nyquist.aliases && *cycles > nyquist.max),
            strongest,
            second,
            nearest,
            hidden: self.hidden(mean.cycles),
            is_crowded,
            stay: statistics.stay,
            lines: shape.lines.count(),
            nyquist,
        };
        conclude::channels(followed, &workspace.solution, statistics, fit);
        let mut other = Other::default();
        let mut between = 0.0;
        if tests.line >= Z_LINE {
            (between, other) = self.test_residuals(memory, &tested);
        }
        let tests = Tests {
            between,
            other: other.deviate,
            ..tests
        };
        (figures.tests, figures.other) = (&tests, &other);
        fit.status = figures.status();
        let reading = figures.other_reading();
        let score = if (self.is_scored || strongest > 1) && fit.status.has_tone() {
            self.score(memory, &tested)
        } else {
            f32::NEG_INFINITY
        };
        let (span, statistics) = (&*self.frames.span, &self.frames.statistics);
        fit.tests = tests;
        if fit.status.has_tone() {
            fit.other_tone = reading.map(|reading| OtherTone {
                frequency: span.frequency(reading.cycles),
                share: reading.share,
            });
            fit.frequency = span.frequency(mean.cycles);
            // No frequency is known better than it is written.
            fit.sigma = libm::hypotf(span.frequency(mean.sigma), f32::EPSILON * fit.frequency);
            fit.movement = movement;
            fit.harmonics = shape.lines.max() as u8;
            fit.overtones = overtones;
            for (k, channel) in statistics.order.iter().enumerate().take(statistics.width) {
                fit.with_tone |= (tested.with_tone >> k & 1) << channel;
            }
        }
        Some(Concluded {
            score,
            strongest,
            is_crowded,
        })
    }

    /// A part of a frequency at which a tone would have gone as hum.
    fn hidden(&self, cycles: f32) -> Option<f32> {
        let hum = self.frames.hum?.cycles_per_frame * self.frames.span.effective_frames();
        let parts = (2..=self.scene.harmonics()).map(|part| cycles / f32::from(part));
        let mut hidden = parts.filter(|part| f32::abs(part - hum) < HUM_CYCLES);
        hidden.next()
    }

    /// Logarithm of the likelihood of what a tone and its movement leave of the frames, channel by
    /// channel, less the Bayesian criterion's price. The solution is solved.
    #[inline(never)]
    fn score(&mut self, memory: &mut Memory, tested: &Tested) -> f32 {
        let model = tested.model(&memory.workspace.solution);
        let (width, mut squares) = (self.frames.width(), [0.0; CHANNELS_MAX]);
        self.frames.visit_residuals(Some(&model), |frame| {
            let pairs = squares.iter_mut().zip(&frame.values);
            pairs.for_each(|(square, value)| *square += value * value);
        });
        let frames = self.all.count;
        let pairs = squares.iter().zip(&self.all.squares_min).take(width);
        let logs: f32 = pairs
            .map(|(square, min)| libm::logf(square.max(*min) / frames))
            .sum();
        let unknowns = width * tested.shape.unknowns()
            + tested.followed.unknowns().max(tested.followed.fitted.phase);
        -0.5 * (frames * logs + unknowns as f32 * libm::logf(frames))
    }

    /// What a tone leaves: the deviate of lines between its own, and another line.
    #[inline(never)]
    fn test_residuals(&mut self, memory: &mut Memory, tested: &Tested) -> (f32, Other) {
        let Memory {
            blocks, workspace, ..
        } = memory;
        let mut between = 0.0;
        if tested.followed.moves {
            tested
                .followed
                .take_out_motion(blocks, &mut workspace.solution);
        } else {
            workspace.solution.project(blocks, tested.shape);
        }
        if self.scene.harmonics() > 1 {
            let mut noise = Noise {
                noise_bins: &mut workspace.noise_bins,
                memory: &mut workspace.memory,
                weights: &workspace.weights,
                all: self.all,
            };
            between = tested.between(self.frames, &workspace.solution, blocks, &mut noise);
        }
        if !tested.followed.moves {
            workspace.solution.solve();
        }
        let model = tested.model(&workspace.solution);
        // Where the tone was expected, the search before has looked at all other frequencies.
        if self.is_expected {
            return (between, Other::default());
        }
        let sums = Sums {
            memory: workspace.memory.as_flattened_mut(),
            more: workspace.normal.matrix.as_flattened_mut(),
        };
        let other = tested.other(self.frames, &model, sums, blocks.scratch());
        (between, other)
    }

    fn collect(&mut self, blocks: &mut Blocks, trajectory: &Trajectory, lines: Lines) {
        let pass = Pass {
            trajectory: *trajectory,
            scale: 1.0,
            lines,
            multiple_max: 2 * lines.max(),
        };
        blocks.collect(self.frames, &pass, None);
    }

    fn refinement(&self) -> Refinement<'w> {
        Refinement {
            all: self.all,
            width: self.frames.width(),
            frames: self.all.count,
            harmonics: usize::from(self.scene.harmonics()),
            may_share: self.scene.may_share(),
            is_white: self.scene.is_white(),
            nyquist: self.frames.nyquist(),
            band: self.scene.band.over(self.frames.span.frequency(1.0)),
        }
    }
}

/// Figures behind a verdict.
struct Concluded {
    /// Score of the tone with its movement; minus infinity where it has none.
    score: f32,
    /// Number of the strongest line.
    strongest: usize,
    /// True if lines and baseline have more unknowns than the window has room for.
    is_crowded: bool,
}

impl Concluded {
    const UNKNOWN: Self = Self {
        score: f32::NEG_INFINITY,
        strongest: 0,
        is_crowded: false,
    };
}

/// Numbers of the two strongest lines; 0 where there is none.
fn strongest(tested: &Tested) -> [usize; 2] {
    let (mut numbers, mut powers) = ([0; 2], [0.0; 2]);
    for (line, power) in tested.shape.lines.iter().zip(&tested.powers) {
        if power.all > powers[0] {
            (numbers, powers) = ([line, numbers[0]], [power.all, powers[0]]);
        } else if power.all > powers[1] {
            (numbers[1], powers[1]) = (line, power.all);
        }
    }
    numbers
}

/// Change of the amplitude, RMS over the blocks.
fn fading(followed: &Followed) -> f32 {
    const PLACES: usize = 32;
    let motion = followed.motion();
    let square = (0..PLACES).map(|i| {
        let p = legendre::<{ crate::limits::DEGREES_MAX + 1 }>(
            (2 * i + 1) as f32 / PLACES as f32 - 1.0,
        );
        let amplitude: f32 = motion
            .amplitude
            .iter()
            .zip(&p[1..])
            .map(|(c, p)| c * p)
            .sum();
        amplitude * amplitude
    });
    crate::sqrt(square.sum::<f32>() / PLACES as f32)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::limits::{
        BLOCK_LINES, BLOCK_LINES_CHIP, IMPULSES_CHIP, IMPULSES_MAX, POINTS_CHIP, POINTS_MAX,
    };
    use crate::{blocks, workspace};
    extern crate std;
    use std::format;

    /// Maximum number of bytes of a fitter on the chip.
    const BUDGET: usize = 23_000;

    #[test]
    fn on_the_chip_it_takes_no_more_than_its_budget() {
        let rows = |lines, points| blocks::rows(lines, points) + workspace::rows(points);
        let longer = (rows(BLOCK_LINES, POINTS_MAX) - rows(BLOCK_LINES_CHIP, POINTS_CHIP))
            * size_of::<crate::source::Values>()
            + (BLOCK_LINES - BLOCK_LINES_CHIP) * size_of::<crate::phase::Wave>();
        let more = size_of::<Impulses>() / IMPULSES_MAX * (IMPULSES_MAX - IMPULSES_CHIP);
        let size = size_of::<Fitter>() - longer - more;
        assert!(size <= BUDGET, "{size} bytes");
    }

    #[test]
    fn a_fresh_one_is_all_zeros() {
        let fresh = format!("{:?}", Fitter::new());
        let values = fresh.split(|c: char| !c.is_alphanumeric() && c != '.' && c != '-');
        let mut numbers = values.filter(|value| value.starts_with(|c: char| c.is_ascii_digit()));
        assert!(
            numbers.all(|number| number.parse() == Ok(0.0)),
            "{fresh:.500}"
        );
        assert!(!fresh.contains("true"));
    }
}
