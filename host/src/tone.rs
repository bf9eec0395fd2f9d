//! A frequency, its uncertainty and its movement as programs see them, with names by their unit.

use ridgetone_proto::telemetry::{Abscissa, Estimate, Movement, OtherTone};
#[cfg(test)]
use schemars::JsonSchema;
use serde::Serialize;

/// A field that exists by time or by place alone. Where it exists and nothing is known it is null.
pub type InUnit<T> = Option<Option<T>>;

/// The tone of a window. Without a tone all but `interferer_hz` are null.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(test, derive(JsonSchema))]
pub struct Tone<T> {
    /// Common frequency in time: its mean over the window.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub frequency_hz: InUnit<T>,
    /// Standard deviation of the frequency.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sigma_hz: InUnit<T>,
    /// Common frequency by place: its mean over the window.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub frequency_per_mm: InUnit<T>,
    /// Standard deviation of the frequency by place.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sigma_per_mm: InUnit<T>,
    /// Spatial period by place, the frequency's inverse.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub period_mm: InUnit<T>,
    /// Standard deviation of the period.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub period_sigma_mm: InUnit<T>,
    /// How much the frequency differs from its mean, root mean square over the window.
    pub wander_percent: Option<f32>,
    /// Standard deviation of the wander.
    pub wander_sigma_percent: Option<f32>,
    /// Change of the frequency with time.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub chirp_hz_per_s: InUnit<f32>,
    /// Standard deviation of the chirp.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub chirp_sigma_hz_per_s: InUnit<f32>,
    /// Frequency of a second tone that is significant beside the first.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub other_tone_hz: InUnit<f32>,
    /// Change of the frequency with place.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub chirp_per_mm2: InUnit<f32>,
    /// Standard deviation of the chirp by place.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub chirp_sigma_per_mm2: InUnit<f32>,
    /// Frequency by place of a second tone that is significant beside the first.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub other_tone_per_mm: InUnit<f32>,
    /// Power of the second tone over that of the first.
    pub other_tone_fraction: Option<f32>,
    /// Frequency of the interferer as fitted; null if none is set, or if the window is too short
    /// to fit it.
    pub interferer_hz: Option<f32>,
}

/// A value with its standard deviation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WithSigma<T> {
    pub value: T,
    pub sigma: T,
}

/// Telemetry has single precision, a table's fit double.
pub trait Precision: Copy + Default + Into<f64> {
    fn rounded(value: f64) -> Self;
}

impl Precision for f32 {
    fn rounded(value: f64) -> Self {
        value as f32
    }
}

impl Precision for f64 {
    fn rounded(value: f64) -> Self {
        value
    }
}

impl<T: Precision> WithSigma<T> {
    /// The period of a frequency.
    pub fn inverse(self) -> Self {
        let (value, sigma): (f64, f64) = (self.value.into(), self.sigma.into());
        Self {
            value: T::rounded(1.0 / value),
            sigma: T::rounded(sigma / value / value),
        }
    }
}

impl<T: Precision> Tone<T> {
    /// Frequency and movement are none without a tone, and in the abscissa's unit.
    pub fn new(
        abscissa: Abscissa,
        frequency: Option<WithSigma<T>>,
        movement: Option<Movement>,
        other_tone: Option<OtherTone>,
        interferer_hz: Option<f32>,
    ) -> Self {
        let (value, sigma) = (frequency.map(|f| f.value), frequency.map(|f| f.sigma));
        let period = frequency.map(WithSigma::inverse);
        let (chirp, chirp_sigma) = (movement.map(|m| m.chirp), movement.map(|m| m.chirp_sigma));
        let other = other_tone.map(|other| other.frequency);
        let both = Self {
            wander_percent: movement.map(|m| 100.0 * m.wander),
            wander_sigma_percent: movement.map(|m| 100.0 * m.wander_sigma),
            other_tone_fraction: other_tone.map(|other| other.share),
            interferer_hz,
            ..Self::default()
        };
        match abscissa {
            Abscissa::Time => Self {
                frequency_hz: Some(value),
                sigma_hz: Some(sigma),
                chirp_hz_per_s: Some(chirp),
                chirp_sigma_hz_per_s: Some(chirp_sigma),
                other_tone_hz: Some(other),
                ..both
            },
            Abscissa::Place => Self {
                frequency_per_mm: Some(value),
                sigma_per_mm: Some(sigma),
                period_mm: Some(period.map(|p| p.value)),
                period_sigma_mm: Some(period.map(|p| p.sigma)),
                chirp_per_mm2: Some(chirp),
                chirp_sigma_per_mm2: Some(chirp_sigma),
                other_tone_per_mm: Some(other),
                ..both
            },
        }
    }

    /// The frequency in the abscissa's unit; none without a tone.
    pub fn frequency(&self) -> Option<WithSigma<T>> {
        known(
            self.frequency_hz.or(self.frequency_per_mm),
            self.sigma_hz.or(self.sigma_per_mm),
        )
    }

    /// The chirp in the abscissa's unit; none without a tone.
    pub fn chirp(&self) -> Option<WithSigma<f32>> {
        known(
            self.chirp_hz_per_s.or(self.chirp_per_mm2),
            self.chirp_sigma_hz_per_s.or(self.chirp_sigma_per_mm2),
        )
    }

    /// The second tone in the abscissa's unit.
    pub fn other_tone(&self) -> Option<OtherTone> {
        let frequency = self.other_tone_hz.or(self.other_tone_per_mm).flatten()?;
        let share = self.other_tone_fraction?;
        Some(OtherTone { frequency, share })
    }
}

fn known<T>(value: InUnit<T>, sigma: InUnit<T>) -> Option<WithSigma<T>> {
    let (value, sigma) = (value.flatten()?, sigma.flatten()?);
    Some(WithSigma { value, sigma })
}

impl From<&Estimate> for Tone<f32> {
    fn from(event: &Estimate) -> Self {
        let has_tone = event.status.has_tone();
        let frequency = WithSigma {
            value: event.frequency,
            sigma: event.sigma,
        };
        Self::new(
            event.abscissa,
            has_tone.then_some(frequency),
            has_tone.then_some(event.movement),
            event.other_tone,
            event.interferer_hz,
        )
    }
}
