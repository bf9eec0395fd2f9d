//! The simplest scene of the paper's protocol: a grating is pressed on the finger, slides, and is lifted.
//!
//! Protocol, periods and speeds: Oddo et al. 2009, section 3.1 and tables 1 to 3. What the channels look like
//! (amplitudes, spikes, overtones) is not in the paper as numbers; the values here are plausible, not measured.

mod skin;

pub use skin::{Channel, HARMONICS};

use crate::random::{Random, Stream};
use crate::scene::{INPUTS, Scene};
use skin::skin;

/// Speed in mm/s and spatial period in mm of the paper's ten combinations C1 to C10, in the order of its table 3.
pub const TABLE_2: [(f64, f64); 10] = [
    (15.0, 3.6),
    (30.0, 3.6),
    (15.0, 4.1),
    (30.0, 4.1),
    (15.0, 3.1),
    (30.0, 3.1),
    (48.0, 3.1),
    (15.0, 2.6),
    (30.0, 2.6),
    (48.0, 2.6),
];

/// Seconds from touch to the full load and the spike's peak, and from the beginning of the release to its end.
const RISE_S: f64 = 0.010;
/// Seconds in which the spike decays to 1/e.
const DECAY_S: f64 = 0.040;

/// Parameters of a [`SlidingScene`]; the defaults are the paper's protocol at 30 mm/s and 3.6 mm with 20 dB.
#[derive(Clone, Debug, PartialEq)]
pub struct Sliding {
    /// Speed of the grating in mm/s, > 0.
    pub speed_mm_s: f64,
    /// Spatial period of the grating in mm, > 0.
    pub period_mm: f64,
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
    /// amplitude A, over sigma^2, the same on all channels, per reading. `None`: no noise.
    pub snr_db: Option<f64>,
    /// Amplitudes of the 2nd, 3rd and 4th harmonic relative to the fundamental; 0 leaves one out.
    pub overtones: [f64; HARMONICS - 1],
    /// Varies gains, phases and offsets mildly, and the noise.
    pub seed: u64,
}

impl Default for Sliding {
    fn default() -> Self {
        Self {
            speed_mm_s: 30.0,
            period_mm: 3.6,
            slide_mm: 60.0,
            idle_s: 0.5,
            hold_before_s: 1.0,
            hold_after_s: 1.0,
            release_idle_s: 0.5,
            snr_db: Some(20.0),
            overtones: [0.4, 0.2, 0.1],
            seed: 1,
        }
    }
}

/// A parameter of [`Sliding`] that is out of its range.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{name} = {value}: must be finite and {wanted}")]
pub struct ParameterError {
    /// Field of [`Sliding`].
    pub name: &'static str,
    /// Its value.
    pub value: f64,
    wanted: &'static str,
}

/// What a scene's signals were made from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Truth {
    /// Time of the contact spike's peak in seconds.
    pub contact_s: f64,
    /// Beginning of the slide in seconds.
    pub slide_start_s: f64,
    /// End of the slide in seconds.
    pub slide_end_s: f64,
    /// Beginning of the release in seconds.
    pub release_s: f64,
    /// The tone: speed over period, in hertz.
    pub frequency_hz: f64,
    /// End of the scene in seconds.
    pub end_s: f64,
}

/// The scene. The tone is a function of the position of the grating, so all signals are continuous.
#[derive(Clone, Debug)]
pub struct SlidingScene {
    parameters: Sliding,
    truth: Truth,
    channels: [Channel; INPUTS],
    noise_v: f64,
    random: Random,
}

impl SlidingScene {
    /// Builds the scene.
    ///
    /// # Errors
    /// Names the first parameter that is not finite or out of the range its documentation gives.
    pub fn new(parameters: Sliding) -> Result<Self, ParameterError> {
        check(&parameters)?;
        let Sliding { speed_mm_s, period_mm, .. } = parameters;
        let contact_s = parameters.idle_s + RISE_S;
        let slide_start_s = contact_s + parameters.hold_before_s;
        let slide_end_s = slide_start_s + parameters.slide_mm / speed_mm_s;
        let release_s = slide_end_s + parameters.hold_after_s;
        let truth = Truth {
            contact_s,
            slide_start_s,
            slide_end_s,
            release_s,
            frequency_hz: speed_mm_s / period_mm,
            end_s: release_s + parameters.release_idle_s,
        };
        let channels = skin(period_mm, parameters.overtones, parameters.seed);
        let power = channels.iter().map(|c| c.amplitude_v * c.amplitude_v / 2.0).sum::<f64>() / INPUTS as f64;
        let noise_v = parameters.snr_db.map_or(0.0, |db| libm::sqrt(power / libm::pow(10.0, db / 10.0)));
        let random = Random::new(parameters.seed, Stream::SceneNoise);
        Ok(Self { parameters, truth, channels, noise_v, random })
    }

    /// What the signals were made from.
    pub fn truth(&self) -> Truth {
        self.truth
    }

    /// The parameters as given.
    pub fn parameters(&self) -> &Sliding {
        &self.parameters
    }

    /// What each channel looks like.
    pub fn channels(&self) -> &[Channel; INPUTS] {
        &self.channels
    }

    /// Standard deviation of the noise in volts.
    pub fn noise_v(&self) -> f64 {
        self.noise_v
    }

    /// Position of the grating in mm: 0 before the slide, constant after it.
    pub fn position_mm(&self, t_s: f64) -> f64 {
        (self.parameters.speed_mm_s * (t_s - self.truth.slide_start_s)).clamp(0.0, self.parameters.slide_mm)
    }

    /// Volts on AIN`input` without the noise. Inputs above 15 are at 0 V.
    pub fn clean_volts(&self, input: u8, t_s: f64) -> f64 {
        let Some(channel) = self.channels.get(usize::from(input)) else { return 0.0 };
        let load = self.load(t_s);
        // Without contact there is no tone either.
        channel.offset_v
            + load * (channel.load_v + channel.tone_v(self.position_mm(t_s)))
            + channel.spike_v * self.spike(t_s)
    }

    /// Normal load relative to the hold's: a step on with the touch, a step off with the release.
    fn load(&self, t_s: f64) -> f64 {
        step((t_s - self.truth.contact_s) / RISE_S + 1.0) * (1.0 - step((t_s - self.truth.release_s) / RISE_S))
    }

    /// Overshoot of the touch relative to its peak.
    fn spike(&self, t_s: f64) -> f64 {
        let since_peak_s = t_s - self.truth.contact_s;
        if since_peak_s < 0.0 { step(since_peak_s / RISE_S + 1.0) } else { libm::exp(-since_peak_s / DECAY_S) }
    }
}

impl Scene for SlidingScene {
    fn volts(&mut self, input: u8, t_s: f64) -> f64 {
        let noise_v = if self.noise_v > 0.0 { self.noise_v * self.random.gaussian() } else { 0.0 };
        self.clean_volts(input, t_s) + noise_v
    }

    fn end_s(&self) -> f64 {
        self.truth.end_s
    }
}

/// From 0 to 1 along half a cosine while `x` goes from 0 to 1.
fn step(x: f64) -> f64 {
    0.5 - 0.5 * libm::cos(core::f64::consts::PI * x.clamp(0.0, 1.0))
}

fn check(p: &Sliding) -> Result<(), ParameterError> {
    let positive = [("speed_mm_s", p.speed_mm_s), ("period_mm", p.period_mm), ("slide_mm", p.slide_mm)];
    if let Some(&(name, value)) = positive.iter().find(|(_, value)| !(value.is_finite() && *value > 0.0)) {
        return Err(ParameterError { name, value, wanted: "greater than 0" });
    }
    let [second, third, fourth] = p.overtones;
    let not_negative = [
        ("idle_s", p.idle_s),
        ("hold_before_s", p.hold_before_s),
        ("hold_after_s", p.hold_after_s),
        ("release_idle_s", p.release_idle_s),
        ("overtones[0]", second),
        ("overtones[1]", third),
        ("overtones[2]", fourth),
    ];
    if let Some(&(name, value)) = not_negative.iter().find(|(_, value)| !(value.is_finite() && *value >= 0.0)) {
        return Err(ParameterError { name, value, wanted: "not negative" });
    }
    match p.snr_db {
        Some(value) if !value.is_finite() => Err(ParameterError { name: "snr_db", value, wanted: "a number" }),
        _ => Ok(()),
    }
}
