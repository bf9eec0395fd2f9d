//! Simulates the STM32's own 12-bit ADC behind the amplifiers of the wiring page. The caller
//! decides when to sample.
//!
//! Not modelled: offset and gain errors (up to 3 steps each), nonlinearity (integral 1.5 to 3
//! steps, differential 1 to 2; DS8626, table ADC accuracy), which gives a strong tone overtones,
//! and the charge that one input leaves in the sampling capacitor for the next.

use crate::random::{Random, Stream};
use crate::scene::Scene;

/// Number of codes of the ADC.
const STEPS: f64 = 4096.0;
/// Noise of a sample in steps, including rounding. The datasheets' typical signal-to-noise ratio,
/// 65 to 68 dB (ADC dynamic accuracy, from memory), corresponds to 0.8 to 0.6; a board's supply,
/// which is the reference, adds some noise.
const NOISE_STEPS: f64 = 1.0;
/// Idle voltage of a bridge, volts: half of 5 V.
const IDLE_V: f64 = 2.5;

/// Amplifier between a bridge and a pin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Amplifier {
    /// A wire. The bridge runs from the board's 3.3 V, so its voltage is scaled down from 5 V in
    /// proportion.
    Bare,
    /// An amplifier of this gain, referred to half of the bridge's supply; its output idles at half
    /// of the board's supply.
    Gain(f64),
}

/// The STM32's ADC in front of a scene.
pub struct Stm32Adc {
    scene: Box<dyn Scene>,
    amplifier: Amplifier,
    noise: Random,
}

impl Stm32Adc {
    /// Reference, volts: the board's supply.
    pub const VREF_V: f64 = 3.3;

    /// Creates an ADC that samples `scene` through `amplifier`, with noise seeded by `seed`.
    pub fn new(scene: Box<dyn Scene>, amplifier: Amplifier, seed: u64) -> Self {
        Self {
            scene,
            amplifier,
            noise: Random::new(seed, Stream::ChipNoise),
        }
    }

    /// Samples an input at `t_s` seconds of scene time, which never decreases: 0 to 4095.
    pub fn sample(&mut self, input: u8, t_s: f64) -> u16 {
        let bridge_v = self.scene.volts(input, t_s);
        let pin_v = match self.amplifier {
            Amplifier::Bare => bridge_v * Self::VREF_V / (2.0 * IDLE_V),
            Amplifier::Gain(gain) => 0.5 * Self::VREF_V + gain * (bridge_v - IDLE_V),
        };
        let steps = pin_v / Self::VREF_V * STEPS + NOISE_STEPS * self.noise.gaussian();
        // NaN, a missing reading, becomes zero.
        steps.floor().clamp(0.0, STEPS - 1.0) as u16
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Constant;

    fn mean(volts: f64, amplifier: Amplifier) -> f64 {
        let scene = Constant {
            volts: [volts; 16],
            ..Constant::default()
        };
        let mut adc = Stm32Adc::new(Box::new(scene), amplifier, 1);
        let sum: u32 = (0..10_000)
            .map(|at| u32::from(adc.sample(0, f64::from(at))))
            .sum();
        f64::from(sum) / 10_000.0
    }

    #[test]
    fn samples_are_steps_of_the_supply() {
        // Samples are rounded down: half a step.
        assert!((mean(2.5, Amplifier::Bare) - 2047.5).abs() < 0.05);
        assert!((mean(2.5, Amplifier::Gain(20.0)) - 2047.5).abs() < 0.05);
        // 10 mV at the bridge: 6.6 mV if it runs from 3.3 V, and 200 mV with a gain of 20.
        assert!((mean(2.51, Amplifier::Bare) - 2047.5 - 8.192).abs() < 0.05);
        assert!((mean(2.51, Amplifier::Gain(20.0)) - 2047.5 - 248.24).abs() < 0.05);
        assert_eq!(mean(0.0, Amplifier::Gain(20.0)), 0.0);
        assert_eq!(mean(5.0, Amplifier::Gain(20.0)), 4095.0);
    }
}
