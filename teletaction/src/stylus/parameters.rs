//! Parameters of a stylus. A reset discards them: after a start the stylus is silent until a PC
//! sends a texture and enables it.

use super::SAMPLE_HZ;
use crate::stimulus::{Actuator, AmplitudeLaw, Encoder, Error, Stimulus, within};
use heapless::String;
use ridgetone_proto::settings::SettingsError;
use serde::{Deserialize, Serialize};

/// Samples from reading the encoder to the middle of the held output: one until the next trigger,
/// and half of the holding time.
const CONVERTER_SAMPLES: f32 = 1.5;

#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Parameters {
    /// Limits of the actuator. Its voltage is the amplifier's output at the converter's maximum
    /// code.
    pub actuator: Actuator,
    /// One count of the encoder, all four edges counted, millimetres, 0.0001 to 1.
    pub count_mm: f32,
    /// Latency after the converter, such as a filter's, seconds, 0 to 0.0198. The converter's own
    /// 1.5 samples are added.
    pub latency_s: f32,
    /// Amplitude of a texture without a power.
    pub law: AmplitudeLaw,
    /// Time without a movement of two counts after which the vibration stops until the hand moves;
    /// seconds, 0.01 to 60.
    pub still_s: f32,
    /// Time without a complete request after which the vibration stops until it is enabled again;
    /// seconds, 0.01 to 60.
    pub silence_s: f32,
}

impl Parameters {
    /// The paper's actuator, encoder and law (Okamoto et al., section III-A, equation 2), and half
    /// a second to stop: people who explore do not keep a finger still for longer, and a link that
    /// loses every third request at 10 Hz is silent for that long once an hour.
    pub const DEFAULT: Self = Self {
        actuator: Actuator::PIEZO,
        count_mm: Encoder::OKAMOTO.count_mm,
        latency_s: 0.0,
        law: AmplitudeLaw::OKAMOTO,
        still_s: 0.5,
        silence_s: 0.5,
    };

    /// Creates a stimulus with these parameters, or names the impossible parameter.
    pub fn stimulus(&self) -> Result<Stimulus, SettingsError> {
        self.check().map_err(refusal)?;
        let encoder = Encoder {
            count_mm: self.count_mm,
            rate_hz: SAMPLE_HZ as f32,
            latency_s: self.whole_latency_s(),
        };
        Stimulus::new(self.actuator, encoder, self.law).map_err(refusal)
    }

    /// Latency including the converter's, seconds.
    pub fn whole_latency_s(&self) -> f32 {
        CONVERTER_SAMPLES / SAMPLE_HZ as f32 + self.latency_s
    }

    fn check(&self) -> Result<(), Error> {
        within("still_s", self.still_s, 0.01, 60.0)?;
        within("silence_s", self.silence_s, 0.01, 60.0)?;
        // Check without the converter's latency, so that the bounds are the field's.
        within("latency_s", self.latency_s, 0.0, 0.0198)
    }
}

/// Converts an error to the form that is transmitted.
pub(crate) fn refusal(error: Error) -> SettingsError {
    let Error {
        name,
        value,
        min,
        max,
    } = error;
    SettingsError {
        field: String::try_from(name).unwrap_or_default(),
        value,
        min,
        max,
    }
}

pub(crate) fn samples(s: f32) -> u32 {
    (s * SAMPLE_HZ as f32) as u32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_defaults_are_possible_and_impossible_parameters_are_named() {
        assert!(Parameters::DEFAULT.stimulus().is_ok());
        type Change = fn(&mut Parameters);
        let cases: [(Change, &str); 7] = [
            (|p| p.still_s = f32::NAN, "still_s"),
            (|p| p.silence_s = 0.0, "silence_s"),
            (|p| p.latency_s = 0.0199, "latency_s"),
            (|p| p.count_mm = -0.005, "count_mm"),
            (|p| p.actuator.voltage_v = f32::NAN, "voltage_v"),
            (|p| p.actuator.slew_v_s = f32::INFINITY, "slew_v_s"),
            (|p| p.law.power_max = f32::NAN, "power_max"),
        ];
        for (change, name) in cases {
            let mut parameters = Parameters::DEFAULT;
            change(&mut parameters);
            assert_eq!(parameters.stimulus().expect_err(name).field, name);
        }
        let mut slowest = Parameters::DEFAULT;
        slowest.latency_s = 0.0198;
        assert!(slowest.stimulus().is_ok());
    }
}
