//! Frequency of a tone with its uncertainty and modulation, as in JSON: the unit is part of each
//! name.

use ridgetone_proto::telemetry::{Estimate, Movement, OtherTone};
#[cfg(test)]
use schemars::JsonSchema;
use serde::Serialize;

/// Domain in which a fit counts cycles.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(test, derive(JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum Domain {
    /// Cycles per second.
    Time,
    /// Cycles per millimetre, by positions that are known.
    Position,
}

impl Domain {
    /// Returns the unit of a frequency.
    pub const fn unit(self) -> &'static str {
        match self {
            Self::Time => "Hz",
            Self::Position => "/mm",
        }
    }
}

/// Field of the time domain or of the spatial domain only: `None` in the other domain, and
/// `Some(None)`, which is written as null, if the value is not known.
pub type InUnit<T> = Option<Option<T>>;

/// The tone of a window. Without a tone all but `interferer_hz` are null.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(test, derive(JsonSchema))]
pub struct Tone {
    /// Common frequency in time: its mean over the window.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub frequency_hz: InUnit<f64>,
    /// Standard deviation of the frequency.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sigma_hz: InUnit<f64>,
    /// Common spatial frequency: its mean over the window.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub frequency_per_mm: InUnit<f64>,
    /// Standard deviation of the spatial frequency.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sigma_per_mm: InUnit<f64>,
    /// Spatial period, the inverse of the spatial frequency.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub period_mm: InUnit<f64>,
    /// Standard deviation of the period.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub period_sigma_mm: InUnit<f64>,
    /// RMS deviation of the frequency from its mean over the window.
    pub wander_percent: Option<f32>,
    /// Standard deviation of the wander.
    pub wander_sigma_percent: Option<f32>,
    /// Change of the frequency with time.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub chirp_hz_per_s: InUnit<f32>,
    /// Standard deviation of the chirp.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub chirp_sigma_hz_per_s: InUnit<f32>,
    /// Frequency of a second tone that is significant in the presence of the first.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub other_tone_hz: InUnit<f32>,
    /// Change of the spatial frequency with position.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub chirp_per_mm2: InUnit<f32>,
    /// Standard deviation of the chirp by position.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub chirp_sigma_per_mm2: InUnit<f32>,
    /// Spatial frequency of a second tone that is significant in the presence of the first.
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
pub struct WithSigma {
    pub value: f64,
    pub sigma: f64,
}

impl WithSigma {
    /// Returns the inverse with its standard deviation, such as the period of a frequency.
    pub fn inverse(self) -> Self {
        let Self { value, sigma } = self;
        Self {
            value: 1.0 / value,
            sigma: sigma / value / value,
        }
    }
}

impl Tone {
    /// Creates a tone. Frequency and movement are in the domain's unit, and `None` without a tone.
    pub fn new(
        domain: Domain,
        frequency: Option<WithSigma>,
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
            other_tone_fraction: other_tone.map(|other| other.fraction),
            interferer_hz,
            ..Self::default()
        };
        match domain {
            Domain::Time => Self {
                frequency_hz: Some(value),
                sigma_hz: Some(sigma),
                chirp_hz_per_s: Some(chirp),
                chirp_sigma_hz_per_s: Some(chirp_sigma),
                other_tone_hz: Some(other),
                ..both
            },
            Domain::Position => Self {
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

    /// Returns the frequency in the domain's unit; `None` without a tone.
    pub fn frequency(&self) -> Option<WithSigma> {
        Some(WithSigma {
            value: self.frequency_hz.or(self.frequency_per_mm).flatten()?,
            sigma: self.sigma_hz.or(self.sigma_per_mm).flatten()?,
        })
    }

    /// Replaces the frequency and the period.
    #[must_use]
    pub fn with_frequency(self, found: WithSigma) -> Self {
        let (value, sigma) = (Some(Some(found.value)), Some(Some(found.sigma)));
        let period = found.inverse();
        match self.frequency_hz {
            Some(_) => Self {
                frequency_hz: value,
                sigma_hz: sigma,
                ..self
            },
            None => Self {
                frequency_per_mm: value,
                sigma_per_mm: sigma,
                period_mm: Some(Some(period.value)),
                period_sigma_mm: Some(Some(period.sigma)),
                ..self
            },
        }
    }

    /// Adds a second tone.
    #[must_use]
    pub fn beside(self, other: OtherTone) -> Self {
        let frequency = Some(Some(other.frequency));
        Self {
            other_tone_hz: self.other_tone_hz.and(frequency),
            other_tone_per_mm: self.other_tone_per_mm.and(frequency),
            other_tone_fraction: Some(other.fraction),
            ..self
        }
    }

    /// Returns the chirp in the domain's unit; `None` without a tone.
    pub fn chirp(&self) -> Option<WithSigma> {
        let sigma = self.chirp_sigma_hz_per_s.or(self.chirp_sigma_per_mm2);
        Some(WithSigma {
            value: self.chirp_hz_per_s.or(self.chirp_per_mm2).flatten()?.into(),
            sigma: sigma.flatten()?.into(),
        })
    }

    /// Returns the second tone in the domain's unit.
    pub fn other_tone(&self) -> Option<OtherTone> {
        let frequency = self.other_tone_hz.or(self.other_tone_per_mm).flatten()?;
        let fraction = self.other_tone_fraction?;
        Some(OtherTone {
            frequency,
            fraction,
        })
    }
}

impl From<&Estimate> for Tone {
    fn from(event: &Estimate) -> Self {
        let has_tone = event.status.has_tone();
        let frequency = WithSigma {
            value: event.frequency.into(),
            sigma: event.sigma.into(),
        };
        Self::new(
            Domain::Time,
            has_tone.then_some(frequency),
            has_tone.then_some(event.movement),
            event.other_tone,
            event.interferer_hz,
        )
    }
}
