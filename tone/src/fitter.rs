//! Least squares over all channels with one common frequency: the order of the steps.

use crate::coarse::{Scratch, levels_and_means};
use crate::conclude::conclude;
use crate::fit::{Fit, Status};
use crate::frame_span::FrameSpan;
use crate::guess::InitialGuess;
use crate::levels::{Levels, levels};
use crate::limits::HARMONICS_MAX;
use crate::nuisance::Curve;
use crate::refine::refine;
use crate::search::{search, search_means};
use crate::source::Overwritten;
use crate::spectrum::Spectrum;
use crate::window::{Window, Work};

/// Frames of a long window's middle: as many as the most means of four frames.
const MIDDLE_FRAMES: u32 = 256;
/// Fewest frames that are fitted.
pub const FRAMES_MIN: u32 = 16;

/// The estimator: scratch memory and settings of the fit.
#[derive(Debug)]
pub struct Fitter {
    scratch: Scratch,
    harmonics_max: usize,
}

impl Fitter {
    /// A fitter of up to `harmonics_max` harmonics, the fundamental included (1 to [`HARMONICS_MAX`]); `const`, so that
    /// its memory can live in a static.
    pub const fn new(harmonics_max: u8) -> Self {
        let mut fitter = Self { scratch: Scratch::new(), harmonics_max: 1 };
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
    pub fn fit(&mut self, span: &mut FrameSpan) -> Result<Fit, Overwritten> {
        // On the stack, which has enough space: the statics are close to their limit.
        let mut work = Work::NONE;
        let (levels, coarse) = levels_and_means(span, &mut self.scratch)?;
        if levels.usable == 0 || levels.frames < FRAMES_MIN {
            return Ok(Fit::without_tone(Status::Nothing, &Levels { usable: 0, ..levels }));
        }
        // More gaps than frames leave the frequency open.
        if 2 * levels.frames < span.frames {
            return Ok(Fit::without_tone(Status::TooShort, &levels));
        }
        let harmonics_max = self.harmonics_max;
        let mut window = Window { span: span.reborrow(), levels: &levels, work: &mut work, harmonics_max };
        // A drift can hide a tone that is too fast for the means: without a tone the next search follows.
        if let Some(guess) = search_means(&mut window, coarse.as_ref(), &mut self.scratch)?
            && let Some(fit) = fit_tone(&mut window, guess)?
        {
            return Ok(fit);
        }
        if let Some(guess) = self.search_middle(&mut window)?
            && let Some(fit) = fit_tone(&mut window, guess)?
        {
            return Ok(fit);
        }
        match search(&mut window, &mut self.scratch)? {
            Some(guess) => fit_from(&mut window, guess),
            None => Ok(Fit::without_tone(Status::NoTone, &levels)),
        }
    }

    /// Where a long window has a tone too fast for its means: those of its middle, of fewer frames each.
    // Not inlined: its levels and means leave the stack when it is done.
    #[inline(never)]
    fn search_middle(&mut self, window: &mut Window) -> Result<Option<InitialGuess>, Overwritten> {
        let (all, harmonics_max) = (window.span.frames, self.harmonics_max);
        if all <= MIDDLE_FRAMES || !window.span.is_in_time() {
            return Ok(None);
        }
        let mut span = window.span.part((all - MIDDLE_FRAMES) / 2, MIDDLE_FRAMES);
        let (levels, coarse) = levels_and_means(&mut span, &mut self.scratch)?;
        if levels.usable == 0 || 2 * levels.frames < MIDDLE_FRAMES {
            return Ok(None);
        }
        let mut middle = Window { span, levels: &levels, work: &mut *window.work, harmonics_max };
        let guess = search_means(&mut middle, coarse.as_ref(), &mut self.scratch)?;
        let scale = all as f32 / MIDDLE_FRAMES as f32;
        Ok(guess.map(|guess| InitialGuess { nu: guess.nu * scale, ..guess }))
    }

    /// The periodogram that a search of all frames begins with, for display.
    ///
    /// # Errors
    /// If the frames were overwritten meanwhile.
    pub fn spectrum(&mut self, span: &mut FrameSpan) -> Result<Spectrum<'_>, Overwritten> {
        let (mut work, levels) = (Work::NONE, levels(span, None)?);
        let mut window = Window { span: span.reborrow(), levels: &levels, work: &mut work, harmonics_max: 1 };
        let nuisances = window.nuisances(Curve::None)?;
        Spectrum::new(self.scratch.for_transforms(), &mut window.span, &levels, &nuisances)
    }
}

/// The fit from a guess.
// Large and called from several places: one copy is enough.
#[inline(never)]
fn fit_from(window: &mut Window, guess: InitialGuess) -> Result<Fit, Overwritten> {
    match refine(window, guess)? {
        Some(nuisances) => conclude(window, &nuisances, &guess),
        None => Ok(Fit::without_tone(Status::TooShort, window.levels)),
    }
}

/// The fit from a guess, if it has a tone.
fn fit_tone(window: &mut Window, guess: InitialGuess) -> Result<Option<Fit>, Overwritten> {
    fit_from(window, guess).map(|fit| fit.status.has_tone().then_some(fit))
}
