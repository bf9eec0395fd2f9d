//! Windows made in f64, and a fit in f64 that shares no code with the one under test.

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
    /// Harmonics, the fundamental included.
    pub harmonics: usize,
    /// Amplitudes of the second to fourth over that of the fundamental.
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

/// One channel's truth; the phase is that of a cosine at the window's centre.
#[derive(Clone, Copy, Debug)]
pub struct Truth {
    pub amplitude: f64,
    pub offset: f64,
    pub phase_rad: f64,
}

impl Tone {
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
        let mut noise = self.uniform(0);
        let channels: Vec<_> = (0..16).map(|c| self.channel(c)).collect();
        let centre = 0.5 * (self.frames as f64 - 1.0);
        (0..self.frames)
            .map(|n| {
                let mut frame = [0.0; 16];
                for (c, value) in frame.iter_mut().enumerate() {
                    let Truth { amplitude, offset, phase_rad } = channels[c];
                    let theta = TAU * self.frequency * (n as f64 - centre) + phase_rad;
                    let mut wave = theta.cos();
                    for h in 2..=self.harmonics {
                        wave += self.overtones[h - 2] * (h as f64 * theta + (c * h) as f64).cos();
                    }
                    *value = (offset + amplitude * wave + self.noise * normal(&mut noise)).round() as f32;
                }
                frame
            })
            .collect()
    }
}

pub fn unit(rng: &mut ChaCha8Rng) -> f64 {
    (rng.next_u64() >> 11) as f64 / (1u64 << 53) as f64
}

pub fn normal(rng: &mut ChaCha8Rng) -> f64 {
    (-2.0 * (1.0 - unit(rng)).ln()).sqrt() * (TAU * unit(rng)).cos()
}

/// Frequency, cycles per frame, where the likelihood with unknown noise in every channel is
/// greatest, within half a bin of `near`: golden section over sums of logarithms of residuals.
pub fn log_likelihood_peak(values: &[[f32; 16]], near: f64, harmonics: usize, slope: bool) -> f64 {
    let centre = 0.5 * (values.len() as f64 - 1.0);
    let places: Vec<f64> = (0..values.len()).map(|k| k as f64 - centre).collect();
    peak_along(values, &places, near, 0.4 / values.len() as f64, harmonics, slope)
}

/// The same along a path, in cycles per unit of `places`, within `reach` of `near`.
pub fn peak_along(values: &[[f32; 16]], places: &[f64], near: f64, reach: f64, harmonics: usize, slope: bool) -> f64 {
    let cost = |f: f64| (0..16).map(|c| residual(values, places, c, f, harmonics, slope).ln()).sum::<f64>();
    let (mut a, mut b) = (near - reach, near + reach);
    let ratio = (5f64.sqrt() - 1.0) / 2.0;
    for _ in 0..60 {
        let (x, y) = (b - ratio * (b - a), a + ratio * (b - a));
        if cost(x) < cost(y) { b = y } else { a = x }
    }
    0.5 * (a + b)
}

/// Residual sum of squares of one channel after a least-squares fit at frequency `f`: modified
/// Gram-Schmidt on the columns.
fn residual(values: &[[f32; 16]], places: &[f64], c: usize, f: f64, harmonics: usize, slope: bool) -> f64 {
    let mut columns: Vec<Vec<f64>> = vec![vec![1.0; values.len()]];
    if slope {
        columns.push(places.to_vec());
    }
    for h in 1..=harmonics {
        columns.push(places.iter().map(|place| (TAU * f * h as f64 * place).cos()).collect());
        columns.push(places.iter().map(|place| (TAU * f * h as f64 * place).sin()).collect());
    }
    let mut rest: Vec<f64> = values.iter().map(|frame| frame[c] as f64).collect();
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let mut basis: Vec<Vec<f64>> = Vec::new();
    for mut column in columns {
        for _ in 0..2 {
            for unit in &basis {
                let along = dot(&column, unit);
                column.iter_mut().zip(unit).for_each(|(x, u)| *x -= along * u);
            }
        }
        let length = dot(&column, &column).sqrt();
        column.iter_mut().for_each(|x| *x /= length);
        let along = dot(&rest, &column);
        rest.iter_mut().zip(&column).for_each(|(x, u)| *x -= along * u);
        basis.push(column);
    }
    dot(&rest, &rest)
}
