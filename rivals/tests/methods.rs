//! Every method on clean tones, on what is no tone, and against the bound.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use rivals::{Frame, Method, Scratch};
use std::f64::consts::TAU;

/// The paper's 8.33 Hz at 241.14 frames per second, cycles per frame.
const FREQUENCY: f64 = 8.3333 / 241.14;

/// Normal numbers by Box and Muller.
struct Noise(ChaCha8Rng);

impl Noise {
    fn new(seed: u64) -> Self {
        Self(ChaCha8Rng::seed_from_u64(seed))
    }

    fn uniform(&mut self) -> f64 {
        (self.0.next_u64() >> 11) as f64 / (1u64 << 53) as f64
    }

    fn normal(&mut self) -> f64 {
        (-2.0 * (1.0 - self.uniform()).ln()).sqrt() * (TAU * self.uniform()).cos()
    }
}

/// Sixteen channels of one tone of 1000 codes with any phase, on offsets up to 2^23, in whole codes.
fn tone(frequency: f64, frames: usize, sigma: f64, seed: u64) -> Vec<Frame> {
    let mut noise = Noise::new(seed);
    let channels: [(f64, f64); 16] = std::array::from_fn(|_| ((noise.uniform() - 0.5) * 1.6e7, noise.uniform() * TAU));
    let value = |n: usize, (offset, phase): (f64, f64), noise: &mut Noise| {
        offset + 1000.0 * (TAU * frequency * n as f64 + phase).sin() + sigma * noise.normal()
    };
    (0..frames).map(|n| channels.map(|channel| value(n, channel, &mut noise).round() as f32)).collect()
}

/// Root mean square of the errors, in cycles per window, and how many windows gave none.
fn errors(method: Method, channels: usize, frames: usize, sigma: f64, runs: u64) -> (f64, u64) {
    let mut scratch = Scratch::new();
    let (mut sum, mut none) = (0.0, 0);
    for seed in 0..runs {
        match method.estimate(&tone(FREQUENCY, frames, sigma, seed), channels, &mut scratch) {
            Some(found) => sum += ((f64::from(found) - FREQUENCY) * frames as f64).powi(2),
            None => none += 1,
        }
    }
    ((sum / (runs - none) as f64).sqrt(), none)
}

#[test]
fn survey() {
    for frames in [48, 96, 145, 241] {
        for channels in [1, 2, 16] {
            for sigma in [0.0, 70.7] {
                for method in Method::ALL {
                    let t = std::time::Instant::now();
                    let (rms, none) = errors(method, channels, frames, sigma, 40);
                    println!("{frames} {channels} {sigma} {:20} {rms:.6} {none} {:?}", method.name(), t.elapsed() / 40);
                }
            }
        }
    }
}
