//! A window of a slide as the fit gets it, and its truth.

use crate::bound::{self, Channel, Clue, Harmonic};
use anyhow::{Result, ensure};
use hal_mock::{Scene, Sliding, SlidingScene};
use ridgetone_finger::converter::Ads1258Plan;
use ridgetone_finger::internals::{TRIM_FRAMES, window_frames_max};
use ridgetone_host::input::{REFERENCE_V, frame_rate_hz};
use ridgetone_proto::plan::Plan;
use ridgetone_proto::settings::TAXELS;
use ridgetone_tone::{FRAMES_MIN, Values};
use std::f64::consts::{FRAC_PI_2, TAU};

/// Volts of one code (SBAS297G: VREF / 780000h).
pub(crate) const CODE_V: f64 = REFERENCE_V / 7_864_320.0;

/// Standard deviation of rounding to whole codes, codes: the root of 1/12.
const ROUNDING_CODES: f64 = 0.288_675;

/// Noise of a conversion by DRATE 0 to 3, microvolts rms (SBAS297G, noise performance).
const NOISE_UV: [f64; 4] = [2.8, 4.5, 7.9, 12.0];
/// CHOP divides it by this (SBAS297G).
const CHOP_FACTOR: f64 = 1.4;

/// From the start of the slide to the earliest window, seconds.
const AFTER_START_S: f64 = 0.1;

/// How a scene becomes frames.
#[derive(Clone, Copy, Debug)]
struct Sampling {
    rate_hz: f64,
    /// Bit k: frames have taxel k; the others are zero.
    inputs: u16,
    /// Factor of all that the scene makes, its noise included.
    gain: f64,
}

impl Sampling {
    /// The default scan, and the scene as it is.
    fn usual() -> Self {
        Self {
            rate_hz: frame_rate_hz(),
            inputs: u16::MAX,
            gain: 1.0,
        }
    }
}

#[derive(Clone, Debug)]
pub struct Simulated {
    /// The frames, in codes less a reference; all channels at the frame's time.
    pub values: Vec<Values>,
    /// Bit k: taxel k has values.
    pub inputs: u16,
    pub frame_rate_hz: f64,
    pub frequency_hz: f64,
    pub channels: Vec<Channel>,
}

impl Simulated {
    /// A window of `window_s` seconds of a scene. The seed moves it within a cycle too.
    pub fn new(parameters: &Sliding, window_s: f64) -> Result<Self> {
        Self::sampled(
            SlidingScene::new(parameters.clone())?,
            parameters.seed,
            window_s,
            Sampling::usual(),
        )
    }

    /// A window by a scan plan, the scene so weak that its noise is `noise_v`.
    pub fn by_plan(parameters: &Sliding, window_s: f64, plan: &Plan, noise_v: f64) -> Result<Self> {
        let scene = SlidingScene::new(parameters.clone())?;
        let gain = noise_v / scene.noise_v();
        let sampling = Sampling {
            rate_hz: plan.frame_rate_hz().into(),
            inputs: plan.inputs,
            gain,
        };
        Self::sampled(scene, parameters.seed, window_s, sampling)
    }

    fn sampled(scene: SlidingScene, seed: u64, window_s: f64, sampling: Sampling) -> Result<Self> {
        let truth = scene.truth();
        let from_s = truth.slide_start_s + AFTER_START_S + spread(seed) / truth.frequency_hz;
        let slide_s = truth.slide_end_s - truth.slide_start_s;
        ensure!(
            from_s + window_s <= truth.slide_end_s,
            "a window of {window_s} s in a slide of {slide_s} s"
        );
        Ok(Self::at(
            scene,
            from_s,
            (window_s * sampling.rate_hz).round() as usize,
            sampling,
        ))
    }

    /// The whole slide of a scene as the detector cuts it out, its ends trimmed. The seed moves it
    /// within a frame.
    pub fn whole_slide(parameters: &Sliding) -> Result<Self> {
        let scene = SlidingScene::new(parameters.clone())?;
        let (truth, rate_hz) = (scene.truth(), frame_rate_hz());
        let slide = ((truth.slide_end_s - truth.slide_start_s) * rate_hz) as u32;
        let frames = slide.saturating_sub(2 * TRIM_FRAMES);
        ensure!(
            (FRAMES_MIN..=window_frames_max(&Plan::PAPER)).contains(&frames),
            "a slide of {slide} frames"
        );
        let from_s =
            truth.slide_start_s + (f64::from(TRIM_FRAMES) + spread(parameters.seed)) / rate_hz;
        Ok(Self::at(scene, from_s, frames as usize, Sampling::usual()))
    }

    /// `frames` frames from the time `from_s` on.
    fn at(mut scene: SlidingScene, from_s: f64, frames: usize, sampling: Sampling) -> Self {
        let Sampling {
            rate_hz,
            inputs,
            gain,
        } = sampling;
        let truth = scene.truth();
        let zeros_v: Vec<f64> = scene
            .channels()
            .iter()
            .map(|channel| channel.offset_v)
            .collect();
        let mut frame = |number: usize| {
            let t_s = from_s + number as f64 / rate_hz;
            std::array::from_fn(|c| match inputs >> c & 1 {
                0 => 0.0,
                _ => (gain * (scene.volts(c as u8, t_s) - zeros_v[c]) / CODE_V).round() as f32,
            })
        };
        let values = (0..frames).map(&mut frame).collect();

        let centre_s = from_s + 0.5 * (frames as f64 - 1.0) / rate_hz;
        let turns = truth.frequency_hz * (centre_s - truth.slide_start_s);
        let sigma = (gain * scene.noise_v() / CODE_V).hypot(ROUNDING_CODES);
        let channels = scene.channels()[..TAXELS].iter().map(|channel| {
            let harmonics = channel.sliding.tone.iter().zip(1..).map(|(harmonic, h)| {
                // The scene counts its phases from the sine.
                let phase_rad = f64::from(h) * TAU * turns + harmonic.phase_rad() - FRAC_PI_2;
                Harmonic::polar(gain * harmonic.amplitude_v() / CODE_V, phase_rad)
            });
            Channel {
                sigma,
                harmonics: harmonics.collect(),
            }
        });
        Self {
            values,
            inputs,
            frame_rate_hz: rate_hz,
            frequency_hz: truth.frequency_hz,
            channels: channels.collect(),
        }
    }

    /// Information of each channel about the frequency with `harmonics` harmonics, and with or
    /// without an unknown slope.
    pub fn clues(&self, slope: bool, harmonics: usize) -> Result<Vec<Clue>> {
        let frames = self.values.len();
        let window = bound::Window {
            frames,
            frame_rate_hz: self.frame_rate_hz,
            slope,
        };
        let mut channels = self.channels.clone();
        channels
            .iter_mut()
            .for_each(|channel| channel.harmonics.truncate(harmonics));
        let value = |channel: usize, frame: usize| f64::from(self.values[frame][channel]);
        bound::clues(&window, self.frequency_hz, &channels, &value)
    }
}

/// A number from 0 to 1 for each seed, evenly spread over many of them: multiples of the golden
/// ratio.
fn spread(seed: u64) -> f64 {
    (0.618_033_988_75 * seed as f64).fract()
}

/// Noise of a conversion of the ADS1258 in a plan, volts rms.
pub fn converter_noise_v(plan: &Plan) -> f64 {
    let own = Ads1258Plan::of(plan);
    let chopped = if own.chop { CHOP_FACTOR } else { 1.0 };
    1e-6 * NOISE_UV[usize::from(own.data_rate & 3)] / chopped
}
