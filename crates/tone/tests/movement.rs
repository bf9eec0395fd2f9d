//! Compares the measured phase modulation within a window with its formula: RMS wander, plain mean
//! and chirp.

mod common;

use ridgetone_tone::{Fit, Status};
use std::f64::consts::{PI, TAU};

const FRAMES: usize = 240;
const CHANNELS: usize = 16;
/// Maximum error, in standard deviations.
const SURE: f64 = 4.0;

/// Fits a tone of `cycles` cycles per window in white noise at 30 dB. `phase` is its phase
/// modulation in cycles, as a function of u from -1 to 1.
fn fit(cycles: f64, phase: &dyn Fn(f64) -> f64) -> Fit {
    fit_in(0.022, cycles, phase)
}

/// Fits the modulated tone in white noise of standard deviation `sigma`.
fn fit_in(sigma: f64, cycles: f64, phase: &dyn Fn(f64) -> f64) -> Fit {
    let mut noise = common::normal(1);
    let value = |n: usize, c: usize, noise: f64| {
        let u = place(n);
        ((TAU * (0.5 * cycles * u + phase(u)) + c as f64).cos() + sigma * noise) as f32
    };
    let values: Vec<f32> = (0..FRAMES)
        .flat_map(|n| (0..CHANNELS).map(move |c| (n, c)))
        .map(|(n, c)| value(n, c, noise()))
        .collect();
    common::fit_harmonics(&values, CHANNELS, 1)
}

/// Position of a frame in the window, from -1 to 1.
fn place(n: usize) -> f64 {
    (2.0 * n as f64 + 1.0) / FRAMES as f64 - 1.0
}

/// Returns mean and standard deviation of the frequency's deviation over the window, cycles per
/// window.
fn moves(slope: &dyn Fn(f64) -> f64) -> (f64, f64) {
    let deviations: Vec<f64> = (0..FRAMES).map(|n| 2.0 * slope(place(n))).collect();
    let mean = deviations.iter().sum::<f64>() / FRAMES as f64;
    let square = deviations
        .iter()
        .map(|deviation| (deviation - mean).powi(2))
        .sum::<f64>()
        / FRAMES as f64;
    (mean, square.sqrt())
}

#[test]
fn a_slow_wander_is_found_within_a_fifth_and_its_mean_holds() {
    for (cycles, turns, start) in [
        (21.3, 1.0, 0.0),
        (21.3, 1.0, 0.5),
        (21.3, 1.5, 0.5),
        (21.3, 2.0, 0.0),
        (40.7, 2.0, 0.25),
    ] {
        let angle = |u: f64| PI * (turns * u + start);
        let fit = fit(cycles, &|u| 0.02 * angle(u).cos());
        let (mean, wander) = moves(&|u| -0.02 * PI * turns * angle(u).sin());
        let (wander, found) = (wander / cycles, f64::from(fit.movement.wander));
        let what = format!("{cycles} {turns} {start}: {found} for {wander}, {fit:?}");
        assert!((found / wander - 1.0).abs() < 0.2, "{what}");
        let wander_sigma = f64::from(fit.movement.wander_sigma);
        assert!((found - wander).abs() < 2.0 * wander_sigma, "{what}");
        // The weighted mean frequency may differ from the plain mean by up to ten times its
        // uncertainty.
        let error = f64::from(fit.frequency) * FRAMES as f64 - (cycles + mean);
        let sigma = f64::from(fit.sigma) * FRAMES as f64;
        assert!(error.abs() < 2.0 * sigma, "{what}: {error} of {sigma}");
    }
}

/// The speed wanders at all frequencies, with the power 1 / (1 + (f / corner)^2). Corners are in
/// half cycles per window. `wander` covers the modulation that is tracked, and sigma of the mean
/// must include the rest.
#[test]
fn the_mean_counts_a_wander_that_is_not_seen() {
    let (mut holds, mut seen) = (0, 0.0);
    for (corner, size) in [(10.0, 0.003), (20.0, 0.003), (20.0, 0.01)] {
        for draw in 0..20 {
            let waves = (1..=40).map(|k| (f64::from(k), f64::from(draw * 7 + k * k * 3)));
            let of = |k: f64| size / (1.0 + (k / corner).powi(2)).sqrt();
            let phase = |u: f64| {
                waves
                    .clone()
                    .map(|(k, angle)| of(k) / (PI * k) * (PI * k * u + angle).sin())
                    .sum::<f64>()
            };
            let slope = |u: f64| {
                waves
                    .clone()
                    .map(|(k, angle)| of(k) * (PI * k * u + angle).cos())
                    .sum::<f64>()
            };
            let fit = fit(21.3, &phase);
            let (mean, wander) = moves(&slope);
            let error = f64::from(fit.frequency) * FRAMES as f64 - (21.3 + mean);
            holds += u32::from(error.abs() < 1.96 * f64::from(fit.sigma) * FRAMES as f64);
            seen += f64::from(fit.movement.wander) / (wander / 21.3) / 60.0;
        }
    }
    println!("{holds} of 60 means hold, {seen:.2} of the wander is seen");
    assert!(holds >= 54 && (0.3..0.8).contains(&seen), "{holds} {seen}");
}

#[test]
fn a_steady_tone_does_not_wander() {
    let fit = fit(21.3, &|_| 0.0);
    let movement = &fit.movement;
    assert!(
        f64::from(movement.wander) < SURE * f64::from(movement.wander_sigma),
        "{fit:?}"
    );
    assert!(movement.wander + movement.wander_sigma < 1e-3, "{fit:?}");
    assert!(
        movement.chirp.abs() < SURE as f32 * movement.chirp_sigma,
        "{fit:?}"
    );
}

#[test]
fn a_chirp_is_found_with_its_sign() {
    for size in [0.03, -0.03] {
        let fit = fit(21.3, &|u| size * u * u);
        // Second derivative of the phase, cycles per frame per frame.
        let chirp = 2.0 * size / (FRAMES as f64 / 2.0).powi(2);
        let (found, sigma) = (
            f64::from(fit.movement.chirp),
            f64::from(fit.movement.chirp_sigma),
        );
        assert!(
            (found / chirp - 1.0).abs() < 0.1 && (found - chirp).abs() < SURE * sigma,
            "{found} {sigma} for {chirp}"
        );
    }
}

/// A modulated tone can be good: the interval must cover the mean frequency even if the noise is
/// far below the modulation.
#[test]
fn beside_little_noise_what_moves_is_good_and_its_mean_holds() {
    for cycles in [4.2, 8.3, 31.7] {
        for wander in [3e-5, 5e-3] {
            // The frequency deviation is proportional to u, whose RMS is the root of a third.
            let size = wander * cycles * 3f64.sqrt() / 4.0;
            let fit = fit_in(2e-5, cycles, &|u| size * (u * u - 1.0 / 3.0));
            assert_eq!(fit.status, Status::Good, "{cycles} {wander}: {fit:?}");
            let off = f64::from(fit.frequency) * FRAMES as f64 / cycles - 1.0;
            // The constant allows for rounding to f32.
            let sigma = f64::from(fit.sigma) * FRAMES as f64 / cycles + 2e-6;
            assert!(
                off.abs() < SURE * sigma,
                "{cycles} {wander}: {off} of {sigma}"
            );
        }
    }
}
