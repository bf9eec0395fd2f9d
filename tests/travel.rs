//! Tests spatial period, speed and direction over the whole path on a PC, from SPI bytes to
//! telemetry, with the simulated finger behind the chip.

#[allow(dead_code, reason = "every test file uses a part of it")]
mod support;

use hal_mock::{Finger, Sliding, SlidingScene, load_scene};
use ridgetone_proto::settings::{Array, FRAME_RATE_HZ, Settings, Slide, SlideRule};
use ridgetone_proto::telemetry::{Direction, Estimate, Status, TravelStatus};
use std::path::Path;
use support::{Rate, all, outcome, run};

fn estimates(scene: Sliding, settings: Settings) -> Vec<Estimate> {
    let out = outcome(&run(SlidingScene::new(scene).unwrap(), settings, all));
    assert_eq!(
        (out.slides_s.len(), out.slide_fits.len()),
        (1, 1),
        "{out:?}"
    );
    assert!(!out.window_fits.is_empty());
    out.window_fits.into_iter().chain(out.slide_fits).collect()
}

/// Array as measured on the simulated finger by `ridgetone calibrate` (`host/tests/calibrate.rs`).
const CALIBRATED: Array = Array {
    edge_phase_sigma_rad: 0.01,
    ..Array::DEFAULT
};

fn with_array(array: Array) -> Settings {
    Settings {
        array,
        ..Settings::DEFAULT
    }
}

/// The physical finger on a grating, with an SNR of 20 dB.
fn noisy(reverse: bool, period_mm: f64) -> Sliding {
    Sliding {
        period_mm,
        snr_db: Some(20.0),
        reverse,
        ..Sliding::physical()
    }
}

/// Asserts status and direction, and that the relative error of the period is below `within`.
#[track_caller]
fn assert_travel(fit: &Estimate, status: TravelStatus, reverse: bool, period_mm: f64, within: f64) {
    let found = (fit.travel.status, fit.travel.direction);
    assert_eq!(found, (status, towards(reverse)), "{fit:?}");
    let off = f64::from(fit.travel.spatial_period_mm) / period_mm - 1.0;
    assert!(off.abs() < within, "{fit:?}");
}

fn towards(reverse: bool) -> Direction {
    if reverse {
        Direction::Backward
    } else {
        Direction::Forward
    }
}

/// Requirements at 20 dB in windows of 1 s: period within 1 %, speed within 1.5 %, and the
/// direction always right.
#[test]
fn all_of_table_2_both_ways_within_the_bars() {
    let scenes = Path::new(env!("CARGO_MANIFEST_DIR")).join("hal-mock/scenes");
    let (mut worst, mut sigmas, mut rate) = ((0.0f64, 0.0f64), 0.0f64, Rate::default());
    for number in 1..=10 {
        let scene =
            load_scene(scenes.join(format!("c{number}.toml")), FRAME_RATE_HZ.into()).unwrap();
        for (seed, reverse) in [(1, false), (2, true), (3, true)] {
            let scene = Sliding {
                snr_db: Some(20.0),
                seed: 10 * number + seed,
                reverse,
                ..scene.clone()
            };
            let (period_mm, speed_mm_s) = (scene.period_mm, scene.speed_mm_s);
            for fit in estimates(scene, with_array(CALIBRATED)) {
                let what = format!("c{number}, seed {seed}: {fit:?}");
                let travel = fit.travel;
                // Travel must not be reported without a good tone.
                rate.add(&fit);
                if fit.status != Status::Good {
                    assert!(!travel.is_known(), "{what}");
                    continue;
                }
                assert_eq!(
                    (travel.status, travel.direction),
                    (TravelStatus::Unique, towards(reverse)),
                    "{what}"
                );
                let period_off = f64::from(travel.spatial_period_mm) / period_mm - 1.0;
                let speed_off = f64::from(travel.speed_mm_s) / speed_mm_s - 1.0;
                worst = (worst.0.max(period_off.abs()), worst.1.max(speed_off.abs()));
                // Sigma includes the calibration's uncertainty, but not the bias of the onset.
                let off_mm = f64::from(travel.spatial_period_mm) - period_mm;
                let off = off_mm.abs() / f64::from(travel.spatial_period_sigma_mm);
                sigmas = sigmas.max(off);
                assert!(off < 4.0, "{off} standard deviations: {what}");
                assert!(period_off.abs() < 0.01 && speed_off.abs() < 0.015, "{what}");
            }
        }
    }
    rate.assert_good();
    eprintln!(
        "worst: period {:.3} %, {sigmas:.2} sigma; speed {:.3} %",
        100.0 * worst.0,
        100.0 * worst.1
    );
}

/// A slide faster than any in the paper: at 92 Hz the channels' slots are up to 7 % of a turn
/// apart.
#[test]
fn a_fast_grating_is_as_good_as_a_slow_one() {
    for reverse in [false, true] {
        let fast = Sliding {
            speed_mm_s: 240.0,
            slide_mm: 600.0,
            ..noisy(reverse, 2.6)
        };
        for fit in estimates(fast, with_array(CALIBRATED)) {
            assert_travel(&fit, TravelStatus::Unique, reverse, 2.6, 0.01);
        }
    }
}

/// If the speed is declared, the period follows from it, and the phases yield the direction and a
/// check.
#[test]
fn with_a_given_speed_the_period_comes_from_it() {
    for reverse in [false, true] {
        let fits_at = |speed_mm_s| {
            let rule = SlideRule::Protocol;
            let slide = Slide {
                rule,
                delay_s: 1.0,
                speed_mm_s,
                length_mm: 55.0,
            };
            let settings = Settings {
                slide,
                ..with_array(CALIBRATED)
            };
            estimates(noisy(reverse, 3.6), settings)
        };
        for fit in fits_at(30.0) {
            assert_travel(&fit, TravelStatus::Given, reverse, 3.6, 0.002);
            let travel = fit.travel;
            assert_eq!((travel.speed_mm_s, travel.speed_sigma_mm_s), (30.0, 0.0));
            let expected_mm = 3.6 * fit.sigma / fit.frequency;
            let off = travel.spatial_period_sigma_mm / expected_mm - 1.0;
            assert!(off.abs() < 0.01, "{fit:?}");
        }
        // A speed that is a sixth too low belongs to a different grating.
        for fit in fits_at(25.0) {
            assert_eq!(fit.travel.status, TravelStatus::Contradicted, "{fit:?}");
        }
    }
}

/// A grating finer than the pitch resembles one of the paper's. If both are possible, the result is
/// ambiguous.
#[test]
fn a_grating_finer_than_the_pitch_is_ambiguous() {
    let fine = Sliding {
        ridge_mm: 0.4,
        ..noisy(Sliding::physical().reverse, 1.5)
    };
    let array = Array {
        period_min_mm: 1.4,
        ..CALIBRATED
    };
    for fit in estimates(fine, with_array(array)) {
        assert_eq!(fit.travel.status, TravelStatus::Ambiguous, "{fit:?}");
        assert!(
            !fit.travel.is_known() && fit.travel.speed_mm_s == 0.0,
            "{fit:?}"
        );
    }
}

/// The defaults are for a contact 8 mm long; the guide states their error for other lengths.
#[test]
fn another_contact_wants_a_calibration_of_its_own() {
    for (contact_mm, min, max) in [(7.0, 0.024, 0.04), (9.0, -0.03, -0.005)] {
        for period_mm in [2.6, 3.1, 3.6] {
            let finger = Some(Finger {
                contact_mm,
                ..Finger::default()
            });
            let scene = Sliding {
                period_mm,
                finger,
                ..Sliding::physical()
            };
            for fit in estimates(scene, Settings::DEFAULT) {
                let off = f64::from(fit.travel.spatial_period_mm) / period_mm - 1.0;
                let what = format!("{contact_mm} mm: {off}, {fit:?}");
                assert!((min..max).contains(&off), "{what}");
                // The sigma of an uncalibrated array covers the bias.
                let sigma = f64::from(fit.travel.spatial_period_sigma_mm) / period_mm;
                assert_eq!(fit.travel.status, TravelStatus::Uncalibrated, "{what}");
                assert!(off.abs() < sigma, "{what}");
            }
        }
    }
}
