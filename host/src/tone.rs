//! A frequency and its uncertainty in JSON, with names by their unit.

use ridgetone_proto::telemetry::Abscissa;
use serde::Serialize;

/// Fields of a tone in JSON: in hertz, or by place in cycles per millimetre; null without a tone.
#[derive(Debug, Serialize)]
#[serde(untagged)]
pub enum JsonTone<T> {
    Time { frequency_hz: Option<T>, sigma_hz: Option<T> },
    Place { frequency_per_mm: Option<T>, sigma_per_mm: Option<T>, period_mm: Option<T>, period_sigma_mm: Option<T> },
}

impl<T: Copy> JsonTone<T> {
    /// Fields of a frequency and its standard deviation; `period` turns both into those of the period.
    pub fn new(abscissa: Abscissa, tone: Option<(T, T)>, period: fn((T, T)) -> (T, T)) -> Self {
        let (frequency, sigma) = (tone.map(|(frequency, _)| frequency), tone.map(|(_, sigma)| sigma));
        match abscissa {
            Abscissa::Time => Self::Time { frequency_hz: frequency, sigma_hz: sigma },
            Abscissa::Place => Self::Place {
                frequency_per_mm: frequency,
                sigma_per_mm: sigma,
                period_mm: tone.map(|tone| period(tone).0),
                period_sigma_mm: tone.map(|tone| period(tone).1),
            },
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
