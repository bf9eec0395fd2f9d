//! push(conversion) -> events; composes the rooms; knows no hardware.
//!
//! The chip runs the two halves as tasks of different priority: [`Detector`] for every conversion,
//! [`Estimator`] for every window that falls due. [`Pipeline`] is both in one call, for a PC. The
//! halves share only the [`Ring`] and pass [`Window`]s, so both ways give the same numbers for every
//! window that is fitted; the chip may have to skip a hop, and counts it.

pub use crate::detector::{Counters, Detector};
use crate::frame::TimedConversion;
use crate::settings::{Settings, TAXELS};
use crate::sine_fit::{Fit, Fitter};
use crate::stretch::Stretch;
use crate::telemetry::{Channel, Estimate, Event, Span, Status};
use crate::window::{FrameSource, Ring, Window, reached};
use ads1258::reading;
use core::f32::consts::PI;

/// Frames of the shortest window that grows: a tenth of a second, as the shortest that can be set.
pub const GROWING_FRAMES_MIN: u32 = 24;

/// Spectrum and sine fit: the lowest task. Owns their scratch memory.
#[derive(Debug)]
pub struct Estimator {
    volts_per_code: f32,
    fitter: Fitter,
    accuracy: f32,
    interferer_hz: f32,
    window_s: f32,
    /// Frame behind the latest estimate that was accurate enough.
    told: u32,
}

impl Estimator {
    /// An estimator; `const`, so that its scratch memory can live in a static.
    pub const fn new(settings: Settings) -> Self {
        let Settings { accuracy, interferer_hz, window_s, .. } = settings;
        let fitter = Fitter::new(settings.harmonics);
        Self { volts_per_code: reading::volts(1, settings.vref_v), fitter, accuracy, interferer_hz, window_s, told: 0 }
    }

    /// Fits a window. None if its frames were overwritten before they were read; the inner None says that it
    /// has to grow to be as accurate as was asked for.
    pub fn run(&mut self, window: &Window, source: &mut dyn FrameSource) -> Option<Option<Estimate>> {
        if !(self.accuracy > 0.0) || window.span == Span::Slide {
            return self.fit(window, source).map(Some);
        }
        // What told an estimate tells no other.
        let end = window.first.wrapping_add(window.frames);
        let first = if reached(self.told, window.first) && reached(end, self.told) { self.told } else { window.first };
        let window = Window { first, frames: end.wrapping_sub(first), ..*window };
        if window.frames < GROWING_FRAMES_MIN {
            return Some(None);
        }
        let estimate = self.fit(&window, source)?;
        let met = estimate.status == Status::Good && estimate.sigma_hz <= self.accuracy * estimate.frequency_hz;
        // Half a frame short is as long as it gets.
        if !met && estimate.window_s < self.window_s - 0.5 / window.frame_rate_hz {
            return Some(None);
        }
        self.told = end;
        Some(Some(estimate))
    }

    fn fit(&mut self, window: &Window, source: &mut dyn FrameSource) -> Option<Estimate> {
        let mut stretch = Stretch::new(source, window.first, window.frames);
        if self.interferer_hz > 0.0 {
            stretch = stretch.with_interferer(self.interferer_hz / window.frame_rate_hz);
        }
        let fit = self.fitter.fit(&mut stretch)?;
        let mut estimate = Estimate {
            t_us: window.end_us,
            window_s: window.frames as f32 / window.frame_rate_hz,
            span: window.span,
            status: fit.status,
            frequency_hz: fit.frequency * window.frame_rate_hz,
            sigma_hz: fit.sigma * window.frame_rate_hz,
            harmonics: fit.harmonics,
            frames_missing: window.frames.saturating_sub(fit.frames).min(u16::MAX as u32) as u16,
            channels: heapless::Vec::new(),
        };
        for taxel in 0..TAXELS {
            if fit.usable & 1 << taxel != 0 {
                // There is room for every taxel.
                let _ = estimate.channels.push(self.channel(&fit, taxel, &window.reference));
            }
        }
        Some(estimate)
    }

    fn channel(&self, fit: &Fit, taxel: usize, reference: &[i32; TAXELS]) -> Channel {
        let channel = &fit.channels[taxel];
        // A taxel's slot comes later in the scan than the frame's time: its phase is ahead by that.
        let ahead = 2.0 * PI * fit.frequency * taxel as f32 / crate::frame::SLOTS as f32;
        let phase_rad = channel.phase_rad - ahead;
        Channel {
            taxel: taxel as u8,
            offset_v: (reference[taxel] as f32 + channel.offset) * self.volts_per_code,
            amplitude_v: channel.amplitude * self.volts_per_code,
            phase_rad: if phase_rad < -PI { phase_rad + 2.0 * PI } else { phase_rad },
            residual_v: channel.residual * self.volts_per_code,
        }
    }
}

/// The whole path in one call, as a PC runs it: the detector, and each due window fitted at once.
#[derive(Debug)]
pub struct Pipeline {
    detector: Detector,
    estimator: Estimator,
    ring: Ring,
}

impl Pipeline {
    /// A pipeline at rest. `settings` must have passed [`Settings::validate`].
    pub const fn new(settings: Settings) -> Self {
        Self { detector: Detector::new(settings), estimator: Estimator::new(settings), ring: Ring::new() }
    }

    /// The greeting to send before anything else.
    pub fn hello(&self) -> Event {
        self.detector.hello()
    }

    /// Takes one conversion; events go to `emit`.
    pub fn push(&mut self, conversion: TimedConversion, emit: &mut dyn FnMut(Event)) {
        let mut windows = heapless::Vec::<Window, 8>::new();
        self.detector.push(conversion, &mut self.ring, &Counters::default(), emit, &mut |window| {
            let _ = windows.push(window);
        });
        self.fit(&windows, emit);
    }

    /// The signal has ended: closes what is open and reports health.
    pub fn finish(&mut self, emit: &mut dyn FnMut(Event)) {
        let mut windows = heapless::Vec::<Window, 8>::new();
        self.detector.finish(&mut self.ring, &Counters::default(), emit, &mut |window| {
            let _ = windows.push(window);
        });
        self.fit(&windows, emit);
    }

    fn fit(&mut self, windows: &[Window], emit: &mut dyn FnMut(Event)) {
        for window in windows {
            if let Some(Some(estimate)) = self.estimator.run(window, &mut &self.ring) {
                emit(Event::Estimate(estimate));
            }
        }
    }
}
