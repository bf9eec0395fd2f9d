//! The unit of a window's frequency: cycles in time, or by place on the surface.

mod delay_error;

use crate::scan::Scan;
use crate::surface::odometry::track::Track;
use crate::surface::odometry::trajectory::Trajectory;
use crate::window::Window;
use crate::wiring::Wiring;
use core::f32::consts::PI;
use delay_error::{DelayError, Way};
use ridgetone_proto::plan::Sampling;
use ridgetone_proto::settings::{Declared, Settings, TAXELS};
use ridgetone_proto::telemetry::{Abscissa, Span};
use ridgetone_tone::{
    Band, Baseline, Channels, Fit, Fitter, FrameSource, FrameSpan, Noise, Overwritten, Scene,
    Speed, Status,
};

/// A fit, and the unit of its frequency.
#[derive(Clone, Debug)]
pub struct Fitted {
    /// The fit.
    pub fit: Fit,
    /// What its frequency is over.
    pub abscissa: Abscissa,
    /// The frequency in hertz or in cycles per millimetre, over that of the fit.
    pub per_unit: f32,
    /// From one slot of the scan to the next, in the fit's unit: frames, or millimetres.
    pub per_slot: f32,
    /// The slot whose moment the fit's phases refer to.
    pub slot: f32,
    /// The scan.
    pub scan: Scan,
    /// Frames at the window's end that were left out: the robot's messages of them were not there
    /// yet.
    pub unplaced: u32,
}

/// So many windows of a slide after a search for its tone, the tone is searched for anew.
const SEARCH_EVERY: u8 = 4;

/// The fitter, and the tone of the latest window: the next one of its slide is expected to have it.
#[derive(Debug)]
pub struct Tracker {
    /// The fitter.
    pub fitter: Fitter,
    /// First frame of the slide.
    slide_first: u32,
    /// What the frequency is over.
    abscissa: Abscissa,
    /// Frequency in the fit's unit; 0 where no good one is known.
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
            fitter: Fitter::new(),
            slide_first: 0,
            abscissa: Abscissa::Time,
            frequency: 0.0,
            windows: 0,
        }
    }

    /// The frequency that a window is expected to have.
    fn expected(&self, window: &Window, abscissa: Abscissa) -> Option<f32> {
        let is_next = window.span == Span::Window
            && window.slide_first == self.slide_first
            && abscissa == self.abscissa;
        (is_next && self.frequency > 0.0 && self.windows < SEARCH_EVERY).then_some(self.frequency)
    }

    /// Keeps the frequency of a window for the next one.
    fn keep(&mut self, window: &Window, abscissa: Abscissa, fit: &Fit) {
        let is_expected = self.expected(window, abscissa).is_some();
        self.windows = if is_expected { self.windows + 1 } else { 1 };
        (self.slide_first, self.abscissa) = (window.slide_first, abscissa);
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
        let ahead =
            self.fit.frequency * self.per_slot * (self.scan.slots_late(taxel) as f32 - self.slot);
        self.fit
            .channels
            .get(taxel)
            .map_or(0.0, |channel| channel.phase_rad / (2.0 * PI))
            - ahead
    }

    /// From one frame to the next, in the fit's unit: by place, millimetres.
    pub fn per_frame(&self) -> f32 {
        self.per_slot * self.scan.slots as f32
    }
}

/// What a fit goes by.
#[derive(Clone, Copy, Debug)]
pub struct Setup<'a> {
    /// The settings in force.
    pub settings: &'a Settings,
    /// The board's wiring.
    pub wiring: Wiring,
}

/// Fits a window by the places in `track` that its [`Mark`](crate::surface::odometry::Mark) names,
/// or by time if there are none. Fails if frames or places were overwritten.
pub fn fit(
    tracker: &mut Tracker,
    window: &Window,
    source: &mut dyn FrameSource,
    setup: Setup<'_>,
    track: Option<&Track>,
) -> Result<Fitted, Overwritten> {
    let Setup { settings, wiring } = setup;
    let scene = &scene(&settings.scene, settings.harmonics);
    let scan = Scan::new(&window.plan);
    let Scan {
        channels, slots, ..
    } = scan;
    // By the converter's own clock: a single frame's time stamp has the jitter of its interrupt.
    let frame_us = 1e6 / window.frame_rate_hz;
    let last = window.frames.saturating_sub(1);
    let lasts_us = (last as f32 * frame_us) as u32;
    // The middle of the taxels' slots, from the first: by place, a frame is there, and its taxels
    // are read before and after it.
    let middle_slot = match scan.sampling {
        Sampling::InTurn => 0.5 * (channels as f32 - 1.0),
        Sampling::AtOnce => 0.0,
    };
    let middle_us = (middle_slot * scan.slot_ns() as f32 * 1e-3) as u32;
    let trajectory =
        track.and_then(|track| Trajectory::new(track, &window.odometry, lasts_us, middle_us));
    let unplaced = trajectory
        .as_ref()
        .map_or(0, |trajectory| frames_in(trajectory.missing_us, frame_us));
    // Frames hold codes.
    let mut span = FrameSpan::new(source, window.first, window.frames.saturating_sub(unplaced))
        .with_quantization(1.0);
    if settings.interferer_hz > 0.0 {
        span = span.with_interferer(settings.interferer_hz / window.frame_rate_hz);
    }
    let place_mm = trajectory
        .as_ref()
        .map(|trajectory| |frame: u32| trajectory.place_mm(frame as f32 * frame_us));
    let last = last.saturating_sub(unplaced);
    let (mut late, mut at, mut inputs) = ([0.0; TAXELS], -middle_slot, scan.inputs);
    for late in &mut late {
        if inputs == 0 || scan.sampling == Sampling::AtOnce {
            break;
        }
        *late = at / slots as f32;
        at += (inputs & 1) as f32;
        inputs >>= 1;
    }
    let abscissa = if place_mm.is_some() {
        Abscissa::Place
    } else {
        Abscissa::Time
    };
    if let Some(frequency) = tracker.expected(window, abscissa) {
        span = span.expecting(frequency);
    }
    // One place for the fit: a second one would lie on the stack beside it.
    let mut fit = match &place_mm {
        None => tracker.fitter.fit(&mut span, scene),
        Some(place_mm) => match span.along(place_mm) {
            Some(span) => tracker.fitter.fit(&mut span.with_lateness(&late), scene),
            None => Ok(Fit::at_rest(window.frames)),
        },
    };
    let fit = fit.as_mut().map_err(|overwritten| *overwritten)?;
    tracker.keep(window, abscissa, fit);
    let (mut per_unit, mut per_slot, mut slot) = (window.frame_rate_hz, 1.0 / slots as f32, 0.0);
    if let Some(place_mm) = &place_mm {
        (per_unit, slot) = (1.0, middle_slot);
        per_slot = (place_mm(last) - place_mm(0)) / (last.max(1) * slots) as f32;
        let way = Way {
            place_mm,
            last,
            frame_rate_hz: window.frame_rate_hz,
        };
        let delay_s = wiring.low_pass.delay_s;
        let late = DelayError::new(way, delay_s, fit.frequency, &fit.overtones);
        fit.frequency /= 1.0 + late.by_low_pass;
        let change_per_s = late.per_s * fit.frequency;
        let sigmas_s = [window.odometry.delay_sigma_s(), wiring.low_pass.sigma_s()];
        let delay_variance: f32 = sigmas_s.map(|sigma_s| sigma_s * sigma_s).iter().sum();
        let by_delay = delay_variance * change_per_s * change_per_s;
        fit.sigma = libm::sqrtf(fit.sigma * fit.sigma + by_delay);
    }
    if trajectory
        .as_ref()
        .is_some_and(|trajectory| !trajectory.is_intact())
    {
        return Err(Overwritten);
    }
    Ok(Fitted {
        fit: fit.clone(),
        abscissa,
        per_unit,
        per_slot,
        slot,
        scan,
        unplaced,
    })
}

/// The scene of what is declared, with at most so many harmonics, the fundamental included.
pub fn scene(declared: &Declared, harmonics: u8) -> Scene {
    Scene {
        harmonics,
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

/// Frames that a time takes, rounded up.
fn frames_in(time_us: u32, frame_us: f32) -> u32 {
    let frames = (time_us as f32 / frame_us) as u32;
    if time_us > 0 { frames + 1 } else { 0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ridgetone_proto::plan::Plan;

    #[test]
    fn a_good_tone_is_expected_in_three_windows_of_its_slide_and_then_searched_for() {
        let window = Window::new(Plan::PAPER, 241);
        let mut fit = Fit::at_rest(241);
        (fit.status, fit.frequency) = (Status::Good, 0.04);
        let mut tracker = Tracker::new();
        let mut next = |window: &Window, fit: &Fit| {
            let expected = tracker.expected(window, Abscissa::Time);
            tracker.keep(window, Abscissa::Time, fit);
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
        assert_eq!(tracker.expected(&window, Abscissa::Place), None);
    }
}
