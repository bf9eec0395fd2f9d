//! Tests few channels with few cycles. Part of a cycle with overtones resembles one and a half
//! cycles on a curved baseline.

mod common;

use ridgetone_tone::{Fit, Status};
use std::f64::consts::TAU;

const FRAMES: usize = 240;
const WINDOWS: u32 = 500;

/// Fits a tone with overtones in `channels` channels, 20 dB above white noise. The same `number`
/// creates the same window.
fn fit(cycles: f64, channels: usize, number: u32) -> Fit {
    let seed = u64::from(number) * 7_919 + (cycles * 1e6) as u64 + channels as u64;
    let mut even = common::even(seed);
    for _ in 0..4 {
        even();
    }
    let start = even();
    let phases: Vec<f64> = (0..4).map(|_| even()).collect();
    let mut values = Vec::new();
    for frame in 0..FRAMES {
        let t = (frame as f64 + 0.5) / FRAMES as f64 - 0.5;
        for channel in 0..channels {
            let turns = cycles * t + start + 0.11 * channel as f64;
            let wave = |h: u32, amplitude: f64| {
                amplitude * (TAU * (f64::from(h) * turns + phases[h as usize - 1])).cos()
            };
            // The sum of twelve uniform numbers is nearly normal.
            let noise = (0..12).map(|_| even()).sum::<f64>() - 6.0;
            values.push(
                (wave(1, 1.0) + wave(2, 0.4) + wave(3, 0.2) + wave(4, 0.1) + 0.0707 * noise) as f32,
            );
        }
    }
    common::fit_harmonics(&values, channels, 4)
}

/// Counts the good fits, and how many of them are off by more than 5 %.
fn good_and_wrong(cycles: f64, channels: usize) -> (u32, u32) {
    let (mut good, mut wrong) = (0, 0);
    for number in 0..WINDOWS {
        let fit = fit(cycles, channels, number);
        let is_off = (f64::from(fit.frequency) * FRAMES as f64 / cycles - 1.0).abs() > 0.05;
        good += u32::from(fit.status == Status::Good);
        wrong += u32::from(fit.status == Status::Good && is_off);
    }
    (good, wrong)
}

/// At most 1 % of the fits may be good but wrong.
#[test]
fn a_part_of_a_cycle_in_few_channels_is_no_tone_of_more_cycles() {
    for channels in [1, 2, 4, 8] {
        for cycles in [0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9] {
            let (_, wrong) = good_and_wrong(cycles, channels);
            assert!(
                wrong <= WINDOWS / 100,
                "{channels} channels, {cycles} cycles: {wrong} of {WINDOWS}"
            );
        }
    }
}

/// With enough cycles, at most 1 % may not be good. One or two channels need two cycles or more,
/// because their fit can follow any bump.
#[test]
fn two_cycles_in_few_channels_are_good() {
    for (channels, cycles) in [(1, 2.4), (1, 3.1), (2, 2.3), (4, 1.5), (8, 1.5)] {
        let (good, wrong) = good_and_wrong(cycles, channels);
        assert!(
            good >= WINDOWS - WINDOWS / 100 && wrong == 0,
            "{channels} channels, {cycles} cycles: {good}, {wrong}"
        );
    }
}
