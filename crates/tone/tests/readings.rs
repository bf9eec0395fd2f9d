//! Windows with two readings: the right one is reported, and the other one is named where both
//! explain the window.

mod common;

use common::{even, fit_scene, normal};
use ridgetone_tone::{CHANNELS_MAX, Fit, Scene, Status};
use std::f64::consts::TAU;

/// Amplitudes of the ridges' harmonics.
const RIDGES: [f64; 4] = [1.0, 0.4, 0.2, 0.1];

/// A window in all channels, with gains and phases of their own; noise 20 dB below a fundamental of
/// amplitude 1.
fn window(frames: usize, cycles: f64, harmonics: &[f64], seed: u64) -> Vec<f64> {
    let (mut even, mut normal) = (even(seed), normal(seed + 1000));
    let gains: Vec<f64> = (0..CHANNELS_MAX).map(|_| 0.5 + even()).collect();
    let phases: Vec<f64> = (0..CHANNELS_MAX * harmonics.len())
        .map(|_| even())
        .collect();
    let mut values = Vec::new();
    for frame in 0..frames {
        let t = frame as f64 / frames as f64;
        for (channel, gain) in gains.iter().enumerate() {
            let lines = (1..).zip(harmonics).map(|(number, amplitude)| {
                let phase = phases[channel * harmonics.len() + number - 1];
                amplitude * (TAU * (number as f64 * cycles * t + phase)).cos()
            });
            values.push(gain * lines.sum::<f64>() + 0.0707 * normal());
        }
    }
    values
}

fn as_f32(values: &[f64]) -> Vec<f32> {
    values.iter().map(|value| *value as f32).collect()
}

/// A fit of all channels in cycles a window.
fn fit(values: &[f64], step: f32) -> Fit {
    let frames = (values.len() / CHANNELS_MAX) as f32;
    fit_scene(&as_f32(values), CHANNELS_MAX, &Scene::DEFAULT, |span| {
        span.with_frame_rate(frames).with_quantization(step)
    })
}

/// A coarse step that is declared costs nothing.
#[test]
fn a_declared_step_leaves_the_error_as_it_is() {
    const STEP: f64 = 0.33;
    for frames in [96, 241, 940] {
        let mut squares = [0.0; 2];
        for seed in 0..20 {
            let cycles = 2.1 + 0.5 * seed as f64;
            let values = window(frames, cycles, &RIDGES, seed);
            let rounded = values.iter().map(|value| (value / STEP).round() * STEP);
            let rounded: Vec<f64> = rounded.collect();
            for (square, step) in squares.iter_mut().zip([0.0, STEP as f32]) {
                let off = f64::from(fit(&rounded, step).frequency) - cycles;
                *square += off * off;
            }
        }
        let ratio = (squares[1] / squares[0]).sqrt();
        assert!((0.8..1.25).contains(&ratio), "{frames} frames: {ratio}");
    }
}

/// More frames than a transform has points.
#[test]
fn long_windows_have_tones_up_to_half_the_frame_rate() {
    const FRAMES: usize = 57_142;
    for per_frame in [0.031, 0.13, 0.26, 0.37, 0.46] {
        let (mut normal, mut values) = (normal(5), Vec::new());
        for frame in 0..FRAMES {
            for channel in 0..2 {
                let turns = per_frame * frame as f64 + 0.2 * f64::from(channel);
                values.push((TAU * turns).cos() + normal());
            }
        }
        let fit = fit_scene(&as_f32(&values), 2, &Scene::with_harmonics(1), |span| span);
        let off = (f64::from(fit.frequency) - per_frame).abs();
        // f32 writes a frequency to 6e-8 of itself.
        let sigma = f64::from(fit.sigma).max(3e-8);
        assert_eq!(fit.status, Status::Good, "{per_frame}: {fit:?}");
        assert!(off < 4.0 * sigma && sigma < 1e-6, "{per_frame}: {fit:?}");
    }
}
