//! push(conversion) -> events; composes the rooms; knows no hardware.
//!
//! The chip runs the two halves as tasks of different priority: [`Detector`] for every conversion,
//! [`Estimator`] for every window that falls due. [`Pipeline`] is both in one call, for a PC. The
//! halves share only the [`Ring`] and pass [`Window`]s, so both ways give the same numbers for every
//! window that is fitted; the chip may have to skip a hop, and counts it.

pub use crate::detector::{Counters, Detector};
use crate::frame::{CONVERSION_NS, SLOTS, TimedConversion};
use crate::profile::Profile;
use crate::settings::{Settings, TAXELS};
use crate::sine_fit::{ChannelFit, Fit, Fitter};
use crate::stretch::Stretch;
use crate::telemetry::{Abscissa, Channel, Estimate, Event, Status};
use crate::window::{FrameSource, Ring, Window};
use ads1258::reading;
use core::f32::consts::PI;

/// The middle of a scan, in slots from its first: along a path all taxels of a frame count as read there.
const MIDDLE_SLOT: f32 = 0.5 * (TAXELS as f32 - 1.0);

/// Spectrum and sine fit: the lowest task. Owns their scratch memory.
#[derive(Debug)]
pub struct Estimator {
    volts_per_code: f32,
    fitter: Fitter,
    profile: Option<Profile>,
}

/// How a fit's frequency is told.
struct Scale {
    abscissa: Abscissa,
    /// Its unit in that of the fit.
    per_unit: f32,
    /// Cycles from one slot to the next, in cycles of the fit's frequency, and the slot whose phase the
    /// fit gives.
    per_slot: f32,
    slot: f32,
}

impl Estimator {
    /// An estimator; `const`, so that its scratch memory can live in a static.
    pub const fn new(settings: Settings) -> Self {
        let (volts_per_code, fitter) = (reading::volts(1, settings.vref_v), Fitter::new(settings.harmonics));
        Self { volts_per_code, fitter, profile: None }
    }

    /// With a speed profile estimates come in cycles per millimetre, from the next window on; without, in hertz.
    pub fn follow(&mut self, profile: Option<Profile>) {
        self.profile = profile;
    }

    /// Fits a window. None if its frames were overwritten before they were read.
    pub fn run(&mut self, window: &Window, source: &mut dyn FrameSource) -> Option<Estimate> {
        let (fit, scale) = match &self.profile {
            None => fit_in_time(&mut self.fitter, window, source)?,
            Some(profile) => fit_by_place(&mut self.fitter, profile, window, source)?,
        };
        let mut estimate = Estimate {
            t_us: window.end_us,
            window_s: window.frames as f32 / window.frame_rate_hz,
            span: window.span,
            status: fit.status,
            abscissa: scale.abscissa,
            frequency: fit.frequency * scale.per_unit,
            sigma: fit.sigma * scale.per_unit,
            harmonics: fit.harmonics,
            frames_missing: window.frames.saturating_sub(fit.frames).min(u16::MAX as u32) as u16,
            channels: heapless::Vec::new(),
        };
        for taxel in 0..TAXELS {
            if fit.usable & 1 << taxel != 0 {
                // There is room for every taxel.
                let _ = estimate.channels.push(self.channel(&fit, &scale, taxel, &window.reference));
            }
        }
        Some(estimate)
    }

    fn channel(&self, fit: &Fit, scale: &Scale, taxel: usize, reference: &[i32; TAXELS]) -> Channel {
        let channel = &fit.channels[taxel];
        // A taxel's slot comes later in the scan than the time of its frame: its phase is ahead by that.
        let ahead = fit.frequency * scale.per_slot * (taxel as f32 - scale.slot);
        let turns = channel.phase_rad / (2.0 * PI) - ahead;
        let phase_rad = 2.0 * PI * (turns - libm::roundf(turns));
        Channel {
            taxel: taxel as u8,
            offset_v: (reference[taxel] as f32 + channel.offset) * self.volts_per_code,
            amplitude_v: channel.amplitude * self.volts_per_code,
            phase_rad,
            residual_v: channel.residual * self.volts_per_code,
        }
    }
}

fn fit_in_time(fitter: &mut Fitter, window: &Window, source: &mut dyn FrameSource) -> Option<(Fit, Scale)> {
    let (per_unit, per_slot) = (window.frame_rate_hz, 1.0 / SLOTS as f32);
    let fit = fitter.fit(&mut Stretch::new(source, window.first, window.frames))?;
    Some((fit, Scale { abscissa: Abscissa::Time, per_unit, per_slot, slot: 0.0 }))
}

fn fit_by_place(
    fitter: &mut Fitter,
    profile: &Profile,
    window: &Window,
    source: &mut dyn FrameSource,
) -> Option<(Fit, Scale)> {
    // By the converter's own clock: a stamp of a single frame has the jitter of its interrupt.
    let frame_us = 1e6 / window.frame_rate_hz;
    let last = window.frames.saturating_sub(1);
    let middle_us = (MIDDLE_SLOT * CONVERSION_NS as f32 / 1e3) as u64;
    let start_us = window.end_us.saturating_add(middle_us).saturating_sub((last as f32 * frame_us) as u64);
    let zero_mm = profile.place_mm(start_us);
    let place_mm = |frame: u32| (profile.place_mm(start_us + (frame as f32 * frame_us) as u64) - zero_mm) as f32;
    let per_slot = place_mm(last) / (last.max(1) * SLOTS) as f32;
    let scale = Scale { abscissa: Abscissa::Place, per_unit: 1.0, per_slot, slot: MIDDLE_SLOT };
    let fit = match Stretch::new(source, window.first, window.frames).along(&place_mm) {
        Some(mut stretch) => fitter.fit(&mut stretch)?,
        // The finger rests.
        None => Fit {
            status: Status::TooShort,
            frequency: 0.0,
            sigma: 0.0,
            harmonics: 0,
            frames: window.frames,
            usable: 0,
            channels: [ChannelFit::default(); TAXELS],
        },
    };
    Some((fit, scale))
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

    /// See [`Estimator::follow`].
    pub fn follow(&mut self, profile: Option<Profile>) {
        self.estimator.follow(profile);
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
        self.detector.finish(&self.ring, &Counters::default(), emit, &mut |window| {
            let _ = windows.push(window);
        });
        self.fit(&windows, emit);
    }

    fn fit(&mut self, windows: &[Window], emit: &mut dyn FnMut(Event)) {
        for window in windows {
            if let Some(estimate) = self.estimator.run(window, &mut &self.ring) {
                emit(Event::Estimate(estimate));
            }
        }
    }
}
