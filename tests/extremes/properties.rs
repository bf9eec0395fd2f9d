//! Properties that the fit must have for any tone in any window.

use crate::case::Case;
use crate::reference::{Noise, codes};
use proptest::prelude::*;
use proptest::strategy::ValueTree;
use proptest::test_runner::{RngSeed, TestRunner};
use ridgetone_tone::Status;
use std::f64::consts::TAU;

#[derive(Clone, Debug)]
struct Any {
    frames: usize,
    /// Cycles per frame.
    frequency: f64,
    /// Codes.
    amplitude: f64,
    /// Ratio of amplitude to noise.
    clear: f64,
    offset: f64,
    phase: f64,
    harmonics: u8,
    seed: u64,
}

impl Any {
    fn case(&self) -> Case {
        let mut noise = Noise::new(self.seed);
        let Self {
            frequency,
            amplitude,
            clear,
            offset,
            phase,
            ..
        } = *self;
        let values = codes(self.frames, |c, t| {
            let tone = (TAU * (frequency * t + phase) + c as f64).cos();
            (offset + amplitude * (tone + noise.next() / clear)).clamp(-8_388_607.0, 8_388_606.0)
        });
        Case {
            harmonics: self.harmonics,
            ..Case::new(values)
        }
    }
}

prop_compose! {
    /// Draws frequencies log-uniformly, from `cycles` in the window to `highest` cycles per frame.
    fn any(cycles: f64, highest: f64, fewest: usize, clear: std::ops::Range<f64>, decades: std::ops::Range<f64>)(
        frames in fewest..=965,
        fraction in 0.0..1.0,
        decades in decades,
        clear in clear,
        offset in -8e6..8e6,
        phase in 0.0..1.0,
        harmonics in 1u8..=5,
        seed: u64,
    ) -> Any {
        // Log-uniform, to draw as many low frequencies as high ones.
        let lowest = cycles / frames as f64;
        let frequency = lowest * (highest / lowest).powf(fraction);
        Any { frames, frequency, amplitude: 10f64.powf(decades), clear: 10f64.powf(clear), offset, phase, harmonics, seed }
    }
}

/// Seed from `.cargo/config.toml`, the same in every run. `cargo xtask test --fresh` draws another.
pub fn seed() -> u64 {
    match ProptestConfig::default().rng_seed {
        RngSeed::Fixed(seed) => seed,
        RngSeed::Random => panic!("PROPTEST_RNG_SEED is not set: run it with cargo, which sets it"),
    }
}

pub fn config(cases: u32, seed: u64) -> ProptestConfig {
    ProptestConfig {
        cases,
        rng_seed: RngSeed::Fixed(seed),
        failure_persistence: None,
        ..ProptestConfig::default()
    }
}

proptest! {
    #![proptest_config(config(1000, seed()))]

    /// Any input must yield finite numbers: [`Case::fit`] checks every field.
    #[test]
    fn any_window_gives_finite_numbers(any in any(0.1, 0.5, 1, -1.5..4.0, -1.0..7.0), holes in 0.0..0.6, marks: u64) {
        let mut case = any.case();
        // Missing frames and taxels, from the bits of a pseudo-random sequence.
        let mut bits = marks;
        for valid in &mut case.valid {
            bits = bits.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            if ((bits >> 32) as f64) < holes * 4_294_967_296.0 {
                *valid = (bits >> 16) as u16 & (bits >> 8) as u16;
            }
        }
        case.fit();
    }

    #[test]
    fn any_interferer_gives_finite_numbers(any in any(0.1, 0.5, 16, -1.0..4.0, 0.0..6.0), cycles in -3.0f32..3.0) {
        let mut case = any.case();
        case.interferer = Some(cycles);
        case.fit();
    }
}

/// Maximum number of tones in 1,000 whose fit is not good.
const NOT_GOOD_MAX: usize = 5;

/// Tones of at least 15 dB (amplitude 8 times the noise) and two cycles.
#[test]
fn clear_tones_are_found_where_they_are() {
    let mut runner = TestRunner::new(config(1, seed()));
    let strategy = any(2.0, 0.45, 24, 0.9..2.0, 2.0..5.5);
    let mut not_good = Vec::new();
    for _ in 0..1000 {
        let any = strategy.new_tree(&mut runner).unwrap().current();
        let any = Any {
            offset: any.offset / 2.0,
            ..any
        };
        let fit = any.case().fit();
        if fit.status == Status::Good {
            let off = (fit.frequency as f64 - any.frequency).abs() / fit.sigma as f64;
            assert!(off < 6.0, "{off} sigma: {any:?}: {fit:?}");
        } else {
            not_good.push((any, fit));
        }
    }
    assert!(
        not_good.len() <= NOT_GOOD_MAX,
        "{} of 1,000, such as {:?}",
        not_good.len(),
        not_good[0]
    );
}
