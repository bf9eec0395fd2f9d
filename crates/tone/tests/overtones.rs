//! Compares the overtones common to the channels with the synthesized ones.

mod common;

use common::fit_harmonics;
use ridgetone_tone::{OVERTONES, Status};
use std::f64::consts::TAU;

const CHANNELS: usize = 16;
const COUNT: usize = 400;
/// Cycles per frame.
const NU: f64 = 0.0437;
/// Standard deviation of the noise; the largest gain is about 1.
const NOISE: f64 = 0.01;

/// Returns sixteen channels that differ in gain and delay, with cos u and overtones of these
/// amplitudes and phases (turns).
fn frames(overtones: [(f64, f64); OVERTONES], seed: u64, shared: f64) -> Vec<f32> {
    let mut unit = common::normal(seed);
    let mut normal = || NOISE * unit();
    let mut out = Vec::new();
    for i in 0..COUNT {
        let disturbance = shared * normal();
        for channel in 0..CHANNELS {
            let u = NU * i as f64 + delay(channel);
            let above = overtones
                .iter()
                .zip(2..)
                .map(|((size, turns), k)| size * (TAU * (f64::from(k) * u + turns)).cos());
            let wave = (TAU * u).cos() + above.sum::<f64>();
            out.push((3.0 + gain(channel) * wave + normal() + disturbance) as f32);
        }
    }
    out
}

fn gain(channel: usize) -> f64 {
    0.2 + 0.05 * channel as f64
}

fn delay(channel: usize) -> f64 {
    0.137 * (channel * channel) as f64
}

/// Overtones in most tests: amplitude, and phase in turns.
const MADE: [(f64, f64); OVERTONES] = [(0.3, 0.1), (0.15, -0.35), (0.08, 0.45)];

fn complex(size: f64, turns: f64) -> [f64; 2] {
    [size * (TAU * turns).cos(), size * (TAU * turns).sin()]
}

/// Standard deviation of a component of the ratio. Each channel's component has 2 / N of the
/// noise's variance, and channels are weighted by their squared gains. The fundamental's noise adds
/// at most (k times the overtone's amplitude) squared of this variance.
fn sigma(number: usize, size: f64) -> f64 {
    let squares: f64 = (0..CHANNELS).map(|channel| gain(channel).powi(2)).sum();
    NOISE * (2.0 / COUNT as f64 / squares * (1.0 + (number as f64 * size).powi(2))).sqrt()
}

#[test]
fn known_ratios_come_back_within_their_noise() {
    const RUNS: u64 = 25;
    let mut squares = [0.0; OVERTONES];
    for seed in 1..=RUNS {
        let fit = fit_harmonics(&frames(MADE, seed, 0.0), CHANNELS, 4);
        assert_eq!((fit.status, fit.harmonics), (Status::Good, 4), "{seed}");
        for (n, (found, made)) in fit.overtones.iter().zip(MADE).enumerate() {
            for (found, made_part) in found.iter().zip(complex(made.0, made.1)) {
                let off = (f64::from(*found) - made_part) / sigma(n + 2, made.0);
                assert!(off.abs() < 5.0, "{seed} {n}: {off} sigma, {fit:?}");
                squares[n] += off * off / (2 * RUNS) as f64;
            }
        }
    }
    println!("mean squares over their bounds: {squares:?}");
    // The mean square of 50 values of variance 1 is known to 0.2. The bound is generous, because it
    // includes all of the fundamental's noise.
    assert!(
        squares.iter().all(|square| (0.3..1.8).contains(square)),
        "{squares:?}"
    );
}

/// Mixing the channels removes a common disturbance from the frequency, but the mixture has
/// different overtones.
#[test]
fn a_shared_disturbance_leaves_them() {
    for seed in 1..=10 {
        let (alone, disturbed) = (
            fit_harmonics(&frames(MADE, seed, 0.0), CHANNELS, 4),
            fit_harmonics(&frames(MADE, seed, 3.0), CHANNELS, 4),
        );
        assert!(disturbed.status.has_tone(), "{disturbed:?}");
        let own = (0..CHANNELS)
            .all(|c| disturbed.channels[c].residual > 2.0 * alone.channels[c].residual);
        assert!(own, "{disturbed:?}");
        for (n, (found, made)) in disturbed.overtones.iter().zip(MADE).enumerate() {
            for (found, made_part) in found.iter().zip(complex(made.0, made.1)) {
                // In the worst case the disturbance adds coherently over the channels, so its
                // variance counts once per channel.
                let sigma = sigma(n + 2, made.0) * (1.0 + 9.0 * CHANNELS as f64).sqrt();
                let off = (f64::from(*found) - made_part) / sigma;
                assert!(off.abs() < 4.0, "{seed} {n}: {disturbed:?}");
            }
        }
    }
}

#[test]
fn what_is_not_fitted_is_zero() {
    for harmonics in 1..=3 {
        let fit = fit_harmonics(&frames(MADE, 7, 0.0), CHANNELS, harmonics);
        let mut others = fit.overtones.iter().skip(harmonics as usize - 1);
        assert!(fit.harmonics <= harmonics && others.all(|o| *o == [0.0; 2]));
    }
    let noise: Vec<f32> = frames([(0.0, 0.0); OVERTONES], 3, 0.0)
        .iter()
        .enumerate()
        .map(|(i, value)| {
            let (frame, channel) = (i / CHANNELS, i % CHANNELS);
            value - (gain(channel) * (TAU * (NU * frame as f64 + delay(channel))).cos()) as f32
        })
        .collect();
    let none = fit_harmonics(&noise, CHANNELS, 4);
    assert_eq!(
        (none.status, none.overtones),
        (Status::NoTone, [[0.0; 2]; OVERTONES])
    );
}

/// Scaling by a power of two is exact.
#[test]
fn a_unit_changes_nothing() {
    let values = frames(MADE, 5, 0.0);
    let scaled: Vec<f32> = values.iter().map(|value| value * 2f32.powi(-20)).collect();
    assert_eq!(
        fit_harmonics(&values, CHANNELS, 4).overtones,
        fit_harmonics(&scaled, CHANNELS, 4).overtones
    );
}
