//! Baselines that drift: linear, and relaxing as skin does after a contact.

use crate::case::Case;
use crate::reference::{Noise, codes};
use ridgetone_tone::{Fit, Status};
use std::f64::consts::TAU;

const FRAMES: usize = 241;
/// Amplitude of the tone, codes.
const AMPLITUDE: f64 = 1000.0;
/// Time constants, windows; the last is a straight line.
const TIMES: [f64; 5] = [0.2, 0.5, 1.0, 3.0, f64::INFINITY];

/// A drift from one at the window's start to zero at its end; `t` is in frames from its centre.
fn drift(time: f64, t: f64) -> f64 {
    let x = t / FRAMES as f64 + 0.5;
    if time.is_finite() {
        ((-x / time).exp() - (-1.0 / time).exp()) / (1.0 - (-1.0 / time).exp())
    } else {
        1.0 - x
    }
}

/// A tone with its noise 20 dB below, on a drift of up to `swing` amplitudes.
fn window(cycles: f64, time: f64, swing: f64, amplitude: f64, seed: u64) -> Case {
    window_with(&[1.0], cycles, Drift { time, swing }, amplitude, seed)
}

/// A drift with its time constant in windows, that moves each channel by up to `swing` amplitudes.
struct Drift {
    time: f64,
    swing: f64,
}

/// As [`window`], with harmonics of these shares.
fn window_with(
    harmonics: &[f64],
    cycles: f64,
    Drift { time, swing }: Drift,
    amplitude: f64,
    seed: u64,
) -> Case {
    let mut noise = Noise::new(seed);
    let factors: Vec<f64> = (0..16)
        .map(|c| swing * AMPLITUDE * ((c as f64 * 0.7 + seed as f64).sin()))
        .collect();
    Case::new(codes(FRAMES, |c, t| {
        let phase = 2.4 * c as f64 + 0.77 * seed as f64;
        let wave = |(h, share): (usize, &f64)| {
            share
                * (TAU * (h + 1) as f64 * cycles / FRAMES as f64 * t
                    + phase * (1.0 + 0.3 * h as f64))
                    .cos()
        };
        let tone = amplitude * harmonics.iter().enumerate().map(wave).sum::<f64>();
        tone + factors[c] * drift(time, t) + 0.0707 * AMPLITUDE * noise.next()
    }))
}

/// The mean error over fifty windows is within its own noise and a tenth of the uncertainty.
fn assert_unbiased(cycles: f64, time: f64, swing: f64) -> Result<(), String> {
    let truth = cycles / FRAMES as f64;
    let fits: Vec<_> = (0..50)
        .map(|seed| window(cycles, time, swing, AMPLITUDE, seed).fit())
        .collect();
    let good: Vec<_> = fits
        .iter()
        .filter(|fit| fit.status == Status::Good)
        .collect();
    let count = good.len() as f64;
    // The bar is the uncertainty of a window without a drift, so that the fit's own estimate cannot
    // widen it.
    let clean = window(cycles, time, 0.0, AMPLITUDE, 0).fit().sigma as f64;
    let errors: Vec<f64> = good
        .iter()
        .map(|fit| (fit.frequency as f64 - truth) / clean)
        .collect();
    let mean = errors.iter().sum::<f64>() / count;
    let spread = (errors
        .iter()
        .map(|error| (error - mean).powi(2))
        .sum::<f64>()
        / (count - 1.0))
        .sqrt();
    let bar = 3.0 * spread / count.sqrt() + 0.1;
    let what = format!(
        "{cycles} cycles, time {time}, swing {swing}: {count} of 50 good, mean error {mean:.2} sigma, spread {spread:.2}"
    );
    if count >= 45.0 && mean.abs() < bar && spread < 2.0 {
        Ok(())
    } else {
        Err(what)
    }
}

/// Asserts it of every number of cycles with every drift under it.
fn assert_all_unbiased(cycles: &[f64], times: &[f64], swings: &[f64]) {
    let (mut failed, mut tried) = (Vec::new(), 0);
    for cycles in cycles {
        for time in times {
            for swing in swings {
                failed.extend(assert_unbiased(*cycles, *time, *swing).err());
                tried += 1;
            }
        }
    }
    assert!(
        failed.is_empty(),
        "{} of {tried}:\n{}",
        failed.len(),
        failed.join("\n")
    );
}

#[test]
fn a_drift_does_not_bias_the_tone() {
    assert_all_unbiased(&[5.2, 8.34, 20.5], &TIMES, &[0.5, 2.0, 5.0]);
}

#[test]
fn a_drift_does_not_bias_three_cycles() {
    assert_all_unbiased(&[3.0, 3.4], &TIMES, &[0.5]);
    assert_all_unbiased(&[3.0, 3.4], &TIMES[1..], &[2.0]);
}

#[test]
fn a_steep_drift_does_not_bias_three_cycles() {
    assert_all_unbiased(&[3.0, 3.4], &TIMES, &[5.0]);
}

#[test]
fn a_quick_drift_does_not_bias_three_cycles() {
    assert_all_unbiased(&[3.0, 3.4], &TIMES[..1], &[2.0]);
}

/// A low line with its overtones mimics a drift and a tone: no fraction of the tone's frequency may
/// be among the answers.
#[test]
fn a_huge_drift_makes_no_tone_a_part_of_itself() {
    let mut wrong = Vec::new();
    for cycles in [2.2, 2.6, 3.0, 3.4, 4.2, 5.2] {
        for time in TIMES {
            for swing in [20.0, 1000.0] {
                let truth = cycles / FRAMES as f64;
                let fits = (0..20).map(|seed| window(cycles, time, swing, AMPLITUDE, seed).fit());
                let good: Vec<_> = fits.filter(|fit| fit.status == Status::Good).collect();
                let off = good
                    .iter()
                    .filter(|fit| (fit.frequency as f64 / truth - 1.0).abs() > 0.25)
                    .count();
                // The curves describe a drift to a three hundredth.
                let least = if swing < 100.0 && time > 0.4 { 18 } else { 0 };
                if off > 0 || good.len() < least {
                    wrong.push(format!(
                        "{cycles} cycles, time {time}, swing {swing}: {} of 20 good, {off} of them off",
                        good.len()
                    ));
                }
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// From one cycle on, no drift turns the tone into another one: good answers are right, and most
/// answers have the right frequency. Most are good from one and a half cycles on, with overtones
/// from 1.66. Shorter windows are never good: a single bump looks the same, and overtones together
/// with the drift's curves explain anything.
#[test]
fn one_cycle_or_two_on_a_drift_are_right() {
    let mut wrong = Vec::new();
    for harmonics in [&[1.0][..], &[1.0, 0.5, 0.3]] {
        for cycles in [1.0, 1.1, 1.25, 1.35, 1.5, 1.66, 1.85, 1.95] {
            for swing in [0.5, 2.0, 10.0] {
                let truth = cycles / FRAMES as f64;
                let case = |k: u64| {
                    let time = TIMES[k as usize % 5];
                    window_with(harmonics, cycles, Drift { time, swing }, AMPLITUDE, k)
                };
                let fits: Vec<_> = (0..30).map(|k| case(k).fit()).collect();
                let good: Vec<_> = fits
                    .iter()
                    .filter(|fit| fit.status == Status::Good)
                    .collect();
                let off =
                    |fit: &&&Fit| (fit.frequency as f64 - truth).abs() > 5.0 * fit.sigma as f64;
                let off = good.iter().filter(off).count();
                let right = |fit: &&Fit| (fit.frequency as f64 / truth - 1.0).abs() < 0.1;
                let right = fits.iter().filter(right).count();
                // With overtones, so few cycles may belong to another tone: a lower one with more
                // of them.
                let is_full = harmonics.len() > 1 && cycles < 1.66;
                let (least, least_right) = if cycles < 1.5 {
                    (0, 9)
                } else {
                    (if is_full { 0 } else { 20 }, 20)
                };
                if off > 0 || good.len() < least || right < least_right {
                    let harmonics = harmonics.len();
                    wrong.push(format!(
                        "{harmonics} harmonics, {cycles} cycles, swing {swing}: {} of 30 good, {off} of them off, {right} right",
                        good.len()
                    ));
                }
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

fn assert_no_tone(times: &[f64], swings: &[f64]) {
    let mut found = Vec::new();
    for time in times.iter().copied() {
        for swing in swings.iter().copied() {
            let good = (0..40)
                .filter(|seed| window(3.0, time, swing, 0.0, *seed).fit().status == Status::Good)
                .count();
            if good > 0 {
                found.push(format!("time {time}, swing {swing}: {good} of 40 good"));
            }
        }
    }
    assert!(found.is_empty(), "{}", found.join("\n"));
}

#[test]
fn a_drift_alone_is_no_tone() {
    assert_no_tone(&TIMES[1..], &[0.1, 0.5, 2.0, 5.0, 1000.0]);
    assert_no_tone(&TIMES[..1], &[0.1, 0.5, 5.0, 1000.0]);
}

#[test]
fn a_quick_drift_alone_is_no_tone() {
    assert_no_tone(&TIMES[..1], &[2.0]);
}

#[test]
fn a_tone_on_a_drift_is_right() {
    for cycles in [3.0, 5.2, 8.34] {
        for time in [1.0, 3.0, f64::INFINITY] {
            for seed in 0..5 {
                let case = window(cycles, time, 3.0, AMPLITUDE, seed);
                case.assert_good(
                    &format!("{cycles} cycles, time {time}"),
                    cycles / FRAMES as f64,
                );
            }
        }
    }
}
