//! Synthetic windows in f64, and a fit in f64 that shares no code with the fit under test.
// Each test uses a part of this module.
#![allow(unused_imports)]

mod likelihood;

pub use likelihood::{Baseline, Likelihood};

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use std::f64::consts::TAU;

/// A window of sixteen channels with one tone.
#[derive(Clone, Debug)]
pub struct Tone {
    /// Cycles per frame.
    pub frequency: f64,
    pub frames: usize,
    /// Amplitude of the fundamental, codes.
    pub amplitude: f64,
    /// Number of harmonics, including the fundamental.
    pub harmonics: usize,
    /// Amplitudes of harmonics 2 to 4, relative to the fundamental's.
    pub overtones: [f64; 3],
    /// Standard deviation of the noise, codes.
    pub noise: f64,
    pub seed: u64,
}

impl Default for Tone {
    fn default() -> Self {
        Self {
            frequency: 0.0346,
            frames: 241,
            amplitude: 1000.0,
            harmonics: 1,
            overtones: [0.5, 0.3, 0.2],
            noise: 100.0,
            seed: 1,
        }
    }
}

/// Truth of one channel; the phase is that of a cosine at the window's centre.
#[derive(Clone, Copy, Debug)]
pub struct Truth {
    pub amplitude: f64,
    pub offset: f64,
    pub phase_rad: f64,
}

impl Tone {
    /// Returns a tone without overtones, with the default amplitude.
    pub fn new(frequency: f64, frames: usize, noise: f64, seed: u64) -> Self {
        Self {
            frequency,
            frames,
            noise,
            seed,
            ..Self::default()
        }
    }

    fn uniform(&self, stream: u64) -> ChaCha8Rng {
        let mut rng = ChaCha8Rng::seed_from_u64(self.seed);
        rng.set_stream(stream);
        rng
    }

    pub fn channel(&self, c: usize) -> Truth {
        let mut rng = self.uniform(100 + c as u64);
        let sign = if c.is_multiple_of(2) { 1.0 } else { -1.0 };
        Truth {
            amplitude: self.amplitude,
            offset: (sign * 4e6 * unit(&mut rng)).round(),
            phase_rad: TAU * unit(&mut rng),
        }
    }

    pub fn values(&self) -> Vec<[f32; 16]> {
        let mut noise = Noise(self.uniform(0));
        let channels: Vec<_> = (0..16).map(|c| self.channel(c)).collect();
        codes(self.frames, |c, t| {
            let Truth {
                amplitude,
                offset,
                phase_rad,
            } = channels[c];
            let theta = TAU * self.frequency * t + phase_rad;
            let mut wave = theta.cos();
            for h in 2..=self.harmonics {
                wave += self.overtones[h - 2] * (h as f64 * theta + (c * h) as f64).cos();
            }
            offset + amplitude * wave + self.noise * noise.next()
        })
    }
}

/// Returns the codes of sixteen channels; `of` returns the value of a channel at a time in frames
/// from the window's centre.
pub fn codes(frames: usize, mut of: impl FnMut(usize, f64) -> f64) -> Vec<[f32; 16]> {
    let centre = 0.5 * (frames as f64 - 1.0);
    let mut frame = |n: usize| {
        let mut values = [0.0; 16];
        for (c, value) in values.iter_mut().enumerate() {
            *value = of(c, n as f64 - centre).round() as f32;
        }
        values
    };
    (0..frames).map(&mut frame).collect()
}

/// Gaussian noise with a standard deviation of one.
pub struct Noise(ChaCha8Rng);

impl Noise {
    pub fn new(seed: u64) -> Self {
        Self(ChaCha8Rng::seed_from_u64(seed))
    }

    pub fn next(&mut self) -> f64 {
        normal(&mut self.0)
    }
}

pub fn unit(rng: &mut ChaCha8Rng) -> f64 {
    (rng.next_u64() >> 11) as f64 / (1u64 << 53) as f64
}

pub fn normal(rng: &mut ChaCha8Rng) -> f64 {
    (-2.0 * (1.0 - unit(rng)).ln()).sqrt() * (TAU * unit(rng)).cos()
}
