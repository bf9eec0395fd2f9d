//! Tests windows in which a tone is expected at the previous window's frequency.

mod common;

use common::{RATE_HZ, fit, fit_with, normal};
use ridgetone_tone::{Fit, Status};
use std::f64::consts::TAU;

const CHANNELS: usize = 16;
const FRAMES: usize = 241;

/// Lines of amplitude 1 at these cycles per window, 23 dB above white noise.
fn window(lines: &[f64], seed: u64) -> Vec<f32> {
    let mut normal = normal(seed);
    let mut values = Vec::new();
    for n in 0..FRAMES {
        for channel in 0..CHANNELS {
            let turns = |cycles: f64| cycles * n as f64 / FRAMES as f64 + 0.13 * channel as f64;
            let tone: f64 = lines
                .iter()
                .map(|cycles| (TAU * turns(*cycles)).cos())
                .sum();
            values.push((tone + 0.05 * normal()) as f32);
        }
    }
    values
}

#[test]
fn it_is_what_a_search_finds() {
    for n in 0..20u32 {
        let cycles = 5.3 + 1.7 * f64::from(n);
        let values = window(&[cycles, 2.0 * cycles], u64::from(n));
        let found = fit(&values, CHANNELS);
        // A hand's speed changes by about a percent between windows.
        let near = cycles as f32 * 1.01;
        let expected = fit_with(&values, CHANNELS, |span| span.expecting(near));
        assert_eq!(expected.status, Status::Good, "{cycles}: {expected:?}");
        assert!(
            (expected.frequency - found.frequency).abs() < 0.1 * found.sigma
                && (expected.sigma / found.sigma - 1.0).abs() < 0.05,
            "{cycles}: {expected:?} {found:?}"
        );
    }
}

/// If the tone is elsewhere, at half the expected frequency, or absent, the result is that of a
/// search without an expectation.
#[test]
fn what_is_not_there_is_searched_for() {
    for (lines, expected) in [
        (vec![12.4], 17.0),
        (vec![8.2, 16.4], 16.4),
        (vec![21.0], 7.0),
        (vec![], 10.0),
    ] {
        let values = window(&lines, 3);
        let found = fit(&values, CHANNELS);
        let tracked = fit_with(&values, CHANNELS, |span| span.expecting(expected));
        let bits = |fit: &Fit| (fit.status, fit.frequency.to_bits());
        assert_eq!(
            bits(&tracked),
            bits(&found),
            "{lines:?} where {expected} is expected"
        );
        let off = f64::from(found.frequency) - lines.first().unwrap_or(&0.0);
        assert!(off.abs() < 0.02, "{found:?}");
    }
    // The expected frequency has the same unit as the fit's, here hertz.
    let values = window(&[9.7], 4);
    let hz = RATE_HZ * 9.7 / FRAMES as f64;
    let tracked = fit_with(&values, CHANNELS, |span| {
        span.with_frame_rate(RATE_HZ as f32).expecting(hz as f32)
    });
    assert!(
        (f64::from(tracked.frequency) - hz).abs() < 0.02,
        "{tracked:?}"
    );
}
