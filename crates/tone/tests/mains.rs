//! Tests mains hum ten times as strong as the tone.

mod common;

use common::{even, fit_with, normal};
use ridgetone_tone::{Fit, Status};
use std::f64::consts::TAU;

const CHANNELS: usize = 16;
const FRAMES: usize = 241;

/// Fits a tone in codes, 17 dB above white noise, with declared hum at `hum` cycles per frame.
fn fit(cycles: f64, hum: f64, seed: u64) -> Fit {
    let (mut even, mut normal) = (even(seed), normal(1000 + seed));
    let phases: Vec<f64> = (0..CHANNELS).map(|_| even()).collect();
    let mut values = Vec::new();
    for frame in 0..FRAMES {
        for (channel, phase) in phases.iter().enumerate() {
            let tone = (TAU * (cycles * frame as f64 / FRAMES as f64 + phase)).cos();
            let hum = (TAU * hum * frame as f64 + channel as f64).cos();
            let value = 1e6 * phase + 1e3 * tone + 1e4 * hum + 100.0 * normal();
            values.push(value.round() as f32);
        }
    }
    fit_with(&values, CHANNELS, |span| {
        span.with_quantization(1.0).with_interferer(hum as f32)
    })
}

/// Hum aliased to zero or half the frame rate must not cost part of the tone.
#[test]
fn hum_that_folds_onto_zero_or_half_the_frame_rate_takes_nothing_of_the_tone() {
    for hum in [1.0, 0.5] {
        for seed in 0..20 {
            for cycles in [8.34, 26.5] {
                let fit = fit(cycles, hum, seed);
                assert_eq!(fit.status, Status::Good, "{hum}, {cycles}: {fit:?}");
                assert!(
                    (f64::from(fit.frequency) - cycles).abs() < 0.02,
                    "{hum}, {cycles}: {fit:?}"
                );
            }
        }
    }
}
