//! Tests a fundamental that is faint next to its second harmonic. If all other harmonics are even,
//! only the line at half the strong line's frequency reveals the fundamental.

mod common;

use ridgetone_tone::{CHANNELS_MAX, Fit, Status};
use std::f64::consts::{SQRT_2, TAU};

/// Amplitude of the second harmonic, 20 dB above noise of variance 1.
const SECOND: f64 = 10.0 * SQRT_2;

/// Returns autoregressive noise of variance 1 for each channel. With a factor of 0.6, half of its
/// power is at low frequencies.
fn noise(factor: f64, seed: u64) -> impl FnMut(usize) -> f64 {
    let (mut normal, mut last) = (common::normal(seed), [0.0; CHANNELS_MAX]);
    move |channel| {
        last[channel] = factor * last[channel] + (1.0 - factor * factor).sqrt() * normal();
        last[channel]
    }
}

/// Fits a tone of `cycles` cycles in noise. Harmonics 1, 2 and 4 have the amplitudes `first`, 1 and
/// 0.4 relative to the second, and a random phase in each channel.
fn fit(
    frames: usize,
    cycles: f64,
    first: f64,
    seed: u64,
    mut noise: impl FnMut(usize) -> f64,
) -> Fit {
    let mut even = common::even(seed);
    let phases: Vec<[f64; 3]> = (0..CHANNELS_MAX)
        .map(|_| core::array::from_fn(|_| even()))
        .collect();
    let mut values = Vec::new();
    for frame in 0..frames {
        let t = (frame as f64 + 0.5) / frames as f64;
        for (channel, phases) in phases.iter().enumerate() {
            let lines = [(1.0, first), (2.0, 1.0), (4.0, 0.4)]
                .into_iter()
                .zip(phases);
            let sum: f64 = lines
                .map(|((number, fraction), phase)| {
                    fraction * (TAU * (number * cycles * t + phase)).cos()
                })
                .sum();
            values.push((SECOND * sum + noise(channel)) as f32);
        }
    }
    common::fit_harmonics(&values, CHANNELS_MAX, 4)
}

/// Counts the good fits in 50 windows, and how many of them take the second harmonic for the tone.
fn good_and_mistaken(
    frames: usize,
    first: f64,
    noise: impl Fn(u64) -> Box<dyn FnMut(usize) -> f64>,
) -> (usize, usize) {
    let (mut good, mut mistaken) = (0, 0);
    for n in 0..50u32 {
        // With fewer cycles, a curved baseline resembles the fundamental.
        let cycles = 2.6 + 0.21 * f64::from(n);
        let seed = u64::from(n) + 10;
        let fit = fit(frames, cycles, first, seed, noise(seed + 1));
        let is_off = (f64::from(fit.frequency) * frames as f64 / cycles - 1.0).abs() > 0.05;
        good += usize::from(fit.status == Status::Good);
        mistaken += usize::from(fit.status == Status::Good && is_off);
    }
    (good, mistaken)
}

fn white(seed: u64) -> Box<dyn FnMut(usize) -> f64> {
    Box::new(noise(0.0, seed))
}

/// Summed over all channels, the noise power at a line follows a chi-square with 32 degrees of
/// freedom, which is below 68 in 4,999 of 5,000 windows. The fundamental adds frames x (fraction x
/// SECOND)^2 / 2 per channel: in total 246 in 96 frames, 347 in 241 and 1,354 in 940. The noise
/// density there may be 1.5 times that around the tone, so in 96 frames a fraction of 0.03, which
/// adds 138, is not always enough.
#[test]
fn a_faint_fundamental_leaves_no_good_answer_of_twice_its_frequency() {
    let mistaken = [(96, 0.04), (241, 0.03), (940, 0.03)]
        .map(|(frames, first)| good_and_mistaken(frames, first, white).1);
    assert_eq!(mistaken, [0; 3], "of 50 each");
}

/// Without a line at half the frequency the fit must be good, even in noise that is stronger there.
#[test]
fn a_tone_without_a_line_at_half_its_frequency_is_good() {
    // Minimum number of good windows in coloured noise: as many as without the test for that line.
    for (frames, without) in [(96, 39), (241, 49), (940, 50)] {
        assert!(
            good_and_mistaken(frames, 0.0, white).0 >= 49,
            "{frames} frames"
        );
        let (coloured, _) = good_and_mistaken(frames, 0.0, |seed| Box::new(noise(0.6, seed)));
        assert!(coloured + 1 >= without, "{frames} frames: {coloured}");
    }
}

/// In very little noise, a fundamental of 1/200 of the second harmonic must also stand out, in all
/// but one of fifty windows.
#[test]
fn beside_little_noise_a_fainter_fundamental_is_found() {
    let little = |seed| -> Box<dyn FnMut(usize) -> f64> {
        let mut noise = noise(0.0, seed);
        Box::new(move |channel| 1e-3 * noise(channel))
    };
    assert!(good_and_mistaken(241, 0.005, little).1 <= 1);
    assert_eq!(good_and_mistaken(241, 0.02, little).1, 0);
}
