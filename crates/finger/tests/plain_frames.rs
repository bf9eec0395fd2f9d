//! Tests frames from a different converter: three channels in volts at 1 kHz.

use ridgetone_finger::{Pipeline, PlainFrame};
use ridgetone_proto::plan::Plan;
use ridgetone_proto::settings::Settings;
use ridgetone_proto::telemetry::{Event, Span, Status};
use std::f64::consts::TAU;

#[path = "../examples/plain_frames.rs"]
mod example;

/// Nearly Gaussian noise with standard deviation `sigma`, from sums of twelve uniform numbers.
fn noise(state: &mut u64, sigma: f64) -> f64 {
    let mut uniform = || {
        *state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (*state >> 33) as f64 / (1u64 << 31) as f64
    };
    sigma * ((0..12).map(|_| uniform()).sum::<f64>() - 6.0)
}

/// Touches from 1 s on, with a load that rises with the time constant `creep_s`, slides at 37.3 Hz
/// from 2 to 4 s, and releases at 4.5 s. Omits frames for which `is_lost` returns true.
fn touch(creep_s: f64, is_lost: impl Fn(u64) -> bool) -> Vec<Event> {
    let plan = Plan::of_frames(1000.0, 3).expect("a plan");
    let settings = Settings {
        vref_v: 2.5,
        ..Settings::DEFAULT.with_plan(plan)
    };
    let mut pipeline = Box::new(Pipeline::new(settings));
    let (mut events, mut state) = (Vec::new(), 7);
    for number in 0..6000 {
        let t_s = number as f64 * 1e-3;
        let load = match t_s {
            1.0..4.5 => 0.02 * (1.0 - (-(t_s - 1.0) / creep_s).exp()),
            _ => 0.0,
        };
        let tone = match t_s {
            2.0..4.0 => 2e-3 * (TAU * 37.3 * t_s).sin(),
            _ => 0.0,
        };
        let readings =
            &[1.0, -0.6, 0.8].map(|gain| (gain * (load + tone) + noise(&mut state, 2e-5)) as f32);
        if !is_lost(number) {
            let t_us = 1000 * number;
            pipeline.push_frame(PlainFrame { t_us, readings }, &mut |event| {
                events.push(event)
            });
        }
    }
    pipeline.finish(&mut |event| events.push(event));
    events
}

#[test]
fn a_touch_is_found_from_its_onset_to_its_release() {
    for creep_s in [0.005, 0.05, 0.15] {
        let events = touch(creep_s, |_| false);
        let [mut contacts, mut slides, mut releases] = [0; 3];
        let near = |t_us: u64, t_s: f64, limit_s: f64, what: &str| {
            let found_s = t_us as f64 * 1e-6;
            let off_s = (found_s - t_s).abs();
            assert!(off_s < limit_s, "{creep_s} s: {what} at {found_s} s");
        };
        for event in &events {
            match event {
                Event::Contact(contact) => {
                    contacts += 1;
                    near(contact.onset_us, 1.0, 0.01, "the onset");
                    assert!(contact.onset_us <= contact.t_us, "{contact:?}");
                }
                Event::Slide(slide) => {
                    slides += 1;
                    near(slide.start_us, 2.0, 0.02, "the slide");
                    if let Some(end_us) = slide.end_us {
                        near(end_us, 4.0, 0.03, "its end");
                    }
                }
                Event::Release(release) => {
                    releases += 1;
                    near(release.t_us, 4.5, 0.02, "the release");
                }
                Event::Estimate(estimate) => {
                    let off = (f64::from(estimate.frequency) - 37.3) / f64::from(estimate.sigma);
                    assert!(off.abs() < 5.0, "{estimate:?}");
                    let found = (estimate.status, estimate.channels.len());
                    assert_eq!(found, (Status::Good, 3));
                }
                Event::Fault(fault) => panic!("{fault:?}"),
                _ => {}
            }
        }
        assert_eq!((contacts, slides, releases), (1, 2, 1), "{creep_s} s");
        let whole = |event: &&Event| matches!(event, Event::Estimate(estimate) if estimate.span == Span::Slide);
        assert_eq!(events.iter().filter(whole).count(), 1);
    }
}

/// If the load rises slowly, its spike comes long after the onset.
#[test]
fn the_spike_of_a_slow_load_is_late() {
    let events = touch(0.15, |_| false);
    let contact = events.iter().find_map(|event| match event {
        Event::Contact(contact) => Some(*contact),
        _ => None,
    });
    let contact = contact.expect("a contact");
    assert!(contact.t_us > contact.onset_us + 100_000, "{contact:?}");
}

#[test]
fn frames_that_are_missing_are_counted() {
    let events = touch(0.05, |number| (700..710).contains(&number));
    let health = events.iter().rev().find_map(|event| match event {
        Event::Health(health) => Some(*health),
        _ => None,
    });
    let health = health.expect("health");
    assert_eq!((health.frames, health.conversions_lost), (5990, 10));
    assert!((health.frame_rate_hz - 1000.0).abs() < 0.1, "{health:?}");
}

#[test]
fn what_cannot_work_is_refused_with_what_can() {
    for (rate_hz, channels, field, bounds) in [
        (1000.0, 0, "channels", (1.0, 16.0)),
        (1000.0, 17, "channels", (1.0, 16.0)),
        (100.0, 3, "frame_rate_hz", (180.0, 23_740.0)),
        (f32::NAN, 3, "frame_rate_hz", (180.0, 23_740.0)),
    ] {
        let error = Plan::of_frames(rate_hz, channels).expect_err("refused");
        assert_eq!((error.field, error.bounds), (field, bounds));
    }
    for rate_hz in [180.0, 241.0, 999.7, 23_740.0] {
        for channels in [1, 3, 16] {
            let plan = Plan::of_frames(rate_hz, channels).expect("a plan");
            let off = plan.frame_rate_hz() / rate_hz - 1.0;
            assert!(off.abs() < 1e-5, "{plan:?}");
            assert_eq!(plan.channels(), channels);
        }
    }
}

#[test]
fn the_example_runs() {
    example::main();
}
