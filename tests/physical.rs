//! Tests the whole path with physical fingers, whose skin creeps: contact, slide and tone of
//! touches on the paper's gratings.

#[allow(dead_code, reason = "every test file uses a part of it")]
mod support;

use hal_mock::{Finger, Options, SimulatedBoard, Sliding, SlidingScene, Truth, load_scene};
use ridgetone_proto::settings::{FRAME_RATE_HZ, Settings};
use ridgetone_proto::telemetry::Status;
use support::{Outcome, all, off, outcome, run_on};

/// Loads the paper's combination `number`, C1 to C10, from its scene file.
fn combination(number: usize) -> Sliding {
    let file = format!("hal-mock/scenes/c{number}.toml");
    load_scene(file, FRAME_RATE_HZ as f64).unwrap()
}

/// Runs a scene, with converter noise from `seed`.
fn touch(sliding: Sliding, seed: u64) -> (Outcome, Truth) {
    let scene = SlidingScene::new(Sliding { seed, ..sliding }).unwrap();
    let truth = scene.truth();
    let board = SimulatedBoard::new(
        scene,
        Options {
            seed,
            ..Options::default()
        },
    );
    (outcome(&run_on(board, Settings::default(), all)), truth)
}

/// With only the chip's noise, the end of a slide must be found to within one frame and its slots.
/// If part of the standstill were fitted too, the tone would be off by more than its uncertainty.
#[test]
fn a_slide_ends_where_it_ends_under_creep() {
    let mut squares = 0.0;
    for number in 1..=10 {
        for seed in 1..=4 {
            let what = format!("C{number}, seed {seed}");
            let (out, truth) = touch(combination(number), seed);
            out.assert_touch(&what, &truth, 0.005);
            let fit = &out.slide_fits[0];
            let sigmas = off(fit, &truth);
            assert_eq!(fit.status, Status::Good, "{what}: {fit:?}");
            assert!(sigmas.abs() < 3.0, "{what}: {sigmas} sigma off: {fit:?}");
            squares += sigmas * sigmas;
        }
    }
    // RMS of 40 normal deviates, plus three of its standard deviations.
    let spread = (squares / 40.0).sqrt();
    assert!(spread < 1.0 + 3.0 / 80f64.sqrt(), "{spread}");
}

#[test]
fn noise_of_20_db_costs_no_slide() {
    for number in 1..=10 {
        for seed in 1..=4 {
            let what = format!("C{number}, seed {seed}");
            let noisy = Sliding {
                snr_db: Some(20.0),
                ..combination(number)
            };
            let (out, truth) = touch(noisy, seed);
            out.assert_touch(&what, &truth, 0.020);
            assert_eq!(out.slide_fits[0].status, Status::Good, "{what}: {out:?}");
        }
    }
}

/// Rubbers that creep by a fifth or within half a second, and a human finger's skin (Moy et al.,
/// table 5, subject 1), which creeps by a third. Without added noise the skin's creep is taken for
/// a slide.
#[test]
fn a_skin_that_creeps_much_or_fast_moves_no_end() {
    for (relaxation_s, creep_s, snr_db) in [
        (2.4, 3.0, None),
        (0.475, 0.5, None),
        (1.42, 2.14, Some(40.0)),
    ] {
        for number in [1, 2, 7] {
            let finger = Some(Finger {
                relaxation_s,
                creep_s,
                ..Finger::default()
            });
            let (out, truth) = touch(
                Sliding {
                    finger,
                    snr_db,
                    ..combination(number)
                },
                1,
            );
            out.assert_touch(&format!("C{number}, {creep_s} s"), &truth, 0.020);
        }
    }
}

/// At 3 Hz the signals change direction only every sixth of a second.
#[test]
fn a_slow_slide_is_not_cut_short() {
    for (seed, snr_db) in [(1, None), (2, Some(20.0)), (3, Some(20.0))] {
        for period_mm in [2.6, 3.1, 3.6] {
            let slow = Sliding {
                speed_mm_s: 3.0 * period_mm,
                period_mm,
                slide_mm: 9.5 * period_mm,
                snr_db,
                ..combination(1)
            };
            let (out, truth) = touch(slow, seed);
            out.assert_touch(&format!("{period_mm} mm, {snr_db:?} dB"), &truth, 0.020);
        }
    }
}
