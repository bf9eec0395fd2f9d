//! Least squares over all channels with one common frequency: the order of the steps.

use crate::blocks::{Blocks, Lines};
use crate::cleaned::Impulses;
use crate::conclude::{conclude, conclude_mixtures, evidence};
use crate::fit::{Fit, Status};
use crate::found::{Found, SAME_NU};
use crate::frame_span::FrameSpan;
use crate::interferer::Interferer;
use crate::limits::{CHANNELS_SEARCHED, HARMONICS_MAX};
use crate::mixture::whiten;
use crate::neighbourhood::neighbourhood;
use crate::other_lines::{has_half_line, lines_between};
use crate::polish::polish;
use crate::refine::{Limits, Refinement, Summit, least_squares};
use crate::search;
use crate::solve::Equations;
use crate::source::Overwritten;
use crate::statistics::Statistics;

/// Fewest frames that are fitted.
pub const FRAMES_MIN: u32 = 16;
/// Steps of the next likely one beside the best, by all channels.
const NEXT_STEPS: usize = 3;
/// Behind a step that moves the highest harmonic by more, in `nu`, a solution's amplitudes are off
/// by half a percent and more.
const SOLVED_STEP: f32 = 0.01;
/// In fewer cycles a straight baseline is tried where a curved one is likelier.
const CYCLES_BENT: f32 = 1.6;
/// A window as short, or with as few cycles, is too rough for blocks: the last step is that of its
/// frames.
const FRAMES_ROUGH: u32 = 32;
const CYCLES_ROUGH: f32 = 1.5;
/// Third differences hold the tone where residuals have at most this share of the noise by these
/// differences.
const HIDING_NOISE_RATIO: f32 = 0.5;
const HIDING_FRAMES: u32 = 128;

/// The estimator: scratch memory and settings of the fit.
#[derive(Debug)]
pub struct Fitter {
    blocks: Blocks,
    equations: Equations,
    harmonics_max: usize,
}

impl Fitter {
    /// A fitter of up to `harmonics_max` harmonics, the fundamental included (1 to
    /// [`HARMONICS_MAX`]); `const`, so that its memory can live in a static.
    pub const fn new(harmonics_max: u8) -> Self {
        let mut fitter = Self {
            blocks: Blocks::new(),
            equations: Equations::NONE,
            harmonics_max: 1,
        };
        fitter.set_harmonics(harmonics_max);
        fitter
    }

    /// From now on up to `harmonics_max` harmonics are fitted, 1 to [`HARMONICS_MAX`].
    pub const fn set_harmonics(&mut self, harmonics_max: u8) {
        let (wanted, most) = (harmonics_max as usize, HARMONICS_MAX);
        self.harmonics_max = if wanted < 1 {
            1
        } else if wanted > most {
            most
        } else {
            wanted
        };
    }

    /// Fits all usable channels of a span.
    ///
    /// # Errors
    /// If its frames were overwritten meanwhile.
    // Not inlined, as the steps: what they take of the stack is given back.
    #[inline(never)]
    pub fn fit(&mut self, span: &mut FrameSpan) -> Result<Fit, Overwritten> {
        let mut impulses = Impulses::NONE;
        let mut fit = const { Fit::at_rest(0) };
        self.fit_with(span, Some(&mut impulses), &mut fit)?;
        if impulses.are_found() {
            span.cleaned(&impulses, |span| self.fit_with(span, None, &mut fit))?;
        }
        Ok(fit)
    }

    /// The same into `fit`, of which each step would else have a copy on the stack; if impulses are
    /// found it ends there.
    #[inline(never)]
    fn fit_with(
        &mut self,
        span: &mut FrameSpan,
        impulses: Option<&mut Impulses>,
        fit: &mut Fit,
    ) -> Result<(), Overwritten> {
        let statistics = self.statistics(span)?;
        if statistics.usable == 0 || statistics.frames < FRAMES_MIN {
            statistics.without_tone(Status::Nothing, fit);
            fit.usable = 0;
            return Ok(());
        }
        // More gaps than frames leave the frequency open.
        if 2 * statistics.frames < span.frames {
            statistics.without_tone(Status::TooShort, fit);
            return Ok(());
        }
        let mut interferer = None;
        let found = self.search(span, &statistics, &mut interferer)?;
        match self.select(span, &statistics, &found, &mut interferer)? {
            Some(summit) => self.conclude(
                span,
                &statistics,
                (&summit, &found),
                impulses,
                interferer,
                fit,
            )?,
            None if found.best.is_none() => statistics.without_tone(Status::NoTone, fit),
            None => statistics.without_tone(Status::TooShort, fit),
        }
        Ok(())
    }

    /// The likeliest candidates, by a few channels; follows the interferer, if there is one.
    #[inline(never)]
    fn search(
        &mut self,
        span: &mut FrameSpan,
        statistics: &Statistics,
        interferer: &mut Option<Interferer>,
    ) -> Result<Found, Overwritten> {
        let few = statistics.order.first(CHANNELS_SEARCHED);
        let Self {
            blocks,
            equations,
            harmonics_max,
        } = self;
        let harmonics = *harmonics_max;
        let mut refinement = Refinement {
            span,
            statistics,
            blocks,
            equations,
        };
        if let Some(given) = Interferer::new(refinement.span) {
            *interferer = Some(given.follow(&mut refinement, &few)?);
        }
        let interferer_nu = Interferer::nu(interferer);
        let of_interferer = interferer
            .filter(|interferer: &Interferer| interferer.reach > 0.0)
            .map(|interferer| (interferer.nu, &refinement.equations.solution));
        let mut candidates = search::lines(
            refinement.span,
            statistics,
            &few,
            harmonics,
            of_interferer,
            refinement.blocks,
        )?;
        let mut found = Found::default();
        for slow in [false, true] {
            if slow && !found.is_plain() {
                candidates = search::slow(
                    statistics,
                    &few,
                    (harmonics, interferer_nu, refinement.span.is_in_time()),
                    refinement.blocks,
                    &candidates,
                );
            }
            for nu in &candidates {
                if found.is_plain() || found.has(*nu) || !slow && search::is_slow(*nu) {
                    continue;
                }
                let lines = Lines {
                    nu: *nu,
                    harmonics,
                    interferer: interferer_nu,
                };
                let limits = Limits {
                    score: found.least_score(),
                    ..Limits::CANDIDATE
                };
                if let Some(mut summit) = refinement.refine(&few, &lines, &limits)? {
                    if found.best.is_none() && summit.is_plain() && harmonics > 1 {
                        if libm::fabsf(refinement.equations.solution.step) * harmonics as f32
                            > SOLVED_STEP
                        {
                            refinement.solve_again(&few, &summit);
                        }
                        let Refinement {
                            span, equations, ..
                        } = &mut refinement;
                        let solution = &equations.solution;
                        let is_overtone =
                            lines_between(span, statistics, &few, solution, interferer_nu)?;
                        found.overtone = is_overtone.then_some(summit.nu);
                        summit.explains_all &= !is_overtone;
                    }
                    found.add(summit);
                }
            }
        }
        // A fundamental without power of its own may be one of a gap, or of a drift.
        if let Some(best) = found.best.filter(|best| best.strongest > 1) {
            let lines = Lines {
                nu: best.strongest as f32 * best.nu,
                harmonics,
                interferer: interferer_nu,
            };
            // Images of its overtones are what makes a comb of a lower one.
            let limits = Limits {
                score: found.least_score(),
                images: true,
                ..Limits::CANDIDATE
            };
            if let Some(summit) = refinement.refine(&few, &lines, &limits)? {
                found.add(summit);
            }
        }
        Ok(found)
    }

    /// Where the likeliest of the candidates ends by all channels; refines the interferer beside
    /// it. None if nowhere.
    #[inline(never)]
    fn select(
        &mut self,
        span: &mut FrameSpan,
        statistics: &Statistics,
        found: &Found,
        interferer: &mut Option<Interferer>,
    ) -> Result<Option<Summit>, Overwritten> {
        let Some(best) = found.best else {
            return Ok(None);
        };
        let (all, limits) = (statistics.order, Limits::RESULT);
        let Self {
            blocks,
            equations,
            harmonics_max,
        } = self;
        let mut refinement = Refinement {
            span,
            statistics,
            blocks,
            equations,
        };
        if let Some(interferer) = interferer {
            // Once more, beside the tone.
            interferer.refine(&mut refinement, &all, best.nu)?;
        }
        let interferer_nu = Interferer::nu(interferer);
        let at = |summit: &Summit| Lines {
            nu: summit.nu,
            harmonics: *harmonics_max,
            interferer: interferer_nu,
        };
        // What a few channels leave open all of them decide; and in few cycles a curve takes a part
        // of a tone that is off.
        let is_bent = 2.0 * best.nu < CYCLES_BENT && best.model.shape.curves > 0;
        let other = found.other.map(|other| (at(&other), limits));
        let straight = is_bent.then(|| {
            (
                at(&best),
                Limits {
                    is_straight: true,
                    ..limits
                },
            )
        });
        let mut next: Option<(Lines, Limits, Summit)> = None;
        for (lines, limits) in [other, straight].into_iter().flatten() {
            let rough = Limits {
                blocks: Limits::CANDIDATE.blocks,
                steps: NEXT_STEPS,
                ..limits
            };
            if let Some(summit) = refinement.refine(&all, &lines, &rough)?
                && next.is_none_or(|(.., next)| summit.lead(&next) > 0.0)
            {
                next = Some((
                    Lines {
                        nu: summit.nu,
                        ..lines
                    },
                    limits,
                    summit,
                ));
            }
        }
        let mut summit = refinement.refine(&all, &at(&best), &limits)?;
        if let Some((lines, limits, next)) = next
            && summit.is_none_or(|summit| next.lead(&summit) > 0.0)
        {
            let baseline = summit.map(|summit| summit.baseline);
            summit = refinement.refine(&all, &lines, &limits)?;
            if let (Some(summit), Some(baseline)) = (&mut summit, baseline)
                && baseline.score > summit.baseline.score
            {
                summit.baseline = baseline;
            }
        }
        Ok(summit)
    }

    /// The result of a summit, whose solution is the latest.
    #[inline(never)]
    fn conclude(
        &mut self,
        span: &mut FrameSpan,
        statistics: &Statistics,
        (summit, found): (&Summit, &Found),
        impulses: Option<&mut Impulses>,
        interferer: Option<Interferer>,
        fit: &mut Fit,
    ) -> Result<(), Overwritten> {
        let Self {
            blocks,
            equations,
            harmonics_max,
        } = self;
        let all = statistics.order;
        let least = least_squares(statistics, &all);
        let at = (equations.nu, Interferer::nu(&interferer));
        // The third differences of a fast tone hide those of impulses. Of a longer window one more
        // pass takes too long.
        let may_hide = statistics.frames <= HIDING_FRAMES
            && equations.solution.noise_ratio(statistics, &all).0 < HIDING_NOISE_RATIO;
        if let Some(impulses) = impulses.filter(|_| statistics.is_spiky || may_hide) {
            impulses.find(span, statistics, &all, &equations.solution, at)?;
            if impulses.are_found() {
                return Ok(());
            }
        }
        let half_power = equations.half_power();
        // It is known now: what follows needs no more of that line.
        blocks.half_line = false;
        // The neighbourhood is that of the blocks' solution. A single harmonic is chosen to be
        // quick; what others leave would be taken for noise that is shared. So would what channels
        // that are late leave where the speed changes.
        let around = neighbourhood(
            blocks,
            &equations.solution,
            *harmonics_max > 1 && !span.is_staggered(),
        );
        let is_rough = statistics.frames <= FRAMES_ROUGH || 2.0 * summit.nu < CYCLES_ROUGH;
        if !span.is_in_time() || is_rough || equations.is_cancelled() {
            polish(span, statistics, &all, &least, at, &mut equations.solution)?;
        }
        let evidence = evidence(statistics, &all, &equations.solution);
        let has_half = has_half_line(
            half_power,
            &equations.solution,
            &around,
            evidence.noise_ratio,
        );
        let by = (summit, &around, &evidence);
        conclude(span, statistics, &all, blocks, &equations.solution, by, fit)?;
        if around.may_share && fit.status.has_tone() {
            let (nu, shape, lines) = (
                equations.solution.nu,
                equations.solution.shape,
                blocks.lines,
            );
            if !blocks.are_intact {
                blocks.collect(span, statistics, &all, lines, Limits::RESULT.blocks)?;
            }
            if whiten(blocks, equations, &least, nu, shape) {
                let around = neighbourhood(blocks, &equations.solution, false);
                conclude_mixtures(fit, span, &equations.solution, &around, &evidence);
            }
        }
        let is_overtone = found
            .overtone
            .is_some_and(|nu| (summit.nu - nu).abs() < SAME_NU);
        if (is_overtone || has_half) && fit.status == Status::Good {
            fit.status = Status::Ambiguous;
        }
        fit.interferer = interferer.map(|interferer| interferer.cycles_per_frame(span.frames));
        Ok(())
    }

    /// Memory that holds nothing between fits: 1536 values on the chip, more with the feature
    /// `long-windows`.
    pub fn scratch(&mut self) -> &mut [f32] {
        self.blocks.scratch()
    }

    #[inline(never)]
    fn statistics(&mut self, span: &mut FrameSpan) -> Result<Statistics, Overwritten> {
        Statistics::collect(span, self.blocks.pieces_mut())
    }
}
