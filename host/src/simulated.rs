//! A window of a slide as the fit gets it, and what is true of it.

use crate::bound::{self, Channel, Harmonic};
use crate::input::{REFERENCE_V, frame_rate_hz};
use anyhow::{Result, ensure};
use hal_mock::{Scene, Sliding, SlidingScene};
use ridgetone::settings::TAXELS;
use ridgetone::window::Values;
use std::f64::consts::{FRAC_PI_2, TAU};

/// Volts of one code (SBAS297G: VREF / 780000h).
const CODE_V: f64 = REFERENCE_V / 7_864_320.0;

/// Standard deviation of rounding to whole codes, codes: the root of 1/12.
const ROUNDING_CODES: f64 = 0.288_675;

/// From the start of the slide to the earliest window, seconds.
const AFTER_START_S: f64 = 0.1;

/// A window.
#[derive(Clone, Debug)]
pub struct Simulated {
    /// The frames, in codes less a reference; all channels at the frame's time.
    pub values: Vec<Values>,
    /// Frames per second.
    pub frame_rate_hz: f64,
    /// The true frequency, hertz.
    pub frequency_hz: f64,
    /// What is true of each channel, in codes.
    pub channels: Vec<Channel>,
}

impl Simulated {
    /// A window of `window_s` seconds of a scene. The seed moves it within a cycle too.
    ///
    /// # Errors
    /// A parameter of the scene; a slide too short for the window.
    pub fn new(parameters: &Sliding, window_s: f64) -> Result<Self> {
        let mut scene = SlidingScene::new(parameters.clone())?;
        let (truth, rate_hz) = (scene.truth(), frame_rate_hz());
        let frames = (window_s * rate_hz).round() as usize;
        // The golden ratio spreads the windows of many seeds evenly over a cycle.
        let shift = (0.618_033_988_75 * parameters.seed as f64).fract();
        let from_s = truth.slide_start_s + AFTER_START_S + shift / truth.frequency_hz;
        let slide_s = truth.slide_end_s - truth.slide_start_s;
        ensure!(from_s + window_s <= truth.slide_end_s, "a window of {window_s} s in a slide of {slide_s} s");

        let zeros_v = scene.channels().map(|channel| channel.offset_v);
        let mut frame = |number: usize| {
            let t_s = from_s + number as f64 / rate_hz;
            std::array::from_fn(|c| ((scene.volts(c as u8, t_s) - zeros_v[c]) / CODE_V).round() as f32)
        };
        let values = (0..frames).map(&mut frame).collect();

        let centre_s = from_s + 0.5 * (frames as f64 - 1.0) / rate_hz;
        let turns = truth.frequency_hz * (centre_s - truth.slide_start_s);
        let sigma = (scene.noise_v() / CODE_V).hypot(ROUNDING_CODES);
        let channels = scene.channels()[..TAXELS].iter().map(|channel| {
            let harmonics =
                channel.relative.iter().zip(channel.extra_phase_rad).zip(1..).map(|((relative, extra), h)| {
                    // The scene counts its phases from the sine.
                    let phase_rad = f64::from(h) * (TAU * turns + channel.phase_rad) + extra - FRAC_PI_2;
                    Harmonic::polar(channel.amplitude_v * relative / CODE_V, phase_rad)
                });
            Channel { sigma, harmonics: harmonics.collect() }
        });
        Ok(Self { values, frame_rate_hz: rate_hz, frequency_hz: truth.frequency_hz, channels: channels.collect() })
    }

    /// The bound for all of its channels, hertz, with or without an unknown slope in each.
    ///
    /// # Errors
    /// Those of [`bound::sigma_hz`].
    pub fn bound_hz(&self, slope: bool) -> Result<f64> {
        let frames = self.values.len();
        let window = bound::Window { frames, frame_rate_hz: self.frame_rate_hz, valid: None, slope };
        bound::sigma_hz(&window, self.frequency_hz, &self.channels)
    }
}
