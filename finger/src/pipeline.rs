//! push(conversion) -> events; composes the rooms; knows no hardware.
//!
//! The chip runs the two halves as tasks of different priority: [`Detector`] for every conversion,
//! [`Estimator`] for every window that falls due. [`Pipeline`] is both in one call, for a PC. The
//! halves share only the [`Ring`] and pass [`Window`]s, so both ways give the same numbers for every
//! window that is fitted; the chip may have to skip a hop, and counts it.

use crate::abscissa::{Fitted, by_place, in_time};
pub use crate::detector::Detector;
pub use crate::faults::diagnostics::Counters;
use crate::faults::diagnostics::Diagnostics;
use crate::faults::qualify::qualify;
use crate::frame::TimedConversion;
use crate::ring::{Ring, reached};
use crate::schedule::GROWING_FRAMES_MIN;
use crate::surface::lag::lag;
use crate::surface::profile::Profile;
use crate::surface::travel;
use crate::window::Window;
use ads1258::reading;
use core::f32::consts::PI;
use ridgetone_proto::fault::FaultSet;
use ridgetone_proto::settings::{Array, Settings, SlideRule, TAXELS};
use ridgetone_proto::telemetry::{Abscissa, Channel, Direction, Estimate, Event, Span, Status, Travel, TravelStatus};
use ridgetone_tone::{Fitter, FrameSource, Overwritten, Values};

/// Spectrum and sine fit: the lowest task. Owns their scratch memory.
#[derive(Debug)]
pub struct Estimator {
    volts_per_code: f32,
    fitter: Fitter,
    accuracy: f32,
    interferer_hz: f32,
    window_s: f32,
    array: Array,
    /// Speed by the protocol, if that is known, millimetres per second.
    speed_mm_s: Option<f32>,
    /// Frame behind the latest estimate that was accurate enough.
    told: u32,
}

impl Estimator {
    /// An estimator; `const`, so that its scratch memory can live in a static.
    pub const fn new(settings: Settings) -> Self {
        let Settings { accuracy, interferer_hz, window_s, array, .. } = settings;
        let speed_mm_s = speed_told(&settings.slide);
        let fitter = Fitter::new(settings.harmonics);
        let volts_per_code = reading::volts(1, settings.vref_v);
        Self { volts_per_code, fitter, accuracy, interferer_hz, window_s, array, speed_mm_s, told: 0 }
    }

    /// From now on these settings are in force; they must have passed [`Settings::validate`].
    pub fn change(&mut self, settings: &Settings) {
        let Settings { accuracy, interferer_hz, window_s, array, .. } = *settings;
        (self.accuracy, self.interferer_hz, self.window_s, self.array) = (accuracy, interferer_hz, window_s, array);
        self.speed_mm_s = speed_told(&settings.slide);
        self.volts_per_code = reading::volts(1, settings.vref_v);
        self.fitter.set_harmonics(settings.harmonics);
    }

    /// Fits a window. None if it has to grow to be as accurate as the settings require. With a speed profile the
    /// estimate is in cycles per millimetre, without in hertz.
    ///
    /// # Errors
    /// If its frames were overwritten before they were read.
    pub fn run(
        &mut self,
        window: &Window,
        source: &mut dyn FrameSource,
        profile: Option<&Profile>,
    ) -> Result<Option<Estimate>, Overwritten> {
        if !(self.accuracy > 0.0) || window.span == Span::Slide {
            return self.fit(window, source, profile).map(Some);
        }
        // What told an estimate tells no other.
        let end = window.first.wrapping_add(window.frames);
        let first = if reached(self.told, window.first) && reached(end, self.told) { self.told } else { window.first };
        let window = Window { first, frames: end.wrapping_sub(first), ..*window };
        if window.frames < GROWING_FRAMES_MIN {
            return Ok(None);
        }
        let estimate = self.fit(&window, source, profile)?;
        let met = estimate.status == Status::Good && estimate.sigma <= self.accuracy * estimate.frequency;
        // Half a frame short is as long as it gets.
        if !met && estimate.window_s < self.window_s - 0.5 / window.frame_rate_hz {
            return Ok(None);
        }
        self.told = end;
        Ok(Some(estimate))
    }

    fn fit(
        &mut self,
        window: &Window,
        source: &mut dyn FrameSource,
        profile: Option<&Profile>,
    ) -> Result<Estimate, Overwritten> {
        let (fitter, interferer_hz) = (&mut self.fitter, self.interferer_hz);
        let fitted = match profile {
            None => in_time(fitter, window, source, interferer_hz)?,
            Some(profile) => by_place(fitter, window, source, interferer_hz, profile)?,
        };
        let fit = &fitted.fit;
        let mut estimate = Estimate {
            t_us: window.end_us,
            window_s: window.frames as f32 / window.frame_rate_hz,
            span: window.span,
            status: reported_status(fit.status),
            abscissa: fitted.abscissa,
            frequency: fit.frequency * fitted.per_unit,
            sigma: fit.sigma * fitted.per_unit,
            harmonics: fit.harmonics,
            frames_missing: window.frames.saturating_sub(fit.frames).min(u16::MAX as u32) as u16,
            faults: FaultSet::NONE,
            travel: self.travel(&fitted, window),
            channels: heapless::Vec::new(),
        };
        for taxel in 0..TAXELS {
            if fit.usable & 1 << taxel != 0 {
                // There is room for every taxel.
                let _ = estimate.channels.push(self.channel(&fitted, taxel, &window.reference));
            }
        }
        Ok(estimate)
    }

    fn travel(&self, fitted: &Fitted, window: &Window) -> Travel {
        let (fit, array) = (&fitted.fit, &self.array);
        match reported_status(fit.status) {
            Status::Good => {}
            Status::Ambiguous => return Travel { status: TravelStatus::Ambiguous, ..Travel::NONE },
            _ => return Travel::NONE,
        }
        let (lag, relative) = (lag(fitted, array), fit.sigma / fit.frequency);
        let frequency = fit.frequency * fitted.per_unit;
        let told = match (fitted.abscissa, self.speed_mm_s) {
            (Abscissa::Place, _) => (1.0 / frequency, fitted.per_frame() * window.frame_rate_hz),
            (Abscissa::Time, Some(speed_mm_s)) => (speed_mm_s / frequency, speed_mm_s),
            (Abscissa::Time, None) => return travel::by_phases(lag, array, (frequency, relative * frequency)),
        };
        let (period_mm, speed_mm_s) = told;
        let way = if speed_mm_s < 0.0 { Direction::Backward } else { Direction::Forward };
        travel::by_speed(lag, array, (period_mm, relative * period_mm), speed_mm_s.abs(), way)
    }

    fn channel(&self, fitted: &Fitted, taxel: usize, reference: &Values) -> Channel {
        let channel = &fitted.fit.channels[taxel];
        let turns = fitted.turns(taxel);
        let phase_rad = 2.0 * PI * (turns - libm::roundf(turns));
        Channel {
            taxel: taxel as u8,
            offset_v: (reference[taxel] + channel.offset) * self.volts_per_code,
            amplitude_v: channel.amplitude * self.volts_per_code,
            phase_rad,
            residual_v: channel.residual * self.volts_per_code,
        }
    }
}

/// A fit's status as an estimate has it.
pub const fn reported_status(status: ridgetone_tone::Status) -> Status {
    use ridgetone_tone::Status as Of;
    match status {
        Of::Good => Status::Good,
        Of::NoTone => Status::NoTone,
        Of::TooShort => Status::TooShort,
        Of::Nothing => Status::Nothing,
        Of::Ambiguous => Status::Ambiguous,
    }
}

/// Speed by the protocol, if that is known, millimetres per second.
const fn speed_told(slide: &SlideRule) -> Option<f32> {
    match slide {
        SlideRule::Found => None,
        SlideRule::Protocol { speed_mm_s, .. } => Some(*speed_mm_s),
    }
}

/// The whole path in one call, as a PC runs it: the detector, and each due window fitted at once.
#[derive(Debug)]
pub struct Pipeline {
    detector: Detector,
    estimator: Estimator,
    ring: Ring,
    diagnostics: Diagnostics,
    profile: Option<Profile>,
}

impl Pipeline {
    /// A pipeline at rest. `settings` must have passed [`Settings::validate`].
    pub const fn new(settings: Settings) -> Self {
        Self {
            detector: Detector::new(settings),
            estimator: Estimator::new(settings),
            ring: Ring::new(),
            diagnostics: Diagnostics::new(),
            profile: None,
        }
    }

    /// From now on estimates come by this speed profile, in cycles per millimetre; without one, in hertz.
    pub fn follow(&mut self, profile: Option<Profile>) {
        self.profile = profile;
    }

    /// The next `frames` frames are reported raw too.
    pub fn report_raw(&mut self, frames: u32) {
        self.detector.report_raw(frames);
    }

    /// The greeting to send before anything else.
    pub fn hello(&self) -> Event {
        self.detector.hello()
    }

    /// Takes one conversion; events go to `emit`.
    pub fn push(&mut self, conversion: TimedConversion, emit: &mut dyn FnMut(Event)) {
        let mut windows = heapless::Vec::<Window, 8>::new();
        self.detector.push(conversion, &mut self.ring, &self.diagnostics, emit, &mut |window| {
            let _ = windows.push(window);
        });
        self.fit(&windows, emit);
    }

    /// The signal has ended: closes what is open and reports health.
    pub fn finish(&mut self, emit: &mut dyn FnMut(Event)) {
        let mut windows = heapless::Vec::<Window, 8>::new();
        self.detector.finish(&mut self.ring, &self.diagnostics, emit, &mut |window| {
            let _ = windows.push(window);
        });
        self.fit(&windows, emit);
    }

    fn fit(&mut self, windows: &[Window], emit: &mut dyn FnMut(Event)) {
        for window in windows {
            if let Ok(Some(mut estimate)) = self.estimator.run(window, &mut &self.ring, self.profile.as_ref()) {
                qualify(&mut estimate, window, &self.diagnostics);
                emit(Event::Estimate(estimate));
            }
        }
    }
}
