//! Accuracy on request: an estimate as soon as its uncertainty meets the requested one, and no
//! sooner.

#[allow(dead_code, reason = "every test file uses a part of it")]
mod support;

use hal_mock::{Sliding, SlidingScene};
use ridgetone_proto::settings::Settings;
use ridgetone_proto::telemetry::{Estimate, Status};
use support::{Outcome, all, outcome, run};

const HOP_S: f64 = 0.05;

fn at(accuracy: f32, snr_db: f64, seed: u64) -> (Outcome, f64) {
    let scene = SlidingScene::new(Sliding {
        snr_db: Some(snr_db),
        seed,
        ..Sliding::default()
    })
    .unwrap();
    let frequency_hz = scene.truth().frequency_hz;
    let settings = Settings {
        accuracy,
        hop_s: HOP_S as f32,
        ..Settings::DEFAULT
    };
    settings.validate().unwrap();
    (outcome(&run(scene, settings, all)), frequency_hz)
}

fn relative_sigma(fit: &Estimate) -> f32 {
    fit.sigma / fit.frequency
}

/// Sigma falls at least with the length's power of -3/2, which bounds that of a window one hop
/// shorter.
#[test]
fn an_estimate_comes_as_soon_as_it_is_accurate_and_no_sooner() {
    let (mut errors, mut late) = (Vec::new(), Vec::new());
    for (accuracy, snr_db) in [(0.01, 10.0), (0.005, 10.0), (0.002, 20.0)] {
        let mut lengths = Vec::new();
        for seed in 0..20 {
            let (out, frequency_hz) = at(accuracy, snr_db, seed);
            assert!(out.window_fits.len() > 1, "{accuracy}: {out:?}");
            for fit in &out.window_fits {
                assert_eq!(fit.status, Status::Good, "{fit:?}");
                assert!(
                    relative_sigma(fit) <= accuracy,
                    "no sooner than {accuracy}: {fit:?}"
                );
                let before_s = fit.window_s - HOP_S as f32;
                // The shortest window may be better than requested, and one of less than one and a
                // half cycles is ambiguous.
                if before_s > 0.1 && f64::from(before_s) * frequency_hz > 1.5 {
                    let before = relative_sigma(fit) * (fit.window_s / before_s).powi(3);
                    if before <= accuracy {
                        late.push((accuracy, fit.window_s, fit.t_us));
                    }
                }
                errors.push((fit.frequency as f64 - frequency_hz) / fit.sigma as f64);
                lengths.push(fit.window_s);
            }
            // No frame is part of two estimates.
            for pair in out.window_fits.windows(2) {
                let begins_s = pair[1].t_us as f64 * 1e-6 - pair[1].window_s as f64;
                assert!(begins_s > pair[0].t_us as f64 * 1e-6 - 0.005, "{pair:?}");
            }
        }
        assert!(
            lengths.iter().all(|length_s| *length_s < 1.0),
            "{accuracy}: {lengths:?}"
        );
    }
    // One window in a hundred may look as if its noise were coloured or its tone moved; such a
    // window grows. In a test of this size chance adds three standard deviations.
    let one_in_a_hundred = errors.len() as f64 / 100.0;
    let most = one_in_a_hundred + 3.0 * one_in_a_hundred.sqrt();
    assert!(
        (late.len() as f64) <= most,
        "{} of {}: {late:?}",
        late.len(),
        errors.len()
    );
    // Stopping where sigma is small enough must not make it a lie.
    let rms = (errors.iter().map(|error| error * error).sum::<f64>() / errors.len() as f64).sqrt();
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
