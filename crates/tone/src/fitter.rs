//! The order of the steps.

use crate::blocks::{Blocks, Pass};
use crate::comb::{Comb, Rival};
use crate::conclude::{self, Figures};
use crate::data::Data;
use crate::fit::{Fit, OtherTone, Status, Tests};
use crate::frame_span::FrameSpan;
use crate::hum::Hum;
use crate::impulses::{self, Impulses};
use crate::late::{Delays, Late};
use crate::lean::follow::{Loop, ROWS, Tracked};
use crate::lean::{self, Lean};
use crate::legendre::legendre;
use crate::limits::{CHANNELS_MAX, FRAMES_MIN};
use crate::lines::Lines;
use crate::movement::{Followed, TWIST_MAX};
use crate::phase_course::Course;
use crate::refine::{Refinement, Steps};
use crate::scene::Scene;
use crate::search::{PEAKS, candidates};
use crate::solve::Shape;
use crate::source::{Overwritten, Values};
use crate::spectrum::Sums;
use crate::statistics::{Products, Statistics};
use crate::tests::{Noise, Other, Tested, Z_LINE};
use crate::work::Work;

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
    work: Work,
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
            work: Work::new(),
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
        &mut self.work.memory.as_chunks_mut().0[0]
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
        let power = self.work.memory.as_flattened_mut();
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
            |data, memory, scene, comb, delays| data.has_late(memory, scene, comb, delays);
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
            work,
        } = self;
        impulses.clear();
        let mut data = Data {
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
            work,
            correction,
        };
        data.fit(&mut memory, scene, &mut fit);
        if data.is_lost {
            Err(Overwritten)
        } else {
            Ok(fit)
        }
    }
}

impl Data<'_, '_> {
    /// Fits what is there.
    fn fit(&mut self, memory: &mut Memory, scene: &Scene, fit: &mut Fit) {
        if let Some(given) = self.span.interferer {
            Hum::take_out(self, memory.blocks, memory.work, given);
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
            let mut window = Window {
                data: self,
                scene,
                all: &all,
                is_expected,
                is_scored: false,
            };
            let Some(comb) = window.best(memory, known) else {
                fit.status = Status::NoTone;
                return;
            };
            if attempt == 1
                && let Some(Correction { delays, correct }) = memory.correction
                && correct(self, memory, scene, &comb, delays)
            {
                known = Some(comb.course.cycles);
                continue;
            }
            let mut window = Window {
                data: self,
                scene,
                all: &all,
                is_expected,
                is_scored: false,
            };
            if !scene.impulses || attempt == ATTEMPTS || !window.has_impulses(memory, &comb) {
                window.conclude_with_rival(memory, &comb, fit);
                return;
            }
            self.centre();
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
        let mut course = comb.course;
        memory.work.restore_weights();
        for number in 0..LATE_FITS {
            let all = self.start(memory, scene);
            let mut window = Window {
                data: self,
                scene,
                all: &all,
                is_expected: false,
                is_scored: false,
            };
            if number > 0 {
                window.collect(memory.blocks, &course, comb.shape.lines);
                let steps = Steps::of_comb(comb.shape);
                let refinement = window.refinement();
                refinement.refine(memory.blocks, &mut course, steps, memory.work);
            }
            memory.work.solution.project(memory.blocks, comb.shape);
            memory.work.solution.solve();
            if !Late::take_out(self, memory.work, &course, delays) {
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
    work: &'m mut Work,
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
type Correct = fn(&mut Data, &mut Memory, &Scene, &Comb, &Delays) -> bool;

/// A window that is fitted.
struct Window<'w, 'd, 's> {
    data: &'w mut Data<'d, 's>,
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
        memory.work.score_of_best = f32::NEG_INFINITY;
        let near = known.and_then(|cycles| Some((self.near(memory, cycles)?, cycles)));
        let (mut best, collected) = match near {
            Some((comb, cycles)) => (comb, Some(Course::steady(cycles))),
            None if self.is_expected => return None,
            None => (self.search(memory)?, None),
        };
        self.choose_degree(memory, &mut best, collected);
        Some(best)
    }

    /// The comb near a frequency, with the blocks at its unit. `None` if the likeliest one there
    /// has another frequency.
    fn near(&mut self, memory: &mut Memory, cycles: f32) -> Option<Comb> {
        let Memory { blocks, work, .. } = memory;
        let refinement = self.refinement();
        let course = Course::steady(cycles);
        self.collect(blocks, &course, refinement.lines(cycles));
        let (degrees, count) = self.degrees(cycles);
        let comb = refinement.best(blocks, work, course, degrees.get(..count)?)?;
        let is_near = f32::abs(comb.course.cycles - cycles) < CYCLES_MIN;
        is_near.then_some(comb)
    }

    /// Degrees of the baseline to try with a candidate, and their number.
    fn degrees(&self, cycles: f32) -> ([usize; 2], usize) {
        let most = self.scene.degree_max();
        let is_curved = cycles < CYCLES_CURVED && most > 1;
        ([1, most], 1 + usize::from(is_curved))
    }

    /// The likeliest comb of those at the peaks, and at half and at a third of each.
    #[inline(never)]
    fn search(&mut self, memory: &mut Memory) -> Option<Comb> {
        let Memory { blocks, work, .. } = memory;
        let refinement = self.refinement();
        let mut peaks = self.candidates(blocks, work);
        let mut tried = [0.0f32; PEAKS * DIVISORS];
        let mut rivals = [Rival::NONE; PEAKS * DIVISORS];
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
                let course = Course::steady(cycles);
                self.collect(blocks, &course, refinement.lines(cycles));
                let (degrees, degrees_count) = self.degrees(cycles);
                let degrees = degrees.get(..degrees_count).unwrap_or_default();
                let most = degrees.last().copied().unwrap_or(1);
                // A part of a peak's frequency needs a line next to the peak's own.
                let fewest = if divisor > 1 { 2 } else { 1 };
                let least = Shape {
                    lines: Lines::up_to(fewest),
                    degree: 1,
                };
                if let Some(best) = &best
                    && refinement.bound(blocks, work, most, &least) < best.score
                {
                    continue;
                }
                let (Some(place), Some(rival)) = (tried.get_mut(count), rivals.get_mut(count))
                else {
                    break;
                };
                *place = cycles;
                count += 1;
                let Some(comb) = refinement.best(blocks, work, course, degrees) else {
                    continue;
                };
                if divisor == 1 {
                    *peak = comb.unit.cycles;
                    *place = comb.unit.cycles;
                    if i == 0 {
                        first = comb.kept;
                    }
                }
                *rival = Rival {
                    score: comb.score,
                    cycles: comb.course.cycles,
                };
                if best.is_none_or(|best| comb.score > best.score) {
                    best = Some(comb);
                }
            }
        }
        let mut best = best?;
        let cycles = best.course.cycles;
        let others = rivals
            .iter()
            .filter(|rival| f32::abs(rival.cycles - cycles) > CYCLES_MIN);
        best.rival = others.fold(Rival::NONE, |most, rival| {
            if rival.score > most.score {
                *rival
            } else {
                most
            }
        });
        best.rival.score -= best.score;
        Some(best)
    }

    /// Fits a comb with each degree of the baseline, by blocks that are at it: they were `collected`
    /// near it, or are collected anew.
    #[inline(never)]
    fn choose_degree(&mut self, memory: &mut Memory, best: &mut Comb, collected: Option<Course>) {
        let Memory { blocks, work, .. } = memory;
        let refinement = self.refinement();
        let cycles = best.course.cycles;
        let lines = refinement.lines(cycles).and(best.shape.lines);
        let twist = collected.map(|from| blocks.twist(&from, &best.course) * lines.most() as f32);
        if twist.is_none_or(|twist| twist > TWIST_MAX) || blocks.lines() != lines {
            self.collect(blocks, &best.course, lines);
        }
        // Blocks that were turned gave the scores so far; these are exact. The least and the highest
        // degree were compared each at its own frequency; those between are at that of the better one.
        let (mut at, degree) = (best.course, best.shape.degree);
        best.score = f32::NEG_INFINITY;
        work.restore_weights();
        let most = self.scene.degree_max();
        let others = (1..=most).filter(|other| *other != degree);
        let mut are_bounded = false;
        for other in core::iter::once(degree).chain(others) {
            let mut steps = Steps::of_comb(best.shape);
            steps.shape.degree = other;
            if other != degree {
                // The first of the others is the least. Below, lines may be left out beside a baseline.
                if !are_bounded
                    && cycles >= CYCLES_CURVED
                    && refinement.bound(blocks, work, most, &steps.shape) <= best.score
                {
                    break;
                }
                are_bounded = true;
                work.solution.project(blocks, steps.shape);
                if refinement.score(&work.solution) <= best.score {
                    continue;
                }
            }
            let from = at;
            refinement.refine(blocks, &mut at, steps, work);
            work.solution.project(blocks, steps.shape);
            let score = refinement.score(&work.solution);
            if score > best.score {
                (best.score, best.shape, best.course) = (score, steps.shape, at);
            } else {
                blocks.turn(&at, &from);
                at = from;
            }
        }
    }

    /// Replaces what a comb leaves of single values; whether there are some.
    #[inline(never)]
    fn has_impulses(&mut self, memory: &mut Memory, comb: &Comb) -> bool {
        let Work {
            solution,
            memory: found,
            ..
        } = &mut *memory.work;
        solution.project(memory.blocks, comb.shape);
        solution.solve();
        let found = found.as_flattened_mut();
        impulses::replace(self.data, solution, &comb.course, found) > 0
    }

    /// The verdict on a comb, or on the strongest of its lines where that is likelier: lines next to
    /// a tone whose amplitude moves look like those of a comb.
    #[inline(never)]
    fn conclude_with_rival(&mut self, memory: &mut Memory, comb: &Comb, fit: &mut Fit) {
        let found = self.conclude(memory, comb, fit);
        if found.strongest < 2 || !fit.status.has_tone() {
            return;
        }
        let cycles = found.strongest as f32 * comb.course.cycles;
        memory.work.score_of_best = f32::NEG_INFINITY;
        let Some(mut line) = self.near(memory, cycles) else {
            return;
        };
        self.choose_degree(memory, &mut line, Some(Course::steady(cycles)));
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
        let Memory { blocks, work, .. } = memory;
        let refinement = self.refinement();
        let mut followed = Followed::at(comb.course, comb.shape);
        work.restore_weights();
        let mut recollect = |blocks: &mut Blocks, course: &Course, lines: Lines| {
            self.collect(blocks, course, lines);
        };
        let is_known = refinement.follow(blocks, work, &mut followed, &mut recollect);
        let judged = is_known.then(|| self.judge(memory, &followed, &comb.rival, fit));
        judged.flatten().unwrap_or_else(|| {
            let frequency = |cycles| self.data.span.frequency(cycles);
            let rival = if comb.rival.cycles > 0.0 {
                comb.rival.cycles
            } else {
                0.5 * comb.course.cycles
            };
            fit.status = Status::Ambiguous;
            fit.frequency = frequency(comb.course.cycles);
            fit.sigma = fit.frequency;
            fit.other_tone = Some(OtherTone {
                frequency: frequency(rival),
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
        rival: &Rival,
        fit: &mut Fit,
    ) -> Option<Concluded> {
        let work = &*memory.work;
        let (reach, width) = (self.data.reach(), self.data.width());
        let tested = Tested::new(followed, work, reach, width);
        let clipped = &self.data.statistics.clipped;
        let mean = conclude::mean(&tested, work, memory.blocks, self.scene, clipped);
        if !(mean.cycles > 0.0 && (mean.cycles + mean.sigma).is_finite()) {
            return None;
        }
        let mut tests = Tests::default();
        tested.near(&work.neighbours, &mut tests);
        let nearest = work.neighbours.strongest_near();
        let shape = tested.shape;
        let [strongest, second] = strongest(&tested);
        let span = &*self.data.span;
        let movement = conclude::movement(followed, &work.normal.matrix, &mean, span);
        let overtones = conclude::overtones(&work.solution, &followed.variances, width);
        let statistics = &self.data.statistics;
        tests.cycles = followed.course.cycles;
        tests.margin = -rival.score;
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
            rival,
            image: Some(tested.loudest as f32 * tests.cycles)
                .filter(|cycles| reach.folds && *cycles > reach.most),
            strongest,
            second,
            nearest,
            hidden: self.hidden(mean.cycles),
            is_crowded,
            stay: statistics.stay,
            lines: shape.lines.count(),
            reach,
        };
        conclude::channels(followed, &work.solution, statistics, fit);
        let mut other = Other::default();
        let mut between = 0.0;
        if tests.line >= Z_LINE {
            (between, other) = self.beside(memory, &tested);
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
        let (span, statistics) = (&*self.data.span, &self.data.statistics);
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
            fit.harmonics = shape.lines.most() as u8;
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
        let hum = self.data.hum?.cycles_per_frame * self.data.span.effective_frames();
        let parts = (2..=self.scene.harmonics()).map(|part| cycles / f32::from(part));
        let mut hidden = parts.filter(|part| f32::abs(part - hum) < HUM_CYCLES);
        hidden.next()
    }

    /// Logarithm of the likelihood of what a tone and its movement leave of the frames, channel by
    /// channel, less the Bayesian criterion's price. The solution is solved.
    #[inline(never)]
    fn score(&mut self, memory: &mut Memory, tested: &Tested) -> f32 {
        let model = tested.model(&memory.work.solution);
        let (width, mut squares) = (self.data.width(), [0.0; CHANNELS_MAX]);
        self.data.visit_beside(Some(&model), |frame| {
            let pairs = squares.iter_mut().zip(&frame.values);
            pairs.for_each(|(square, value)| *square += value * value);
        });
        let frames = self.all.count;
        let pairs = squares.iter().zip(&self.all.least).take(width);
        let logs: f32 = pairs
            .map(|(square, least)| libm::logf(square.max(*least) / frames))
            .sum();
        let unknowns = width * tested.shape.unknowns()
            + tested.followed.unknowns().max(tested.followed.fitted.phase);
        -0.5 * (frames * logs + unknowns as f32 * libm::logf(frames))
    }

    /// What a tone leaves: the deviate of lines between its own, and another line.
    #[inline(never)]
    fn beside(&mut self, memory: &mut Memory, tested: &Tested) -> (f32, Other) {
        let Memory { blocks, work, .. } = memory;
        let mut between = 0.0;
        if tested.followed.moves {
            tested.followed.take_out_motion(blocks, &mut work.solution);
        } else {
            work.solution.project(blocks, tested.shape);
        }
        if self.scene.harmonics() > 1 {
            let mut noise = Noise {
                neighbours: &mut work.neighbours,
                memory: &mut work.memory,
                weights: &work.weights,
                all: self.all,
            };
            between = tested.between(self.data, &work.solution, blocks, &mut noise);
        }
        if !tested.followed.moves {
            work.solution.solve();
        }
        let model = tested.model(&work.solution);
        // Where the tone was expected, the search before has looked at all other frequencies.
        if self.is_expected {
            return (between, Other::default());
        }
        let sums = Sums {
            memory: work.memory.as_flattened_mut(),
            more: work.normal.matrix.as_flattened_mut(),
        };
        let other = tested.other(self.data, &model, sums, blocks.scratch());
        (between, other)
    }

    fn collect(&mut self, blocks: &mut Blocks, course: &Course, lines: Lines) {
        let pass = Pass {
            course: *course,
            scale: 1.0,
            lines,
            most: 2 * lines.most(),
        };
        blocks.collect(self.data, &pass, None);
    }

    #[inline(never)]
    fn candidates(&mut self, blocks: &mut Blocks, work: &mut Work) -> [f32; PEAKS] {
        let (all, scene) = (self.all, self.scene);
        candidates(self.data, blocks, work, all, scene)
    }

    fn refinement(&self) -> Refinement<'w> {
        Refinement {
            all: self.all,
            width: self.data.width(),
            frames: self.all.count,
            harmonics: usize::from(self.scene.harmonics()),
            may_share: self.scene.may_share(),
            is_white: self.scene.is_white(),
            reach: self.data.reach(),
            band: self.scene.band.over(self.data.span.frequency(1.0)),
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
    use crate::{blocks, work};
    extern crate std;
    use std::format;

    /// Maximum number of bytes of a fitter on the chip.
    const BUDGET: usize = 23_000;

    #[test]
    fn on_the_chip_it_takes_no_more_than_its_budget() {
        let rows = |lines, points| blocks::rows(lines, points) + work::rows(points);
        let longer = (rows(BLOCK_LINES, POINTS_MAX) - rows(BLOCK_LINES_CHIP, POINTS_CHIP))
            * size_of::<crate::source::Values>()
            + (BLOCK_LINES - BLOCK_LINES_CHIP) * size_of::<blocks::Wave>();
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
