//! The order of the steps.

use crate::blocks::{Blocks, Pass};
use crate::comb::{Comb, Work};
use crate::conclude::{self, Figures};
use crate::fit::{Fit, Status, Tests};
use crate::frame_span::FrameSpan;
use crate::hum::Hum;
use crate::impulses;
use crate::legendre::legendre;
use crate::limits::FRAMES_MIN;
use crate::lines::Lines;
use crate::movement::Followed;
use crate::phase_course::Course;
use crate::pieces::{Data, Filter, Pieces, frames_each};
use crate::refine::Refinement;
use crate::scene::Scene;
use crate::search::{PEAKS, candidates};
use crate::solve::{Shape, Solution};
use crate::source::Overwritten;
use crate::statistics::{Products, Statistics};
use crate::tests::{Other, Tested, Z_LINE};

/// Fits of a window whose impulses are replaced, the last included.
const ATTEMPTS: usize = 3;
/// Parts of a peak's frequency that are tried, where there are as many harmonics.
const DIVISORS: usize = 3;
/// Fewest cycles of a candidate.
const CYCLES_LEAST: f32 = 0.45;
/// Candidates nearer than this, in cycles, are one.
const CANDIDATES_APART: f32 = 0.1;
/// Below this many cycles a curved baseline is tried for every candidate.
const CYCLES_CURVED: f32 = 5.0;

/// The estimator: memory of its steps.
#[derive(Debug)]
pub struct Fitter {
    pieces: Pieces,
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
            pieces: Pieces::new(),
            blocks: Blocks::new(),
            work: Work::new(),
        }
    }

    /// Memory that holds nothing between fits.
    pub fn scratch(&mut self) -> &mut [f32] {
        self.blocks.scratch()
    }

    /// Fits all usable channels of a span.
    ///
    /// # Errors
    /// If its frames were overwritten meanwhile.
    #[inline(never)]
    pub fn fit(&mut self, span: &mut FrameSpan, scene: &Scene) -> Result<Fit, Overwritten> {
        let each = frames_each(span.frames);
        span.trim(each);
        let statistics = Statistics::collect(span)?;
        if statistics.width == 0 || statistics.frames < FRAMES_MIN {
            return Ok(Fit::without_tone(Status::Nothing, statistics.frames));
        }
        // More gaps than frames leave the frequency open.
        if 2 * statistics.frames < span.frames {
            return Ok(Fit::without_tone(Status::TooShort, statistics.frames));
        }
        statistics.keep(span, &mut self.pieces)?;
        let Self {
            pieces,
            blocks,
            work,
        } = self;
        let rounding = statistics.rounding(span);
        let mut data = Data {
            pieces,
            place: *span.abscissa(),
            each,
            width: statistics.width,
            cycles_max: 0.5 * span.effective_frames() / each as f32,
        };
        let hum = span
            .interferer
            .and_then(|given| Hum::take_out(&mut data, &rounding, blocks, work, given));
        let mut memory = Memory { blocks, work };
        let mut attempt = 1;
        let mut fit = loop {
            let all = data.products(&rounding, scene.may_share());
            let mut window = Window {
                data: &mut data,
                statistics: &statistics,
                scene,
                all: &all,
                span,
            };
            let Some(comb) = window.best(&mut memory) else {
                return Ok(Fit::without_tone(Status::NoTone, statistics.frames));
            };
            if scene.impulses && attempt < ATTEMPTS && window.has_impulses(&mut memory, &comb) {
                attempt += 1;
                data.centre();
                continue;
            }
            break window.conclude(&mut memory, &comb);
        };
        fit.interferer = hum.map(|hum| hum.cycles_per_frame());
        Ok(fit)
    }
}

/// Memory of the steps.
struct Memory<'m> {
    blocks: &'m mut Blocks,
    work: &'m mut Work,
}

/// A window that is fitted.
struct Window<'w, 'd, 's> {
    data: &'w mut Data<'d>,
    statistics: &'w Statistics,
    scene: &'w Scene,
    all: &'w Products,
    span: &'w FrameSpan<'s>,
}

impl<'w> Window<'w, '_, '_> {
    /// The likeliest comb of those at the peaks, and at half and at a third of each; the blocks are at
    /// it.
    #[inline(never)]
    fn best(&self, memory: &mut Memory) -> Option<Comb> {
        let Memory { blocks, work } = memory;
        let (refinement, scene) = (self.refinement(), self.scene);
        let unit = self.span.frequency(1.0);
        let mut peaks = candidates(self.data, blocks.scratch(), &self.all.matrix, scene, unit);
        blocks.start(self.data);
        let most = scene.degree_max();
        let mut tried = [0.0f32; PEAKS * DIVISORS];
        let (mut best, mut count, mut first) = (None::<Comb>, 0, Lines::NONE);
        for divisor in 1..=DIVISORS.min(refinement.harmonics) {
            for (i, peak) in peaks.iter_mut().enumerate() {
                let cycles = *peak / divisor as f32;
                // A harmonic of the strongest peak is a line of its comb already.
                let times = libm::roundf(*peak / tried[0].max(CYCLES_LEAST));
                let is_harmonic = f32::abs(*peak - times * tried[0]) < CANDIDATES_APART
                    && first.has(times as usize);
                let is_known = i > 0 && is_harmonic
                    || tried[..count]
                        .iter()
                        .any(|other| f32::abs(other - cycles) < CANDIDATES_APART);
                if cycles < CYCLES_LEAST || is_known {
                    continue;
                }
                tried[count] = cycles;
                count += 1;
                let course = Course::steady(cycles);
                self.collect(blocks, &course, refinement.lines(cycles));
                let degrees = [1, most];
                let curved = usize::from(cycles < CYCLES_CURVED && most > 1);
                if let Some(best) = &best
                    && divisor > 1
                    && refinement.bound(blocks, degrees[curved]) < best.score
                {
                    continue;
                }
                let comb = refinement.best(blocks, work, course, &degrees[..=curved])?;
                if divisor == 1 {
                    *peak = comb.tried;
                    tried[count - 1] = comb.tried;
                    if i == 0 {
                        first = comb.kept;
                    }
                }
                if best.as_ref().is_none_or(|best| comb.score > best.score) {
                    best = Some(comb);
                }
            }
        }
        let mut best = best?;
        let lines = refinement.lines(best.course.cycles);
        self.collect(blocks, &best.course, lines.and(best.shape.lines));
        for degree in 2..most {
            let shape = Shape {
                degree,
                ..best.shape
            };
            let score = refinement.score(&Solution::new(blocks, shape));
            if score > best.score {
                (best.score, best.shape) = (score, shape);
            }
        }
        Some(best)
    }

    /// Replaces what a comb leaves of single values; whether there are some.
    #[inline(never)]
    fn has_impulses(&mut self, memory: &mut Memory, comb: &Comb) -> bool {
        let solution = Solution::new(memory.blocks, comb.shape);
        impulses::replace(self.data, &solution, &comb.course) > 0
    }

    /// The verdict on a comb, whose phase is followed and tested. It leaves the residuals in the
    /// window's memory.
    #[inline(never)]
    fn conclude(&mut self, memory: &mut Memory, comb: &Comb) -> Fit {
        let Memory { blocks, work } = memory;
        let (statistics, scene) = (self.statistics, self.scene);
        let refinement = self.refinement();
        let cycles_max = refinement.cycles_max;
        let mut followed = Followed::none();
        followed.course = comb.course;
        followed.solution.shape = comb.shape;
        followed.noise.inverse = comb.weights;
        let mut recollect = |blocks: &mut Blocks, course: &Course, lines: Lines| {
            self.collect(blocks, course, lines);
        };
        let is_known = refinement.follow(blocks, work, &mut followed, &mut recollect);
        let mut fit = Fit::without_tone(Status::Ambiguous, statistics.frames);
        if !is_known {
            fit.frequency = self.span.frequency(comb.course.cycles);
            fit.sigma = fit.frequency;
            return fit;
        }
        let tested = Tested::new(&followed, cycles_max, statistics.width);
        let powers = tested.powers();
        let mean = conclude::mean(&followed, &powers, &work.neighbours, blocks, scene);
        let mut tests = Tests::default();
        tested.near(&work.neighbours, &mut tests);
        let mut other = Other::default();
        if tests.line >= Z_LINE {
            let model = tested.model();
            self.data
                .change(&mut |piece| piece.values = model.residual(piece));
            if scene.harmonics() > 1 {
                tests.between = tested.between(self.data, blocks, work);
            }
            other = tested.other(self.data, blocks.scratch());
        }
        let shape = followed.solution.shape;
        tests.other = other.deviate;
        tests.cycles = followed.course.cycles;
        tests.unfollowed = libm::sqrtf(mean.phase.unfollowed);
        tests.fading = fading(&followed);
        tests.steady = mean.phase.steady;
        tests.degree = shape.degree as u8;
        tests.degrees = followed.fitted.phase as u8;
        tests.lines = shape.lines.iter().fold(0, |mask, line| mask | 1 << line);
        let strongest = shape
            .lines
            .iter()
            .zip(&powers)
            .fold((0, 0.0), |best, (line, power)| {
                if power.all > best.1 {
                    (line, power.all)
                } else {
                    best
                }
            });
        let room = 2.0 * shape.lines.most() as f32 * tests.cycles + 1.0;
        let verdict = Figures {
            tests: &tests,
            mean: &mean,
            other: &other,
            lowest: shape.lines.least(),
            strongest: strongest.0,
            is_crowded: shape.degree > 1 && room < (2 * shape.lines.count() + shape.degree) as f32,
            lines: shape.lines.count(),
        };
        fit.status = verdict.status();
        fit.tests = tests;
        let per_piece = followed.course.cycles / (2.0 * self.data.cycles_max);
        let gain = Filter::new(self.data.each).gain(per_piece);
        conclude::channels(&followed, statistics, gain, &mut fit);
        if fit.status.has_tone() {
            let span = self.span;
            fit.other_tone = verdict.other_tone(span);
            fit.frequency = span.frequency(mean.cycles);
            fit.sigma = span.frequency(mean.sigma);
            fit.movement = conclude::movement(&followed, &mean, span);
            fit.harmonics = shape.lines.most() as u8;
            fit.overtones = conclude::overtones(&followed, statistics.width);
            let with_tone = tested.with_tone();
            for k in 0..statistics.width {
                fit.with_tone |= (with_tone >> k & 1) << statistics.order[k];
            }
        }
        fit
    }

    fn collect(&self, blocks: &mut Blocks, course: &Course, lines: Lines) {
        let pass = Pass {
            course: *course,
            scale: 1.0,
            lines,
            most: 2 * lines.most(),
        };
        blocks.collect(self.data, &pass);
    }

    fn refinement(&self) -> Refinement<'w> {
        Refinement {
            all: self.all,
            width: self.statistics.width,
            frames: self.all.count,
            harmonics: usize::from(self.scene.harmonics()),
            may_share: self.scene.may_share(),
            // Lines above half the pieces' rate are where they are folded to.
            cycles_max: self.data.cycles_max * self.data.each as f32,
        }
    }
}

/// How far the amplitude goes, root mean square over the blocks.
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
    libm::sqrtf(square.sum::<f32>() / PLACES as f32)
}
