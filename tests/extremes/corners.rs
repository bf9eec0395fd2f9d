//! Corner cases of the fit's input: any scale, a level far above the tone, few or many frames, a
//! single live channel. The error of the f32 fit must stay within [`OFF_MAX`] standard deviations
//! of the f64 reference. The seed is fixed; `cargo xtask test --fresh` draws another.

use crate::case::{Case, OFF_MAX};
use crate::properties::{config, seed};
use crate::reference::Noise;
use proptest::prelude::*;
use proptest::test_runner::{TestCaseError, TestError, TestRunner};
use ridgetone_tone::{FRAMES_MAX, Status};
use std::f64::consts::TAU;

/// Smallest sigma assumed, as a fraction of the frequency: a few units in the last place of f32,
/// because a fit cannot be closer than half a unit.
const LAST_DIGITS: f64 = 1e-6;
/// Maximum error among thousands of corners, in standard deviations.
const THOUSANDS_OFF_MAX: f64 = 6.0;
/// Minimum numbers of channels and frames with which a tone must be found.
const CLEAR: (usize, usize) = (4, 64);

/// Number of frames in the longest window, which depends on how the estimator is built.
const LONGEST: f64 = FRAMES_MAX as f64;

#[derive(Clone, Debug)]
struct Corner {
    frames: usize,
    cycles: f64,
    /// Level, in any unit, and the ratio of the level to the tone.
    level: f64,
    over_tone: f64,
    /// Ratio of amplitude to noise.
    clear: f64,
    /// Bit c: channel c is not constant.
    alive: u16,
    harmonics: u8,
    seed: u64,
}

prop_compose! {
    fn corner(longest: f64)(
        long in 0.0..1.0,
        fraction in 0.0..1.0,
        scale in -30.0..30.0,
        // Log10 of the ratio of level to tone: from 1 up to 5e6 (5 V over a tone of 1 uV).
        over in 0.0..6.7,
        // Log10 of amplitude over noise, at least 15 dB: below that, the answer depends on how the
        // channels are weighted.
        clear in 0.9..2.5,
        alive in prop_oneof![Just(u16::MAX), (0u32..16).prop_map(|c| 1 << c), 1u16..],
        harmonics in 1u8..=4,
        seed: u64,
    ) -> Corner {
        // Log-uniform in length and in frequency; all harmonics are in the band.
        let frames = (24.0 * (longest / 24.0f64).powf(long)).round();
        let (min, max) = (2.0, (0.4 / f64::from(harmonics) * frames).max(2.1));
        let cycles = min * f64::powf(max / min, fraction);
        let (level, over_tone, clear) = (10f64.powf(scale), 10f64.powf(over), 10f64.powf(clear));
        Corner { frames: frames as usize, cycles, level, over_tone, clear, alive, harmonics, seed }
    }
}

impl Corner {
    fn case(&self) -> Case {
        let mut noise = Noise::new(self.seed);
        let tone = self.level / self.over_tone;
        let mut value = |n: usize, c: usize| {
            let wave = (TAU * self.cycles * n as f64 / self.frames as f64 + c as f64).cos()
                + noise.next() / self.clear;
            let level = if c.is_multiple_of(2) {
                self.level
            } else {
                -self.level
            };
            (level
                + if self.alive & 1 << c == 0 {
                    0.0
                } else {
                    tone * wave
                }) as f32
        };
        let values = (0..self.frames)
            .map(|n| std::array::from_fn(|c| value(n, c)))
            .collect();
        Case {
            harmonics: self.harmonics,
            step: 0.0,
            ..Case::new(values)
        }
    }

    fn is_clear(&self) -> bool {
        let (channels, frames) = CLEAR;
        // If the tone spans only a few steps of f32, rounding creates harmonics.
        let is_whole = self.over_tone < 1e5;
        self.alive.count_ones() as usize >= channels && self.frames >= frames && is_whole
    }

    /// Frequency error caused by rounding the values to f32 if the noise is too small to dither it:
    /// a phase error of half a step at either end.
    fn rounding(&self) -> f64 {
        let steps = f64::from(f32::EPSILON) * self.over_tone;
        if steps * self.clear > 1.0 {
            steps / (TAU * self.frames as f64)
        } else {
            0.0
        }
    }

    fn check(&self, off_max: f64) -> Result<(), TestCaseError> {
        let case = self.case();
        let fit = case.fit();
        prop_assert!(fit.status.has_tone() || !self.is_clear(), "{fit:?}");
        if fit.status == Status::Good {
            let truth = self.cycles / self.frames as f64;
            // An error of half a bin or more means that the fit found a different tone, which other
            // files test.
            if (f64::from(fit.frequency) - truth).abs() * (self.frames as f64) < 0.5 {
                let min = (LAST_DIGITS * truth).max(self.rounding());
                let (off, _) = case.off_at_least(&fit, truth, min);
                prop_assert!(off < off_max, "{off} of the bound: {fit:?}");
            } else {
                prop_assert!(!self.is_clear(), "another line: {fit:?}");
            }
        }
        Ok(())
    }
}

fn check(cases: u32, longest: f64, seed: u64, off_max: f64) {
    println!("PROPTEST_RNG_SEED={seed}");
    match TestRunner::new(config(cases, seed)).run(&corner(longest), |corner| corner.check(off_max))
    {
        Ok(()) => {}
        Err(TestError::Fail(reason, corner)) => {
            panic!("PROPTEST_RNG_SEED={seed}: {corner:?}: {reason}")
        }
        Err(error) => panic!("PROPTEST_RNG_SEED={seed}: {error}"),
    }
}

#[test]
fn f32_is_beside_f64_in_every_corner_of_a_window() {
    check(300, 965.0, seed(), OFF_MAX);
}

#[test]
fn f32_is_beside_f64_in_every_corner_of_a_recording() {
    check(12, LONGEST, seed(), OFF_MAX);
}

/// With a strong tone of about two cycles, a refinement may explain a misfit by a curved baseline.
/// The fit must not stop there.
#[test]
fn a_strong_tone_of_few_cycles_is_at_its_maximum() {
    for frames in [965, FRAMES_MAX.min(10_012)] {
        for cycles in [1.55, 1.9, 2.02, 2.0238, 2.04, 2.1, 2.5, 3.0] {
            let corner = Corner {
                frames,
                cycles,
                level: 1.0,
                over_tone: 1.0,
                clear: 140.0,
                alive: u16::MAX,
                harmonics: 1,
                seed: 1,
            };
            corner
                .check(OFF_MAX)
                .unwrap_or_else(|error| panic!("{corner:?}: {error}"));
        }
    }
}

#[test]
#[ignore = "long: cargo xtask test --all"]
fn f32_is_beside_f64_in_thousands_of_corners() {
    check(2000, 965.0, seed(), THOUSANDS_OFF_MAX);
    check(60, LONGEST, seed(), THOUSANDS_OFF_MAX);
}

/// The rounding of a drifting level must not be taken for harmonics or for a lower fundamental,
/// regardless of where the level lies between two powers of two.
#[test]
fn the_rounding_of_a_level_is_no_tone() {
    for level in [1.1, 1.5, 1.9, 9.5e-29, 1.9e20] {
        for seed in 0..16 {
            let corner = Corner {
                frames: 4950.min(FRAMES_MAX),
                cycles: 21.0 + seed as f64 / 16.0,
                level,
                over_tone: 6.6e4,
                clear: 123.0,
                alive: 0b1000_0101_0101,
                harmonics: 3,
                seed,
            };
            corner
                .check(OFF_MAX)
                .unwrap_or_else(|error| panic!("{corner:?}: {error}"));
        }
    }
}
