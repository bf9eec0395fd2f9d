//! Seeded random numbers, the same on every platform.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

pub struct Draw(ChaCha8Rng);

impl Draw {
    pub fn new(seed: u64) -> Self {
        Self(ChaCha8Rng::seed_from_u64(seed))
    }

    fn uniform(&mut self) -> f64 {
        (self.0.next_u64() >> 11) as f64 / (1u64 << 53) as f64
    }

    pub fn coin(&mut self) -> bool {
        self.uniform() < 0.5
    }

    /// A whole number, both ends included.
    pub fn whole(&mut self, least: u64, most: u64) -> u64 {
        least + self.0.next_u64() % (most - least + 1)
    }

    pub fn even(&mut self, least: f64, most: f64) -> f64 {
        least + (most - least) * self.uniform()
    }

    /// Gaussian, mean 0, variance 1 (Box and Muller).
    pub fn normal(&mut self) -> f64 {
        let (radius, angle) = (
            -2.0 * libm::log(1.0 - self.uniform()),
            std::f64::consts::TAU * self.uniform(),
        );
        radius.sqrt() * libm::cos(angle)
    }

    /// From `least` to `most`, evenly in the logarithm: as many short ones as long ones.
    pub fn log(&mut self, least: f64, most: f64) -> f64 {
        least * (most / least).powf(self.uniform())
    }
}
