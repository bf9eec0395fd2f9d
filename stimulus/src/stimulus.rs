//! The voltage, sample by sample.

use crate::actuator::Actuator;
use crate::error::Error;
use crate::hand::{Encoder, Hand};
use crate::law::AmplitudeLaw;
use crate::texture::{HARMONICS_MAX, Texture};
use core::f32::consts::PI;

/// Turns as 32 bits: phases are exact for any place, and wrap by themselves.
const TURN: f32 = 4_294_967_296.0;

/// A texture under a hand: y = A(period) sin(2 pi x / period) + B, by the place x of the hand (Okamoto et al., equations 1 to 5, with the
/// place in place of speed times time: a hand that stops or turns stays on the same surface).
#[derive(Clone, Copy, Debug)]
pub struct Stimulus {
    actuator: Actuator,
    encoder: Encoder,
    law: AmplitudeLaw,
    hand: Hand,
    /// Phase at count 0, and of one count: 2^32 are a cycle.
    offset: u32,
    step: u32,
    step_cycles: f32,
    /// Amplitude that the texture wants, volts, and the one that has come so far.
    wanted_v: f32,
    amplitude_v: f32,
    overtones: [(f32, u32); HARMONICS_MAX - 1],
    /// Sum of all amplitudes over the fundamental's.
    peak: f32,
    /// Where the hand was last.
    counts: i32,
    is_down: bool,
    output_v: f32,
}

impl Stimulus {
    /// With no texture: the output is at its bias.
    pub fn new(actuator: Actuator, encoder: Encoder, law: AmplitudeLaw) -> Result<Self, Error> {
        actuator.check()?;
        encoder.check()?;
        law.check()?;
        Ok(Self {
            actuator,
            encoder,
            law,
            hand: Hand::default(),
            offset: 0,
            step: 0,
            step_cycles: 0.0,
            wanted_v: 0.0,
            amplitude_v: 0.0,
            overtones: [(0.0, 0); HARMONICS_MAX - 1],
            peak: 1.0,
            counts: 0,
            is_down: false,
            output_v: actuator.bias_v(),
        })
    }

    /// Takes a texture. The phase goes on where it is, and the amplitude changes within [`Actuator::fade_s`].
    pub fn set_texture(&mut self, texture: &Texture) -> Result<(), Error> {
        texture.check()?;
        let phase = self.phase_at(self.counts);
        let cycles = f64::from(self.encoder.count_mm) / f64::from(texture.period_mm);
        // A count of more than half of a cycle would be an alias; the phase is right all the same.
        self.step = (cycles * f64::from(TURN)) as u64 as u32;
        self.step_cycles = cycles as f32;
        self.offset = phase.wrapping_sub(self.step.wrapping_mul(self.counts as u32));
        let overtone = |n: usize| {
            let harmonic = texture.overtones[n];
            (harmonic.amplitude, (f64::from(harmonic.phase_cycles) * f64::from(TURN)) as i64 as u32)
        };
        self.overtones = core::array::from_fn(overtone);
        self.peak = 1.0 + self.overtones.iter().map(|(amplitude, _)| amplitude).sum::<f32>();
        // With overtones the peak is at most the actuator's.
        self.wanted_v = self.actuator.bias_v() * self.law.share(texture.period_mm, texture.power) / self.peak;
        Ok(())
    }

    /// The hand is off the surface, or the line is silent: the vibration fades within [`Actuator::fade_s`]. [`Self::down`] ends it.
    pub fn lift(&mut self) {
        self.is_down = false;
    }

    /// The hand is on the surface.
    pub fn down(&mut self) {
        self.is_down = true;
    }

    /// The next sample, volts, from the encoder's counts; it may wrap. Call it at the encoder's rate.
    ///
    /// Always from 0 to the actuator's voltage, and no farther from the last sample than its slew.
    pub fn next(&mut self, counts: i32) -> f32 {
        let (counts, ahead, speed) = self.hand.advance(&self.encoder, counts);
        self.counts = counts;
        // Places ahead may be many cycles if the hand is fast and the latency long.
        let ahead = (ahead * self.step_cycles) % 1.0;
        let phase = self.phase_at(counts).wrapping_add((ahead * TURN) as i64 as u32);
        let frequency_hz = speed * self.step_cycles * self.encoder.rate_hz;
        let wanted_v = if self.is_down { self.wanted_v * self.actuator.share(frequency_hz) } else { 0.0 };
        let step_v = self.actuator.bias_v() / (self.actuator.fade_s * self.encoder.rate_hz);
        self.amplitude_v += (wanted_v - self.amplitude_v).clamp(-step_v, step_v);
        let mut sum = sine(phase);
        for (n, (amplitude, offset)) in (2..).zip(self.overtones) {
            if amplitude > 0.0 {
                // Each harmonic has the reach of its own frequency.
                let share = self.actuator.share(n as f32 * frequency_hz);
                sum += amplitude * share * sine(phase.wrapping_mul(n).wrapping_add(offset));
            }
        }
        let bias_v = self.actuator.bias_v();
        let slew_v = self.actuator.slew_v_s / self.encoder.rate_hz;
        let moved = (bias_v + self.amplitude_v * sum).clamp(self.output_v - slew_v, self.output_v + slew_v);
        self.output_v = moved.clamp(0.0, self.actuator.voltage_v);
        self.output_v
    }

    /// Phase of the texture under the middle of the latest count, cycles, 0 to 1.
    pub fn phase_cycles(&self) -> f32 {
        self.phase_at(self.counts) as f32 / TURN
    }

    /// Amplitude of the fundamental now, volts.
    pub fn amplitude_v(&self) -> f32 {
        self.amplitude_v
    }

    fn phase_at(&self, counts: i32) -> u32 {
        self.offset.wrapping_add(self.step.wrapping_mul(counts as u32))
    }
}

/// Sine of a phase.
fn sine(phase: u32) -> f32 {
    libm::sinf(phase as i32 as f32 * (PI / (0.5 * TURN)))
}
