//! Windows with a drifting baseline: linear, or relaxing as skin does after a contact.

use crate::case::{Case, GoodFits};
use crate::reference::{Noise, codes};
use ridgetone_tone::{Fit, Status};
use std::f64::consts::TAU;

const FRAMES: usize = 241;
/// Amplitude of the tone, codes.
const AMPLITUDE: f64 = 1000.0;
/// Time constants of the drift, windows; the infinite one makes it a straight line.
const TIMES: [f64; 5] = [0.2, 0.5, 1.0, 3.0, f64::INFINITY];

/// Drift from one at the window's start to zero at its end; `t` is in frames from the centre.
fn drift(time: f64, t: f64) -> f64 {
    let x = t / FRAMES as f64 + 0.5;
    if time.is_finite() {
        ((-x / time).exp() - (-1.0 / time).exp()) / (1.0 - (-1.0 / time).exp())
    } else {
        1.0 - x
    }
}

/// A tone 20 dB above its noise, on a drift of up to `swing` amplitudes.
fn window(cycles: f64, time: f64, swing: f64, amplitude: f64, seed: u64) -> Case {
    window_with(&[1.0], cycles, Drift { time, swing }, amplitude, seed)
}

/// A drift of up to `swing` amplitudes in each channel; `time` is its time constant, windows.
#[derive(Clone, Copy)]
struct Drift {
    time: f64,
    swing: f64,
}

/// Like [`window`], but with harmonics of these relative amplitudes.
fn window_with(harmonics: &[f64], cycles: f64, drift: Drift, amplitude: f64, seed: u64) -> Case {
    let Drift { time, swing } = drift;
    let mut noise = Noise::new(seed);
    let factor = |c: usize| swing * AMPLITUDE * (c as f64 * 0.7 + seed as f64).sin();
    Case::new(codes(FRAMES, |c, t| {
        let phase = 2.4 * c as f64 + 0.77 * seed as f64;
        let wave = |(h, fraction): (usize, &f64)| {
            let turns = (h + 1) as f64 * cycles / FRAMES as f64 * t;
            fraction * (TAU * turns + phase * (1.0 + 0.3 * h as f64)).cos()
        };
        let tone = amplitude * harmonics.iter().enumerate().map(wave).sum::<f64>();
        tone + factor(c) * self::drift(time, t) + 0.0707 * AMPLITUDE * noise.next()
    }))
}

/// Fits fifty windows. The mean error must be within its statistical error plus a tenth of the
/// uncertainty, and at least `min` fits must be good, and none of them wrong.
fn assert_unbiased(cycles: f64, time: f64, swing: f64, min: usize) -> Result<(), String> {
    let truth = cycles / FRAMES as f64;
    let good = good(50, |seed| window(cycles, time, swing, AMPLITUDE, seed));
    let count = good.len() as f64;
    // Errors are relative to the sigma of a window without drift, because a drift that widens sigma
    // could hide a bias.
    let clean = window(cycles, time, 0.0, AMPLITUDE, 0).fit().sigma as f64;
    let errors = || {
        good.iter()
            .map(|fit| (fit.frequency as f64 - truth) / clean)
    };
    let mean = errors().sum::<f64>() / count;
    let squares = errors().map(|error| (error - mean).powi(2)).sum::<f64>();
    let spread = (squares / (count - 1.0)).sqrt();
    let limit = 3.0 * spread / count.sqrt() + 0.1;
    let wrong = good.iter().filter(|fit| is_off(fit, truth)).count();
    let is_unbiased = good.len() < FEW || mean.abs() < limit && spread < 2.0;
    if good.len() >= min && wrong == 0 && is_unbiased {
        Ok(())
    } else {
        Err(format!(
            "{cycles} cycles, time {time}, swing {swing}: {count} of 50 good, {wrong} wrong, mean error {mean:.2} sigma, spread {spread:.2}"
        ))
    }
}

/// Fits the windows of `seeds` seeds, and returns the good fits.
fn good(seeds: u64, case: impl Fn(u64) -> Case) -> Vec<Fit> {
    let fits = (0..seeds).map(|seed| case(seed).fit());
    fits.filter(|fit| fit.status == Status::Good).collect()
}

/// With fewer good windows than this, their mean is not checked.
const FEW: usize = 10;

/// True if a fit is more than 5 sigma from the truth.
fn is_off(fit: &Fit, truth: f64) -> bool {
    (f64::from(fit.frequency) - truth).abs() > 5.0 * f64::from(fit.sigma)
}

/// Asserts that the fit is unbiased for each number of cycles on each drift.
fn assert_all_unbiased(cycles: &[f64], times: &[f64], swings: &[f64], min: usize) {
    let (mut failed, mut tried) = (Vec::new(), 0);
    for cycles in cycles {
        for time in times {
            for swing in swings {
                failed.extend(assert_unbiased(*cycles, *time, *swing, min).err());
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
    assert_all_unbiased(&[5.2, 8.34, 20.5], &TIMES, &[0.5, 2.0, 5.0], 45);
}

/// The baseline is a polynomial. Next to three cycles its misfit to an exponential may be taken for
/// a line, which makes the fit ambiguous.
#[test]
fn a_drift_does_not_bias_three_cycles() {
    assert_all_unbiased(&[3.0, 3.4], &TIMES, &[0.5, 2.0, 5.0], 0);
}

/// The baseline's polynomial fits a slope exactly.
#[test]
fn a_slope_leaves_three_cycles_good() {
    assert_all_unbiased(&[2.5, 3.0, 3.4], &TIMES[4..], &[0.5, 5.0, 20.0], 45);
}

/// A low line with overtones can mimic a drift and a tone, but no good fit may be at a fraction of
/// the tone's frequency.
#[test]
fn a_huge_drift_makes_no_tone_a_part_of_itself() {
    let mut wrong = Vec::new();
    for cycles in [2.2, 2.6, 3.0, 3.4, 4.2, 5.2] {
        for (time, swing) in TIMES
            .into_iter()
            .flat_map(|time| [20.0, 1000.0].map(|s| (time, s)))
        {
            let truth = cycles / FRAMES as f64;
            let good = good(20, |seed| window(cycles, time, swing, AMPLITUDE, seed));
            let is_off = |fit: &&Fit| (fit.frequency as f64 / truth - 1.0).abs() > 0.25;
            let off = good.iter().filter(is_off).count();
            // A polynomial approximates a drift to one part in three hundred, and may absorb up to
            // three cycles of the tone.
            let is_plain = swing < 100.0 && time > 0.4 && cycles > 3.2;
            let min = if is_plain { 18 } else { 0 };
            if off > 0 || good.len() < min {
                wrong.push(format!(
                    "{cycles} cycles, time {time}, swing {swing}: {} of 20 good, {off} of them off",
                    good.len()
                ));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// With one to two cycles, at most 1 % of the good fits may be wrong, on any drift. On a slope,
/// most fits are good from one and a half cycles on. On an exponential drift few fits are good,
/// because a polynomial resembles so few cycles.
#[test]
fn one_cycle_or_two_on_a_drift_are_right() {
    let (mut count, mut wrong, mut few) = (0, Vec::new(), Vec::new());
    for harmonics in [&[1.0][..], &[1.0, 0.5, 0.3]] {
        for cycles in [1.0, 1.1, 1.25, 1.35, 1.5, 1.66, 1.85, 1.95] {
            for swing in [0.5, 2.0, 10.0] {
                for time in TIMES {
                    let truth = cycles / FRAMES as f64;
                    let what =
                        format!("{harmonics:?}, {cycles} cycles, time {time}, swing {swing}");
                    let drift = Drift { time, swing };
                    let good = good(20, |k| window_with(harmonics, cycles, drift, AMPLITUDE, k));
                    let off = good.iter().filter(|fit| is_off(fit, truth)).count();
                    count += good.len();
                    wrong.extend(std::iter::repeat_n(what.clone(), off));
                    if cycles >= 1.5 && time.is_infinite() && good.len() < 18 {
                        few.push(format!("{what}: {} of 20 good", good.len()));
                    }
                }
            }
        }
    }
    assert!(100 * wrong.len() <= count, "{wrong:#?} of {count}");
    assert!(few.is_empty(), "{few:#?}");
}

fn assert_no_tone(times: &[f64], swings: &[f64]) {
    for time in times {
        for swing in swings {
            let good = good(40, |seed| window(3.0, *time, *swing, 0.0, seed));
            assert!(
                good.is_empty(),
                "time {time}, swing {swing}: {} of 40 good",
                good.len()
            );
        }
    }
}

#[test]
fn a_drift_alone_is_no_tone() {
    assert_no_tone(&TIMES, &[0.1, 0.5, 2.0, 5.0, 1000.0]);
}

#[test]
fn a_tone_on_a_drift_is_right() {
    let mut fits = GoodFits::default();
    for cycles in [5.2, 8.34] {
        for time in [1.0, 3.0, f64::INFINITY] {
            for seed in 0..10 {
                let case = window(cycles, time, 3.0, AMPLITUDE, seed);
                let what = format!("{cycles} cycles, time {time}");
                fits.add(&case, &what, cycles / FRAMES as f64);
            }
        }
    }
    fits.assert_sure();
}
