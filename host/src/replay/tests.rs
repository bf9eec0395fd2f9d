//! Recordings through the library: their uncertainties hold at any rate of the rows.

use super::*;
use crate::input::{Input, SLOT_S, Source, frame_rate_hz};
use hal_mock::{Sliding, SlidingScene, write_csv};
use ridgetone_proto::telemetry::{Span, Status};

/// Estimates of windows of touches of which some channels were recorded at `rate_hz`: each one's
/// error by its sigma.
fn errors(rate_hz: f64, decimals: usize, channels: usize) -> Vec<f64> {
    let (folder, mut errors) = (tempfile::tempdir().unwrap(), Vec::new());
    let path = folder.path().join("touch.csv");
    for seed in 0..30 {
        let speed_mm_s = 20.0 + (seed * 7 % 23) as f64;
        let scene = Sliding {
            seed,
            speed_mm_s,
            slide_mm: 3.0 * speed_mm_s,
            ..Sliding::default()
        };
        let mut scene = SlidingScene::new(scene).unwrap();
        let mut csv = Vec::new();
        write_csv(&mut scene, rate_hz, SLOT_S, &mut csv).unwrap();
        let rounded = |line: &str| {
            let (time, values) = line.split_once(',').unwrap();
            let values = values
                .split(',')
                .take(channels)
                .collect::<Vec<_>>()
                .join(",");
            time.parse::<f64>()
                .map_or(format!("{time},{values}"), |t_s| {
                    format!("{t_s:.decimals$},{values}")
                })
        };
        let csv: Vec<String> = str::from_utf8(&csv).unwrap().lines().map(rounded).collect();
        std::fs::write(&path, csv.join("\n")).unwrap();
        let source = Source::Trace {
            samples: crate::samples::Samples::file(&path).unwrap(),
            rate_hz: None,
            volts_per_unit: 1.0,
        };
        let input = Input {
            source,
            converter_noise: false,
            seed: 1,
        }
        .open()
        .unwrap();
        let mut sink = |packet: &Packet| {
            if let Event::Estimate(fit) = &packet.event
                && fit.span == Span::Window
                && fit.status == Status::Good
            {
                let off_hz = f64::from(fit.frequency) - scene.truth().frequency_hz;
                errors.push(off_hz / f64::from(fit.sigma));
            }
            Ok(())
        };
        run(
            input,
            Settings {
                window_s: 0.5,
                ..Settings::DEFAULT
            },
            &mut sink,
            &mut |_, _| {},
        )
        .unwrap();
    }
    errors
}

#[test]
fn recordings_of_any_rate_leave_intervals_that_hold() {
    for (rate_hz, decimals, channels) in [
        (frame_rate_hz(), 9, 16),
        (frame_rate_hz(), 3, 16),
        (241.0, 6, 16),
        (1000.0, 3, 16),
        (200.0, 3, 16),
        (100.0, 3, 16),
        // Few channels hold little noise in which to see that neighbouring scans are alike.
        (150.0, 3, 4),
        (150.0, 3, 1),
    ] {
        let errors = errors(rate_hz, decimals, channels);
        let held =
            errors.iter().filter(|error| error.abs() < 1.96).count() as f64 / errors.len() as f64;
        let rms =
            (errors.iter().map(|error| error * error).sum::<f64>() / errors.len() as f64).sqrt();
        let what = format!(
            "{rate_hz} Hz, {channels} channels, {} windows: {held:.3}, rms {rms:.2}",
            errors.len()
        );
        assert!(
            (0.92..=0.98).contains(&held) && (0.85..1.2).contains(&rms) && errors.len() > 300,
            "{what}"
        );
    }
}

/// A pass that ends early, or fails, is no shorter recording.
#[test]
fn a_second_pass_that_differs_from_the_first_is_noticed() {
    use crate::samples::Samples;
    use std::sync::Arc;
    use std::sync::atomic::{AtomicU32, Ordering};

    let whole = Arc::new(AtomicU32::new(0));
    let opened = Arc::clone(&whole);
    let samples = Samples::rows(
        "a file",
        Arc::new(move || {
            let rows = if opened.fetch_add(1, Ordering::Relaxed) == 0 {
                2000
            } else {
                900
            };
            let value_at = Arc::new(|row: usize, _| 1e-3 * (row as f64 / 5.0).sin());
            let time_s = Arc::new(|row: usize| row as f64 / 241.0);
            let names = vec!["a".to_owned()];
            let all = Samples::array("a file", names, rows, value_at, Some(time_s));
            all.opener()()
        }),
    );
    let source = Source::Trace {
        samples,
        rate_hz: None,
        volts_per_unit: 1.0,
    };
    let input = Input {
        source,
        ..Input::default()
    };
    let opened = input.open().unwrap();
    let error = conversions(opened, &mut |_| Ok(()))
        .unwrap_err()
        .to_string();
    assert_eq!(whole.load(Ordering::Relaxed), 2);
    assert!(
        error.contains("a file: row 900: it ended after 900 rows, and had 2000 before"),
        "{error}"
    );
}
