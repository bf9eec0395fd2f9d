//! The parts of a window that are no noise: tones, waves, baselines.

use crate::draw::Draw;
use ridgetone_proto::settings::TAXELS;
use std::f64::consts::TAU;

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

/// What is in the window beside tone and noise. Sizes are in amplitudes of the tone; without a tone
/// in standard deviations of the noise.
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
    /// A second tone of equal strength, faster by this many cycles a window.
    CloseTone(f64, f64),
    /// Values are rounded to this share of the amplitude.
    Rounded(f64),
    /// Gains of the channels over four decades.
    Gains,
    /// Three channels that stay at one value, two that are noise alone.
    DeadChannels,
    /// Channels from this one on stay at one value.
    Channels(usize),
    /// Three channels that are clipped at a rail, two that stay there.
    Saturated,
    /// Mains hum of this size at [`MAINS_HZ`].
    Mains(f64),
}

/// The tone's frequency in each frame, cycles per frame.
pub fn frequencies(tone: &Tone, count: usize, rate_hz: f64, draw: &mut Draw) -> Vec<f64> {
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
        Speed::Chirp(share) => (0..count)
            .map(|n| middle * (1.0 + share * ((n as f64 + 0.5) / count as f64 - 0.5)))
            .collect(),
    }
}

/// A tone that may move.
#[derive(Clone, Copy)]
pub struct Sound<'a> {
    /// Cycles per frame, frame by frame.
    pub frequencies: &'a [f64],
    /// Relative amplitudes, the fundamental's first.
    pub harmonics: &'a [f64],
    pub amplitude: f64,
}

/// Adds a tone and gives its derivative by the frequency.
pub fn add_tone(
    frames: &mut [[f64; TAXELS]],
    sound: Sound<'_>,
    extra: Extra,
    draw: &mut Draw,
) -> Vec<[f64; TAXELS]> {
    let Sound {
        frequencies,
        harmonics,
        amplitude,
    } = sound;
    let count = frames.len();
    let mut derivative = vec![[0.0; TAXELS]; count];
    let phases: [[f64; 5]; TAXELS] =
        std::array::from_fn(|_| std::array::from_fn(|_| draw.even(0.0, TAU)));
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
            let wave = |(h, relative): (usize, &f64)| {
                relative * (TAU * (h + 1) as f64 * turns + phases[c][h]).cos()
            };
            *value += envelope
                * amplitude
                * gains[c]
                * harmonics.iter().enumerate().map(wave).sum::<f64>();
            let slope = |(h, relative): (usize, &f64)| {
                let turn = TAU * (h + 1) as f64;
                -turn * n as f64 * relative * (turn * turns + phases[c][h]).sin()
            };
            derivative[n][c] =
                amplitude * gains[c] * harmonics.iter().enumerate().map(slope).sum::<f64>();
        }
        // From one frame to the next the phase gains the mean of both frequencies.
        let next = frequencies.get(n + 1).unwrap_or(frequency);
        turns += 0.5 * (frequency + next);
    }
    derivative
}

/// Adds a wave with a phase and a gain of its own in each channel.
pub fn add_waves(frames: &mut [[f64; TAXELS]], frequency: f64, amplitude: f64, draw: &mut Draw) {
    for c in 0..TAXELS {
        let (gain, phase) = (amplitude * draw.even(0.5, 1.5), draw.even(0.0, TAU));
        let wave = |n: usize| gain * (TAU * frequency * n as f64 + phase).cos();
        frames
            .iter_mut()
            .enumerate()
            .for_each(|(n, frame)| frame[c] += wave(n));
    }
}

/// Adds what is neither tone nor noise, with a gain of its own in each channel, and gives its
/// shapes.
pub fn add_baseline(
    frames: &mut [[f64; TAXELS]],
    extra: Extra,
    amplitude: f64,
    draw: &mut Draw,
) -> Vec<Vec<f64>> {
    let count = frames.len();
    let (place, width) = (draw.even(0.2, 0.8), draw.log(0.08, 0.25));
    let decay = draw.even(0.02, 0.05);
    let mut shapes = Vec::new();
    let mut add = |size: f64, shape: &dyn Fn(f64) -> f64, draw: &mut Draw| {
        let gains: [f64; TAXELS] =
            std::array::from_fn(|_| if draw.coin() { 1.0 } else { -1.0 } * draw.even(0.5, 1.5));
        shapes.push(
            (0..count)
                .map(|n| shape((n as f64 + 0.5) / count as f64))
                .collect::<Vec<f64>>(),
        );
        for (frame, shape) in frames.iter_mut().zip(shapes.last().into_iter().flatten()) {
            frame
                .iter_mut()
                .zip(gains)
                .for_each(|(value, gain)| *value += gain * size * amplitude * shape);
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
        Extra::Bump(size) => add(
            size,
            &|part| (-0.5 * ((part - place) / width).powi(2)).exp(),
            draw,
        ),
        // It begins in the first quarter of the window. Its length is a share of the window, as all
        // lengths here are.
        Extra::Spike(size) => add(
            size,
            &|part| {
                if part < 0.3 * place {
                    0.0
                } else {
                    (-(part - 0.3 * place) / decay).exp()
                }
            },
            draw,
        ),
        _ => {}
    }
    shapes
}
