//! Synthetic windows, and random numbers that are the same in every run.
// Each test program uses a part of this module.
#![allow(dead_code)]

use ridgetone_tone::{Fit, Fitter, FrameSpan, Frames, Scene};

pub const RATE_HZ: f64 = 241.14;

/// Returns uniform numbers from 0 to 1, from a linear congruential generator (D. E. Knuth, MMIX).
pub fn even(seed: u64) -> impl FnMut() -> f64 {
    let mut state = seed;
    move || {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (state >> 40) as f64 / (1 << 24) as f64
    }
}

/// Returns nearly normal numbers with mean 0 and variance 1: sums of twelve uniform numbers.
pub fn normal(seed: u64) -> impl FnMut() -> f64 {
    let mut even = even(seed);
    move || (0..12).map(|_| even()).sum::<f64>() - 6.0
}

/// Fits frames with at most `harmonics` harmonics; the frequency is in cycles per frame.
pub fn fit_harmonics(values: &[f32], channels: usize, harmonics: u8) -> Fit {
    fit_scene(
        values,
        channels,
        &Scene::with_harmonics(harmonics),
        |span| span,
    )
}

/// Fits frames in a scene, with the options that `known` sets; the frequency is in cycles per
/// frame.
pub fn fit_scene(
    values: &[f32],
    channels: usize,
    scene: &Scene,
    known: impl FnOnce(FrameSpan<'_>) -> FrameSpan<'_>,
) -> Fit {
    let mut frames = Frames::new(values, channels).expect("1 to 16 channels");
    let count = frames.count();
    let mut span = known(FrameSpan::new(&mut frames, 0, count));
    Fitter::new()
        .fit(&mut span, scene)
        .expect("its frames are there")
}

/// Fits frames with the options that `known` sets; the frequency is in cycles per window.
pub fn fit_with(
    values: &[f32],
    channels: usize,
    known: impl FnOnce(FrameSpan<'_>) -> FrameSpan<'_>,
) -> Fit {
    let count = (values.len() / channels) as f32;
    fit_scene(values, channels, &Scene::DEFAULT, |span| {
        known(span.with_frame_rate(count))
    })
}

/// Fits frames; the frequency is in cycles per window.
pub fn fit(values: &[f32], channels: usize) -> Fit {
    fit_with(values, channels, |span| span)
}

/// Fits a converter's codes; the frequency is in cycles per window.
pub fn fit_codes(values: &[f32], channels: usize) -> Fit {
    fit_with(values, channels, |span| span.with_quantization(1.0))
}
