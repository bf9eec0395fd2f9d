//! Computes the voltage, sample by sample.

use super::actuator::Actuator;
use super::error::{Error, between};
use super::hand::{Encoder, Hand};
use super::law::AmplitudeLaw;
use super::texture::{HARMONICS_MAX, Texture};
use core::f32::consts::FRAC_PI_2;

/// One cycle in units of a 32-bit phase, which is exact at any position and wraps by itself.
pub(crate) const TURN: f32 = 4_294_967_296.0;

/// A texture that is checked and converted to phase steps for an encoder: made by
/// [`Stimulus::prepare`], used by [`Stimulus::take`].
#[derive(Clone, Copy, Debug)]
pub struct Prepared {
    step: u32,
    step_cycles: f32,
    wanted_v: f32,
    /// Amplitude at which the peak reaches the actuator's maximum, volts.
    max_v: f32,
    overtones: [(f32, u32); HARMONICS_MAX - 1],
}

/// A texture under a hand: y = A(period) sin(2 pi x / period) + B, with the position x of the hand
/// (Okamoto et al., equations 1 to 5, with position instead of speed times time: a hand that stops
/// or turns stays on the same surface).
#[derive(Clone, Copy, Debug)]
pub struct Stimulus {
    actuator: Actuator,
    encoder: Encoder,
    law: AmplitudeLaw,
    hand: Hand,
    /// Phase at count 0, and phase per count, in units of 2^-32 cycles.
    offset: u32,
    step: u32,
    step_cycles: f32,
    /// Amplitude of the texture, and amplitude reached so far, volts.
    wanted_v: f32,
    amplitude_v: f32,
    overtones: [(f32, u32); HARMONICS_MAX - 1],
    /// Latest position of the hand, and lead of the output, counts.
    counts: i32,
    ahead: f32,
    is_down: bool,
    output_v: f32,
}

/// Uses the paper's actuator, encoder and law.
impl Default for Stimulus {
    fn default() -> Self {
        Self::of(Actuator::PIEZO, Encoder::OKAMOTO, AmplitudeLaw::OKAMOTO)
    }
}

impl Stimulus {
    /// Creates a stimulus without a texture: the output is at its bias.
    pub fn new(actuator: Actuator, encoder: Encoder, law: AmplitudeLaw) -> Result<Self, Error> {
        actuator.check()?;
        encoder.check()?;
        law.check()?;
        Ok(Self::of(actuator, encoder, law))
    }

    fn of(actuator: Actuator, encoder: Encoder, law: AmplitudeLaw) -> Self {
        Self {
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
            counts: 0,
            ahead: 0.0,
            is_down: false,
            output_v: actuator.bias_v(),
        }
    }

    /// Sets the texture. The phase is continuous, and the amplitude changes within
    /// [`Actuator::fade_s`].
    pub fn set_texture(&mut self, texture: &Texture) -> Result<(), Error> {
        let prepared = self.prepare(texture)?;
        self.take(&prepared);
        Ok(())
    }

    /// Checks a texture and does the slow computations, so that [`Self::take`], which may block an
    /// interrupt on a board, is short.
    pub fn prepare(&self, texture: &Texture) -> Result<Prepared, Error> {
        texture.check()?;
        let cycles = f64::from(self.encoder.count_mm) / f64::from(texture.period_mm);
        let overtone = |n: usize| {
            let harmonic = texture.overtones[n];
            (
                harmonic.amplitude,
                (f64::from(harmonic.phase_cycles) * f64::from(TURN)) as i64 as u32,
            )
        };
        let overtones = core::array::from_fn(overtone);
        let peak = 1.0
            + overtones
                .iter()
                .map(|(amplitude, _)| amplitude)
                .sum::<f32>();
        let fraction = self.law.fraction(texture.period_mm, texture.power);
        Ok(Prepared {
            // A count longer than half a cycle would alias, but the phase would still be right.
            step: (cycles * f64::from(TURN)) as u64 as u32,
            step_cycles: cycles as f32,
            // With overtones, the peak is limited to the actuator's amplitude.
            wanted_v: self.actuator.bias_v() * fraction / peak,
            max_v: self.actuator.bias_v() / peak,
            overtones,
        })
    }

    /// Sets a texture made by [`Self::prepare`], like [`Self::set_texture`], in about ten
    /// instructions.
    pub fn take(&mut self, prepared: &Prepared) {
        let Prepared {
            step,
            step_cycles,
            wanted_v,
            max_v,
            overtones,
        } = *prepared;
        // The phase is continuous at the output, which is ahead of the count, and where the period
        // changes. A first texture starts at the count.
        let ahead = if self.step_cycles > 0.0 {
            self.ahead
        } else {
            0.0
        };
        let phase = self
            .phase_at(self.counts)
            .wrapping_add(turns(ahead * self.step_cycles));
        let behind = step
            .wrapping_mul(self.counts as u32)
            .wrapping_add(turns(ahead * step_cycles));
        self.offset = phase.wrapping_sub(behind);
        (self.step, self.step_cycles) = (step, step_cycles);
        (self.wanted_v, self.overtones) = (wanted_v, overtones);
        // Overtones start at once, so the amplitude may have to make room for them. The slew
        // softens the change.
        self.amplitude_v = between(self.amplitude_v, 0.0, max_v);
    }

    /// Lifts the hand, or handles a silent line: the vibration fades within [`Actuator::fade_s`],
    /// until [`Self::down`].
    pub fn lift(&mut self) {
        self.is_down = false;
    }

    /// Puts the hand on the surface.
    pub fn down(&mut self) {
        self.is_down = true;
    }

    /// Returns the next sample, volts, for the encoder's counts, which may wrap. Call it at the
    /// encoder's rate.
    ///
    /// The result is from 0 to the actuator's voltage, and within the slew of the last sample.
    pub fn next(&mut self, counts: i32) -> f32 {
        let (counts, ahead, speed) = self.hand.advance(&self.encoder, counts);
        (self.counts, self.ahead) = (counts, ahead);
        let phase = self
            .phase_at(counts)
            .wrapping_add(turns(ahead * self.step_cycles));
        let frequency_hz = speed * self.step_cycles * self.encoder.rate_hz;
        let wanted_v = if self.is_down {
            self.wanted_v * self.actuator.fraction(frequency_hz)
        } else {
            0.0
        };
        let step_v = self.actuator.bias_v() / (self.actuator.fade_s * self.encoder.rate_hz);
        self.amplitude_v += between(wanted_v - self.amplitude_v, -step_v, step_v);
        let mut sum = sine(phase);
        for (n, (amplitude, offset)) in (2..).zip(self.overtones) {
            if amplitude > 0.0 {
                // Each harmonic is limited at its own frequency.
                let fraction = self.actuator.fraction(n as f32 * frequency_hz);
                sum += amplitude * fraction * sine(phase.wrapping_mul(n).wrapping_add(offset));
            }
        }
        let bias_v = self.actuator.bias_v();
        let slew_v = self.actuator.slew_v_s / self.encoder.rate_hz;
        let moved = between(
            bias_v + self.amplitude_v * sum,
            self.output_v - slew_v,
            self.output_v + slew_v,
        );
        self.output_v = between(moved, 0.0, self.actuator.voltage_v);
        self.output_v
    }

    /// Phase of the texture at the lower edge of the latest count, cycles, 0 to 1.
    pub fn phase_cycles(&self) -> f32 {
        self.phase_at(self.counts) as f32 / TURN
    }

    /// Spatial period, millimetres; infinite before the first texture.
    pub fn period_mm(&self) -> f32 {
        self.encoder.count_mm / self.step_cycles
    }

    /// Current amplitude of the fundamental, volts.
    pub fn amplitude_v(&self) -> f32 {
        self.amplitude_v
    }

    /// Speed of the hand used for the prediction, millimetres per second, signed.
    pub fn speed_mm_s(&self) -> f32 {
        self.hand.speed() * self.encoder.count_mm * self.encoder.rate_hz
    }

    pub const fn actuator(&self) -> &Actuator {
        &self.actuator
    }

    fn phase_at(&self, counts: i32) -> u32 {
        self.offset
            .wrapping_add(self.step.wrapping_mul(counts as u32))
    }
}

/// Converts cycles to a phase. Drops the whole cycles, which may be many if the hand is fast and
/// the latency long.
fn turns(cycles: f32) -> u32 {
    let part = cycles - (cycles as i32) as f32;
    // `part` is below one in magnitude, so half a turn of it fits an i32; doubling the result loses
    // no bit of the f32.
    ((part * (0.5 * TURN)) as i32 as u32) << 1
}

/// Coefficients of sin(pi x / 2) from -1 to 1 in odd powers of x, within 6e-9 (Hastings,
/// *Approximations for Digital Computers*, sheet 16). `libm::sinf` computes in f64, which takes a
/// thousand cycles on a processor with only an f32 FPU.
const SINE: [f32; 5] = [
    FRAC_PI_2,
    -0.645_963_7,
    0.079_689_68,
    -0.004_673_766,
    0.000_151_485,
];

/// Sine of a phase, within 3e-7.
pub(crate) fn sine(phase: u32) -> f32 {
    const QUARTER: u32 = 1 << 30;
    // From a quarter to three quarters of a turn, mirror: sin(pi - x) = sin(x).
    let is_behind = phase.wrapping_add(QUARTER) >= 2 * QUARTER;
    let phase = if is_behind {
        (2 * QUARTER).wrapping_sub(phase)
    } else {
        phase
    };
    let x = phase as i32 as f32 * (1.0 / QUARTER as f32);
    let square = x * x;
    x * SINE
        .iter()
        .rev()
        .fold(0.0, |sum, coefficient| sum * square + coefficient)
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::f64::consts::TAU;

    #[test]
    fn the_sine_is_that_of_f64() {
        for n in 0..1_000_000u32 {
            let phase = n.wrapping_mul(4_294_967);
            let true_sine = libm::sin(TAU * f64::from(phase) / f64::from(TURN));
            assert!((f64::from(sine(phase)) - true_sine).abs() < 3e-7, "{phase}");
        }
        assert_eq!(
            [0, 1 << 30, 1 << 31, 3 << 30].map(|phase| libm::roundf(1e6 * sine(phase))),
            [0.0, 1e6, 0.0, -1e6]
        );
    }

    #[test]
    fn whole_cycles_drop_out() {
        for (cycles, phase) in [
            (0.25, 1 << 30),
            (1200.25, 1 << 30),
            (-0.25, 3 << 30),
            (-3.5, 1 << 31),
            (7.0, 0),
        ] {
            assert_eq!(turns(cycles), phase, "{cycles}");
        }
    }
}
