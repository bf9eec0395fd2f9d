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

    /// Returns a uniform integer from `min` to `max`, both included.
    pub fn whole(&mut self, min: u64, max: u64) -> u64 {
        min + self.0.next_u64() % (max - min + 1)
    }

    pub fn even(&mut self, min: f64, max: f64) -> f64 {
        min + (max - min) * self.uniform()
    }

    pub fn log(&mut self, min: f64, max: f64) -> f64 {
        min * (max / min).powf(self.uniform())
    }
}
