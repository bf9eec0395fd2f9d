//! The honest opponent: at the maximum of a likelihood that shares no code with it, and its
//! intervals hold.

use crate::baselines::Frame;
use crate::baselines::nls::estimate;
use crate::draw::Draw;
use std::f64::consts::TAU;

#[allow(dead_code, reason = "one of its functions is for paths")]
#[path = "../../../../tests/reference/likelihood.rs"]
mod likelihood;

use likelihood::{Baseline, Likelihood};

/// Sixteen channels of one tone with two overtones, on a slope, in white noise of `noise` codes.
fn tone(frequency: f64, frames: usize, noise: f64, seed: u64) -> Vec<Frame> {
    let mut draw = Draw::new(seed);
    let phases: [[f64; 3]; 16] =
        std::array::from_fn(|_| std::array::from_fn(|_| draw.even(0.0, TAU)));
    let slopes: [f64; 16] = std::array::from_fn(|_| draw.even(-2.0, 2.0));
    let mut value = |n: usize, c: usize| {
        let wave = |h: usize| {
            (TAU * (h + 1) as f64 * frequency * n as f64 + phases[c][h]).cos() / (h + 1) as f64
        };
        (1e5 + slopes[c] * n as f64
            + 1000.0 * (0..3).map(wave).sum::<f64>()
            + noise * draw.normal())
        .round() as f32
    };
    (0..frames)
        .map(|n| std::array::from_fn(|c| value(n, c)))
        .collect()
}

/// From one cycle in the window to many, from few frames to many.
const SETTINGS: [(f64, usize); 5] = [
    (1.1 / 48.0, 48),
    (2.3 / 96.0, 96),
    (0.0346, 241),
    (0.11, 300),
    (0.0052, 940),
];

#[test]
fn it_is_at_the_maximum_of_the_likelihood_and_as_sure_as_it_is_sharp() {
    for (number, (frequency, frames)) in (0..).zip(SETTINGS) {
        let values = tone(frequency, frames, 100.0, number);
        let found = estimate(&values, 16, 4, None).expect("a tone");
        assert_eq!(found.harmonics, 3, "{frames} frames");
        let reference = Likelihood::new(&values, 3, Baseline::Line);
        let peak = reference.peak(frequency, 0.3 / frames as f64);
        let sigma = reference.sigma(peak);
        assert!(
            (found.frequency - peak).abs() < 1e-3 * sigma,
            "{frames} frames: {} {peak} {sigma}",
            found.frequency
        );
        assert!(
            (found.sigma_white / sigma - 1.0).abs() < 0.03,
            "{frames} frames: {} {sigma}",
            found.sigma_white
        );
    }
}

/// Rife and Boorstyn 1974, many cycles: var(omega) = 24 sigma^2 / (A^2 N^3) for one channel. With
/// an overtone of 1/h its information is that of the fundamental, for it turns h times as fast.
#[test]
fn its_errors_are_the_bound_and_its_intervals_hold() {
    let (frequency, frames, noise, runs) = (0.11, 200, 200.0, 200);
    let information = 3.0 * 16.0 * (1000.0f64 / noise).powi(2) * (frames as f64).powi(3) / 24.0;
    let bound = information.sqrt().recip() / TAU;
    let (mut squares, mut held) = (0.0, 0);
    for seed in 0..runs {
        let found =
            estimate(&tone(frequency, frames, noise, 100 + seed), 16, 4, None).expect("a tone");
        squares += (found.frequency - frequency).powi(2);
        held += u32::from((found.frequency - frequency).abs() <= found.half_width);
    }
    let ratio = (squares / runs as f64).sqrt() / bound;
    // Three standard deviations of the root of a chi-square of 200, and of a binomial share of 95
    // %.
    assert!((0.85..1.15).contains(&ratio), "{ratio}");
    assert!((181..=199).contains(&held), "{held}");
}

#[test]
fn what_is_no_tone_has_no_frequency() {
    let mut draw = Draw::new(3);
    let mut tones = 0;
    for _ in 0..50 {
        let noise: Vec<Frame> = (0..96)
            .map(|_| std::array::from_fn(|_| (1000.0 * draw.normal()) as f32))
            .collect();
        tones += u32::from(estimate(&noise, 16, 4, None).is_some());
        assert_eq!(estimate(&noise, 0, 4, None), None);
    }
    assert_eq!(tones, 0);
    assert_eq!(estimate(&[[7.0; 16]; 96], 16, 4, None), None);
    assert_eq!(estimate(&[], 16, 4, None), None);
    assert_eq!(
        estimate(&[[1.0; 16], [2.0; 16], [1.0; 16]], 16, 4, None),
        None
    );
}

/// A channel that does not vary, or is not a number, is left out; a known interferer is fitted.
#[test]
fn broken_channels_and_an_interferer_do_no_harm() {
    let mut values = tone(0.0346, 241, 100.0, 7);
    values.iter_mut().for_each(|frame| frame[0] = 5.0);
    values[17][1] = f32::NAN;
    for (n, frame) in values.iter_mut().enumerate() {
        frame
            .iter_mut()
            .skip(2)
            .for_each(|value| *value += 5000.0 * (TAU * 0.2053 * n as f64).cos() as f32);
    }
    let found = estimate(&values, 16, 4, Some(0.2053)).expect("a tone");
    assert!(
        (found.frequency - 0.0346).abs() < 5.0 * found.sigma && found.sigma < 1e-5,
        "{found:?}"
    );
}
