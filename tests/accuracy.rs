//! Tests the required accuracy: an estimate is reported as soon as its uncertainty is small enough,
//! and no sooner.

#[allow(dead_code, reason = "every test file uses a part of it")]
mod support;

use hal_mock::{Sliding, SlidingScene};
use ridgetone_proto::settings::Settings;
use ridgetone_proto::telemetry::{Estimate, Status};
use support::{Outcome, all, outcome, run};

const STRIDE_S: f64 = 0.05;

const SEEDS: u64 = 20;

fn touch(settings: Settings, snr_db: f64, seed: u64) -> (Outcome, f64) {
    let scene = SlidingScene::new(Sliding {
        snr_db: Some(snr_db),
        seed,
        ..Sliding::default()
    })
    .unwrap();
    let frequency_hz = scene.truth().frequency_hz;
    settings.validate().unwrap();
    (outcome(&run(scene, settings, all)), frequency_hz)
}

fn at(accuracy: f32, snr_db: f64, seed: u64) -> (Outcome, f64) {
    let settings = Settings {
        accuracy,
        stride_s: STRIDE_S as f32,
        ..Settings::DEFAULT
    };
    touch(settings, snr_db, seed)
}

fn relative_sigma(fit: &Estimate) -> f32 {
    fit.sigma / fit.frequency
}

/// Mean relative sigma of the good windows of one length.
fn mean_sigma(window_s: f64, snr_db: f64) -> f64 {
    let (mut sum, mut count) = (0.0, 0);
    for seed in 0..SEEDS {
        let settings = Settings {
            window_s: window_s as f32,
            stride_s: window_s as f32,
            ..Settings::DEFAULT
        };
        let (out, _) = touch(settings, snr_db, seed);
        let good = out
            .window_fits
            .iter()
            .filter(|fit| fit.status == Status::Good);
        for fit in good {
            (sum, count) = (sum + f64::from(relative_sigma(fit)), count + 1);
        }
    }
    sum / f64::from(count)
}

/// Returns the shortest window, in whole strides, whose mean sigma meets the accuracy.
fn length_needed_s(accuracy: f32, snr_db: f64) -> f64 {
    (2..20)
        .map(|strides| f64::from(strides) * STRIDE_S)
        .find(|length_s| mean_sigma(*length_s, snr_db) <= f64::from(accuracy))
        .expect("a second is enough")
}

/// Judges only the mean length: a window's noise is estimated from a few bins and scatters by some
/// tens of percent.
#[test]
fn an_estimate_comes_as_soon_as_it_is_accurate_and_no_sooner() {
    let mut errors = Vec::new();
    for (accuracy, snr_db) in [(0.01, 10.0), (0.005, 10.0), (0.002, 20.0)] {
        let mut lengths = Vec::new();
        for seed in 0..SEEDS {
            let (out, frequency_hz) = at(accuracy, snr_db, seed);
            assert!(out.window_fits.len() > 1, "{accuracy}: {out:?}");
            for fit in &out.window_fits {
                assert_eq!(fit.status, Status::Good, "{fit:?}");
                assert!(
                    relative_sigma(fit) <= accuracy,
                    "no sooner than {accuracy}: {fit:?}"
                );
                errors.push((fit.frequency as f64 - frequency_hz) / fit.sigma as f64);
                lengths.push(f64::from(fit.window_s));
            }
            // Windows do not overlap.
            for pair in out.window_fits.windows(2) {
                let begins_s = pair[1].t_us as f64 * 1e-6 - pair[1].window_s as f64;
                assert!(begins_s > pair[0].t_us as f64 * 1e-6 - 0.005, "{pair:?}");
            }
        }
        let needed_s = length_needed_s(accuracy, snr_db);
        let mean_s = lengths.iter().sum::<f64>() / lengths.len() as f64;
        println!("{accuracy}: {mean_s} s on average, {needed_s} s needed");
        assert!(
            (mean_s - needed_s).abs() < 1.5 * STRIDE_S,
            "{accuracy}: {mean_s} s on average, {needed_s} s needed: {lengths:?}"
        );
    }
    // Stopping as soon as sigma is small enough must not make sigma too small.
    let rms = (errors.iter().map(|error| error * error).sum::<f64>() / errors.len() as f64).sqrt();
    println!("{rms}");
    assert!(rms < 1.25, "{rms} sigma over {} estimates", errors.len());
}

#[test]
fn what_cannot_be_met_is_reported_at_the_greatest_length() {
    let (out, _) = at(1e-5, 10.0, 1);
    assert!(!out.window_fits.is_empty(), "{out:?}");
    for fit in &out.window_fits {
        assert!((fit.window_s - 1.0).abs() < 0.003, "{fit:?}");
        assert!(relative_sigma(fit) > 1e-5);
    }
    assert_eq!(out.slide_fits.len(), 1);
}
