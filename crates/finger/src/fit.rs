//! Fits a window: turns frames of the ring into frequency and phases.

use crate::scan::Scan;
use crate::window::Window;
use core::f32::consts::PI;
use ridgetone_proto::settings::{Declared, Settings};
use ridgetone_proto::telemetry::Span;
use ridgetone_tone::{
    Band, Baseline, Channels, Fit, Fitter, FrameSource, FrameSpan, Noise, Overwritten, Scene,
    Speed, Status, Tracked,
};

/// Fit of a window.
#[derive(Clone, Debug)]
pub struct Fitted {
    /// The fit; frequencies are in cycles per frame.
    pub fit: Fit,
    /// Frames per second.
    pub frame_rate_hz: f32,
    /// Frames per slot of the scan.
    pub per_slot: f32,
    /// The scan.
    pub scan: Scan,
}

/// Number of windows per full search while a tone is tracked. It runs after the window's estimate.
const SEARCH_EVERY: u8 = 4;

/// Tone of the latest window, which is expected in the next window of its slide.
#[derive(Debug)]
pub struct Tracker {
    slide_first: u32,
    /// Frame after the window, or after the latest one up to which the tone was followed.
    end: u32,
    /// Frequency in cycles per frame; 0 if no good one is known.
    frequency: f32,
    /// Windows since the latest search, including the searched one.
    windows: u8,
}

impl Default for Tracker {
    fn default() -> Self {
        Self::new()
    }
}

impl Tracker {
    /// Starts without a tone.
    pub const fn new() -> Self {
        Self {
            slide_first: 0,
            end: 0,
            frequency: 0.0,
            windows: 0,
        }
    }

    /// True if the good tone of the latest window is expected in this one too.
    fn is_known(&self, window: &Window) -> bool {
        let is_next = window.span == Span::Window && window.slide_first == self.slide_first;
        is_next && self.frequency > 0.0
    }

    /// Frequency expected in a window; `None` if unknown, or if a search that was due was skipped.
    fn expected(&self, window: &Window) -> Option<f32> {
        (self.is_known(window) && self.windows <= SEARCH_EVERY).then_some(self.frequency)
    }

    /// Keeps the frequency of a window's fit, with or without a search, for the next window.
    fn keep(&mut self, window: &Window, fit: &Fit, was_expected: bool) {
        // This is at most `SEARCH_EVERY` + 1, because then no tone is expected.
        self.windows = if was_expected { self.windows + 1 } else { 1 };
        self.slide_first = window.slide_first;
        self.end = window.first.wrapping_add(window.frames);
        self.frequency = if fit.status == Status::Good {
            fit.frequency
        } else {
            0.0
        };
    }

    /// True if the latest window must be searched as well, because the ones before it were only
    /// tracked.
    fn is_search_due(&self, window: &Window) -> bool {
        self.windows > SEARCH_EVERY && self.is_known(window)
    }

    /// Searches a window whose estimate came from tracking alone, if a search is due. The next
    /// window then expects the tone found.
    #[inline(never)]
    pub fn search(
        &mut self,
        fitter: &mut Fitter,
        window: &Window,
        source: &mut dyn FrameSource,
        settings: &Settings,
    ) -> Result<(), Overwritten> {
        if self.is_search_due(window) {
            let scene = &scene(&settings.scene, settings.harmonics);
            let fit = fitter.fit(&mut span(window, source, settings), scene)?;
            self.keep(window, &fit, false);
        }
        Ok(())
    }

    /// Follows the tone of the latest fit to the end of a later window of its slide. Returns the
    /// window's frequency, in cycles per frame, or `None` if the window has to be fitted.
    pub fn follow(
        &mut self,
        fitter: &mut Fitter,
        window: &Window,
        source: &mut dyn FrameSource,
    ) -> Option<Tracked> {
        let first = self.end;
        let frames = window.first.wrapping_add(window.frames).wrapping_sub(first);
        if window.slide_first != self.slide_first || !(1..=window.frames).contains(&frames) {
            return None;
        }
        self.end = first.wrapping_add(frames);
        let span = &mut FrameSpan::new(source, first, frames);
        fitter.follow(span).ok().flatten()
    }
}

impl Fitted {
    /// Phase that a taxel would have if all taxels were read at once, turns.
    pub fn turns(&self, taxel: usize) -> f32 {
        // Correct for the delay of the taxel's slot in the scan.
        let ahead = self.fit.frequency * self.per_slot * self.scan.slots_after_first(taxel) as f32;
        self.fit
            .channels
            .get(taxel)
            .map_or(0.0, |channel| channel.phase_rad / (2.0 * PI))
            - ahead
    }
}

// Inlined, so that its stack frame does not add to that of a fit, the deepest use of the stack.
#[inline(always)]
fn span<'s>(
    window: &Window,
    source: &'s mut dyn FrameSource,
    settings: &Settings,
) -> FrameSpan<'s> {
    // Frames hold integer codes.
    let span = FrameSpan::new(source, window.first, window.frames).with_quantization(1.0);
    if settings.interferer_hz > 0.0 {
        span.with_interferer(settings.interferer_hz / window.frame_rate_hz)
    } else {
        span
    }
}

/// Fits a window. Fails if frames were overwritten.
pub fn fit(
    fitter: &mut Fitter,
    tracker: &mut Tracker,
    window: &Window,
    source: &mut dyn FrameSource,
    settings: &Settings,
) -> Result<Fitted, Overwritten> {
    let scene = &scene(&settings.scene, settings.harmonics);
    let expected = tracker.expected(window);
    let mut span = span(window, source, settings);
    if let Some(frequency) = expected {
        span = span.expecting(frequency);
    }
    let fit = fitter.fit(&mut span, scene)?;
    tracker.keep(window, &fit, expected.is_some());
    let scan = Scan::new(&window.plan);
    Ok(Fitted {
        fit,
        frame_rate_hz: window.frame_rate_hz,
        per_slot: 1.0 / scan.slots as f32,
        scan,
    })
}

/// Scene of a declaration, with a maximum number of harmonics including the fundamental. With
/// nothing declared it is [`Scene::LEAN`].
pub fn scene(declared: &Declared, harmonics: u8) -> Scene {
    Scene {
        harmonics: if declared.overtones { harmonics } else { 1 },
        baseline: if declared.curved_baseline {
            Baseline::Curved
        } else {
            Baseline::Slope
        },
        noise: if declared.coloured_noise {
            Noise::Any
        } else {
            Noise::White
        },
        channels: if declared.shared_noise {
            Channels::MayShare
        } else {
            Channels::Independent
        },
        speed: if declared.moving_speed {
            Speed::MayMove
        } else {
            Speed::Steady
        },
        impulses: declared.impulses,
        band: Band::default(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ridgetone_proto::plan::Plan;

    #[test]
    fn each_part_of_a_scene_is_left_out_by_its_own_setting_and_the_lean_one_by_all() {
        let all = Declared::DEFAULT;
        assert_eq!(scene(&all, 4), Scene::DEFAULT);
        let default = Scene::DEFAULT;
        let cases = [
            (
                Declared {
                    overtones: false,
                    ..all
                },
                Scene {
                    harmonics: 1,
                    ..default
                },
            ),
            (
                Declared {
                    curved_baseline: false,
                    ..all
                },
                Scene {
                    baseline: Baseline::Slope,
                    ..default
                },
            ),
            (
                Declared {
                    coloured_noise: false,
                    ..all
                },
                Scene {
                    noise: Noise::White,
                    ..default
                },
            ),
            (
                Declared {
                    shared_noise: false,
                    ..all
                },
                Scene {
                    channels: Channels::Independent,
                    ..default
                },
            ),
            (
                Declared {
                    moving_speed: true,
                    ..all
                },
                Scene {
                    speed: Speed::MayMove,
                    ..default
                },
            ),
            (
                Declared {
                    impulses: false,
                    ..all
                },
                Scene {
                    impulses: false,
                    ..default
                },
            ),
        ];
        for (declared, expected) in cases {
            assert_eq!(scene(&declared, 4), expected);
        }
        assert_eq!(scene(&Declared::LEAN, 4), Scene::LEAN);
    }

    #[test]
    fn a_good_tone_is_expected_in_its_slide_and_every_fourth_window_is_searched_after_its_answer() {
        let window = Window::new(Plan::PAPER, 241);
        let mut fit = Fit::without_tone(Status::TooShort, 241);
        (fit.status, fit.frequency) = (Status::Good, 0.04);
        let mut tracker = Tracker::new();
        // Returns whether the tone was expected, and whether the window must be searched as well.
        let mut next = |window: &Window, fit: &Fit| {
            let was_expected = tracker.expected(window).is_some();
            tracker.keep(window, fit, was_expected);
            let is_due = tracker.is_search_due(window);
            if is_due {
                tracker.keep(window, fit, false);
            }
            (was_expected, is_due)
        };
        let seen: [_; 9] = core::array::from_fn(|_| next(&window, &fit));
        assert_eq!(
            seen.map(|(expected, _)| expected),
            [false, true, true, true, true, true, true, true, true]
        );
        assert_eq!(
            seen.map(|(_, due)| due),
            [false, false, false, false, true, false, false, false, true]
        );
        // The tone is not expected in a different slide, nor in a whole slide.
        let other = Window {
            slide_first: 500,
            ..window
        };
        assert!(!next(&other, &fit).0 && next(&other, &fit).0);
        let whole = Window {
            span: Span::Slide,
            ..other
        };
        assert!(!next(&whole, &fit).0);
        // After a window that is not good, no tone is expected.
        assert!(!next(&window, &fit).0);
        fit.status = Status::Ambiguous;
        assert!(next(&window, &fit).0 && !next(&window, &fit).0);
    }
    #[test]
    fn a_window_is_searched_at_once_if_the_search_before_it_was_left_out() {
        let window = Window::new(Plan::PAPER, 241);
        let mut fit = Fit::without_tone(Status::TooShort, 241);
        (fit.status, fit.frequency) = (Status::Good, 0.04);
        let mut tracker = Tracker::new();
        let seen: [_; 6] = core::array::from_fn(|_| {
            let was_expected = tracker.expected(&window).is_some();
            tracker.keep(&window, &fit, was_expected);
            was_expected
        });
        assert_eq!(seen, [false, true, true, true, true, false]);
    }
}
