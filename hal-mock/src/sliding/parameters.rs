//! Parameters of a scene, and their ranges.

use super::finger::{Finger, Grating};
use super::motion::{Hand, Stimulator};
use super::random_channels::OVERTONES;
use super::range::{ParameterError, Range, check};

/// Parameters of a [`SlidingScene`](super::SlidingScene); the defaults are the paper's protocol at
/// 30 mm/s and 3.6 mm, on random channels at 20 dB. Scene files start from
/// [`physical`](Self::physical) instead.
#[derive(Clone, Debug, PartialEq, serde::Deserialize)]
#[serde(deny_unknown_fields, default = "Sliding::physical")]
pub struct Sliding {
    /// Speed of the grating in mm/s, > 0.
    pub speed_mm_s: f64,
    /// Spatial period of the grating in mm, > 0.
    pub period_mm: f64,
    /// Width of the grating's ridges in mm, 0 < x < `period_mm`; the rest of a period is groove.
    /// Only used with a `finger`.
    pub ridge_mm: f64,
    /// Position of a ridge at the touch, in mm ahead of the middle of the contact.
    pub start_mm: f64,
    /// True to slide from units 2 and 4 to units 1 and 3 instead of the other way round.
    pub reverse: bool,
    /// Distance slid in mm, > 0.
    pub slide_mm: f64,
    /// Phase A, before the touch, in seconds, >= 0.
    pub idle_s: f64,
    /// Phase B, from the spike's peak to the beginning of the slide, in seconds, >= 0.
    pub hold_before_s: f64,
    /// Phase D, from the end of the slide to the release, in seconds, >= 0.
    pub hold_after_s: f64,
    /// Phase E, from the beginning of the release to the end, in seconds, >= 0.
    pub release_idle_s: f64,
    /// Signal-to-noise ratio of a reading: 10 log10(mean(A^2 / 2) / sigma^2), where A is a
    /// channel's amplitude of the fundamental and sigma is the same on all channels. `None` for
    /// only the finger's own noise.
    pub snr_db: Option<f64>,
    /// Amplitudes of the 2nd, 3rd and 4th harmonic of random channels relative to the fundamental;
    /// 0 omits a harmonic.
    #[serde(skip)]
    pub overtones: [f64; OVERTONES],
    /// Seed of the run: noise, phase of the ripple, jitter; for random channels also their gains,
    /// phases and offsets.
    pub seed: u64,
    /// Deviations of the stimulator from the nominal speed and time.
    pub stimulator: Stimulator,
    /// A hand instead of the stimulator: `speed_mm_s`, `slide_mm` and `stimulator` are ignored.
    pub hand: Option<Hand>,
    /// Physical model of the fingertip. `None`: random channels, without creep and filter.
    pub finger: Option<Finger>,
    /// The chip that reads the scene. The scene itself does not use it.
    pub converter: Converter,
}

/// The chip that reads a scene.
#[derive(Clone, Copy, Debug, PartialEq, serde::Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Converter {
    /// Error of the chip's crystal in parts per million; positive is fast. -10,000 to 10,000,
    /// default 0.
    pub clock_error_ppm: f64,
    /// True if the chip adds its own noise. Default true.
    pub converter_noise: bool,
}

impl Default for Converter {
    fn default() -> Self {
        Self {
            clock_error_ppm: 0.0,
            converter_noise: true,
        }
    }
}

impl Default for Sliding {
    fn default() -> Self {
        Self {
            speed_mm_s: 30.0,
            period_mm: 3.6,
            ridge_mm: 0.6,
            start_mm: 0.0,
            reverse: false,
            slide_mm: 60.0,
            idle_s: 0.5,
            hold_before_s: 1.0,
            hold_after_s: 1.0,
            release_idle_s: 0.5,
            snr_db: Some(20.0),
            overtones: [0.4, 0.2, 0.1],
            seed: 1,
            stimulator: Stimulator::IDEAL,
            hand: None,
            finger: None,
            converter: Converter::default(),
        }
    }
}

impl Sliding {
    /// The paper's protocol on the physical finger, with only the finger's own noise.
    pub fn physical() -> Self {
        Self {
            snr_db: None,
            stimulator: Stimulator::default(),
            finger: Some(Finger::default()),
            ..Self::default()
        }
    }

    pub(crate) fn grating(&self) -> Grating {
        let Self {
            period_mm,
            ridge_mm,
            start_mm,
            reverse,
            ..
        } = *self;
        Grating {
            period_mm,
            ridge_mm,
            start_mm,
            reverse,
        }
    }

    pub(crate) fn check(&self) -> Result<(), ParameterError> {
        let s = self.stimulator;
        let speed_mm_s = self.speed_mm_s * (1.0 + 0.01 * s.speed_error_percent);
        // A limit that depends on other parameters comes after their rules, so that they are
        // checked first.
        let mut rules = vec![
            ("speed_mm_s", self.speed_mm_s, Range::Positive),
            ("period_mm", self.period_mm, Range::Positive),
            ("slide_mm", self.slide_mm, Range::Positive),
            ("start_mm", self.start_mm, Range::Any),
            ("idle_s", self.idle_s, Range::NotNegative),
            ("hold_before_s", self.hold_before_s, Range::NotNegative),
            ("hold_after_s", self.hold_after_s, Range::NotNegative),
            ("release_idle_s", self.release_idle_s, Range::NotNegative),
            ("overtones[0]", self.overtones[0], Range::NotNegative),
            ("overtones[1]", self.overtones[1], Range::NotNegative),
            ("overtones[2]", self.overtones[2], Range::NotNegative),
            (
                "snr_db",
                self.snr_db.unwrap_or(0.0),
                Range::Between(-100.0, 200.0),
            ),
            (
                "speed_error_percent",
                s.speed_error_percent,
                Range::Between(-99.0, 1000.0),
            ),
            (
                "ripple_percent",
                s.ripple_percent,
                Range::Between(0.0, 99.0),
            ),
            ("ripple_hz", s.ripple_hz, Range::Positive),
            (
                "clock_error_ppm",
                self.converter.clock_error_ppm,
                Range::Between(-1e4, 1e4),
            ),
            (
                "onset_jitter_s",
                s.onset_jitter_s,
                Range::UpTo(self.hold_before_s, "hold_before_s"),
            ),
            (
                "ramp_s",
                s.ramp_s,
                Range::UpTo(self.slide_mm / speed_mm_s, "slide_mm / speed_mm_s"),
            ),
        ];
        if let Some(hand) = self.hand {
            rules.extend([
                ("peak_mm_s", hand.peak_mm_s, Range::Positive),
                // A hand swings much more slowly than the chip scans.
                ("swing_hz", hand.swing_hz, Range::Between(1e-6, 100.0)),
                ("swings", hand.swings, Range::Positive),
            ]);
        }
        if let Some(finger) = self.finger {
            rules.push(("ridge_mm", self.ridge_mm, Range::Positive));
            rules.push((
                "ridge_mm",
                self.ridge_mm,
                Range::Below(self.period_mm, "period_mm"),
            ));
            rules.extend(finger.rules());
            // Otherwise there would be moments at which no ridge carries the load.
            let max_mm = finger.contact_mm + self.ridge_mm;
            rules.push((
                "period_mm",
                self.period_mm,
                Range::UpTo(max_mm, "contact_mm + ridge_mm"),
            ));
        }
        check(&rules)
    }
}
