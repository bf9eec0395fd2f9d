//! Seeded random numbers that are the same on every platform: ChaCha8, and Gaussian ones by Box and
//! Muller with `libm`.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

/// Streams keep users of one seed apart: switching the noise off must not change the poison.
#[derive(Clone, Copy, Debug)]
#[repr(u64)]
pub(crate) enum Stream {
    ChipNoise = 1,
    Poison = 2,
    SceneNoise = 3,
    Skin = 4,
    Stimulator = 5,
}

/// A seeded generator with one spare Gaussian number (Box and Muller's come in pairs).
#[derive(Clone, Debug)]
pub(crate) struct Random {
    bits: ChaCha8Rng,
    spare: Option<f64>,
}

impl Random {
    pub(crate) fn new(seed: u64, stream: Stream) -> Self {
        let mut bits = ChaCha8Rng::seed_from_u64(seed);
        bits.set_stream(stream as u64);
        Self { bits, spare: None }
    }

    pub(crate) fn byte(&mut self) -> u8 {
        (self.bits.next_u32() >> 24) as u8
    }

    /// Uniform in 0 <= x < 1, 53 bits.
    pub(crate) fn uniform(&mut self) -> f64 {
        (self.bits.next_u64() >> 11) as f64 * (1.0 / (1u64 << 53) as f64)
    }

    /// Uniform in -1 <= x < 1.
    pub(crate) fn symmetric(&mut self) -> f64 {
        2.0 * self.uniform() - 1.0
    }

    /// Mean 0, standard deviation 1.
    pub(crate) fn gaussian(&mut self) -> f64 {
        if let Some(spare) = self.spare.take() {
            return spare;
        }
        // 1 - u is in 0 < x <= 1: the logarithm of 0 cannot happen.
        let radius = libm::sqrt(-2.0 * libm::log(1.0 - self.uniform()));
        let (sin, cos) = libm::sincos(core::f64::consts::TAU * self.uniform());
        self.spare = Some(radius * sin);
        radius * cos
    }
}
