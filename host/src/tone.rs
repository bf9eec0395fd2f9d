//! A frequency, its uncertainty and its movement in JSON, with names by their unit.

use ridgetone_proto::telemetry::{Abscissa, Estimate, Movement, OtherTone};
use serde::Serialize;

/// Fields of a tone in JSON: in hertz, or by place in cycles per millimetre; null without a tone.
#[derive(Debug, Serialize)]
#[serde(untagged)]
pub enum JsonTone<T> {
    Time {
        frequency_hz: Option<T>,
        sigma_hz: Option<T>,
    },
    Place {
        frequency_per_mm: Option<T>,
        sigma_per_mm: Option<T>,
        period_mm: Option<T>,
        period_sigma_mm: Option<T>,
    },
}

impl<T: Copy> JsonTone<T> {
    /// Fields of a frequency and its standard deviation; `period` turns both into those of the
    /// period.
    pub fn new(abscissa: Abscissa, tone: Option<(T, T)>, period: fn((T, T)) -> (T, T)) -> Self {
        let (frequency, sigma) = (
            tone.map(|(frequency, _)| frequency),
            tone.map(|(_, sigma)| sigma),
        );
        match abscissa {
            Abscissa::Time => Self::Time {
                frequency_hz: frequency,
                sigma_hz: sigma,
            },
            Abscissa::Place => Self::Place {
                frequency_per_mm: frequency,
                sigma_per_mm: sigma,
                period_mm: tone.map(|tone| period(tone).0),
                period_sigma_mm: tone.map(|tone| period(tone).1),
            },
        }
    }
}

/// What an estimate has besides its tone.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Beside {
    /// None without a tone.
    pub movement: Option<Movement>,
    pub other_tone: Option<OtherTone>,
    pub interferer_hz: Option<f32>,
}

impl From<&Estimate> for Beside {
    fn from(e: &Estimate) -> Self {
        let movement = e.status.has_tone().then_some(e.movement);
        Self {
            movement,
            other_tone: e.other_tone,
            interferer_hz: e.interferer_hz,
        }
    }
}

/// Fields of [`Beside`] in JSON; null where they are not known.
#[derive(Debug, Serialize)]
pub struct JsonBeside {
    wander_percent: Option<f32>,
    wander_sigma_percent: Option<f32>,
    #[serde(flatten)]
    in_unit: JsonInUnit,
    other_tone_share: Option<f32>,
    interferer_hz: Option<f32>,
}

#[derive(Debug, Serialize)]
#[serde(untagged)]
enum JsonInUnit {
    Time {
        sigma_mean_hz: Option<f32>,
        chirp_hz_per_s: Option<f32>,
        chirp_sigma_hz_per_s: Option<f32>,
        other_tone_hz: Option<f32>,
    },
    Place {
        sigma_mean_per_mm: Option<f32>,
        chirp_per_mm2: Option<f32>,
        chirp_sigma_per_mm2: Option<f32>,
        other_tone_per_mm: Option<f32>,
    },
}

impl JsonBeside {
    pub fn new(abscissa: Abscissa, beside: &Beside) -> Self {
        let part = |part: fn(&Movement) -> f32| beside.movement.as_ref().map(part);
        let [sigma_mean, chirp, chirp_sigma] = [
            part(|m| m.sigma_mean),
            part(|m| m.chirp),
            part(|m| m.chirp_sigma),
        ];
        let other_tone = beside.other_tone.map(|other| other.frequency);
        Self {
            wander_percent: part(|m| 100.0 * m.wander),
            wander_sigma_percent: part(|m| 100.0 * m.wander_sigma),
            in_unit: match abscissa {
                Abscissa::Time => JsonInUnit::Time {
                    sigma_mean_hz: sigma_mean,
                    chirp_hz_per_s: chirp,
                    chirp_sigma_hz_per_s: chirp_sigma,
                    other_tone_hz: other_tone,
                },
                Abscissa::Place => JsonInUnit::Place {
                    sigma_mean_per_mm: sigma_mean,
                    chirp_per_mm2: chirp,
                    chirp_sigma_per_mm2: chirp_sigma,
                    other_tone_per_mm: other_tone,
                },
            },
            other_tone_share: beside.other_tone.map(|other| other.share),
            interferer_hz: beside.interferer_hz,
        }
    }
}

/// Period of a tone and its standard deviation.
pub fn period((frequency, sigma): (f64, f64)) -> (f64, f64) {
    (1.0 / frequency, sigma / frequency / frequency)
}

/// The same in the precision of telemetry.
pub fn period_f32((frequency, sigma): (f32, f32)) -> (f32, f32) {
    let (period, sigma) = period((frequency.into(), sigma.into()));
    (period as f32, sigma as f32)
}
