//! Lean scenes: lines in white, independent noise, with a level and a slope.
//!
//! A separate code path. It reads the frames twice: once to mix channels for one or a few
//! transforms, and once to sum up blocks, on which everything else works. With several lines it may
//! read them again for each possible fundamental of the highest peak. A window that is not as the
//! scene declares is not reported as good: see [`declaration`].

mod blocks;
mod declaration;
pub mod follow;
mod plain;
mod reference;
mod search;
mod solve;
mod verdict;

use crate::domain::Domain;
use crate::fit::{Fit, OtherTone, Status};
use crate::frame_span::FrameSpan;
use crate::limits::FRAMES_MIN;
use crate::scene::{Band, Baseline, Channels, Noise, Scene, Speed};
use crate::source::{Overwritten, Values};
pub use blocks::LEAN_ROWS;
use blocks::{BLOCKS_FEWER, Blocks, LINES, Pass};
use declaration::Tested;
pub use reference::Reference;
use search::{Comb, Peak, Search};
pub use solve::Solution;
use verdict::{Line, Verdict};

/// Maximum number of passes over the frames when a peak is fitted.
const PASSES: usize = 3;
/// Maximum number of steps after a pass.
const STEPS: usize = 6;
/// A step of less than this many standard deviations is the last.
const STEP_LAST: f32 = 0.03;
/// Lines are chosen once a step is below this many standard deviations.
const STEP_NEAR: f32 = 1.0;
/// Number of cycles below which a peak may be off by half a cycle, due to its negative frequency.
const CYCLES_FEW: f32 = 3.0;
/// Starting points relative to a peak of few cycles, cycles per window.
const STARTS: [f32; 3] = [0.0, -0.5, 0.5];
/// Maximum distance from the expected frequency, cycles; a tone further away counts as a different
/// tone.
const EXPECTED_NEAR: f32 = 0.45;
/// Number of cycles below which a curved baseline resembles a tone.
pub const CYCLES_CURVED: f32 = 5.0;
/// Minimum number of cycles of a subharmonic of a peak.
const CYCLES_PART: f32 = 0.8;
/// Threshold for keeping a line: one in a thousand by chance.
const Z_KEPT: f32 = 3.1;

/// A fit of a lean scene.
pub struct Task {
    pub scene: Scene,
    pub reference: Reference,
    /// True if the window may contain more than the lean scene.
    pub may_have_more: bool,
}

/// The lean path, with memory that is free between fits.
pub struct Lean<'m> {
    search: Search<'m>,
    blocks: Blocks<'m>,
    solution: &'m mut Solution,
    /// True if the fundamental is the strongest line.
    is_lowest_strongest: bool,
}

impl<'m> Lean<'m> {
    /// The lean path with memory: rows for [`POINTS_MAX`](crate::limits::POINTS_MAX) points and
    /// [`LEAN_ROWS`] more, half as many powers, and a solution.
    #[inline(always)]
    pub fn new(rows: &'m mut [Values], power: &'m mut [f32], solution: &'m mut Solution) -> Self {
        let (points, blocks) = rows.split_at_mut(rows.len().saturating_sub(LEAN_ROWS));
        Self {
            search: Search::new(points, power),
            blocks: Blocks::new(blocks),
            solution,
            is_lowest_strongest: false,
        }
    }

    /// True for scenes and spans that the lean path covers: lines in white, independent noise at a
    /// steady speed, without impulses or curved baselines; evenly spaced in time, without an
    /// interferer.
    pub fn takes(span: &FrameSpan, scene: &Scene) -> bool {
        usize::from(scene.harmonics()) <= LINES
            && scene.baseline == Baseline::Slope
            && scene.noise == Noise::White
            && scene.channels == Channels::Independent
            && scene.speed == Speed::Steady
            && !scene.impulses
            && span.interferer.is_none()
            && matches!(span.domain(), Domain::Time { .. })
    }

    /// Fits all usable channels of a span. If the window may contain more than the lean scene, the
    /// fit is good only if tests find nothing more.
    #[inline(never)]
    pub fn fit(
        &mut self,
        span: &mut FrameSpan,
        task: &Task,
        fit: &mut Fit,
    ) -> Result<(), Overwritten> {
        if span.frames < FRAMES_MIN {
            (fit.status, fit.frames) = (Status::TooShort, span.frames);
            return Ok(());
        }
        if task.reference.width == 0 {
            return Ok(());
        }
        self.fit_any(span, task, fit)?;
        if task.may_have_more && fit.status == Status::Good && !self.is_plain(span, task, fit)? {
            fit.status = Status::Unsteady;
        }
        Ok(())
    }

    /// True if the frames contain only what was fitted. Adds the movement to the fit.
    #[inline(never)]
    fn is_plain(
        &mut self,
        span: &mut FrameSpan,
        task: &Task,
        fit: &mut Fit,
    ) -> Result<bool, Overwritten> {
        let per_cycle = span.frequency(1.0);
        let (cycles, harmonics) = (fit.tests.cycles, usize::from(task.scene.harmonics()));
        if fit.tests.beside > plain::Z_OF_SEVEN
            || cycles < CYCLES_CURVED
            || Self::lines(span, cycles, harmonics) < harmonics.min(LINES)
            || !self.is_lowest_strongest
        {
            return Ok(false);
        }
        let tested = Tested {
            solution: self.solution,
            place: 0,
            harmonics,
        };
        let fitted = plain::Fitted {
            reference: &task.reference,
            tested,
            cycles,
        };
        let plain = plain::test(span, &fitted, self.search.scratch())?;
        fit.frequency += per_cycle * plain.step;
        fit.movement = plain.movement(cycles, per_cycle * span.per_u());
        Ok(plain.is_met())
    }

    /// Fits near the expected frequency, or anywhere.
    #[inline(never)]
    fn fit_any(
        &mut self,
        span: &mut FrameSpan,
        task: &Task,
        fit: &mut Fit,
    ) -> Result<(), Overwritten> {
        let scene = &task.scene;
        let per_cycle = span.frequency(1.0);
        let harmonics = usize::from(scene.harmonics());
        if let Some(expected) = span.expected {
            let cycles = expected / per_cycle;
            let peak = Peak {
                cycles,
                is_searched: false,
            };
            self.fit_at(span, task, &peak, fit)?;
            let moved = f32::abs(fit.frequency / per_cycle - peak.cycles);
            let is_near = moved < EXPECTED_NEAR && fit.status.has_tone();
            // Near a tone that is not good, the whole fit does better than another search.
            let is_whole_fit_due = task.may_have_more && self.is_lowest_strongest;
            if is_near && (fit.status == Status::Good || is_whole_fit_due) {
                return Ok(());
            }
        }
        let band = scene.band.over(per_cycle);
        // Harmonics may be above the band of the fundamental.
        let lines = Band {
            max: band.max * harmonics as f32,
            ..band
        };
        let peak = self.search.peak(span, &task.reference, lines)?;
        if task.may_have_more && peak.cycles < CYCLES_CURVED {
            fit.status = Status::Ambiguous;
            return Ok(());
        }
        self.fit_at(span, task, &peak, fit)?;
        let may_be_part = matches!(fit.status, Status::Ambiguous | Status::NoTone);
        if harmonics == 1 || !may_be_part || task.may_have_more {
            return Ok(());
        }
        // The peak may be a harmonic.
        match self.part_of(span, &task.reference, &peak, scene)? {
            None => {}
            Some(Part::Likelier(peak)) => self.fit_at(span, task, &peak, fit)?,
            Some(Part::Close(cycles)) => {
                let frequency = span.frequency(cycles);
                let fraction = 1.0;
                fit.other_tone = Some(OtherTone {
                    frequency,
                    fraction,
                });
            }
        }
        Ok(())
    }

    /// Number of harmonics below half the frame rate, at least 1.
    fn lines(span: &FrameSpan, cycles: f32, harmonics: usize) -> usize {
        let max = 0.5 * (span.frames as f32 - 1.0);
        (1..=harmonics.min(LINES))
            .take_while(|line| *line == 1 || *line as f32 * cycles < max)
            .count()
    }

    /// Finds a subharmonic that is a likelier fundamental than the peak; the current solution must
    /// be that of the peak.
    #[inline(never)]
    fn part_of(
        &mut self,
        span: &mut FrameSpan,
        reference: &Reference,
        peak: &Peak,
        scene: &Scene,
    ) -> Result<Option<Part>, Overwritten> {
        let band = scene.band.over(span.frequency(1.0));
        let harmonics = usize::from(scene.harmonics());
        let of_peak = self.solution.score(reference);
        let peak_comb = Comb::new(peak.cycles, harmonics, span.frames);
        // Margin by which a subharmonic must win, because it needs a second line next to the peak.
        let margin = reference.width as f32 * libm::logf(span.frames as f32);
        let (mut best, mut found): (f32, Option<f32>) = (of_peak, None);
        for part in 2..=harmonics {
            let cycles = peak.cycles / part as f32;
            let lines = Self::lines(span, cycles, harmonics);
            let comb = Comb::new(cycles, harmonics, span.frames);
            let is_in = cycles > CYCLES_PART && band.has(cycles);
            if !is_in || !self.search.may_have(&comb, &peak_comb, part) {
                continue;
            }
            let pass = Pass {
                cycles,
                lines,
                blocks: Blocks::max(span.frames, lines),
            };
            let scratch = self.search.scratch();
            self.blocks.collect(span, reference, pass, scratch)?;
            self.solution.choose((2 << lines) - 2);
            self.solution.solve(&self.blocks, reference, 0.0);
            let turn = self.solution.turn + self.solution.step();
            self.solution.solve(&self.blocks, reference, turn);
            let score = self.solution.score(reference);
            if score
                > best
                    + if found.is_some() {
                        margin
                    } else {
                        0.5 * margin
                    }
            {
                self.solution.finish();
                best = score;
                found = Some(cycles + self.solution.cycles());
            }
        }
        Ok(found.map(|cycles| {
            if best > of_peak + margin {
                Part::Likelier(Peak { cycles, ..*peak })
            } else {
                Part::Close(cycles)
            }
        }))
    }

    /// Fits the lines at a peak and its multiples.
    fn fit_at(
        &mut self,
        span: &mut FrameSpan,
        task: &Task,
        peak: &Peak,
        fit: &mut Fit,
    ) -> Result<(), Overwritten> {
        let (reference, harmonics) = (&task.reference, usize::from(task.scene.harmonics()));
        let lines = Self::lines(span, peak.cycles, harmonics);
        self.solution.choose((2 << lines) - 2);
        let mut cycles = peak.cycles;
        let max = Blocks::max(span.frames, harmonics);
        let is_open = peak.is_searched && harmonics == 1 && cycles < CYCLES_FEW;
        for pass in 1..=PASSES {
            let (blocks, solution) = (&mut self.blocks, &mut *self.solution);
            let is_open = is_open && pass == 1;
            let pass = Pass {
                cycles,
                lines,
                blocks: if is_open { BLOCKS_FEWER } else { max },
            };
            let scratch = self.search.scratch();
            blocks.collect(span, reference, pass, scratch)?;
            let frames = blocks.frames();
            if frames < FRAMES_MIN as f32 || 2.0 * frames < span.frames as f32 {
                *fit = Fit::without_tone(Status::TooShort, frames as u32);
                return Ok(());
            }
            if is_open {
                solution.start(blocks, reference, &STARTS);
            } else {
                solution.solve(blocks, reference, 0.0);
            }
            let mut is_chosen = false;
            for _ in 0..STEPS {
                let step = f32::abs(solution.step()) / solution.turn_sigma;
                if !is_chosen && step < STEP_NEAR {
                    is_chosen = true;
                    let kept = kept(solution, reference);
                    if kept != solution.mask() {
                        solution.choose(kept);
                        solution.solve(blocks, reference, solution.turn);
                        continue;
                    }
                }
                if step < STEP_LAST {
                    solution.finish();
                    break;
                }
                solution.solve(blocks, reference, solution.turn + solution.step());
            }
            cycles += solution.cycles();
            if solution.cycles().abs() < blocks.near(solution.sigma(), cycles, reference.width) {
                break;
            }
        }
        let (blocks, solution) = (&self.blocks, &*self.solution);
        let fundamental = Line::new(solution, reference, 0);
        let (mut strongest, mut noise) = (fundamental, fundamental.noise);
        for place in 1..solution.orders().len() {
            let line = Line::new(solution, reference, place);
            noise += line.noise;
            if line.power > strongest.power {
                strongest = line;
            }
        }
        self.is_lowest_strongest = strongest.place == 0;
        let tested = Tested {
            solution,
            place: strongest.place,
            harmonics,
        };
        let declared = declaration::test(blocks, reference, &tested, self.search.scratch());
        let missing = 1.0 - blocks.frames() / span.frames.max(1) as f32;
        let comb = Comb::new(cycles, harmonics, span.frames);
        let second = if peak.is_searched {
            self.search.second(&comb, missing)
        } else {
            None
        };
        let verdict = Verdict {
            cycles,
            reference,
            solution,
            strongest: &strongest,
            fundamental: &fundamental,
            noise,
            declared: &declared,
            second,
        };
        verdict.fit(span, blocks, fit);
        Ok(())
    }
}

/// A subharmonic of a peak.
enum Part {
    /// Explains the window better.
    Likelier(Peak),
    /// Explains the window nearly as well (frequency in cycles per window).
    Close(f32),
}

/// Mask of the lines whose power stands out of the noise, and of the fundamental.
fn kept(solution: &Solution, reference: &Reference) -> u16 {
    let mut kept = 0b10;
    for (place, order) in solution.orders().iter().enumerate().skip(1) {
        if Line::new(solution, reference, place).deviate > Z_KEPT {
            kept |= 1 << order;
        }
    }
    kept
}
