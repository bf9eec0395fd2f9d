//! Harmonics above half the frame rate, which are seen at their images.

mod common;

use common::{fit, normal};
use ridgetone_estimator::Status;
use std::f64::consts::TAU;

const CHANNELS: usize = 16;
const FRAMES: usize = 240;

/// A tone whose channels have one wave, each at its own time.
fn window(cycles: f64, harmonics: [f64; 4], noise: f64) -> Vec<f32> {
    let mut normal = normal((cycles * 1e9) as u64);
    let mut values = Vec::new();
    for frame in 0..FRAMES {
        let t = (frame as f64 + 0.5) / FRAMES as f64 - 0.5;
        for channel in 0..CHANNELS {
            let turns = cycles * t + 0.11 * channel as f64;
            let waves = harmonics
                .iter()
                .zip(1..)
                .map(|(a, h)| a * (TAU * f64::from(h) * turns + f64::from(h)).cos());
            values.push((waves.sum::<f64>() + noise * normal()) as f32);
        }
    }
    values
}

/// From 8 to 118 cycles a window of 240 frames: most overtones are above half the frame rate. They
/// are lines of the tone, and a comb of a lower frequency through their images is no reading of it.
/// Bar: one of a hundred is wrong and good, two thirds are good beside hardly any noise and five
/// sixths beside some.
#[test]
fn overtones_above_half_the_frame_rate_are_the_tones_own() {
    for harmonics in [
        [1.0, 0.1, 0.05, 0.02],
        [1.0, 0.2, 0.2, 0.1],
        [1.0, 0.5, 0.33, 0.25],
    ] {
        for (noise, least) in [(0.001, 200), (0.03, 250)] {
            let (mut good, mut wrong) = (0, 0);
            for number in 0..300 {
                let cycles = 8.0 + 0.367 * f64::from(number);
                let fit = fit(&window(cycles, harmonics, noise), CHANNELS);
                let is_good = fit.status == Status::Good;
                good += u32::from(is_good);
                let is_off = (f64::from(fit.frequency) - cycles).abs() > 0.5;
                wrong += u32::from(is_good && is_off);
            }
            assert!(
                wrong <= 3 && good >= least,
                "{harmonics:?}, noise {noise}: {good} good, {wrong} of them wrong"
            );
        }
    }
}

/// Fast for its frame rate: the second and the third harmonic are folded onto places of their own.
#[test]
fn a_tone_near_half_the_frame_rate_has_overtones() {
    for number in 0..20 {
        let cycles = 82.6 + 0.31 * f64::from(number);
        let fit = fit(&window(cycles, [1.0, 0.4, 0.2, 0.0], 0.1), CHANNELS);
        assert_eq!(fit.status, Status::Good, "{cycles}: {fit:?}");
        assert!(
            (f64::from(fit.frequency) - cycles).abs() < 4.0 * f64::from(fit.sigma),
            "{cycles}: {fit:?}"
        );
        assert!(fit.harmonics >= 3, "{cycles}: {fit:?}");
    }
}
