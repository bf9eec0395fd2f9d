//! Limits of an actuator.

use super::error::{Error, between, within};
use serde::{Deserialize, Serialize};

#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Actuator {
    /// Maximum voltage, volts, 0.01 to 1000; the minimum is 0, and the bias is in the middle.
    pub voltage_v: f32,
    /// Cut-off frequency (-3 dB), hertz, 1 to 20,000. Vibrations above it fade, and are gone at
    /// twice the cut-off.
    pub cutoff_hz: f32,
    /// Maximum change of the voltage, volts per second, 1 to 1e9.
    pub slew_v_s: f32,
    /// Time over which a vibration fades in and out, seconds, 0.001 to 10.
    pub fade_s: f32,
}

impl Actuator {
    /// The piezo stack of Okamoto et al., section III-A: 150 V and 310 Hz. The paper states no
    /// slew; ours allows one and a half times the full amplitude of 75 V at 310 Hz. It fades in and
    /// out in 20 ms.
    pub const PIEZO: Self = Self {
        voltage_v: 150.0,
        cutoff_hz: 310.0,
        slew_v_s: 220_000.0,
        fade_s: 0.02,
    };

    pub(crate) fn check(&self) -> Result<(), Error> {
        within("voltage_v", self.voltage_v, 0.01, 1e3)?;
        within("cutoff_hz", self.cutoff_hz, 1.0, 2e4)?;
        within("slew_v_s", self.slew_v_s, 1.0, 1e9)?;
        within("fade_s", self.fade_s, 1e-3, 10.0)
    }

    /// Voltage without a vibration: half of the maximum (equation 1).
    pub fn bias_v(&self) -> f32 {
        0.5 * self.voltage_v
    }

    /// Allowed fraction of the amplitude at a frequency, 0 to 1: zero from twice the cut-off.
    pub fn fraction(&self, frequency_hz: f32) -> f32 {
        between(2.0 - libm::fabsf(frequency_hz) / self.cutoff_hz, 0.0, 1.0)
    }
}
