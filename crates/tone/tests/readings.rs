//! Tests windows with two interpretations: the right one must be reported, and the other named if
//! both explain the window.

mod common;

use common::{RATE_HZ, even, fit_scene, normal};
use ridgetone_tone::{CHANNELS_MAX, Fit, Scene, Status};
use std::f64::consts::TAU;

/// Amplitudes of the harmonics of ridges.
const RIDGES: [f64; 4] = [1.0, 0.4, 0.2, 0.1];

/// Returns a window in all channels, with different gains and phases. The noise is 20 dB below a
/// fundamental of amplitude 1.
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

/// Fits all channels; the frequency is in cycles per window.
fn fit(values: &[f64], step: f32) -> Fit {
    let frames = (values.len() / CHANNELS_MAX) as f32;
    fit_scene(&as_f32(values), CHANNELS_MAX, &Scene::DEFAULT, |span| {
        span.with_frame_rate(frames).with_quantization(step)
    })
}

/// The lines around a decaying tone must not be taken for harmonics of a third of its frequency.
#[test]
fn a_tone_that_decays_is_not_reported_at_a_fraction_of_its_frequency() {
    const FRAMES: usize = 200;
    let mut right = 0;
    for seed in 0..30 {
        let (mut even, mut normal) = (even(seed + 70), normal(seed + 71));
        for _ in 0..5 {
            even();
        }
        let (cycles, decay, phase) = (3.6 + 0.8 * even(), 0.3 + 1.7 * even(), even());
        let value = |frame: usize, noise: f64| {
            let t = frame as f64 / FRAMES as f64;
            (-decay * t).exp() * (TAU * (cycles * t + phase)).cos() + 0.0035 * noise
        };
        let values: Vec<f64> = (0..FRAMES).map(|frame| value(frame, normal())).collect();
        let fit = fit_scene(&as_f32(&values), 1, &Scene::DEFAULT, |span| {
            span.with_frame_rate(FRAMES as f32)
        });
        let off = (f64::from(fit.frequency) / cycles - 1.0).abs();
        right += u32::from(off < 0.03);
        assert!(
            fit.status != Status::Good || off < 0.01,
            "{cycles}: {fit:?}"
        );
        let is_named = fit.other_tone.is_some();
        assert!(fit.status != Status::Ambiguous || is_named, "{fit:?}");
    }
    println!("{right} of 30 right");
    assert!(right >= 24, "{right} of 30");
}

/// If a tone is subtracted as hum, its second harmonic remains, and must not be taken for the tone.
#[test]
fn a_tone_next_to_mains_is_not_good_at_twice_its_frequency() {
    for (tone_hz, is_hidden) in [
        (49.0, true),
        (49.7, true),
        (50.2, true),
        (51.0, true),
        (17.0, false),
        (36.0, false),
    ] {
        for seed in 0..5 {
            let values = window(120, tone_hz * 120.0 / RATE_HZ, &RIDGES[..2], seed);
            let fit = fit_scene(&as_f32(&values), CHANNELS_MAX, &Scene::DEFAULT, |span| {
                span.with_frame_rate(RATE_HZ as f32)
                    .with_interferer((50.0 / RATE_HZ) as f32)
            });
            let off = (f64::from(fit.frequency) - tone_hz).abs();
            let is_good = fit.status == Status::Good;
            assert!(!is_good || off < 0.5, "{tone_hz}: {fit:?}");
            assert!(is_good || is_hidden, "{tone_hz}: {fit:?}");
        }
    }
}

/// Declaring a coarse quantization step must not change the error.
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

/// The window has more frames than the transform has points.
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
        // An f32 resolves a frequency to 6e-8 of its value.
        let sigma = f64::from(fit.sigma).max(3e-8);
        assert_eq!(fit.status, Status::Good, "{per_frame}: {fit:?}");
        assert!(off < 4.0 * sigma && sigma < 1e-6, "{per_frame}: {fit:?}");
    }
}
