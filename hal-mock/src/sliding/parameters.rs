//! Parameters of a scene, and what is impossible among them.

use super::drawn::HARMONICS;
use super::finger::Finger;
use super::motion::{Hand, Stimulator};

/// Parameters of a [`SlidingScene`](super::SlidingScene); the defaults are the paper's protocol at 30 mm/s and 3.6 mm,
/// on drawn channels with 20 dB. A scene file begins with [`physical`](Self::physical) instead.
#[derive(Clone, Debug, PartialEq, serde::Deserialize)]
#[serde(deny_unknown_fields, default = "Sliding::physical")]
pub struct Sliding {
    /// Speed of the grating in mm/s, > 0.
    pub speed_mm_s: f64,
    /// Spatial period of the grating in mm, > 0.
    pub period_mm: f64,
    /// Width of its ridges in mm, 0 < x < `period_mm`; the rest of a period is groove. Only a `finger` feels it.
    pub ridge_mm: f64,
    /// Where a ridge is at the touch, in mm ahead of the middle of the contact.
    pub start_mm: f64,
    /// Slides from units 2 and 4 to units 1 and 3 instead of the other way.
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
    /// 10 log10 of the tone's mean power over the noise's: mean over channels of A^2 / 2, with the fundamental's
    /// amplitude A, over sigma^2, the same on all channels, per reading. `None`: no noise but the finger's own.
    pub snr_db: Option<f64>,
    /// Amplitudes of the 2nd, 3rd and 4th harmonic of drawn channels relative to the fundamental; 0 leaves one out. A
    /// `finger` has those of its geometry.
    #[serde(skip)]
    pub overtones: [f64; HARMONICS - 1],
    /// Of the run: its noise, the ripple's phase, the jitter; of drawn channels their gains, phases and offsets too.
    pub seed: u64,
    /// What the stimulator makes of speed and time.
    pub stimulator: Stimulator,
    /// A hand in the stimulator's place: `speed_mm_s`, `slide_mm` and `stimulator` do not count.
    pub hand: Option<Hand>,
    /// The fingertip as a physical thing. `None`: drawn channels, without creep and filter.
    pub finger: Option<Finger>,
    /// The chip behind the scene; it is for whoever builds that.
    pub converter: Converter,
}

/// How the chip is to be built that reads a scene.
#[derive(Clone, Copy, Debug, PartialEq, serde::Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Converter {
    /// Error of its crystal in parts per million; positive is fast. -10,000 to 10,000, default 0.
    pub clock_error_ppm: f64,
    /// Whether it adds its own noise. Default yes.
    pub converter_noise: bool,
}

impl Default for Converter {
    fn default() -> Self {
        Self { clock_error_ppm: 0.0, converter_noise: true }
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
    /// The paper's protocol on the physical finger, with no noise but its own.
    pub fn physical() -> Self {
        Self { snr_db: None, stimulator: Stimulator::default(), finger: Some(Finger::default()), ..Self::default() }
    }

    pub(super) fn check(&self) -> Result<(), ParameterError> {
        let s = self.stimulator;
        let rules = [
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
            ("snr_db", self.snr_db.unwrap_or(0.0), Range::Any),
            ("speed_error_percent", s.speed_error_percent, Range::Between(-99.0, 1000.0)),
            ("ripple_percent", s.ripple_percent, Range::Between(0.0, 99.0)),
            ("ripple_hz", s.ripple_hz, Range::Positive),
            ("clock_error_ppm", self.converter.clock_error_ppm, Range::Between(-1e4, 1e4)),
        ];
        check_all(&rules)?;
        // These compare with what was found sound above.
        let told_mm_s = self.speed_mm_s * (1.0 + 0.01 * s.speed_error_percent);
        check_all(&[
            ("onset_jitter_s", s.onset_jitter_s, Range::UpTo(self.hold_before_s, "hold_before_s")),
            ("ramp_s", s.ramp_s, Range::UpTo(self.slide_mm / told_mm_s, "slide_mm / speed_mm_s")),
        ])?;
        if let Some(hand) = self.hand {
            check_all(&[
                ("peak_mm_s", hand.peak_mm_s, Range::Positive),
                ("swing_hz", hand.swing_hz, Range::Positive),
                ("swings", hand.swings, Range::Positive),
            ])?;
        }
        self.finger.map_or(Ok(()), |finger| {
            check_all(&[
                ("ridge_mm", self.ridge_mm, Range::Positive),
                ("ridge_mm", self.ridge_mm, Range::Below(self.period_mm, "period_mm")),
            ])?;
            check_all(&finger.rules())?;
            // Otherwise there are moments in which no ridge carries the load.
            let most_mm = finger.contact_mm + self.ridge_mm;
            check_all(&[("period_mm", self.period_mm, Range::UpTo(most_mm, "contact_mm + ridge_mm"))])
        })
    }
}

/// What a parameter may be; all have to be finite.
pub(super) enum Range {
    Any,
    Positive,
    NotNegative,
    Between(f64, f64),
    /// From 0 to a limit, which has a name.
    UpTo(f64, &'static str),
    /// Below a limit, which has a name.
    Below(f64, &'static str),
}

fn check_all(rules: &[(&'static str, f64, Range)]) -> Result<(), ParameterError> {
    let broken = rules.iter().find_map(|&(name, value, ref range)| {
        let (fits, wanted, limit) = match *range {
            Range::Any => (true, "a number".into(), ""),
            Range::Positive => (value > 0.0, "greater than 0".into(), ""),
            Range::NotNegative => (value >= 0.0, "not negative".into(), ""),
            Range::Between(low, high) => ((low..=high).contains(&value), format!("from {low} to {high}"), ""),
            Range::UpTo(limit, what) => {
                ((0.0..=limit).contains(&value), format!("from 0 to {limit:.4} = {what}"), what)
            }
            Range::Below(limit, what) => (value < limit, format!("less than {limit} = {what}"), what),
        };
        (!(fits && value.is_finite())).then_some(ParameterError { name, value, wanted, limit })
    });
    broken.map_or(Ok(()), Err)
}

/// A parameter of [`Sliding`] that is out of its range.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{name} = {value}: must be finite and {wanted}")]
pub struct ParameterError {
    /// Field of [`Sliding`] or of a part of it.
    pub name: &'static str,
    /// Its value.
    pub value: f64,
    wanted: String,
    /// The expression of other fields that limits it, or nothing.
    limit: &'static str,
}

impl ParameterError {
    /// The fields that it is about: the one out of its range, then those that limit it.
    pub(crate) fn keys(&self) -> impl Iterator<Item = &'static str> {
        [self.name].into_iter().chain(self.limit.split(' '))
    }
}
