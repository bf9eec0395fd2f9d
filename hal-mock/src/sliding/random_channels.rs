//! Channels drawn at random around plausible values, with overtones of chosen amplitude: for tests
//! that need to know the tone exactly. The paper does not quantify the channels.
//!
//! AIN 4 u + k is piezoresistor k + 1 of unit u + 1. Piezoresistors 1 and 3 lie along the sliding
//! direction and respond most strongly, with opposite signs. Units 2 and 4 are one pitch further
//! along it.

use super::channel::{Channel, Harmonic, PITCH_MM, Pattern};
use crate::random::{Random, Stream};
use crate::scene::INPUTS;
use core::f64::consts::{PI, TAU};

/// Overtones of a random channel: harmonics 2 to 4.
pub(crate) const OVERTONES: usize = 3;

/// A quarter bridge of equal resistances at 5 V.
const BRIDGE_V: f64 = 2.5;

pub(crate) fn channels(
    period_mm: f64,
    overtones: [f64; OVERTONES],
    seed: u64,
) -> [Channel; INPUTS] {
    // Tone and load per piezoresistor in millivolts, relative height of its spike, and relative
    // sensitivity of each unit.
    const TONE_MV: [f64; 4] = [6.0, 2.4, -5.2, 1.9];
    const LOAD_MV: [f64; 4] = [14.0, 8.0, -11.0, -6.0];
    const SPIKE: [f64; 4] = [0.90, 0.35, 0.70, 0.20];
    const UNIT: [f64; 4] = [1.00, 0.80, 1.15, 0.90];

    let mut random = Random::new(seed, Stream::Skin);
    let [second, third, fourth] = overtones;
    std::array::from_fn(|input| {
        let (unit, piezo) = (input / 4, input % 4);
        let mut about = |value: f64, spread: f64| value * (1.0 + spread * random.symmetric());
        let load_v = about(1e-3 * LOAD_MV[piezo] * UNIT[unit], 0.15);
        let spike_v = load_v * about(SPIKE[piezo] * UNIT[3 - unit], 0.05);
        let amplitude_v = about(1e-3 * TONE_MV[piezo] * UNIT[unit], 0.15);
        let offset_v = BRIDGE_V + 0.03 * random.symmetric();
        let place_mm = if unit % 2 == 1 { PITCH_MM } else { 0.0 };
        // Every piezoresistor is slightly off its unit's centre, hence the fixed phase per
        // piezoresistor.
        let phase_rad =
            -TAU * place_mm / period_mm + 0.35 * piezo as f64 + 0.3 * random.symmetric();
        let mut own = || PI * random.symmetric();
        let harmonics = [(1.0, 0.0), (second, own()), (third, own()), (fourth, own())];
        let tone = harmonics
            .into_iter()
            .zip(1..)
            .map(|((relative, extra_rad), h)| {
                Harmonic::of_sine(amplitude_v * relative, f64::from(h) * phase_rad + extra_rad)
            });
        let sliding = Pattern {
            mean_v: load_v,
            tone: tone.collect(),
        };
        Channel {
            offset_v,
            sliding,
            drag: Pattern::default(),
            spike_v,
        }
    })
}
