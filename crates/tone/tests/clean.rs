//! Tests windows with very little noise. The model's misfit is then the rounding of values and
//! sums, which must not be taken for a line.

mod common;

use common::{RATE_HZ, even, fit_codes};
use hal_mock::{Scene as _, Sliding, SlidingScene};
use ridgetone_tone::{Fit, Status};
use std::f64::consts::TAU;

const CHANNELS: usize = 16;

#[track_caller]
fn assert_good_and_right(fit: &Fit, cycles: f64, what: &str) {
    let off = f64::from(fit.frequency) / cycles - 1.0;
    assert_eq!(fit.status, Status::Good, "{what}, {cycles} cycles: {fit:?}");
    assert!(off.abs() < 0.01, "{what}, {cycles} cycles: {fit:?}");
}

/// Tests a finger on a grating with no noise except the converter's rounding, with and without
/// overtones: the paper's signal, and a compressed solid.
#[test]
fn a_clean_finger_is_good() {
    for (speed_mm_s, period_mm) in [(30.0, 3.6), (30.0, 2.6), (60.0, 3.1), (20.0, 3.6)] {
        for (base, overtone) in [
            (Sliding::default(), 0.0),
            (Sliding::default(), 0.3),
            (Sliding::physical(), 0.0),
        ] {
            let is_physical = base.finger.is_some();
            let mut parameters = Sliding {
                speed_mm_s,
                period_mm,
                slide_mm: 120.0,
                snr_db: None,
                ..base
            };
            if !is_physical {
                parameters.overtones[0] = overtone;
            }
            let mut scene = SlidingScene::new(parameters).expect("a scene");
            let truth = scene.truth();
            let slide = (truth.slide_start_s * RATE_HZ) as usize;
            // A scan reads one input after another.
            let values: Vec<f32> = (0..(slide + 400) * CHANNELS)
                .map(|at| {
                    let (frame, input) = (at / CHANNELS, at % CHANNELS);
                    let t_s = (frame as f64 + input as f64 / 21.0) / RATE_HZ;
                    (scene.volts(input as u8, t_s) / 5.0 * f64::from(1 << 23)).round() as f32
                })
                .collect();
            for frames in [96, 120, 241] {
                for first in [24, 71, 118] {
                    let window = &values[(slide + first) * CHANNELS..][..frames * CHANNELS];
                    let cycles = truth.frequency_hz / RATE_HZ * frames as f64;
                    let what = format!("{speed_mm_s} mm/s, {period_mm} mm, {overtone}");
                    let fit = fit_codes(window, CHANNELS);
                    assert_good_and_right(&fit, cycles, &what);
                }
            }
        }
    }
}

/// Rounding creates endless overtones, some of which alias to fractions of the tone's frequency.
#[test]
fn a_sine_that_is_rounded_is_good() {
    for frames in [48, 120, 241] {
        for amplitude in [10.0, 1e3, 1e6] {
            for number in 0..20u32 {
                let cycles = 2.0 + 0.77 * f64::from(number);
                let mut even = even(u64::from(number));
                let phases: Vec<f64> = (0..CHANNELS).map(|_| even()).collect();
                let values: Vec<f32> = (0..frames * CHANNELS)
                    .map(|at| {
                        let turns = cycles * (at / CHANNELS) as f64 / frames as f64;
                        let wave = (TAU * (turns + phases[at % CHANNELS])).cos();
                        (amplitude * wave).round() as f32
                    })
                    .collect();
                let what = format!("amplitude {amplitude}, {frames} frames");
                let fit = fit_codes(&values, CHANNELS);
                assert_good_and_right(&fit, cycles, &what);
            }
        }
    }
}

/// The window has a second line, at a hundredth of the tone's amplitude and 4/3 of its frequency.
/// The two must not be taken for harmonics of an absent line at a third of the tone's frequency.
#[test]
fn a_faint_line_beside_the_tone_makes_no_comb_without_a_fundamental() {
    for number in 0..40u32 {
        let cycles = 3.3 + 0.21 * f64::from(number);
        let mut even = even(100 + u64::from(number));
        let phases: Vec<[f64; 2]> = (0..CHANNELS).map(|_| [even(), even()]).collect();
        let values: Vec<f32> = (0..96 * CHANNELS)
            .map(|at| {
                let turns = cycles * (at / CHANNELS) as f64 / 96.0;
                let [one, other] = phases[at % CHANNELS];
                let faint = 50.0 * (TAU * (4.0 / 3.0 * turns + other)).cos();
                (5000.0 * (TAU * (turns + one)).cos() + faint + 5.0 * even()).round() as f32
            })
            .collect();
        let fit = fit_codes(&values, CHANNELS);
        assert_good_and_right(&fit, cycles, "a faint line");
    }
}
