//! Few channels and few cycles: a part of a cycle with overtones looks like one to three cycles
//! beside a curved baseline.

mod common;

use common::{even, fit};
use ridgetone_estimator::Status;
use std::f64::consts::TAU;

const FRAMES: usize = 240;
const WINDOWS: u64 = 200;

/// A tone with overtones 20 dB above white noise, as `channels` channels see it.
fn window(cycles: f64, channels: usize, number: u64) -> Vec<f32> {
    let mut even = even(number * 7_919 + (cycles * 1e6) as u64 + channels as u64);
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
            // A sum of twelve even numbers is nearly normal.
            let noise = (0..12).map(|_| even()).sum::<f64>() - 6.0;
            let tone = wave(1, 1.0) + wave(2, 0.4) + wave(3, 0.2) + wave(4, 0.1);
            values.push((tone + 0.0707 * noise) as f32);
        }
    }
    values
}

/// Good answers, and those of them that are off by more than 5 %.
fn good_and_wrong(cycles: f64, channels: usize) -> [u64; 2] {
    let (mut good, mut wrong) = (0, 0);
    for number in 0..WINDOWS {
        let fit = fit(&window(cycles, channels, number), channels);
        let is_good = fit.status == Status::Good;
        good += u64::from(is_good);
        wrong += u64::from(is_good && (f64::from(fit.frequency) / cycles - 1.0).abs() > 0.05);
    }
    [good, wrong]
}

/// The likeliest comb of another frequency is hardly less likely then. One of a hundred may be
/// wrong and good, all cases together, and one of twenty of a case.
#[test]
fn a_part_of_a_cycle_in_few_channels_is_no_tone_of_more_cycles() {
    let (mut all, mut windows) = (0, 0);
    for channels in [1, 2, 4, 8] {
        for cycles in [0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9] {
            let [_, wrong] = good_and_wrong(cycles, channels);
            println!("{channels} channels, {cycles} cycles: {wrong} of {WINDOWS}");
            assert!(
                wrong <= WINDOWS / 20,
                "{channels} channels, {cycles} cycles: {wrong} of {WINDOWS}"
            );
            all += wrong;
            windows += WINDOWS;
        }
    }
    assert!(all <= windows / 100, "{all} of {windows}");
}

/// A tone of more cycles is good in 95 % of the windows. One or two channels can follow any bump, so
/// that a tone of theirs needs two cycles.
#[test]
fn two_cycles_in_few_channels_are_good() {
    for (channels, cycles) in [(1, 2.5), (2, 2.3), (4, 1.5), (8, 1.5)] {
        let [good, wrong] = good_and_wrong(cycles, channels);
        assert!(
            good >= WINDOWS - WINDOWS / 20 && wrong == 0,
            "{channels} channels, {cycles} cycles: {good} good, {wrong} of them wrong"
        );
    }
}
