//! Tests weak tones in the default scene: sixteen channels find tones that a single one misses, and
//! noise that is red or common to channels is not taken for a tone.

mod common;

use ridgetone_tone::Status;
use std::f64::consts::TAU;

const FRAMES: usize = 241;
const WINDOWS: u32 = 60;

/// Noise; its variance is 1 unless shared.
#[derive(Clone, Copy, Debug)]
enum Noise {
    White,
    /// Independent autoregressions with this coefficient in each channel.
    Red(f64),
    /// Two such autoregressions, mixed with different gains in each channel, plus a hundredth of
    /// white noise.
    Shared(f64),
}

/// Counts the good fits, and how many of them are off by more than 5 %.
fn good_and_wrong(channels: usize, noise: Noise, snr_db: f64, seed: u64) -> (u32, u32) {
    let (mut good, mut wrong) = (0, 0);
    for number in 0..WINDOWS {
        let seed = seed * 1_000_003 + u64::from(number);
        let (mut even, mut normal) = (common::even(seed), common::normal(seed + 7_919));
        for _ in 0..4 {
            even();
        }
        let cycles = 4.0 * 7.0f64.powf(even());
        // A fundamental at `snr_db`, and three overtones.
        let amplitude = 2f64.sqrt() * 10f64.powf(snr_db / 20.0);
        let mut values = vec![0.0; FRAMES * channels];
        let mut red = |factor: f64| {
            let mut at = normal();
            let kick = (1.0 - factor * factor).sqrt();
            let next = |_| {
                let value = at;
                at = factor * at + kick * normal();
                value
            };
            (0..FRAMES).map(next).collect::<Vec<f64>>()
        };
        let sources = match noise {
            Noise::Shared(factor) => [red(factor), red(factor)],
            _ => [vec![0.0; FRAMES], vec![0.0; FRAMES]],
        };
        for channel in 0..channels {
            let (gain, turn) = (0.5 + even(), even());
            let phases: [f64; 4] = core::array::from_fn(|_| even());
            let own = red(if let Noise::Red(factor) = noise {
                factor
            } else {
                0.0
            });
            let (floor, angle) = match noise {
                Noise::Shared(_) => (0.1, TAU * turn),
                _ => (1.0, 0.0),
            };
            for frame in 0..FRAMES {
                let t = (frame as f64 + 0.5) / FRAMES as f64;
                let lines = (1..).zip([1.0, 0.4, 0.2, 0.1]).zip(phases);
                let wave = |((order, size), phase): ((i32, f64), f64)| {
                    size * (TAU * (f64::from(order) * cycles * t + phase)).cos()
                };
                let tone = amplitude * gain * lines.map(wave).sum::<f64>();
                let shared = angle.cos() * sources[0][frame] + angle.sin() * sources[1][frame];
                values[frame * channels + channel] = (tone + floor * own[frame] + shared) as f32;
            }
        }
        let fit = common::fit(&values, channels);
        if fit.status == Status::Good {
            good += 1;
            wrong += u32::from((f64::from(fit.frequency) / cycles - 1.0).abs() > 0.05);
        }
    }
    (good, wrong)
}

#[test]
fn sixteen_channels_find_a_tone_that_one_does_not() {
    for (channels, snr_db, min) in [(16, -8.0, 97), (16, -10.0, 90), (4, -6.0, 85)] {
        let (good, wrong) = good_and_wrong(channels, Noise::White, snr_db, 31);
        assert!(
            wrong == 0 && 100 * good >= min * WINDOWS,
            "{channels} channels, {snr_db} dB: {good} good, {wrong} wrong of {WINDOWS}"
        );
    }
}

/// Without a tone, at most one of sixty windows may be good.
#[test]
fn noise_is_no_weak_tone() {
    for noise in [
        Noise::White,
        Noise::Red(0.6),
        Noise::Red(0.9),
        Noise::Shared(0.9),
    ] {
        for channels in [4, 16] {
            let (good, _) = good_and_wrong(channels, noise, f64::NEG_INFINITY, 32);
            assert!(good <= 1, "{noise:?}, {channels} channels: {good} good");
        }
    }
}
