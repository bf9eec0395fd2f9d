//! What each of the sixteen channels makes of load and grating.
//!
//! AIN 4 u + k is piezoresistor k + 1 of unit u + 1. Piezoresistors 1 and 3 lie along the sliding direction: they feel
//! it most, with opposite sign. Units 2 and 4 lie one pitch of 2.3 mm (the paper's array) further along it.

use crate::random::{Random, Stream};
use crate::scene::INPUTS;
use core::f64::consts::{PI, TAU};

/// The fundamental and three overtones.
pub const HARMONICS: usize = 4;

/// Pitch of the units along the sliding direction in mm (paper, section 2.2).
const PITCH_MM: f64 = 2.3;
/// A quarter bridge of equal resistances at 5 V.
const BRIDGE_V: f64 = 2.5;

/// One channel's view of the world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Channel {
    /// Voltage without contact, in volts.
    pub offset_v: f64,
    /// Amplitude of the fundamental in volts; negative on the piezoresistors of opposite sign.
    pub amplitude_v: f64,
    /// Phase of the fundamental at position 0, in radians.
    pub phase_rad: f64,
    /// Change by the static load in volts, either sign.
    pub load_v: f64,
    /// Height of the contact spike over the load's step in volts, same sign as the step.
    pub spike_v: f64,
    /// Amplitudes of the harmonics relative to the fundamental, which is the first.
    pub relative: [f64; HARMONICS],
    /// Phases of the harmonics against the fundamental, in radians; the first is 0.
    pub extra_phase_rad: [f64; HARMONICS],
    /// Spatial period in mm.
    pub period_mm: f64,
}

impl Channel {
    /// The tone in volts at a position of the grating.
    pub fn tone_v(&self, position_mm: f64) -> f64 {
        // Whole periods taken off first: sines of small arguments, whatever the distance.
        let periods = position_mm / self.period_mm;
        let phase = TAU * (periods - libm::floor(periods)) + self.phase_rad;
        let sum: f64 = (0..HARMONICS)
            .map(|h| self.relative[h] * libm::sin((h + 1) as f64 * phase + self.extra_phase_rad[h]))
            .sum();
        self.amplitude_v * sum
    }
}

/// Draws all channels.
pub(crate) fn skin(period_mm: f64, overtones: [f64; HARMONICS - 1], seed: u64) -> [Channel; INPUTS] {
    // Millivolts of tone and load per piezoresistor, relative heights of its spike, and how strongly a unit feels it.
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
        // Every piezoresistor sits a little beside its unit's centre, hence the fixed part per piezoresistor.
        let phase_rad = -TAU * place_mm / period_mm + 0.35 * piezo as f64 + 0.3 * random.symmetric();
        let mut own = || PI * random.symmetric();
        Channel {
            offset_v,
            amplitude_v,
            phase_rad,
            load_v,
            spike_v,
            relative: [1.0, second, third, fourth],
            extra_phase_rad: [0.0, own(), own(), own()],
            period_mm,
        }
    })
}
