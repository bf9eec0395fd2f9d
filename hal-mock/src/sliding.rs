//! The paper's protocol as a scene: a grating is pressed on the finger, slides, and is lifted.
//!
//! Protocol, periods and speeds: Oddo et al. 2009, section 3.1 and tables 1 to 3. The channels'
//! responses are either drawn at random around plausible values, so that tests know the tone
//! exactly, or follow from geometry, elasticity and friction ([`Finger`]). A [`Finger`] also has
//! creep and the bridge's filter. Both kinds have noise.

mod channel;
mod finger;
mod kelvin;
mod line_load;
mod motion;
mod parameters;
mod random_channels;
mod range;

pub use channel::{Channel, Harmonic, Pattern};
pub use finger::Finger;
pub use motion::{Hand, Stimulator};
pub use parameters::{Converter, Sliding};
pub use range::ParameterError;

use crate::random::{Random, Stream};
use crate::scene::{INPUTS, Scene};
use kelvin::{KelvinBody, Lag};
use motion::Motion;

/// Speed in mm/s and spatial period in mm of the paper's ten combinations C1 to C10, in the order
/// of its table 3.
pub const TABLE_2: [(f64, f64); 10] = [
    (15.0, 3.6),
    (30.0, 3.6),
    (15.0, 4.1),
    (30.0, 4.1),
    (15.0, 3.1),
    (30.0, 3.1),
    (48.0, 3.1),
    (15.0, 2.6),
    (30.0, 2.6),
    (48.0, 2.6),
];

/// Seconds from touch to full load and to the peak of the contact spike; also the duration of the
/// release.
const RISE_S: f64 = 0.010;
/// Time constant of the contact spike's decay, seconds.
const DECAY_S: f64 = 0.040;
/// Speed in mm/s at which friction has three quarters of its full strength; plausible.
const SLIP_MM_S: f64 = 1.0;
/// Longest integration step of creep and filter in seconds, a quarter of the filter's time
/// constant: the error at 100 Hz is 0.03 %.
const STEP_S: f64 = 1e-4;

/// Ground truth of a scene: the times of its events, and the tone.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Truth {
    /// Time of the contact spike's peak in seconds.
    pub contact_s: f64,
    /// Beginning of the slide in seconds.
    pub slide_start_s: f64,
    /// End of the slide in seconds.
    pub slide_end_s: f64,
    /// Beginning of the release in seconds.
    pub release_s: f64,
    /// Frequency of the tone in hertz: speed over period, without the speed's ripple; for a hand,
    /// at its peak speed.
    pub frequency_hz: f64,
    /// End of the scene in seconds.
    pub end_s: f64,
}

/// State of the skin's creep over each input.
#[derive(Clone, Copy, Debug)]
pub struct SkinState([Delay; INPUTS]);

/// A scene of the paper's protocol. The tone is a function of position, so all signals are
/// continuous at any finite speed.
#[derive(Clone, Debug)]
pub struct SlidingScene {
    parameters: Sliding,
    truth: Truth,
    motion: Motion,
    channels: [Channel; INPUTS],
    /// Creep and filter behind the elastic skin; random channels have none.
    delays: Option<[Delay; INPUTS]>,
    noise_v: f64,
    random: Random,
}

/// Creep and filter of one channel, and the time up to which they have advanced.
#[derive(Clone, Copy, Debug)]
struct Delay {
    at_s: f64,
    skin: KelvinBody,
    crept_v: f64,
    filter: Lag,
    filtered_v: f64,
}

impl SlidingScene {
    /// Builds the scene. The error names the first parameter outside its documented range.
    pub fn new(parameters: Sliding) -> Result<Self, ParameterError> {
        parameters.check()?;
        let Sliding {
            speed_mm_s,
            slide_mm,
            stimulator,
            finger,
            seed,
            ..
        } = parameters;
        let mut run = Random::new(seed, Stream::Stimulator);
        let (motion, jitter_s) = match parameters.hand {
            Some(hand) => (Motion::Hand(hand), 0.0),
            None => (
                Motion::steady(speed_mm_s, slide_mm, stimulator, run.uniform()),
                stimulator.onset_jitter_s * run.symmetric(),
            ),
        };
        let contact_s = parameters.idle_s + RISE_S;
        let slide_start_s = contact_s + parameters.hold_before_s + jitter_s;
        let slide_end_s = slide_start_s + motion.duration_s();
        let release_s = slide_end_s + parameters.hold_after_s;
        let truth = Truth {
            contact_s,
            slide_start_s,
            slide_end_s,
            release_s,
            frequency_hz: motion.tone_speed_mm_s() / parameters.period_mm,
            end_s: release_s + parameters.release_idle_s,
        };
        let channels = match &finger {
            Some(finger) => finger.channels(parameters.grating()),
            None => random_channels::channels(parameters.period_mm, parameters.overtones, seed),
        };
        let delays = finger.map(|finger| {
            let (skin, filter) = (finger.skin(), Lag::new(finger.filter_s()));
            [Delay {
                at_s: 0.0,
                skin,
                crept_v: 0.0,
                filter,
                filtered_v: 0.0,
            }; INPUTS]
        });
        let power = channels
            .iter()
            .map(|c| c.amplitude_v() * c.amplitude_v() / 2.0)
            .sum::<f64>()
            / INPUTS as f64;
        let own_v = finger.map_or(0.0, |finger| 1e-6 * finger.noise_uv);
        let noise_v = parameters
            .snr_db
            .map_or(own_v, |db| libm::sqrt(power / libm::pow(10.0, db / 10.0)));
        let random = Random::new(seed, Stream::SceneNoise);
        Ok(Self {
            parameters,
            truth,
            motion,
            channels,
            delays,
            noise_v,
            random,
        })
    }

    /// The times of the events, and the tone.
    pub fn truth(&self) -> Truth {
        self.truth
    }

    /// Responses of the channels.
    pub fn channels(&self) -> &[Channel; INPUTS] {
        &self.channels
    }

    /// State of the skin's creep, to continue in another scene of the same finger; `None` for a
    /// scene without a finger.
    pub fn skin(&self) -> Option<SkinState> {
        self.delays.map(SkinState)
    }

    /// Continues with the state of the skin at the end of another scene.
    pub fn set_skin(&mut self, skin: Option<SkinState>) {
        self.delays = skin.map(|SkinState(delays)| delays);
    }

    /// Standard deviation of the noise in volts.
    pub fn noise_v(&self) -> f64 {
        self.noise_v
    }

    /// Position of a ridge ahead of the middle of the contact, in mm.
    pub fn position_mm(&self, t_s: f64) -> f64 {
        let slid_mm = self.motion.place_mm(t_s - self.truth.slide_start_s);
        self.parameters.start_mm + self.direction() * slid_mm
    }

    /// Speed of the grating in mm/s, negative while it slides from units 2 and 4 to units 1 and 3.
    pub fn speed_mm_s(&self, t_s: f64) -> f64 {
        self.direction() * self.motion.speed_mm_s(t_s - self.truth.slide_start_s)
    }

    fn direction(&self) -> f64 {
        if self.parameters.reverse { -1.0 } else { 1.0 }
    }

    /// Volts on AIN`input` without noise, creep and filter. Inputs above 15 are at 0 V.
    pub fn clean_volts(&self, input: u8, t_s: f64) -> f64 {
        self.channels
            .get(usize::from(input))
            .map_or(0.0, |channel| {
                channel.offset_v + self.elastic_v(channel, t_s)
            })
    }

    /// Volts above the offset.
    fn elastic_v(&self, channel: &Channel, t_s: f64) -> f64 {
        let load = self.load(t_s);
        let pressed_v = if load > 0.0 {
            let drag =
                libm::tanh(self.motion.speed_mm_s(t_s - self.truth.slide_start_s) / SLIP_MM_S);
            // The load also scales the tone: without contact there is none.
            load * channel.loaded_v(self.position_mm(t_s) / self.parameters.period_mm, drag)
        } else {
            0.0
        };
        pressed_v + channel.spike_v * self.spike(t_s)
    }

    /// Advances a channel's creep and filter to `t_s`.
    fn delayed_v(&self, channel: &Channel, mut delay: Delay, t_s: f64) -> Delay {
        // If the scene is played again, keep the state of the skin.
        if t_s < delay.at_s {
            delay.at_s = t_s;
            return delay;
        }
        let steps = libm::ceil((t_s - delay.at_s) / STEP_S);
        if steps < 1.0 {
            return delay;
        }
        let (from_s, step_s) = (delay.at_s, (t_s - delay.at_s) / steps);
        let mut elastic_v = self.elastic_v(channel, from_s);
        for step in 1..=steps as u64 {
            let next_v = self.elastic_v(channel, from_s + step as f64 * step_s);
            let crept_v = delay.skin.advance(step_s, elastic_v, next_v);
            delay.filtered_v = delay.filter.advance(step_s, delay.crept_v, crept_v);
            (elastic_v, delay.crept_v) = (next_v, crept_v);
        }
        delay.at_s = t_s;
        delay
    }

    /// Normal load relative to that of the hold: rises with the touch, falls with the release.
    pub fn load(&self, t_s: f64) -> f64 {
        step((t_s - self.truth.contact_s) / RISE_S + 1.0)
            * (1.0 - step((t_s - self.truth.release_s) / RISE_S))
    }

    /// Contact spike relative to its peak.
    pub fn spike(&self, t_s: f64) -> f64 {
        let since_peak_s = t_s - self.truth.contact_s;
        if since_peak_s < 0.0 {
            step(since_peak_s / RISE_S + 1.0)
        } else {
            libm::exp(-since_peak_s / DECAY_S)
        }
    }
}

impl Scene for SlidingScene {
    fn volts(&mut self, input: u8, t_s: f64) -> f64 {
        let noise_v = if self.noise_v > 0.0 {
            self.noise_v * self.random.gaussian()
        } else {
            0.0
        };
        let at = usize::from(input);
        let before = self
            .delays
            .as_ref()
            .and_then(|delays| delays.get(at))
            .copied();
        let Some((delay, channel)) = before.zip(self.channels.get(at)) else {
            return self.clean_volts(input, t_s) + noise_v;
        };
        let delay = self.delayed_v(channel, delay, t_s);
        let volts = channel.offset_v + delay.filtered_v;
        self.delays.iter_mut().for_each(|delays| delays[at] = delay);
        volts + noise_v
    }

    fn end_s(&self) -> f64 {
        self.truth.end_s
    }
}

/// Rises from 0 to 1 as half a cosine while `x` goes from 0 to 1.
fn step(x: f64) -> f64 {
    0.5 - 0.5 * libm::cos(core::f64::consts::PI * x.clamp(0.0, 1.0))
}
