//! Tests windows that are fitted frame by frame, with some frames missing: windows too short for
//! chunks, and windows along a path.

mod common;

use common::fit_harmonics;
use ridgetone_tone::{Fitter, FrameSpan, Frames, Scene, Status};
use std::f64::consts::TAU;

const CHANNELS: usize = 16;
/// Standard deviation of the noise relative to the amplitude, for 20 dB.
const NOISE: f64 = 0.070_71;

/// Returns frames of a tone of `cycles` cycles, at positions from 0 to 1. Every ninth frame is
/// missing.
fn frames(places: &[f64], cycles: f64, seed: u64) -> Vec<f32> {
    let mut normal = common::normal(seed);
    let mut values = Vec::new();
    for (number, place) in places.iter().enumerate() {
        for channel in 0..CHANNELS {
            let value = 4.0 + (TAU * cycles * place + channel as f64).cos() + NOISE * normal();
            values.push(if number % 9 == 5 {
                f32::NAN
            } else {
                value as f32
            });
        }
    }
    values
}

/// Returns the Cramer-Rao bound of the frequency (cycles over the whole range), from sums over the
/// frames that are present. Amplitudes and phases of all channels are unknown; with many cycles
/// they are independent of the levels.
fn bound(places: &[f64]) -> f64 {
    let there: Vec<f64> = places
        .iter()
        .enumerate()
        .filter(|(number, _)| number % 9 != 5)
        .map(|(_, at)| *at)
        .collect();
    let mean = there.iter().sum::<f64>() / there.len() as f64;
    let spread: f64 = there.iter().map(|at| (at - mean).powi(2)).sum();
    NOISE / TAU / (0.5 * CHANNELS as f64 * spread).sqrt()
}

/// Fits twenty windows, asserts that they are good, and returns the RMS error relative to the
/// bound.
fn error_over_bound(places: &[f64], cycles: f64, fit: impl Fn(&[f32]) -> (Status, f64)) -> f64 {
    let square = |seed| {
        let (status, found) = fit(&frames(places, cycles, seed));
        assert_eq!(status, Status::Good, "{} frames, seed {seed}", places.len());
        ((found - cycles) / bound(places)).powi(2)
    };
    ((1..=20).map(square).sum::<f64>() / 20.0).sqrt()
}

/// Range that contains the RMS of twenty errors, relative to their standard deviation, in 99 % of
/// cases.
const NEAR_THE_BOUND: std::ops::Range<f64> = 0.6..1.4;

#[test]
fn short_windows_are_on_the_bound() {
    for count in [28usize, 31, 32, 33, 40] {
        let places: Vec<f64> = (0..count)
            .map(|number| number as f64 / count as f64)
            .collect();
        let ratio = error_over_bound(&places, 3.6, |values| {
            let fit = fit_harmonics(values, CHANNELS, 1);
            (fit.status, f64::from(fit.frequency) * count as f64)
        });
        assert!(NEAR_THE_BOUND.contains(&ratio), "{count} frames: {ratio}");
    }
}

#[test]
fn windows_along_a_path_are_on_the_bound() {
    for (count, bend) in [(100usize, 0.3), (240, 0.6), (544, -0.3)] {
        let at = |number: u32| {
            let time = f64::from(number) / (count as f64 - 1.0);
            (time + bend * time * time) / (1.0 + bend)
        };
        let places: Vec<f64> = (0..count as u32).map(at).collect();
        let ratio = error_over_bound(&places, 7.3, |values| {
            let mut source = Frames::new(values, CHANNELS).unwrap();
            let place = |number: u32| at(number) as f32;
            let span = FrameSpan::new(&mut source, 0, count as u32);
            let mut span = span.along(&place).unwrap();
            let fit = Fitter::new()
                .fit(&mut span, &Scene::with_harmonics(1))
                .unwrap();
            (fit.status, f64::from(fit.frequency))
        });
        assert!(NEAR_THE_BOUND.contains(&ratio), "{count} frames: {ratio}");
    }
}
