//! A known interferer, mains hum, followed to where it is in truth.

use crate::blocks::Lines;
use crate::frame_span::FrameSpan;
use crate::phase::{TURN, from_turns};
use crate::refine::{Limits, Refinement, Summit};
use crate::search;
use crate::source::Overwritten;
use crate::statistics::Channels;

/// An interferer of fewer cycles in a span than this, as sampling folds it, is a part of the
/// baseline.
const ALIAS_CYCLES_MIN: f32 = 0.5;
/// As far an interferer may be off, as a share of its frequency; and the least, a fraction of a
/// cycle per half window.
const INTERFERER_REACH: f32 = 0.012;
const REACH_MIN: f32 = 0.2;

/// A span's interferer.
#[derive(Clone, Copy)]
pub struct Interferer {
    /// Cycles per half window, as sampling folds it.
    pub nu: f32,
    /// The same of the frequency that is given, how far it may be off, and that frequency, cycles
    /// per frame.
    given_nu: f32,
    pub reach: f32,
    given: f32,
}

impl Interferer {
    /// None if there is none that is a line of its own, or along a path, where it has no frequency.
    pub fn new(span: &FrameSpan) -> Option<Self> {
        let given = span.interferer.filter(|_| span.is_in_time())?;
        let turns = from_turns(given);
        let (folded, half) = (
            turns.min(turns.wrapping_neg()) as f32 / TURN,
            0.5 * span.frames as f32,
        );
        let (nu, reach) = (
            folded * half,
            (INTERFERER_REACH * given * half).max(REACH_MIN),
        );
        (2.0 * nu >= ALIAS_CYCLES_MIN).then_some(Self {
            nu,
            given_nu: nu,
            reach,
            given,
        })
    }

    pub fn nu(interferer: &Option<Self>) -> Option<f32> {
        interferer.map(|interferer| interferer.nu)
    }

    /// Where it is in truth. Leaves its solution.
    pub fn follow(
        mut self,
        refinement: &mut Refinement,
        channels: &Channels,
    ) -> Result<Self, Overwritten> {
        // At half the frame rate it is its own mirror image.
        if refinement.span.nu_max() - self.given_nu < REACH_MIN {
            self.reach = 0.0;
            return Ok(self);
        }
        let reach = (self.given_nu, self.reach);
        self.nu = search::interferer(
            refinement.span,
            refinement.statistics,
            channels,
            reach,
            refinement.blocks,
        )?;
        self.refine_alone(refinement, channels, None)?;
        Ok(self)
    }

    pub fn refine(
        &mut self,
        refinement: &mut Refinement,
        channels: &Channels,
        tone_nu: f32,
    ) -> Result<(), Overwritten> {
        if self.reach > 0.0 {
            self.refine_alone(refinement, channels, Some(tone_nu))
        } else {
            Ok(())
        }
    }

    fn refine_alone(
        &mut self,
        refinement: &mut Refinement,
        channels: &Channels,
        other: Option<f32>,
    ) -> Result<(), Overwritten> {
        let lines = Lines {
            nu: self.nu,
            harmonics: 1,
            interferer: other,
        };
        // As long as there is no tone the pieces are needed, which more blocks would take the place
        // of.
        let limits = if other.is_some() {
            Limits::RESULT
        } else {
            Limits {
                steps: Limits::RESULT.steps,
                ..Limits::CANDIDATE
            }
        };
        let limits = Limits {
            sigmas: Limits::CANDIDATE.sigmas,
            ..limits
        };
        let summit = refinement.refine(channels, &lines, &limits)?;
        let is_there = |summit: &Summit| {
            (summit.nu - self.given_nu).abs() <= self.reach
                && summit.model.score > summit.baseline.score
        };
        self.nu = summit
            .filter(is_there)
            .map_or(self.given_nu, |summit| summit.nu);
        Ok(())
    }

    /// Its frequency, not folded.
    pub fn cycles_per_frame(&self, frames: u32) -> f32 {
        let off = (self.nu - self.given_nu) / (0.5 * frames as f32);
        let is_mirrored = self.given - libm::roundf(self.given) < 0.0;
        if is_mirrored {
            self.given - off
        } else {
            self.given + off
        }
    }
}
