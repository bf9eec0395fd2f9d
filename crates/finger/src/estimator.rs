//! The estimator: turns windows into estimates.

use crate::faults::qualify::doubt;
use crate::fit::{Fitted, Tracker, fit};
use crate::ring::reached;
use crate::schedule::GROWING_FRAMES_MIN;
use crate::surface::lag::lag;
use crate::surface::texture::TextureReporter;
use crate::surface::travel;
use crate::window::Window;
use ads1258::reading;
use core::f32::consts::PI;
use ridgetone_proto::fault::FaultSet;
use ridgetone_proto::settings::{Settings, SlideRule, TAXELS, TRACK_STRIDE_S};
use ridgetone_proto::telemetry::{
    Channel, Estimate, Event, Movement, OtherTone, Overtones, Span, Status, Track, Travel,
    TravelStatus,
};
use ridgetone_tone::{Fit, Fitter, FrameSource, OVERTONES, Overwritten, Values};

/// Inverse of the fraction of a window above which a gap may mislead the search for a tone: the
/// spectrum of two pieces with a gap between them has side lines nearly as strong as the tone's. In
/// 94,000 windows of the named plans, with consecutive frames removed, no outliers were reported as
/// `good` with 11 % missing, 1 with 13 %, 3 with 15 %, and 6 to 11 % with 45 %. Scattered missing
/// frames do no harm: there were no outliers with 40 % missing.
const GAP_DIVISOR: u32 = 10;
/// Minimum time between full estimates while tracks are reported, microseconds.
const ESTIMATES_US: u64 = (1e6 * TRACK_STRIDE_S) as u64;
const READ_FRAMES: usize = 16;

/// Result of a window.
#[derive(Clone, Debug, PartialEq)]
#[allow(clippy::large_enum_variant, reason = "no allocation on the chip")]
pub enum WindowFit {
    /// An estimate to report.
    Done(Estimate),
    /// The window has to grow before it is as accurate as the settings require.
    Growing,
}

/// Turns windows into estimates. A [`Fitter`] has the memory for a fit.
#[derive(Debug)]
pub struct Estimator {
    settings: Settings,
    tracker: Tracker,
    /// Frame after the window of the latest estimate that was accurate enough.
    reported_end: u32,
    /// Device time of the latest full estimate while tracks are reported, microseconds.
    estimate_us: u64,
    /// Overtones of the latest fit, relative to its fundamental.
    overtones: Overtones,
    /// Compares textures with the latest reported one.
    pub textures: TextureReporter,
}

impl Estimator {
    /// Creates an estimator.
    pub const fn new(settings: Settings) -> Self {
        Self {
            settings,
            tracker: Tracker::new(),
            reported_end: 0,
            estimate_us: 0,
            overtones: [[0.0; 2]; OVERTONES],
            textures: TextureReporter::new(),
        }
    }

    /// Applies settings, which must have passed [`Settings::validate`].
    pub fn change(&mut self, settings: &Settings) {
        self.settings = *settings;
    }

    /// Fits a window, unless its frames were overwritten.
    pub fn run(
        &mut self,
        fitter: &mut Fitter,
        window: &Window,
        source: &mut dyn FrameSource,
    ) -> Result<WindowFit, Overwritten> {
        let (mut first, end) = (window.first, window.first.wrapping_add(window.frames));
        let grows = self.settings.accuracy > 0.0 && window.span != Span::Slide;
        // Do not reuse the frames of a reported estimate.
        if grows && reached(self.reported_end, first) && reached(end, self.reported_end) {
            first = self.reported_end;
        }
        let frames = end.wrapping_sub(first);
        if grows && frames < GROWING_FRAMES_MIN {
            return Ok(WindowFit::Growing);
        }
        let mut fitted = self.fit(
            fitter,
            &Window {
                first,
                frames,
                ..*window
            },
            source,
        );
        if grows && let Ok(WindowFit::Done(estimate)) = &fitted {
            // The uncertainty of an unsteady tone includes its modulation, which grows with the
            // window.
            let is_accurate = matches!(estimate.status, Status::Good | Status::Unsteady)
                && estimate.sigma <= self.settings.accuracy * estimate.frequency;
            // A window within half a frame of the maximum cannot grow further.
            let window_s = frames as f32 / window.frame_rate_hz;
            if !is_accurate && window_s < self.settings.window_s - 0.5 / window.frame_rate_hz {
                // Change it in place, because a copy would need more stack.
                fitted = Ok(WindowFit::Growing);
            } else {
                self.reported_end = end;
            }
        }
        fitted
    }

    /// Follows the tone of the latest fit to the end of a window, if tracks are reported and no
    /// full estimate is due. Returns `None` if the window has to be fitted.
    pub fn follow(
        &mut self,
        fitter: &mut Fitter,
        window: &Window,
        source: &mut dyn FrameSource,
    ) -> Option<Track> {
        let tracks = self.settings.tracks() && self.settings.accuracy <= 0.0;
        if !tracks || window.span != Span::Window || self.is_estimate_due(window.end_us) {
            return None;
        }
        let tracked = self.tracker.follow(fitter, window, source)?;
        Some(Track {
            t_us: window.end_us,
            frequency: tracked.frequency * window.frame_rate_hz,
            sigma: tracked.sigma * window.frame_rate_hz,
            status: Status::Good,
        })
    }

    /// True if a full estimate is due while tracks are reported.
    fn is_estimate_due(&self, t_us: u64) -> bool {
        // A time before the latest one belongs to a different run.
        t_us.wrapping_sub(self.estimate_us) >= ESTIMATES_US
    }

    /// Reports the estimate of the latest [`Self::run`] in full or, if windows follow each other
    /// fast, as a track, and in full at most twenty times a second. Also reports the texture under
    /// the finger, if new.
    pub fn report(&mut self, estimate: &Estimate, window: &Window, emit: &mut dyn FnMut(Event)) {
        let texture = self.textures.take(estimate, &self.overtones, window);
        let is_track = self.settings.tracks() && estimate.span == Span::Window;
        if is_track {
            emit(Event::Track(Track::from(estimate)));
        }
        if !is_track || self.is_estimate_due(estimate.t_us) {
            self.estimate_us = estimate.t_us;
            emit(Event::Estimate(estimate.clone()));
        }
        if let Some(texture) = texture {
            emit(Event::Texture(texture));
        }
    }

    /// Searches the window of the latest [`Self::run`] for a different tone, if a search is due;
    /// the next window then expects the tone found. Call this after the estimate is reported, so
    /// that the report does not wait for the search. If a search is skipped, as in a growing
    /// window, the next window makes up for it.
    ///
    /// # Errors
    /// If frames were overwritten.
    pub fn search(
        &mut self,
        fitter: &mut Fitter,
        window: &Window,
        source: &mut dyn FrameSource,
    ) -> Result<(), Overwritten> {
        if self.settings.accuracy > 0.0 {
            return Ok(());
        }
        self.tracker.search(fitter, window, source, &self.settings)
    }

    fn fit(
        &mut self,
        fitter: &mut Fitter,
        window: &Window,
        source: &mut dyn FrameSource,
    ) -> Result<WindowFit, Overwritten> {
        let fitted = fit(fitter, &mut self.tracker, window, source, &self.settings);
        // Use a reference, because a copy would need more stack.
        let fitted = fitted.as_ref().map_err(|overwritten| *overwritten)?;
        let min = window.frames / GAP_DIVISOR;
        // Usually no frames are missing, and nothing has to be read again.
        let has_gap =
            fitted.fit.frames.saturating_add(min) < window.frames && has_gap(window, min, source)?;
        self.overtones = fitted.fit.overtones;
        self.estimate(fitted, window, has_gap)
    }

    // Not inlined: its stack frame of 520 bytes would add to that of a fit, the deepest use of the
    // stack.
    #[inline(never)]
    fn estimate(
        &self,
        fitted: &Fitted,
        window: &Window,
        has_gap: bool,
    ) -> Result<WindowFit, Overwritten> {
        let fit = &fitted.fit;
        let (frames, rate_hz) = (window.frames, fitted.frame_rate_hz);
        let mut estimate = Estimate {
            t_us: window.end_us,
            window_s: frames as f32 / rate_hz,
            span: window.span,
            status: reported_status(fit.status),
            frequency: fit.frequency * rate_hz,
            sigma: fit.sigma * rate_hz,
            movement: movement(fit, rate_hz),
            other_tone: other_tone(fit, rate_hz),
            interferer_hz: fit.interferer.map(|cycles| cycles * rate_hz),
            harmonics: fit.harmonics,
            frames_missing: frames.saturating_sub(fit.frames).min(u16::MAX as u32) as u16,
            faults: FaultSet::NONE,
            travel: self.travel(fitted),
            channels: heapless::Vec::new(),
        };
        for taxel in 0..TAXELS {
            if fit.usable & 1 << taxel != 0 {
                // Cannot fail: the list has room for all taxels.
                let _ = estimate
                    .channels
                    .push(self.channel(fitted, taxel, &window.reference));
            }
        }
        if has_gap {
            doubt(&mut estimate);
        }
        Ok(WindowFit::Done(estimate))
    }

    fn travel(&self, fitted: &Fitted) -> Travel {
        let (fit, array) = (&fitted.fit, &self.settings.array);
        match reported_status(fit.status) {
            Status::Good | Status::Unsteady => {}
            Status::Ambiguous => {
                return Travel {
                    status: TravelStatus::Ambiguous,
                    ..Travel::NONE
                };
            }
            _ => return Travel::NONE,
        }
        let (lag, relative) = (lag(fitted, array), fit.sigma / fit.frequency);
        let frequency = fit.frequency * fitted.frame_rate_hz;
        let is_given = matches!(
            self.settings.slide.rule,
            SlideRule::Protocol | SlideRule::Always
        );
        let speed_mm_s = self.settings.slide.speed_mm_s;
        if !(is_given && speed_mm_s > 0.0) {
            return travel::by_phases(lag, array, (frequency, relative * frequency));
        }
        let period_mm = speed_mm_s / frequency;
        let period = (period_mm, relative * period_mm);
        travel::by_speed(lag, array, period, speed_mm_s)
    }

    fn channel(&self, fitted: &Fitted, taxel: usize, reference: &Values) -> Channel {
        let channel = &fitted.fit.channels[taxel];
        let volts_per_code = reading::volts(1, self.settings.vref_v);
        let turns = fitted.turns(taxel);
        let phase_rad = 2.0 * PI * (turns - libm::roundf(turns));
        Channel {
            taxel: taxel as u8,
            offset_v: (reference[taxel] + channel.offset) * volts_per_code,
            amplitude_v: channel.amplitude * volts_per_code,
            phase_rad,
            residual_v: channel.residual * volts_per_code,
        }
    }
}

/// True if more than `min` frames in a row are missing in a window.
fn has_gap(window: &Window, min: u32, source: &mut dyn FrameSource) -> Result<bool, Overwritten> {
    let (mut longest, mut gap, mut left) = (0u32, 0u32, window.frames);
    while left > 0 {
        let mut count = 1;
        let first = window.first.wrapping_add(window.frames - left);
        source.read(first, READ_FRAMES.min(left as usize), &mut |_, valid| {
            count = valid.len() as u32;
            for mask in valid {
                gap = if *mask == 0 { gap + 1 } else { 0 };
                longest = longest.max(gap);
            }
        })?;
        left = left.saturating_sub(count);
    }
    Ok(longest > min)
}

/// Converts a fit's frequency modulation to the units of an estimate; `per_unit` is the estimate's
/// frequency divided by the fit's.
pub fn movement(fit: &Fit, per_unit: f32) -> Movement {
    let ridgetone_tone::Movement {
        wander,
        wander_sigma,
        chirp,
        chirp_sigma,
    } = fit.movement;
    let per_unit_squared = per_unit * per_unit;
    Movement {
        wander,
        wander_sigma,
        chirp: chirp * per_unit_squared,
        chirp_sigma: chirp_sigma * per_unit_squared,
    }
}

/// Converts a fit's second tone to the units of an estimate.
pub fn other_tone(fit: &Fit, per_unit: f32) -> Option<OtherTone> {
    fit.other_tone.map(|other| OtherTone {
        frequency: other.frequency * per_unit,
        fraction: other.fraction,
    })
}

/// Converts a fit's status to that of an estimate.
pub const fn reported_status(status: ridgetone_tone::Status) -> Status {
    use ridgetone_tone::Status as Of;
    match status {
        Of::Good => Status::Good,
        Of::NoTone => Status::NoTone,
        Of::TooShort => Status::TooShort,
        Of::Nothing => Status::Nothing,
        Of::Ambiguous => Status::Ambiguous,
        Of::Unsteady => Status::Unsteady,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_chirp_has_the_square_of_the_frequency_s_unit_and_shares_have_none() {
        let mut fit = Fit::without_tone(ridgetone_tone::Status::TooShort, 100);
        fit.sigma = 0.5;
        fit.movement = ridgetone_tone::Movement {
            wander: 0.02,
            wander_sigma: 0.001,
            chirp: 0.25,
            chirp_sigma: 0.125,
        };
        fit.other_tone = Some(ridgetone_tone::OtherTone {
            frequency: 0.25,
            fraction: 0.5,
        });
        let expected = Movement {
            wander: 0.02,
            wander_sigma: 0.001,
            chirp: 4.0,
            chirp_sigma: 2.0,
        };
        assert_eq!(movement(&fit, 4.0), expected);
        assert_eq!(
            other_tone(&fit, 4.0),
            Some(OtherTone {
                frequency: 1.0,
                fraction: 0.5
            })
        );
    }
}
