//! A window that is made of parts: noise, a tone, how its speed goes, and something else.

use super::process::{self, Noise};
use crate::draw::Draw;
use ridgetone_proto::settings::TAXELS;
use ridgetone_tone::Values;
use std::f64::consts::{FRAC_1_SQRT_2, TAU};

/// Codes of a standard deviation of the noise: rounding to whole codes is far below it.
const CODES_PER_SIGMA: f64 = 1000.0;

/// The speed over the window.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Speed {
    Steady,
    /// Wanders by this share of it, rms, below 2 Hz.
    Wander(f64),
    /// Grows by this share of it from the window's start to its end.
    Chirp(f64),
}

/// The tone.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tone {
    /// Least and most cycles in the window; the highest frequency is 40 Hz.
    pub cycles: (f64, f64),
    /// Amplitudes of the harmonics, of which the strongest is 1.
    pub harmonics: [f64; 5],
    /// Power of the strongest harmonic over that of the noise, decibels.
    pub snr_db: f64,
    pub speed: Speed,
}

/// What is in the window beside tone and noise. Sizes are in amplitudes of the tone; without a tone in standard deviations
/// of the noise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Extra {
    Nothing,
    /// Exponentials to a new level.
    Relaxations(u8, f64),
    /// Logarithm of time since a moment before the window.
    LogCreep(f64),
    Step(f64),
    /// A smooth bump.
    Bump(f64),
    /// A contact spike's tail, which falls within 0.02 to 0.05 of the window.
    Spike(f64),
    /// The tone begins halfway.
    HalfTone,
    /// The tone's amplitude falls tenfold.
    Decay,
    /// A second tone of equal strength, 1.2 to 2.8 times as fast but at no multiple.
    SecondTone,
    /// Values are rounded to this share of the amplitude.
    Rounded(f64),
    /// Gains of the channels over four decades.
    Gains,
    /// Three channels that stay at one value, two that are noise alone.
    DeadChannels,
}

#[derive(Clone, Debug)]
pub struct Window {
    pub values: Vec<Values>,
    /// Step of the values' rounding.
    pub step: f32,
    /// Mean of the frequency over the window, cycles per frame; none without a tone.
    pub mean: Option<f64>,
    /// Its mean weighted by a parabola that is zero at the window's ends.
    pub weighted: Option<f64>,
}

/// The parts of a window.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Recipe {
    pub noise: Noise,
    pub tone: Option<Tone>,
    pub extra: Extra,
}

impl Recipe {
    /// A window of so many frames.
    pub fn make(&self, count: usize, rate_hz: f64, draw: &mut Draw) -> Window {
        let mut frames = process::frames(self.noise, count, rate_hz, draw);
        let (mut mean, mut weighted) = (None, None);
        // Of the strongest harmonic, in standard deviations of the noise.
        let amplitude = self.tone.map_or(1.0, |tone| 10f64.powf(tone.snr_db / 20.0) / FRAC_1_SQRT_2);
        if let Some(tone) = self.tone {
            let frequencies = frequencies(&tone, count, rate_hz, draw);
            let parabola = |n: usize| 1.0 - ((2.0 * n as f64 + 1.0) / count as f64 - 1.0).powi(2);
            let weights: f64 = (0..count).map(parabola).sum();
            mean = Some(frequencies.iter().sum::<f64>() / count as f64);
            weighted = Some(frequencies.iter().enumerate().map(|(n, f)| parabola(n) * f).sum::<f64>() / weights);
            add_tone(&mut frames, &frequencies, &tone.harmonics, amplitude, self.extra, draw);
            if self.extra == Extra::SecondTone {
                let times = *[1.25, 1.4, 1.6, 2.4, 2.6].get(draw.whole(0, 4) as usize).unwrap_or(&1.4);
                let second: Vec<f64> = frequencies.iter().map(|f| times * f).collect();
                add_tone(&mut frames, &second, &tone.harmonics, amplitude, Extra::Nothing, draw);
            }
        }
        add_baseline(&mut frames, self.extra, amplitude, draw);
        let gains: [f64; TAXELS] =
            std::array::from_fn(|c| if self.extra == Extra::Gains { 10f64.powf(4.0 * c as f64 / 15.0 - 2.0) } else { 1.0 });
        let offsets: [f64; TAXELS] = std::array::from_fn(|_| draw.even(-2e5, 2e5).round());
        let step = if let Extra::Rounded(share) = self.extra { (share * amplitude * CODES_PER_SIGMA).round() } else { 1.0 };
        let is_flat = |c: usize| self.extra == Extra::DeadChannels && c < 3;
        let value = |frame: &[f64; TAXELS], c: usize| {
            if is_flat(c) {
                return offsets[c] as f32;
            }
            let value = offsets[c] + CODES_PER_SIGMA * gains[c] * frame[c];
            ((value / step).round() * step) as f32
        };
        let values = frames.iter().map(|frame| std::array::from_fn(|c| value(frame, c))).collect();
        Window { values, step: step as f32, mean, weighted }
    }
}

/// The tone's frequency in each frame, cycles per frame.
fn frequencies(tone: &Tone, count: usize, rate_hz: f64, draw: &mut Draw) -> Vec<f64> {
    let (least, most) = tone.cycles;
    let most = most.min(40.0 / rate_hz * count as f64).max(least);
    let middle = draw.log(least, most) / count as f64;
    match tone.speed {
        Speed::Steady => vec![middle; count],
        Speed::Wander(share) => {
            let phi = (-TAU * 2.0 / rate_hz).exp();
            let mut state = draw.normal();
            let mut next = || {
                let value = state;
                state = phi * state + (1.0 - phi * phi).sqrt() * draw.normal();
                middle * (1.0 + share * value)
            };
            (0..count).map(|_| next()).collect()
        }
        Speed::Chirp(share) => (0..count).map(|n| middle * (1.0 + share * (n as f64 / count as f64 - 0.5))).collect(),
    }
}

fn add_tone(
    frames: &mut [[f64; TAXELS]],
    frequencies: &[f64],
    harmonics: &[f64],
    amplitude: f64,
    extra: Extra,
    draw: &mut Draw,
) {
    let count = frames.len();
    let phases: [[f64; 5]; TAXELS] = std::array::from_fn(|_| std::array::from_fn(|_| draw.even(0.0, TAU)));
    let gains: [f64; TAXELS] = std::array::from_fn(|c| match extra {
        Extra::DeadChannels if (3..5).contains(&c) => 0.0,
        _ => draw.even(0.5, 1.5),
    });
    let mut turns = 0.0;
    for (n, (frame, frequency)) in frames.iter_mut().zip(frequencies).enumerate() {
        let part = n as f64 / count as f64;
        let envelope = match extra {
            Extra::HalfTone if part < 0.5 => 0.0,
            Extra::Decay => 10f64.powf(-part),
            _ => 1.0,
        };
        for (c, value) in frame.iter_mut().enumerate() {
            let wave = |(h, relative): (usize, &f64)| relative * (TAU * (h + 1) as f64 * turns + phases[c][h]).cos();
            *value += envelope * amplitude * gains[c] * harmonics.iter().enumerate().map(wave).sum::<f64>();
        }
        turns += frequency;
    }
}

/// Adds what is neither tone nor noise, with a gain of its own in each channel.
fn add_baseline(frames: &mut [[f64; TAXELS]], extra: Extra, amplitude: f64, draw: &mut Draw) {
    let count = frames.len();
    let (place, width) = (draw.even(0.2, 0.8), draw.log(0.08, 0.25));
    let decay = draw.even(0.02, 0.05);
    let mut add = |size: f64, shape: &dyn Fn(f64) -> f64, draw: &mut Draw| {
        let gains: [f64; TAXELS] = std::array::from_fn(|_| if draw.coin() { 1.0 } else { -1.0 } * draw.even(0.5, 1.5));
        for (n, frame) in frames.iter_mut().enumerate() {
            let shape = size * amplitude * shape((n as f64 + 0.5) / count as f64);
            frame.iter_mut().zip(gains).for_each(|(value, gain)| *value += gain * shape);
        }
    };
    match extra {
        Extra::Relaxations(how_many, size) => {
            for _ in 0..how_many {
                let length = draw.log(0.1, 3.0);
                add(size, &|part| (-part / length).exp(), draw);
            }
        }
        Extra::LogCreep(size) => {
            let before = draw.log(0.03, 1.0);
            add(size, &|part| (part / before).ln_1p(), draw);
        }
        Extra::Step(size) => add(size, &|part| f64::from(u8::from(part > place)), draw),
        Extra::Bump(size) => add(size, &|part| (-0.5 * ((part - place) / width).powi(2)).exp(), draw),
        // It begins in the first quarter of the window. Its length is a share of the window, as all lengths here are.
        Extra::Spike(size) => add(size, &|part| if part < 0.3 * place { 0.0 } else { (-(part - 0.3 * place) / decay).exp() }, draw),
        _ => {}
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TONE: Tone = Tone { cycles: (4.0, 4.0), harmonics: [1.0, 0.0, 0.0, 0.0, 0.0], snr_db: 20.0, speed: Speed::Steady };

    /// Channel power in squared standard deviations of the noise.
    fn power(recipe: Recipe) -> f64 {
        let window = recipe.make(480, 241.14, &mut Draw::new(9));
        let sum = |c: usize| {
            let mean = window.values.iter().map(|v| f64::from(v[c])).sum::<f64>() / 480.0;
            window.values.iter().map(|v| ((f64::from(v[c]) - mean) / CODES_PER_SIGMA).powi(2)).sum::<f64>() / 480.0
        };
        (0..TAXELS).map(sum).sum::<f64>() / TAXELS as f64
    }

    #[test]
    fn a_tone_has_the_power_that_its_decibels_say() {
        let recipe = Recipe { noise: Noise::White, tone: Some(TONE), extra: Extra::Nothing };
        // Gains of 0.5 to 1.5 have a mean square of 13 / 12.
        let relative = (power(recipe) - 1.0) / (100.0 * 13.0 / 12.0);
        assert!((0.8..1.2).contains(&relative), "{relative}");
        let noise = power(Recipe { tone: None, ..recipe });
        assert!((0.9..1.1).contains(&noise), "{noise}");
    }

    #[test]
    fn the_means_of_a_chirp_and_of_a_wander_are_those_of_its_frequencies() {
        let speed = Speed::Chirp(0.1);
        let recipe = Recipe { noise: Noise::White, tone: Some(Tone { speed, ..TONE }), extra: Extra::Nothing };
        let window = recipe.make(480, 241.14, &mut Draw::new(2));
        // Both are symmetric about the window's middle.
        let (mean, weighted) = (window.mean.expect("a tone"), window.weighted.expect("a tone"));
        assert!((mean * 480.0 / 4.0 - 1.0).abs() < 2e-4 && (weighted / mean - 1.0).abs() < 2e-4, "{mean} {weighted}");
        let speed = Speed::Wander(0.05);
        let wander = Recipe { tone: Some(Tone { speed, ..TONE }), ..recipe }.make(480, 241.14, &mut Draw::new(2));
        let off = wander.mean.expect("a tone") * 480.0 / 4.0 - 1.0;
        assert!(off.abs() > 1e-4 && off.abs() < 0.1, "{off}");
    }
}
