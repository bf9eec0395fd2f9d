//! What an actuator can do.

use crate::bounds::between;
use crate::error::{Error, within};

/// Limits of an actuator and of what drives it.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Actuator {
    /// Greatest voltage, volts, 0.01 to 1000; the least one is 0, and the bias is in the middle.
    pub voltage_v: f32,
    /// Frequency at which it moves 3 dB less than at rest, hertz, 1 to 20,000. Vibrations above it
    /// fade, and are gone at twice of it.
    pub cutoff_hz: f32,
    /// Its resonance, hertz, and by how much more it moves there, 1 to 100; 0 and 1: none that
    /// counts.
    pub resonance: (f32, f32),
    /// Greatest change of the voltage, volts per second, 1 to 1e9.
    pub slew_v_s: f32,
    /// Time in which a vibration comes and goes, seconds, 0.001 to 10.
    pub fade_s: f32,
}

impl Actuator {
    /// The piezo stack of Okamoto et al., section III-A: 150 V and 310 Hz. The paper gives no slew;
    /// this one is a full amplitude of 75 V at 310 Hz and a half. 20 ms to come and go.
    pub const PIEZO: Self = Self {
        voltage_v: 150.0,
        cutoff_hz: 310.0,
        resonance: (0.0, 1.0),
        slew_v_s: 220_000.0,
        fade_s: 0.02,
    };

    /// Whether all of it is possible, with samples at a rate.
    pub(crate) fn check(&self) -> Result<(), Error> {
        within("voltage_v", self.voltage_v, 0.01, 1e3)?;
        within("cutoff_hz", self.cutoff_hz, 1.0, 2e4)?;
        within("resonance.0", self.resonance.0, 0.0, 2e4)?;
        within("resonance.1", self.resonance.1, 1.0, 100.0)?;
        within("slew_v_s", self.slew_v_s, 1.0, 1e9)?;
        within("fade_s", self.fade_s, 1e-3, 10.0)
    }

    /// Voltage at rest: half of the greatest (equation 1).
    pub fn bias_v(&self) -> f32 {
        0.5 * self.voltage_v
    }

    /// Share of the amplitude that is allowed at a frequency, 0 to 1: less where the actuator
    /// resonates, none beyond its reach.
    pub fn share(&self, frequency_hz: f32) -> f32 {
        let over = libm::fabsf(frequency_hz) / self.cutoff_hz;
        between(2.0 - over, 0.0, 1.0) * self.resonance_share(frequency_hz)
    }

    /// One over how much more it moves at a frequency, because of its resonance: a second order
    /// with the quality that the peak gives.
    fn resonance_share(&self, frequency_hz: f32) -> f32 {
        let (at_hz, peak) = self.resonance;
        if !(at_hz > 0.0 && peak > 1.0) {
            return 1.0;
        }
        let ratio = frequency_hz / at_hz;
        let (apart, damping) = (1.0 - ratio * ratio, ratio / peak);
        let square = apart * apart + damping * damping;
        if square < 1.0 { root(square) } else { 1.0 }
    }
}

/// Square root of a value from 0 to 1, within 5e-6 of it: two steps of Newton's method for its
/// inverse, from the usual first guess (Lomont, *Fast Inverse Square Root*, 2003). `libm::sqrtf`
/// goes bit by bit where the compiler may not use the processor's own.
fn root(value: f32) -> f32 {
    let mut inverse = f32::from_bits(0x5f37_59df_u32.wrapping_sub(value.to_bits() >> 1));
    for _ in 0..2 {
        inverse *= 1.5 - 0.5 * value * inverse * inverse;
    }
    value * inverse
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_root_is_that_of_f64() {
        assert_eq!(root(0.0), 0.0);
        for n in 1..=100_000 {
            let value = (n as f32 / 1e5) * (n as f32 / 1e5);
            assert!(
                (f64::from(root(value)) / libm::sqrt(f64::from(value)) - 1.0).abs() < 5e-6,
                "{value}"
            );
        }
    }
}
