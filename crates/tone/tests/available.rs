//! Tests windows of any length, at any frequency from one and a half cycles to half the frame rate:
//! the fit must be good and correct, and its interval must cover the truth.

mod common;

use common::{even, fit, normal};
use ridgetone_tone::Status;
use std::f64::consts::TAU;

const CHANNELS: usize = 16;
const WINDOWS: u64 = 100;

/// Frequency of a tone, and its frames in white noise.
struct Window {
    cycles: f64,
    values: Vec<f32>,
}

impl Window {
    /// Returns a window with random frequency, overtones, gains and phases. The noise is `snr_db`
    /// below the fundamental at unit gain.
    fn new(frames: usize, harmonics: u32, snr_db: f64, seed: u64) -> Self {
        let mut even = even(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) + frames as u64);
        let mut normal = normal(seed * 7_919 + 13 * frames as u64);
        for _ in 0..5 {
            even();
        }
        let start = even();
        let max = frames as f64 * if harmonics == 1 { 0.45 } else { 0.11 };
        let cycles = 1.6 * (max / 1.6).powf(even());
        let lines: Vec<[f64; 2]> = (1..=harmonics)
            .map(|h| [if h == 1 { 1.0 } else { 0.5 * even() }, even()])
            .collect();
        let gains: Vec<f64> = (0..CHANNELS).map(|_| 0.3 + even()).collect();
        let sigma = 10f64.powf(-snr_db / 20.0) / 2f64.sqrt();
        let mut values = Vec::new();
        for frame in 0..frames {
            let t = (frame as f64 + 0.5) / frames as f64 - 0.5;
            for (channel, gain) in gains.iter().enumerate() {
                let turns = cycles * t + start + 0.11 * channel as f64;
                let wave = |(h, [amplitude, phase]): (u32, &[f64; 2])| {
                    amplitude * (TAU * (f64::from(h) * turns + phase)).cos()
                };
                let tone: f64 = (1..).zip(&lines).map(wave).sum();
                values.push((gain * tone + sigma * normal()) as f32);
            }
        }
        Self { cycles, values }
    }
}

/// In each test case at least 98 of 100 windows must be good, none of them wrong, and at least 90
/// intervals must cover. Over all cases the coverage must be 93 to 98 %.
#[test]
fn answers_are_good_and_right_and_their_intervals_hold() {
    let (mut held_in_all, mut good_in_all) = (0, 0);
    for frames in [72, 241, 600, 940] {
        for snr_db in [20.0, 40.0] {
            for harmonics in [1, 4] {
                let (mut good, mut held, mut wrong) = (0, 0, 0);
                for seed in 0..WINDOWS {
                    let window = Window::new(frames, harmonics, snr_db, seed);
                    let fit = fit(&window.values, CHANNELS);
                    if fit.status != Status::Good {
                        continue;
                    }
                    let off = (f64::from(fit.frequency) - window.cycles).abs();
                    good += 1;
                    held += u32::from(off < 1.96 * f64::from(fit.sigma));
                    wrong += u32::from(off > 0.05 * window.cycles);
                }
                let cell = format!("{frames} frames, {snr_db} dB, {harmonics} harmonics");
                println!("{cell}: {good} of {WINDOWS} good, {wrong} of them wrong, {held} hold");
                assert!(wrong == 0 && good >= 98 && held >= 90, "{cell}");
                held_in_all += held;
                good_in_all += good;
            }
        }
    }
    let fraction = f64::from(held_in_all) / f64::from(good_in_all);
    assert!((0.93..0.98).contains(&fraction), "{fraction}");
}

/// With two and a half cycles, four harmonics and little noise, the error must come from the noise
/// alone.
#[test]
fn few_cycles_in_little_noise_have_no_bias() {
    let (mut sum, mut squares) = (0.0, 0.0);
    for seed in 0..WINDOWS {
        let mut normal = normal(seed + 900);
        let start = 0.618 * seed as f64;
        let mut values = Vec::new();
        for frame in 0..72 {
            let t = (f64::from(frame) + 0.5) / 72.0 - 0.5;
            for channel in 0..CHANNELS {
                let turns = TAU * (2.5 * t + start + 0.11 * channel as f64);
                let wave = |(h, amplitude): (f64, f64)| amplitude * (h * turns).cos();
                let lines = [(1.0, 1.0), (2.0, 0.4), (3.0, 0.2), (4.0, 0.1)];
                let tone: f64 = lines.into_iter().map(wave).sum();
                values.push((tone + 0.022 * normal()) as f32);
            }
        }
        let fit = fit(&values, CHANNELS);
        let off = (f64::from(fit.frequency) - 2.5) / f64::from(fit.sigma);
        sum += off / WINDOWS as f64;
        squares += off * off / WINDOWS as f64;
    }
    println!(
        "mean {sum:.2} sigma, root of the mean square {:.2}",
        squares.sqrt()
    );
    // Without bias the mean of a hundred windows has a standard deviation of 0.1 sigma.
    assert!(sum.abs() < 0.4 && squares < 1.4, "{sum} {squares}");
}
