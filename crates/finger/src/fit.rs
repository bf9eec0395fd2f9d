//! The fit of a window: frames of the ring in, frequency and phases out.

use crate::scan::Scan;
use crate::window::Window;
use core::f32::consts::PI;
use ridgetone_proto::settings::{Declared, Settings};
use ridgetone_proto::telemetry::Span;
use ridgetone_tone::{
    Band, Baseline, Channels, Fit, Fitter, FrameSource, FrameSpan, Noise, Overwritten, Scene,
    Speed, Status,
};

/// The fit of a window.
#[derive(Clone, Debug)]
pub struct Fitted {
    /// The fit; frequencies are in cycles per frame.
    pub fit: Fit,
    /// Frames per second.
    pub frame_rate_hz: f32,
    /// Frames from one slot of the scan to the next.
    pub per_slot: f32,
    /// The scan.
    pub scan: Scan,
}

/// Windows between full searches while tracking a tone.
const SEARCH_EVERY: u8 = 4;

/// The tone of the latest window: the next one of its slide is expected to have it.
#[derive(Debug)]
pub struct Tracker {
    /// First frame of the slide.
    slide_first: u32,
    /// Frequency in cycles per frame; 0 where no good one is known.
    frequency: f32,
    /// Windows since the latest search.
    windows: u8,
}

impl Default for Tracker {
    fn default() -> Self {
        Self::new()
    }
}

impl Tracker {
    /// No tone yet.
    pub const fn new() -> Self {
        Self {
            slide_first: 0,
            frequency: 0.0,
            windows: 0,
        }
    }

    /// The frequency that a window is expected to have.
    fn expected(&self, window: &Window) -> Option<f32> {
        let is_next = window.span == Span::Window && window.slide_first == self.slide_first;
        (is_next && self.frequency > 0.0 && self.windows < SEARCH_EVERY).then_some(self.frequency)
    }

    /// Keeps the frequency of a window for the next one.
    fn keep(&mut self, window: &Window, fit: &Fit) {
        let is_expected = self.expected(window).is_some();
        self.windows = if is_expected { self.windows + 1 } else { 1 };
        self.slide_first = window.slide_first;
        self.frequency = if fit.status == Status::Good {
            fit.frequency
        } else {
            0.0
        };
    }
}

impl Fitted {
    /// A taxel's phase as if a scan were read at once, turns.
    pub fn turns(&self, taxel: usize) -> f32 {
        // Its slot is later in the scan.
        let ahead = self.fit.frequency * self.per_slot * self.scan.slots_late(taxel) as f32;
        self.fit
            .channels
            .get(taxel)
            .map_or(0.0, |channel| channel.phase_rad / (2.0 * PI))
            - ahead
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
    // Frames hold codes.
    let mut span = FrameSpan::new(source, window.first, window.frames).with_quantization(1.0);
    if settings.interferer_hz > 0.0 {
        span = span.with_interferer(settings.interferer_hz / window.frame_rate_hz);
    }
    if let Some(frequency) = tracker.expected(window) {
        span = span.expecting(frequency);
    }
    let fit = fitter.fit(&mut span, scene)?;
    tracker.keep(window, &fit);
    let scan = Scan::new(&window.plan);
    Ok(Fitted {
        fit,
        frame_rate_hz: window.frame_rate_hz,
        per_slot: 1.0 / scan.slots as f32,
        scan,
    })
}

/// The scene of what is declared, with at most so many harmonics, the fundamental included. With
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
    fn a_good_tone_is_expected_in_three_windows_of_its_slide_and_then_searched_for() {
        let window = Window::new(Plan::PAPER, 241);
        let mut fit = Fit::without_tone(Status::TooShort, 241);
        (fit.status, fit.frequency) = (Status::Good, 0.04);
        let mut tracker = Tracker::new();
        let mut next = |window: &Window, fit: &Fit| {
            let expected = tracker.expected(window);
            tracker.keep(window, fit);
            expected.is_some()
        };
        let expected: [bool; 9] = core::array::from_fn(|_| next(&window, &fit));
        let cycle = [false, true, true, true];
        assert_eq!(expected[..4], cycle);
        assert_eq!(expected[4..8], cycle);
        // Neither in another slide, nor in a whole one.
        let other = Window {
            slide_first: 500,
            ..window
        };
        assert!(!next(&other, &fit) && next(&other, &fit));
        let whole = Window {
            span: Span::Slide,
            ..other
        };
        assert!(!next(&whole, &fit));
        // A window that is not good leaves nothing to expect.
        assert!(!next(&window, &fit));
        fit.status = Status::Ambiguous;
        assert!(next(&window, &fit) && !next(&window, &fit));
    }
}
