//! A texture as sound: for a voice coil, a headphone, or a file.

use super::actuator::Actuator;
use super::delay::Delay;
use super::error::{Error, between, within};
use super::hand::Encoder;
use super::law::AmplitudeLaw;
use super::path::Path;
use super::texture::Texture;
use super::voltage::{Stimulus, TURN, sine};

/// Size of the encoder counts in which positions are passed to the stimulus, millimetres: a
/// twentieth of the paper's encoder count.
const COUNT_MM: f32 = 2.5e-4;

/// Time without a change of position after which the hand rests and the carrier is silent, seconds.
const RESTS_S: f32 = 0.03;

/// A tone whose amplitude follows the texture.
#[derive(Clone, Copy, Debug, Default)]
struct Carrier {
    frequency_hz: f32,
    /// Latest position of the hand, and samples since its last change.
    counts: i32,
    still: u32,
    /// Level of the fade: 1 for a moving hand, 0 for a resting one.
    level: f32,
    output: f32,
}

/// A texture under a hand whose positions arrive one by one, as samples from -1 to 1: for a pointer
/// on a screen, or a hand across a network. `N` is the number of positions kept.
#[derive(Clone, Copy, Debug)]
pub struct Vibration<const N: usize> {
    stimulus: Stimulus,
    rate_hz: f32,
    bias_v: f32,
    carrier: Option<Carrier>,
    path: Path<N>,
    delay: Delay,
    wait_s: f64,
    late: u32,
    is_down: bool,
}

impl<const N: usize> Vibration<N> {
    /// Creates a silent vibration without a texture, for a sample rate in hertz.
    pub fn new(actuator: Actuator, law: AmplitudeLaw, rate_hz: f32) -> Result<Self, Error> {
        // Zero-order hold delays a signal by half a sample.
        let encoder = Encoder {
            count_mm: COUNT_MM,
            rate_hz,
            latency_s: 0.5 / rate_hz.max(1.0),
        };
        Ok(Self {
            stimulus: Stimulus::new(actuator, encoder, law)?,
            rate_hz,
            bias_v: actuator.bias_v(),
            carrier: None,
            path: Path::default(),
            delay: Delay::new(0.0, 0.0, 0)?,
            wait_s: 0.0,
            late: 0,
            is_down: false,
        })
    }

    /// Sets the texture; an impossible one is refused without effect.
    pub fn set_texture(&mut self, texture: &Texture) -> Result<(), Error> {
        self.stimulus.set_texture(texture)
    }

    /// Sets the delay, and the time to wait for each position, 0 to 0.2 s. It should exceed the
    /// interval of positions, so that every sample lies between two known positions.
    pub fn set_delay(&mut self, delay: Delay, wait_s: f32) -> Result<(), Error> {
        within("wait_s", wait_s, 0.0, 0.2)?;
        (self.delay, self.wait_s) = (delay, wait_s.into());
        Ok(())
    }

    /// Sets a tone of 150 to 250 Hz whose amplitude follows the texture: headphones cannot play the
    /// 5 to 60 Hz of ridges under a slow hand, and skin is most sensitive to the tone's
    /// frequencies. `None` plays the texture itself.
    pub fn set_carrier(&mut self, carrier_hz: Option<f32>) -> Result<(), Error> {
        if let Some(frequency_hz) = carrier_hz {
            within("carrier_hz", frequency_hz, 150.0, 250.0)?;
        }
        self.carrier = carrier_hz.map(|frequency_hz| Carrier {
            frequency_hz,
            ..self.carrier.unwrap_or_default()
        });
        Ok(())
    }

    /// Puts the hand down at a position (millimetres) and a time (seconds), even if it was
    /// elsewhere before.
    pub fn down(&mut self, t_s: f64, position_mm: f64) {
        if !self.is_down {
            self.path.clear();
            self.is_down = true;
        }
        self.moved(t_s, position_mm);
        self.stimulus.down();
    }

    /// Moves the hand. Late or non-finite positions are dropped.
    pub fn moved(&mut self, t_s: f64, position_mm: f64) -> bool {
        self.path.push(t_s, position_mm)
    }

    /// Lifts the hand, or marks it as unknown: the vibration fades.
    pub fn lift(&mut self) {
        self.is_down = false;
        self.stimulus.lift();
    }

    /// Returns the next sample, -1 to 1: the voltage about its bias, relative to half of the
    /// actuator's maximum. `t_s` is one sample period after the last.
    pub fn next(&mut self, t_s: f64) -> f32 {
        let at_s = t_s - self.wait_s;
        let is_late = self.is_down && self.path.last().is_some_and(|(last_s, _)| at_s > last_s);
        self.late = self.late.wrapping_add(is_late.into());
        let position_mm = self
            .path
            .position_mm(at_s - self.delay.at_s(t_s))
            .unwrap_or(0.0);
        // Positions wrap at 32 bits, as an encoder's do.
        let counts = libm::floor(position_mm / f64::from(COUNT_MM)) as i64 as i32;
        let felt = ((self.stimulus.next(counts) - self.bias_v) / self.bias_v).clamp(-1.0, 1.0);
        self.carried(felt, counts, t_s)
    }

    /// Applies a sample of the texture to the carrier, if there is one. The amplitude goes from
    /// zero in the texture's grooves to its maximum on the ridges, within the actuator's slew.
    fn carried(&mut self, felt: f32, counts: i32, t_s: f64) -> f32 {
        let amplitude = self.amplitude();
        let Some(carrier) = &mut self.carrier else {
            return felt;
        };
        let actuator = self.stimulus.actuator();
        carrier.still = if counts == carrier.counts {
            carrier.still.saturating_add(1)
        } else {
            0
        };
        carrier.counts = counts;
        let rests = carrier.still as f32 > RESTS_S * self.rate_hz;
        let step = 1.0 / (actuator.fade_s * self.rate_hz);
        let wanted = if rests { 0.0 } else { 1.0 };
        carrier.level += between(wanted - carrier.level, -step, step);
        let cycles = f64::from(carrier.frequency_hz) * t_s;
        let phase = ((cycles - libm::floor(cycles)) * f64::from(TURN)) as u32;
        let envelope = between(0.5 * (amplitude + felt), 0.0, 1.0);
        let reach = carrier.level * actuator.fraction(carrier.frequency_hz);
        let slew = actuator.slew_v_s / self.rate_hz / self.bias_v;
        let tone = reach * envelope * sine(phase) - carrier.output;
        carrier.output = (carrier.output + between(tone, -slew, slew)).clamp(-1.0, 1.0);
        carrier.output
    }

    /// Number of samples for which the hand's next position was not known yet, because it rested or
    /// its report was late. It wraps.
    pub fn late(&self) -> u32 {
        self.late
    }

    /// Current amplitude as a fraction of the maximum.
    pub fn amplitude(&self) -> f32 {
        self.stimulus.amplitude_v() / self.bias_v
    }
}
