//! The lean scene: one line in white, independent noise, next to a level and a slope.
//!
//! A path of its own. It reads the frames twice: once to mix channels for one or a few transforms,
//! and once to sum them up in blocks; everything else works on the blocks. A window that is not
//! what the scene declares is not reported as good: see [`declaration`].

mod blocks;
mod declaration;
mod reference;
mod search;
mod solve;
mod verdict;

use crate::domain::Domain;
use crate::fit::{Fit, Status};
use crate::frame_span::FrameSpan;
use crate::limits::FRAMES_MIN;
use crate::scene::{Baseline, Channels, Noise, Scene, Speed};
use crate::source::{Overwritten, Values};
use blocks::Blocks;
pub use blocks::LEAN_ROWS;
use reference::Reference;
use search::{Peak, Search};
use solve::Solution;
use verdict::Verdict;

/// Most passes over the frames at a frequency.
const PASSES: usize = 3;
/// Most steps after a pass.
const STEPS: usize = 6;
/// Steps from each start below [`CYCLES_FEW`] cycles, before the best start is chosen.
const STEPS_OF_START: usize = 3;
/// A step of less than this many standard deviations is the last.
const STEP_LAST: f32 = 0.03;
/// Cycles below which a peak may be off by half a cycle: its own negative frequency is next to it.
const CYCLES_FEW: f32 = 3.0;
/// Starts next to such a peak, cycles.
const STARTS: [f32; 3] = [0.0, -0.5, 0.5];
/// Farther than this from the frequency of the window before, in cycles, is another tone.
const EXPECTED_NEAR: f32 = 0.45;

/// The lean path, in memory that holds nothing between fits.
pub struct Lean<'m> {
    search: Search<'m>,
    blocks: Blocks<'m>,
}

impl Scene {
    /// True for the scenes of the lean path: one harmonic in white, independent noise at a steady
    /// speed, without impulses or curved baselines.
    pub(crate) fn is_lean(&self) -> bool {
        self.harmonics() == 1
            && self.baseline == Baseline::Slope
            && self.noise == Noise::White
            && self.channels == Channels::Independent
            && self.speed == Speed::Steady
            && !self.impulses
    }
}

impl<'m> Lean<'m> {
    /// The path in rows for [`POINTS_MAX`](crate::limits::POINTS_MAX) points and [`LEAN_ROWS`]
    /// more, and in memory for half as many powers.
    pub fn new(rows: &'m mut [Values], power: &'m mut [f32]) -> Self {
        let (points, blocks) = rows.split_at_mut(rows.len().saturating_sub(LEAN_ROWS));
        Self {
            search: Search::new(points.as_flattened_mut(), power),
            blocks: Blocks::new(blocks),
        }
    }

    /// True if the path can fit this span: evenly spaced in time, without an interferer.
    pub fn takes(span: &FrameSpan, scene: &Scene) -> bool {
        scene.is_lean() && span.interferer.is_none() && matches!(span.domain(), Domain::Time { .. })
    }

    /// Fits all usable channels of a span.
    #[inline(never)]
    pub fn fit(&mut self, span: &mut FrameSpan, scene: &Scene) -> Result<Fit, Overwritten> {
        if span.frames < FRAMES_MIN {
            return Ok(Fit::without_tone(Status::TooShort, span.frames));
        }
        let reference = Reference::new(span)?;
        if reference.width == 0 {
            return Ok(Fit::without_tone(Status::Nothing, 0));
        }
        let per_cycle = span.frequency(1.0);
        if let Some(expected) = span.expected {
            let peak = Peak::expected(expected / per_cycle);
            let fit = self.fit_at(span, &reference, &peak)?;
            let moved = f32::abs(fit.frequency / per_cycle - peak.cycles);
            if fit.status == Status::Good && moved < EXPECTED_NEAR {
                return Ok(fit);
            }
        }
        let band = scene.band.over(per_cycle);
        let peak = self.search.peak(span, &reference, band)?;
        self.fit_at(span, &reference, &peak)
    }

    /// The fit of the line at a peak.
    fn fit_at(
        &mut self,
        span: &mut FrameSpan,
        reference: &Reference,
        peak: &Peak,
    ) -> Result<Fit, Overwritten> {
        let blocks = &mut self.blocks;
        let mut solution = Solution::default();
        let mut cycles = peak.cycles;
        for pass in 1..=PASSES {
            blocks.collect(span, reference, cycles)?;
            if blocks.frames() < FRAMES_MIN as f32 || 2.0 * blocks.frames() < span.frames as f32 {
                let frames = blocks.frames() as u32;
                return Ok(Fit::without_tone(Status::TooShort, frames));
            }
            solution = if pass == 1 && peak.is_searched && cycles < CYCLES_FEW {
                Solution::best_of(blocks, reference, &STARTS, STEPS_OF_START)
            } else {
                Solution::at(blocks, reference, 0.0)
            };
            for _ in 0..STEPS {
                let step = solution.step();
                solution = Solution::at(blocks, reference, solution.turn + step);
                if step.abs() < STEP_LAST * solution.turn_sigma {
                    break;
                }
            }
            cycles += solution.cycles();
            if solution.cycles().abs() < blocks.near(solution.sigma(), cycles, reference.width) {
                break;
            }
        }
        let declared = declaration::test(blocks, reference, &solution);
        let second = self.search.second(span, peak, cycles, blocks);
        let verdict = Verdict {
            cycles,
            reference,
            solution: &solution,
            declared: &declared,
            second,
        };
        Ok(verdict.fit(span, blocks))
    }
}
