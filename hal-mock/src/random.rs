//! Seeded random numbers that are the same on every platform: ChaCha8, and Gaussian numbers by the
//! Box-Muller method with `libm`. Without the feature `scenes`, which brings both crates, the
//! numbers come from SplitMix64 and the standard library instead, and differ.

#[cfg(feature = "scenes")]
use rand_chacha::{
    ChaCha8Rng as Bits,
    rand_core::{Rng, SeedableRng},
};

/// SplitMix64 (Steele, Lea and Flood 2014).
#[cfg(not(feature = "scenes"))]
#[derive(Clone, Debug)]
struct Bits(u64);

#[cfg(not(feature = "scenes"))]
impl Bits {
    fn next_u64(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mixed = (self.0 ^ self.0 >> 30).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let mixed = (mixed ^ mixed >> 27).wrapping_mul(0x94D0_49BB_1331_11EB);
        mixed ^ mixed >> 31
    }

    fn next_u32(&mut self) -> u32 {
        (self.next_u64() >> 32) as u32
    }
}

/// Independent streams of one seed: switching the noise off must not change the poison.
#[derive(Clone, Copy, Debug)]
#[cfg_attr(not(feature = "scenes"), allow(dead_code, reason = "for scenes"))]
#[repr(u64)]
pub(crate) enum Stream {
    ChipNoise = 1,
    Poison = 2,
    SceneNoise = 3,
    Skin = 4,
    Stimulator = 5,
}

/// A seeded generator with one spare Gaussian number (Box-Muller produces pairs).
#[derive(Clone, Debug)]
pub(crate) struct Random {
    bits: Bits,
    spare: Option<f64>,
}

impl Random {
    pub(crate) fn new(seed: u64, stream: Stream) -> Self {
        #[cfg(feature = "scenes")]
        let bits = {
            let mut bits = Bits::seed_from_u64(seed);
            bits.set_stream(stream as u64);
            bits
        };
        #[cfg(not(feature = "scenes"))]
        let bits = Bits(seed ^ (stream as u64) << 56);
        Self { bits, spare: None }
    }

    pub(crate) fn byte(&mut self) -> u8 {
        (self.bits.next_u32() >> 24) as u8
    }

    /// Draws a number uniform in 0 <= x < 1, with 53 bits.
    pub(crate) fn uniform(&mut self) -> f64 {
        (self.bits.next_u64() >> 11) as f64 * (1.0 / (1u64 << 53) as f64)
    }

    /// Draws a number uniform in -1 <= x < 1.
    #[cfg(feature = "scenes")]
    pub(crate) fn symmetric(&mut self) -> f64 {
        2.0 * self.uniform() - 1.0
    }

    /// Draws a Gaussian number with mean 0 and standard deviation 1.
    pub(crate) fn gaussian(&mut self) -> f64 {
        if let Some(spare) = self.spare.take() {
            return spare;
        }
        // 1 - u is in 0 < x <= 1, so the logarithm is finite.
        let (left, turn) = (
            1.0 - self.uniform(),
            core::f64::consts::TAU * self.uniform(),
        );
        #[cfg(feature = "scenes")]
        let (log, (sin, cos)) = (libm::log(left), libm::sincos(turn));
        #[cfg(not(feature = "scenes"))]
        let (log, (sin, cos)) = (left.ln(), turn.sin_cos());
        let radius = (-2.0 * log).sqrt();
        self.spare = Some(radius * sin);
        radius * cos
    }
}
