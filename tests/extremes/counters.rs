//! Tests counters that wrap: the board's microseconds after 71.6 minutes, and the frame numbers
//! after 206 days.

use crate::any_settings::touch::{SCANS, scan};
use ridgetone_finger::{Pipeline, TimedConversion};
use ridgetone_proto::settings::{FRAME_RATE_HZ, Settings};
use ridgetone_proto::telemetry::{Event, Status};

fn events(conversions: impl Iterator<Item = TimedConversion>, accuracy: f32) -> Vec<Event> {
    let settings = Settings {
        window_s: 0.5,
        stride_s: 0.1,
        accuracy,
        ..Settings::DEFAULT
    };
    let mut pipeline = Box::new(Pipeline::new(settings));
    let mut events = Vec::new();
    for conversion in conversions {
        pipeline.push(conversion, &mut |event| events.push(event));
    }
    pipeline.finish(&mut |event| events.push(event));
    events
}

#[test]
fn time_stamps_that_wrap_change_nothing() {
    let plain = events((0..SCANS).flat_map(|n| scan(n, n, 0)), 0.0);
    let fits = plain
        .iter()
        .filter(|event| matches!(event, Event::Estimate(fit) if fit.status == Status::Good))
        .count();
    assert!(fits > 15, "{fits}");
    for seconds in [0, 1, 2, 3] {
        let start_us = 0u32.wrapping_sub(seconds * 1_000_000 + 313);
        assert_eq!(
            events((0..SCANS).flat_map(|n| scan(n, n, start_us)), 0.0),
            plain,
            "{seconds} s before the wrap"
        );
    }
}

/// The finger is idle for 206 days and is then touched. Meanwhile only one conversion an hour
/// arrives, because time stamps cannot measure gaps longer than 71.6 minutes.
#[test]
fn frame_numbers_that_wrap_change_nothing() {
    const IDLE: u64 = 60;
    let steps = 4200;
    // Wraps the number in the middle of the slide, at scan 430.
    let skipped = (1u64 << 32) - 430;
    let later_us = (skipped as f64 * 1e6 / FRAME_RATE_HZ as f64) as u64;
    let numbers = (1..=steps).map(|step| IDLE + skipped * step / steps);
    let rest = numbers.flat_map(|number| scan(IDLE, number, 0).take(1));
    let touch = (IDLE..SCANS).flat_map(|n| scan(n, n + skipped, 0).skip((n == IDLE) as usize));
    let rested = (0..IDLE)
        .flat_map(|n| scan(n, n, 0))
        .chain(rest)
        .chain(touch);
    // With windows of fixed length, and with windows that grow.
    for accuracy in [0.0, 0.001] {
        let wrapped = estimates(&events(rested.clone(), accuracy));
        let plain = estimates(&events((0..SCANS).flat_map(|n| scan(n, n, 0)), accuracy));
        assert!(plain.len() > 4);
        assert_eq!(wrapped.len(), plain.len());
        for (wrapped, plain) in wrapped.iter().zip(&plain) {
            assert_eq!(
                (wrapped.status, wrapped.span, wrapped.harmonics),
                (plain.status, plain.span, plain.harmonics)
            );
            let off = (wrapped.frequency - plain.frequency).abs();
            // Blocks start elsewhere in the ring and are summed in a different order, which changes
            // the f32 rounding. Without a tone both frequencies are zero.
            assert!(
                off <= (0.1 * plain.sigma).max(2e-6 * plain.frequency),
                "{wrapped:?} {plain:?}"
            );
            // The rate is the nominal one, in f32.
            let off = wrapped.t_us.abs_diff(plain.t_us + later_us);
            assert!(
                (off as f64) < 1e-6 * later_us as f64,
                "{wrapped:?} {plain:?}"
            );
        }
    }
}

fn estimates(events: &[Event]) -> Vec<ridgetone_proto::telemetry::Estimate> {
    let fits = events.iter().filter_map(|event| match event {
        Event::Estimate(fit) => Some(fit.clone()),
        _ => None,
    });
    fits.collect()
}
