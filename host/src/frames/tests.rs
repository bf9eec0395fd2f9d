use super::*;
use crate::input::{Input, SLOT_S, frame_rate_hz};
use crate::replay;
use hal_mock::{Sliding, SlidingScene, write_csv};
use ridgetone_proto::telemetry::{Span, Status, WIRE_MAX, encode};
use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};

fn run(frames: &Frames, settings: &Settings) -> Vec<Event> {
    let mut events = Vec::new();
    let mut sink = |packet: &Packet| {
        events.push(packet.event.clone());
        Ok(())
    };
    frames
        .run(settings, false, &mut sink, &mut |_, _| {})
        .expect("a run");
    events
}

fn open(path: &std::path::Path) -> Result<Frames> {
    Frames::open(&Samples::file(path)?, Reading::default())
}

fn estimates(events: &[Event]) -> Vec<&Estimate> {
    let mut estimates = Vec::new();
    for event in events {
        if let Event::Estimate(estimate) = event {
            estimates.push(estimate);
        }
    }
    estimates
}

/// From the raw frames of a recording that starts with the board, the library must find the same
/// events as the board, to the last bit, in both formats of the recording.
#[test]
fn the_raw_frames_of_a_recording_give_the_events_of_the_board_to_the_bit() {
    let settings = Settings {
        window_s: 0.5,
        ..Settings::DEFAULT
    };
    let (mut events, mut pipeline) = (Vec::new(), Box::new(Pipeline::new(settings)));
    pipeline.report_raw(u32::MAX);
    events.push(pipeline.hello());
    let input = Input::default().open().expect("a scene");
    replay::conversions(input, &mut |timed| {
        pipeline.push(timed, &mut |event| events.push(event));
        Ok(())
    })
    .expect("a run");
    pipeline.finish(&mut |event| events.push(event));
    let (mut bytes, mut lines) = (Vec::new(), String::new());
    for (sequence, event) in (0..).zip(events.clone()) {
        let (packet, mut wire) = (Packet { sequence, event }, [0; WIRE_MAX]);
        lines += &crate::events::json(&packet).expect("JSON");
        lines.push('\n');
        let used = encode(&packet, &mut wire).expect("it fits");
        bytes.extend_from_slice(&wire[..used]);
    }
    let folder = tempfile::tempdir().expect("a folder");
    for (name, content) in [("a.rec", bytes), ("a.jsonl", lines.into_bytes())] {
        let path = folder.path().join(name);
        std::fs::write(&path, content).expect("a file");
        let frames = open(&path).expect("frames");
        assert_eq!(frames.settings, settings, "{name}");
        let is_found = |event: &Event| {
            !matches!(
                event,
                Event::Hello(_) | Event::Health(_) | Event::Raw(_) | Event::Fault(_)
            )
        };
        let found = run(&frames, &frames.settings);
        let expected: Vec<Event> = events.iter().filter(|e| is_found(e)).cloned().collect();
        assert!(estimates(&expected).len() >= 5);
        assert_eq!(found, expected, "{name}");
    }
}

/// Writes the table of a scene as `emulate --print-scene` does.
fn table_of(scene: &Sliding, rate_hz: f64, path: &std::path::Path) {
    let mut made = SlidingScene::new(scene.clone()).expect("a scene");
    let file = std::fs::File::create(path).expect("a file");
    write_csv(&mut made, rate_hz, SLOT_S, file).expect("written");
}

/// A scene's table yields the frequencies and periods that a board in front of the scene reports,
/// within 0.3 sigma. The board's converter adds noise, far below that of the scene.
#[test]
fn a_table_in_volts_agrees_with_a_board_in_front_of_the_same_scene() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("scene.csv");
    let c1 = Sliding {
        snr_db: Some(20.0),
        ..crate::input::first_scene().expect("a scene")
    };
    for scene in [Sliding::default(), c1] {
        table_of(&scene, frame_rate_hz(), &path);
        let frames = open(&path).expect("frames");
        let found = run(&frames, &frames.settings);
        let mut of_board = Vec::new();
        let mut sink = |packet: &Packet| {
            of_board.push(packet.event.clone());
            Ok(())
        };
        let input = Input::of(scene).open().expect("a scene");
        replay::run(input, Settings::DEFAULT, &mut sink, &mut |_, _| {}).expect("a run");
        let (found, of_board) = (estimates(&found), estimates(&of_board));
        assert_eq!(found.len(), of_board.len());
        assert!(found.len() >= 5);
        for (found, of_board) in found.iter().zip(of_board) {
            let off = (found.frequency - of_board.frequency).abs() / of_board.sigma;
            assert!(off < 0.3, "{off} sigma: {found:?}\n{of_board:?}");
            let (found, of_board) = (&found.travel, &of_board.travel);
            let off_mm = (found.spatial_period_mm - of_board.spatial_period_mm).abs();
            assert!(
                found.status == of_board.status && off_mm <= 0.3 * of_board.spatial_period_sigma_mm,
                "{found:?}\n{of_board:?}"
            );
        }
    }
}

/// Returns the errors of estimates, in sigmas, for touches recorded with `channels` channels.
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
        let frames = open(&path).unwrap();
        let settings = Settings {
            window_s: 0.5,
            ..frames.settings
        };
        for fit in estimates(&run(&frames, &settings)) {
            if fit.span == Span::Window && fit.status == Status::Good {
                let off_hz = f64::from(fit.frequency) - scene.truth().frequency_hz;
                errors.push(off_hz / f64::from(fit.sigma));
            }
        }
    }
    errors
}

#[test]
fn recordings_of_any_rate_leave_intervals_that_cover_the_truth() {
    for (rate_hz, decimals, channels) in [
        (frame_rate_hz(), 9, 16),
        (frame_rate_hz(), 3, 16),
        (241.0, 6, 16),
        (1000.0, 3, 16),
        (200.0, 3, 16),
        (200.0, 3, 4),
        (200.0, 3, 1),
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

fn refusal(opened: Result<Frames>) -> String {
    opened.err().expect("refused").to_string()
}

#[test]
fn rows_that_are_no_steady_sampling_in_the_bounds_are_refused_with_the_command_that_fits_them() {
    let folder = tempfile::tempdir().expect("a folder");
    let table = |name: &str, columns: usize, times_s: &mut dyn Iterator<Item = f64>| {
        let header: String = (0..columns).map(|c| format!(",c{c}")).collect();
        let row = |t_s| format!("\n{t_s:.6}{}", ",0.5".repeat(columns));
        let text: String = times_s.map(row).collect();
        let path = folder.path().join(name);
        std::fs::write(&path, format!("time_s{header}{text}")).expect("a file");
        path
    };
    let jump = |at: f64, by_s: f64| {
        move |row: u32| {
            let t_s = f64::from(row) * 1e-3;
            if t_s < at { t_s } else { t_s + by_s }
        }
    };
    let slow = table(
        "slow.csv",
        2,
        &mut (0..400).map(|row| f64::from(row) * 0.01),
    );
    let slower = table("a b.csv", 2, &mut (0..400).map(f64::from));
    let fast = table(
        "fast.csv",
        2,
        &mut (0..400).map(|row| f64::from(row) * 2e-5),
    );
    let wide = table(
        "wide.csv",
        17,
        &mut (0..400).map(|row| f64::from(row) * 1e-3),
    );
    let hour = table("hour.csv", 2, &mut (0..450).map(jump(0.25, 3600.0)));
    let pause = table("pause.csv", 2, &mut (0..450).map(jump(0.25, 1.0)));
    let uneven = table(
        "uneven.csv",
        2,
        &mut (0..900)
            .filter(|row| row % 10 < 6)
            .map(|row| f64::from(row) * 1e-3),
    );
    for (path, parts) in [
        (
            slow,
            &[
                "100.00 rows a second",
                "180 to 23740",
                "`ridgetone fit --window 1 ",
            ][..],
        ),
        (
            slower,
            &["`ridgetone fit --window 64 '", "a b.csv'` fits it"],
        ),
        (fast, &["50000 rows a second", "--window 1 "]),
        (wide, &["17 channels", "--columns NAMES"]),
        (
            hour,
            &[
                "row 251",
                "a gap of 3600.00 s",
                "--to 0.249` fits the rows before",
            ],
        ),
        (pause, &["row 251", "a gap of 1.00100 s"]),
        (uneven, &["not evenly spaced", "`ridgetone fit /"]),
    ] {
        let error = refusal(open(&path));
        assert!(parts.iter().all(|part| error.contains(part)), "{error}");
    }
}

/// A second pass that ends early or fails is not taken for a shorter recording.
#[test]
fn a_second_pass_that_differs_from_the_first_is_noticed() {
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
    let frames = Frames::open(&samples, Reading::default()).expect("frames");
    let error = frames.touches().expect_err("refused").to_string();
    assert_eq!(whole.load(Ordering::Relaxed), 2);
    assert!(
        error.contains("a file: row 900: it ended after 900 rows, and had 2000 before"),
        "{error}"
    );
}
