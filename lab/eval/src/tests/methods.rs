//! Every method on clean tones, on what is no tone, and against the bound.

use crate::baselines::{Frame, Method, Scratch};
use crate::draw::Draw;
use std::f64::consts::TAU;

/// The paper's 8.33 Hz at 241.14 frames per second, cycles per frame.
const FREQUENCY: f64 = 8.3333 / 241.14;

/// Sixteen channels of one tone of 1000 codes with any phase, on offsets up to 2^23, in whole
/// codes.
fn tone(frequency: f64, frames: usize, sigma: f64, seed: u64) -> Vec<Frame> {
    let mut noise = Draw::new(seed);
    let channels: [(f64, f64); 16] =
        std::array::from_fn(|_| (noise.even(-0.8e7, 0.8e7), noise.even(0.0, TAU)));
    let value = |n: usize, (offset, phase): (f64, f64), noise: &mut Draw| {
        offset + 1000.0 * (TAU * frequency * n as f64 + phase).sin() + sigma * noise.normal()
    };
    (0..frames)
        .map(|n| channels.map(|channel| value(n, channel, &mut noise).round() as f32))
        .collect()
}

/// Root mean square of the errors, in cycles per window, and how many windows gave none.
fn errors(method: Method, channels: usize, frames: usize, sigma: f64, runs: u64) -> (f64, u64) {
    let mut scratch = Scratch::EMPTY;
    let (mut sum, mut none) = (0.0, 0);
    for seed in 0..runs {
        match method.estimate(
            &tone(FREQUENCY, frames, sigma, seed),
            channels,
            &mut scratch,
        ) {
            Some(found) => sum += ((f64::from(found) - FREQUENCY) * frames as f64).powi(2),
            None => none += 1,
        }
    }
    ((sum / (runs - none) as f64).sqrt(), none)
}

/// How far from the truth without noise, cycles per window: the periodogram's half line, and what
/// rounding to codes does to a least-squares fit.
fn tolerance(method: Method) -> f64 {
    match method {
        Method::Periodogram => 0.5 * 241.0 / 256.0,
        Method::Ieee1057 | Method::Oddo2009 => 1e-4,
    }
}

#[test]
fn every_method_finds_a_clean_tone() {
    let mut scratch = Scratch::EMPTY;
    for method in Method::ALL {
        for channels in [1, 2, 16] {
            for seed in 0..10 {
                let values = tone(FREQUENCY, 241, 0.0, seed);
                let found = method
                    .estimate(&values, channels, &mut scratch)
                    .expect("a tone");
                let off = (f64::from(found) - FREQUENCY) * 241.0;
                assert!(
                    off.abs() < tolerance(method),
                    "{method:?}, {channels} channels, seed {seed}: {off}"
                );
            }
        }
    }
}

#[test]
fn the_fits_work_at_the_ends_of_the_band_and_of_the_windows() {
    let mut scratch = Scratch::EMPTY;
    let fits = [Method::Ieee1057, Method::Oddo2009];
    for (frequency, frames) in [
        (0.41, 940),
        (0.4567, 241),
        (0.0152, 964),
        (0.2501, 1024),
        (0.11, 24),
    ] {
        for method in fits {
            let values = tone(frequency, frames, 0.0, 5);
            let found = method.estimate(&values, 2, &mut scratch).expect("a tone");
            let off = (f64::from(found) - frequency) * frames as f64;
            assert!(
                off.abs() < 5e-4,
                "{method:?}, {frequency} in {frames} frames: {off}"
            );
        }
    }
}

#[test]
fn the_fits_are_on_their_bound() {
    // 20 dB: A^2 / 2 is a hundred times the variance.
    let (frames, sigma) = (241, 1000.0 / 200f64.sqrt());
    for (method, channels) in [
        (Method::Ieee1057, 1),
        (Method::Ieee1057, 16),
        (Method::Oddo2009, 2),
    ] {
        // Rife and Boorstyn 1974 for one channel, with many cycles: var(omega) = 24 sigma^2 / (A^2
        // N^3).
        let n = frames as f64;
        let bound =
            (24.0 * (sigma / 1000.0).powi(2) / n.powi(3) / channels as f64).sqrt() / TAU * n;
        let (rms, none) = errors(method, channels, frames, sigma, 500);
        // The root of a chi-square of 500 stays within 10 % (three of its own standard deviations).
        assert!(
            none == 0 && (0.9..1.1).contains(&(rms / bound)),
            "{method:?}: {rms} of {bound}, {none} none"
        );
    }
}

#[test]
fn what_is_no_tone_gives_no_panic_and_no_frequency_outside_the_band() {
    let mut scratch = Scratch::EMPTY;
    let mut noise = Draw::new(1);
    let mut normal = |_| std::array::from_fn(|_| (100.0 * noise.normal()) as f32);
    let noise: Vec<Frame> = (0..241).map(&mut normal).collect();
    let mut windows = vec![
        vec![],
        noise.clone(),
        noise.iter().cycle().copied().take(1100).collect(),
    ];
    windows.extend((1..20).map(|frames| noise[..frames].to_vec()));
    windows.extend([0.0, 8e6, f32::NAN, f32::INFINITY, 3e38].map(|value| vec![[value; 16]; 241]));
    for broken in [f32::NAN, f32::NEG_INFINITY, 3e38] {
        windows.push(noise.clone());
        windows.last_mut().expect("just pushed")[100][0] = broken;
    }
    // A step, a slope, and the fastest there is.
    windows.push(
        (0..241)
            .map(|n| [if n < 120 { -8e6 } else { 8e6 }; 16])
            .collect(),
    );
    windows.push((0..241).map(|n| [n as f32; 16]).collect());
    windows.push(
        (0..241)
            .map(|n| [if n % 2 == 0 { -1.0 } else { 1.0 }; 16])
            .collect(),
    );
    for method in Method::ALL {
        for (number, window) in windows.iter().enumerate() {
            for channels in [0, 1, 2, 16, 20] {
                let found = method.estimate(window, channels, &mut scratch);
                assert!(
                    found.is_none_or(|f| f > 0.0 && f < 0.5),
                    "{method:?}, window {number}: {found:?}"
                );
            }
        }
        assert_eq!(method.estimate(&noise, 0, &mut scratch), None, "{method:?}");
        assert_eq!(
            method.estimate(&[[7.0; 16]; 241], 16, &mut scratch),
            None,
            "{method:?}"
        );
    }
}

#[test]
fn a_broken_channel_is_left_out() {
    let mut scratch = Scratch::EMPTY;
    for method in Method::ALL {
        let mut values = tone(FREQUENCY, 241, 0.0, 3);
        values.iter_mut().for_each(|frame| frame[0] = 5.0);
        values[17][1] = f32::NAN;
        let channels = if method == Method::Oddo2009 { 2 } else { 16 };
        if channels == 2 {
            // It looks at two channels only.
            values
                .iter_mut()
                .zip(tone(FREQUENCY, 241, 0.0, 3))
                .for_each(|(frame, whole)| frame[1] = whole[1]);
        }
        let found = method
            .estimate(&values, channels, &mut scratch)
            .expect("a tone in the others");
        let off = (f64::from(found) - FREQUENCY) * 241.0;
        assert!(off.abs() < tolerance(method), "{method:?}: {off}");
    }
}

#[test]
fn methods_are_known_by_their_numbers() {
    for method in Method::ALL {
        assert_eq!(Method::from_number(method as u8), Some(method));
    }
    assert_eq!(Method::from_number(Method::ALL.len() as u8), None);
}
