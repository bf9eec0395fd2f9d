//! Sequence of the steps of a fit.

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
use crate::lean::{self, CYCLES_CURVED, Lean, Reference, Task};
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

/// Maximum number of fits of a window with impulses, including the last.
const ATTEMPTS: usize = 3;
/// Maximum number of corrections for delays.
const LATE_FITS: usize = 3;
/// Maximum divisor for subharmonics of a peak, if the scene has as many harmonics.
const DIVISORS: usize = 3;
/// Minimum number of cycles of a candidate.
const CYCLES_MIN: f32 = 0.45;
/// Minimum distance between candidates, cycles per window.
const CANDIDATES_APART: f32 = 0.1;
/// A tone within this distance of hum is subtracted with the hum, cycles per window.
const HUM_CYCLES: f32 = 1.5;

/// Frequency estimator, with the memory of its steps.
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
    /// Creates a fitter of all zeros, so that a static fitter takes no flash.
    pub const fn new() -> Self {
        Self {
            impulses: Impulses::new(),
            blocks: Blocks::new(),
            workspace: Workspace::new(),
        }
    }

    /// Fits all usable channels of a span. Tries lines in white noise first, and everything that
    /// the scene may contain only if that fit is not good.
    ///
    /// # Errors
    /// If frames were overwritten before they were read.
    #[inline(never)]
    pub fn fit(&mut self, span: &mut FrameSpan, scene: &Scene) -> Result<Fit, Overwritten> {
        let mut fit = Fit::without_tone(Status::Nothing, 0);
        if !self.fit_plain(span, scene, &mut fit)? {
            self.fit_all(span, scene, None, &mut fit)?;
        }
        Ok(fit)
    }

    /// Fits a lean scene, or any window that contains only what a lean scene may. Returns false if
    /// the window contains more, or might. Not inlined, so that other fits do not need its stack.
    #[inline(never)]
    fn fit_plain(
        &mut self,
        span: &mut FrameSpan,
        scene: &Scene,
        fit: &mut Fit,
    ) -> Result<bool, Overwritten> {
        let mut task = Task {
            scene: scene.plain(),
            reference: Reference::default(),
            may_have_more: !Lean::takes(span, scene),
        };
        let few = span.frequency(CYCLES_CURVED);
        let is_excluded =
            task.may_have_more && span.expected.is_some_and(|expected| expected < few);
        if is_excluded || !Lean::takes(span, &task.scene) {
            return Ok(false);
        }
        task.reference = Reference::new(span)?;
        let mut solution = lean::Solution::NONE;
        self.fit_lean(span, &task, &mut solution, fit)?;
        if !task.may_have_more {
            return Ok(true);
        }
        // Clipping and ramps show in the frames alone.
        Ok(fit.status == Status::Good && usable_of_plain(span)? == Some(fit.usable))
    }

    /// Tracks the line of the latest fit through the frames after its window, one by one: the span
    /// must begin where the fit's window or the latest span ended. A fit takes as many instructions
    /// as tracking two hundred frames.
    ///
    /// `None` if a new fit is needed: after a fit that was not good, or not of a single line in
    /// white noise at a steady speed; and once the residuals disagree with the fit's noise.
    ///
    /// # Errors
    /// If frames were overwritten before they were read.
    pub fn follow(&mut self, span: &mut FrameSpan) -> Result<Option<Tracked>, Overwritten> {
        Loop::new(self.loop_rows()).follow(span)
    }

    /// Memory of the loop, overwritten by a fit.
    fn loop_rows(&mut self) -> &mut [Values; ROWS] {
        &mut self.workspace.memory.as_chunks_mut().0[0]
    }

    /// Ends the loop after a fit that leaves no line to follow.
    fn end_loop(&mut self) {
        Loop::new(self.loop_rows()).end();
    }

    /// Fits on the lean path. Not inlined, and the solution is in the caller's stack frame, so that
    /// no frame is larger than 4 KiB.
    #[inline(never)]
    fn fit_lean(
        &mut self,
        span: &mut FrameSpan,
        task: &Task,
        solution: &mut lean::Solution,
        fit: &mut Fit,
    ) -> Result<(), Overwritten> {
        let power = self.workspace.memory.as_flattened_mut();
        let fitted = Lean::new(self.blocks.rows(), power, solution).fit(span, task, fit);
        match fitted {
            Ok(()) => Loop::new(self.loop_rows()).start(span, solution, fit),
            Err(Overwritten) => self.end_loop(),
        }
        fitted
    }

    /// Fits all usable channels of a span along a path, and corrects the delay of each channel.
    ///
    /// # Errors
    /// If frames were overwritten before they were read.
    pub fn fit_delayed(
        &mut self,
        span: &mut FrameSpan,
        scene: &Scene,
        delays: &Delays,
    ) -> Result<Fit, Overwritten> {
        let correct: Correct =
            |window, memory, scene, comb, delays| window.has_late(memory, scene, comb, delays);
        // `black_box`: otherwise the compiler would call, and so link, the only such function.
        let correct = core::hint::black_box(correct);
        let correction = Correction { delays, correct };
        let mut fit = Fit::without_tone(Status::Nothing, 0);
        self.fit_all(span, scene, Some(correction), &mut fit)?;
        Ok(fit)
    }

    #[inline(never)]
    fn fit_all(
        &mut self,
        span: &mut FrameSpan,
        scene: &Scene,
        correction: Option<Correction>,
        fit: &mut Fit,
    ) -> Result<(), Overwritten> {
        self.end_loop();
        let statistics = Statistics::collect(span)?;
        *fit = Fit::without_tone(Status::Nothing, statistics.frames);
        if statistics.width == 0 {
            return Ok(());
        }
        // With more gaps than frames the frequency is ambiguous.
        if statistics.frames < FRAMES_MIN || 2 * statistics.frames < span.frames {
            fit.status = Status::TooShort;
            return Ok(());
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
        window.fit(&mut memory, scene, fit);
        let is_lost = window.is_lost;
        // The fit has overwritten the loop.
        self.end_loop();
        if is_lost { Err(Overwritten) } else { Ok(()) }
    }
}

/// Mask of the usable channels of a window; `None` if one is clipped. Not inlined, so that its sums
/// are off the stack while a fit runs.
#[inline(never)]
fn usable_of_plain(span: &mut FrameSpan) -> Result<Option<u16>, Overwritten> {
    let statistics = Statistics::collect(span)?;
    Ok(statistics.is_plain().then(|| statistics.usable()))
}

impl<'d, 's> WindowFrames<'d, 's> {
    /// Subtracts hum, and fits near the expected frequency first.
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

    /// Fits a tone near an expected number of cycles per window only, or anywhere.
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

    /// Sums up the products of the channels, and of the baselines in blocks.
    fn start(&mut self, memory: &mut Memory, scene: &Scene) -> Products {
        let lines = usize::from(scene.harmonics());
        memory.blocks.start(self, lines, scene.may_share())
    }

    /// Corrects the frames for channel delays and the low-pass, using a comb; false if their effect
    /// is below the noise.
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

/// Memory of the steps, and the correction for delays.
struct Memory<'m> {
    blocks: &'m mut Blocks,
    workspace: &'m mut Workspace,
    correction: Option<Correction<'m>>,
}

/// Correction for delays, as a pointer, so that firmware without delays does not link the function.
#[derive(Clone, Copy)]
struct Correction<'c> {
    delays: &'c Delays,
    correct: Correct,
}

/// Corrects frames for delays, using a comb; true if there was an effect.
type Correct = fn(&mut WindowFrames, &mut Memory, &Scene, &Comb, &Delays) -> bool;

/// A window that is being fitted.
struct Window<'w, 'd, 's> {
    frames: &'w mut WindowFrames<'d, 's>,
    scene: &'w Scene,
    all: &'w Products,
    /// True if the tone is searched only near the expected frequency.
    is_expected: bool,
    /// True if a tone is scored even if its strongest line is the fundamental.
    is_scored: bool,
}

impl<'w> Window<'w, '_, '_> {
    /// Finds the likeliest comb near a known frequency, or anywhere; leaves the blocks at its
    /// trajectory.
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

    /// Finds the likeliest comb near a frequency, with the blocks at its unit line. `None` if that
    /// comb has moved to a different frequency.
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

    /// Finds the likeliest comb at the peaks, and at a half and a third of each peak.
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
                // A harmonic of the strongest peak already belongs to that peak's comb.
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
                // A subharmonic of a peak needs a second line next to the peak.
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

    /// Chooses the degree of a comb's baseline. Collects the blocks again, unless the trajectory at
    /// which they were `collected` is near enough.
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
        // The scores so far are from rotated blocks; those below are exact. The lowest and the
        // highest degree were each compared at the comb's own frequency; others are tried at that
        // of the better comb.
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
                // The bound for the lowest other degree covers all others, except below
                // `CYCLES_CURVED`, where a baseline may take the place of lines.
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

    /// Replaces impulses in the residuals of a comb; returns true if there were any.
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

    /// Judges a comb, or only its strongest line if that is likelier: sidebands of a tone with
    /// varying amplitude look like lines of a comb.
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
        // With more unknowns than the window has room for, a comb explains anything and is no
        // likelier.
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
                fraction: 1.0,
            });
        }
    }

    /// Tracks and tests the phase of a comb, and judges the comb.
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
                fraction: 1.0,
            });
            Concluded::UNKNOWN
        })
    }

    /// Judges a tracked tone; returns `None` unless its mean frequency is positive and finite.
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
        // Compare the unknowns of lines and baseline, up to each line, with the window's room of
        // two per cycle: a baseline of degree four alone fills two cycles.
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
                fraction: reading.fraction,
            });
            fit.frequency = span.frequency(mean.cycles);
            // Sigma is at least the rounding of the reported frequency.
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

    /// Subharmonic at which the tone's fundamental would have been subtracted as hum.
    fn hidden(&self, cycles: f32) -> Option<f32> {
        let hum = self.frames.hum?.cycles_per_frame * self.frames.span.effective_frames();
        let parts = (2..=self.scene.harmonics()).map(|part| cycles / f32::from(part));
        let mut hidden = parts.filter(|part| f32::abs(part - hum) < HUM_CYCLES);
        hidden.next()
    }

    /// Log likelihood of the residuals of a tone and its modulation, channel by channel, less the
    /// Bayesian penalty. The workspace's solution must already be solved.
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

    /// Tests the residuals: the deviate of lines between the harmonics, and another line.
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
        // If the tone was expected, an earlier search has covered all other frequencies.
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

/// Figures of a verdict.
struct Concluded {
    /// Score of the tone with its modulation; minus infinity if not scored.
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

/// RMS change of the amplitude over the window, as a fraction.
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
