//! Phases of a touch, found in frames that the tests make.

mod loaded;

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use ridgetone_finger::Ring;
use ridgetone_finger::internals::{Averager, Averages};
use ridgetone_finger::internals::{Change, ContactDetector, Observed};
use ridgetone_proto::plan::Plan;
use ridgetone_proto::settings::{FRAME_RATE_HZ, Slide};
use std::f64::consts::TAU;

/// Codes of one taxel at a time in seconds, without noise; channels differ by `sign` and `lag`.
type Signal = fn(f64, f64, f64) -> f64;

/// What is found, without the images of holds.
fn changes(seconds: f64, noise: f64, signal: Signal) -> Vec<(&'static str, f64)> {
    let mut found = all_changes(seconds, noise, |_| Slide::DEFAULT, signal);
    found.retain(|(name, _)| *name != "image");
    found
}

/// All that is found, by the rule at each time in seconds.
fn all_changes(
    seconds: f64,
    noise: f64,
    rule: fn(f64) -> Slide,
    signal: Signal,
) -> Vec<(&'static str, f64)> {
    let rate = FRAME_RATE_HZ as f64;
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    let mut normal = || {
        (0..12)
            .map(|_| rng.next_u32() as f64 / 4_294_967_296.0)
            .sum::<f64>()
            - 6.0
    };
    let mut ring = Box::new(Ring::new());
    let mut detector = ContactDetector::new(rule(0.0), &Plan::PAPER);
    let mut averager = Averager::new(&Plan::PAPER);
    let mut found = Vec::new();
    let mut report = |change: Change| {
        let at = |frame: u32| frame as f64 / rate;
        match change {
            Change::Contact { frame, .. } => found.push(("contact", at(frame))),
            Change::HoldEnd {
                span: (_, until), ..
            } => found.push(("image", at(until))),
            Change::SlideStart(frame) => found.push(("start", at(frame))),
            Change::SlideEnd(_, frame) => found.push(("end", at(frame))),
            Change::Release(frame) => found.push(("release", at(frame))),
        }
    };
    let frames = (seconds * rate) as u32;
    for n in 0..frames {
        let mut values = [0.0; 16];
        for (c, value) in values.iter_mut().enumerate() {
            let sign = if c % 2 == 0 { 1.0 } else { -1.0 };
            *value =
                (signal(n as f64 / rate, sign, c as f64 / 16.0) + noise * normal()).round() as f32;
        }
        ring.push(&values, u16::MAX, 0);
        averager.push(n, &values, u16::MAX, true);
        detector.slide = rule(n as f64 / rate);
        detector.push(
            n,
            Observed {
                values: &values,
                squares: None,
            },
            Averages::new(&ring, averager.grid()),
            &mut report,
        );
    }
    detector.finish(frames, &mut report);
    found
}

fn assert_reported(found: &[(&str, f64)], expected: &[(&str, f64)], within_s: f64) {
    let names = |list: &[(&str, f64)]| {
        list.iter()
            .map(|(name, _)| name.to_string())
            .collect::<Vec<_>>()
    };
    assert_eq!(names(found), names(expected), "{found:?}");
    for (found, expected) in found.iter().zip(expected) {
        assert!(
            (found.1 - expected.1).abs() < within_s,
            "{found:?} instead of {expected:?}"
        );
    }
}

/// Loading at 1 s with a spike that decays, unloading at `off_s`.
fn load(t: f64, off_s: f64) -> f64 {
    if t < 1.0 || t >= off_s {
        0.0
    } else {
        5000.0 + 4000.0 * (-(t - 1.0) / 0.03).exp()
    }
}

#[test]
fn a_touch_without_a_slide_is_contact_and_release() {
    let found = changes(5.0, 20.0, |t, sign, _| sign * load(t, 3.0));
    assert_reported(&found, &[("contact", 1.0), ("release", 3.0)], 0.01);
}

#[test]
fn a_skin_that_creeps_does_not_slide() {
    // A fifth of the load creeps in over a second, as in a Kelvin body.
    let found = changes(6.0, 20.0, |t, sign, _| {
        let load = load(t, 5.0);
        if load == 0.0 {
            0.0
        } else {
            sign * (load + 1000.0 * (1.0 - (-(t - 1.0) / 0.8).exp()))
        }
    });
    assert_reported(&found, &[("contact", 1.0), ("release", 5.0)], 0.01);
}

#[test]
fn two_slides_in_one_touch() {
    fn slid(t: f64) -> f64 {
        (t - 2.0).clamp(0.0, 1.0) + (t - 4.0).clamp(0.0, 1.0)
    }
    let found = changes(8.0, 20.0, |t, sign, lag| {
        let tone = if load(t, 7.0) == 0.0 {
            0.0
        } else {
            500.0 * (TAU * (6.3 * slid(t) + lag)).sin()
        };
        sign * (load(t, 7.0) + tone)
    });
    let expected = [
        ("contact", 1.0),
        ("start", 2.0),
        ("end", 3.0),
        ("start", 4.0),
        ("end", 5.0),
        ("release", 7.0),
    ];
    assert_reported(&found, &expected, 0.02);
}

#[test]
fn slow_and_fast_tones_are_slides_too() {
    for frequency in [0.7, 7.53, 30.1, 60.3, 100.0] {
        // A function pointer cannot carry the frequency.
        static FREQUENCY: std::sync::atomic::AtomicU64 = std::sync::atomic::AtomicU64::new(0);
        FREQUENCY.store(
            f64::to_bits(frequency),
            std::sync::atomic::Ordering::Relaxed,
        );
        let found = changes(8.0, 20.0, |t, sign, lag| {
            let frequency = f64::from_bits(FREQUENCY.load(std::sync::atomic::Ordering::Relaxed));
            let slid = (t - 2.0).clamp(0.0, 4.0);
            let tone = if load(t, 7.0) == 0.0 {
                0.0
            } else {
                500.0 * (TAU * (frequency * slid + lag)).sin()
            };
            sign * (load(t, 7.0) + tone)
        });
        let expected = [
            ("contact", 1.0),
            ("start", 2.0),
            ("end", 6.0),
            ("release", 7.0),
        ];
        assert_reported(&found, &expected, 0.03);
    }
}

#[test]
fn a_slide_that_lifts_off_ends_and_releases() {
    let found = changes(5.0, 20.0, |t, sign, lag| {
        let tone = if load(t, 4.0) == 0.0 {
            0.0
        } else {
            500.0 * (TAU * (6.3 * (t - 2.0).max(0.0) + lag)).sin()
        };
        sign * (load(t, 4.0) + tone)
    });
    assert_reported(
        &found,
        &[
            ("contact", 1.0),
            ("start", 2.0),
            ("end", 4.0),
            ("release", 4.0),
        ],
        0.02,
    );
}

#[test]
fn a_record_that_ends_in_a_slide_closes_it() {
    let found = changes(4.0, 20.0, |t, sign, lag| {
        let tone = if t < 1.0 {
            0.0
        } else {
            500.0 * (TAU * (6.3 * (t - 2.0).max(0.0) + lag)).sin()
        };
        sign * (load(t, 99.0) + tone)
    });
    assert_reported(
        &found,
        &[("contact", 1.0), ("start", 2.0), ("end", 4.0)],
        0.03,
    );
}

#[test]
fn hum_is_not_a_touch() {
    let found = changes(30.0, 20.0, |t, sign, lag| {
        sign * 100.0 * (TAU * (50.0 * t + lag)).sin()
    });
    assert_reported(&found, &[], 0.0);
}

#[test]
fn a_quiet_signal_of_whole_codes_is_not_a_touch() {
    assert_reported(&changes(10.0, 0.0, |_, _, _| 3.0), &[], 0.0);
}

#[test]
fn a_skin_that_creeps_back_after_the_touch_is_in_the_air() {
    // A quarter of the load stays and creeps back within seconds; the second touch is one again.
    let found = changes(16.0, 20.0, |t, sign, _| {
        let touch = |from: f64, to: f64| {
            if t < from {
                0.0
            } else if t < to {
                5000.0
            } else {
                1250.0 * (-(t - to) / 0.8).exp()
            }
        };
        sign * (touch(1.0, 3.0) + touch(10.0, 12.0))
    });
    let names: Vec<_> = found.iter().map(|(name, _)| *name).collect();
    assert_eq!(
        names,
        ["contact", "release", "contact", "release"],
        "{found:?}"
    );
    assert!((found[2].1 - 10.0).abs() < 0.02, "{found:?}");
}

#[test]
fn a_slide_ends_with_the_touch_even_if_something_shakes_the_finger_for_good() {
    let found = changes(14.0, 20.0, |t, sign, lag| {
        let shake = if t > 3.0 {
            150.0 * (TAU * (23.0 * t + 3.0 * lag)).sin()
        } else {
            0.0
        };
        let load = if (1.0..5.0).contains(&t) || (9.0..11.0).contains(&t) {
            5000.0
        } else {
            0.0
        };
        sign * load + shake
    });
    let last: Vec<_> = found.iter().rev().take(3).map(|(name, _)| *name).collect();
    assert!(
        found
            .iter()
            .any(|(name, at)| *name == "release" && (4.9..5.5).contains(at)),
        "{found:?}"
    );
    assert!(
        found
            .iter()
            .any(|(name, at)| *name == "contact" && (8.9..9.2).contains(at)),
        "{found:?}"
    );
    assert_eq!(last[0], "release", "{found:?}");
}

/// A knock in each hold shakes the finger for 100 ms, which is shorter than any slide.
#[test]
fn a_knock_during_a_hold_is_no_slide_and_moves_no_end() {
    let found = changes(8.0, 20.0, |t, sign, lag| {
        let knock = |from_s: f64| {
            if (from_s..from_s + 0.1).contains(&t) {
                (TAU * 40.0 * (t - from_s)).sin()
            } else {
                0.0
            }
        };
        let tone = if load(t, 7.0) == 0.0 {
            0.0
        } else {
            (TAU * (3.1 * (t - 3.0).clamp(0.0, 2.0) + lag)).sin()
        };
        sign * (load(t, 7.0) + 500.0 * (tone + knock(2.0) + knock(6.0)))
    });
    let expected = [
        ("contact", 1.0),
        ("start", 3.0),
        ("end", 5.0),
        ("release", 7.0),
    ];
    assert_reported(&found, &expected, 0.02);
}

/// Twelve times the hold's square and more is no tap: the finger is down until it is lifted.
#[test]
fn a_high_spike_is_no_tap() {
    let found = changes(6.0, 20.0, |t, sign, _| {
        let load = if (1.0..4.0).contains(&t) {
            1000.0 + 5000.0 * (-(t - 1.0) / 0.04).exp()
        } else {
            0.0
        };
        sign * load
    });
    assert_reported(&found, &[("contact", 1.0), ("release", 4.0)], 0.01);
}

/// Means of four frames have nothing of a tone near 60 Hz.
#[test]
fn a_tone_of_60_hz_as_strong_as_the_noise_is_a_slide() {
    let found = changes(12.0, 100.0, |t, sign, lag| {
        let tone = if (2.0..10.0).contains(&t) {
            141.0 * (TAU * (60.0 * (t - 2.0) + lag)).sin()
        } else {
            0.0
        };
        sign * load(t, 11.0) + tone
    });
    let expected = [
        ("contact", 1.0),
        ("start", 2.0),
        ("end", 10.0),
        ("release", 11.0),
    ];
    assert_reported(&found, &expected, 0.02);
}

#[test]
fn lifting_soon_after_a_slide_moves_no_end() {
    for (lifted_s, signal) in [
        (
            3.06,
            (|t, sign, lag| sign * (load(t, 3.06) + slid(t, 3.06, lag))) as Signal,
        ),
        (3.2, |t, sign, lag| {
            sign * (load(t, 3.2) + slid(t, 3.2, lag))
        }),
        (3.7, |t, sign, lag| {
            sign * (load(t, 3.7) + slid(t, 3.7, lag))
        }),
    ] {
        let expected = [
            ("contact", 1.0),
            ("start", 2.0),
            ("end", 3.0),
            ("release", lifted_s),
        ];
        assert_reported(&changes(6.0, 20.0, signal), &expected, 0.02);
    }
    fn slid(t: f64, off_s: f64, lag: f64) -> f64 {
        if load(t, off_s) == 0.0 {
            0.0
        } else {
            500.0 * (TAU * (8.3 * (t - 2.0).clamp(0.0, 1.0) + lag)).sin()
        }
    }
}

/// A reference that is off for a while scales every level. Nothing has slid between the lift and
/// that.
#[test]
fn a_lift_and_then_a_step_of_all_levels_is_no_slide() {
    for (ms, signal) in [
        (40, stepped::<40> as Signal),
        (50, stepped::<50>),
        (60, stepped::<60>),
        (70, stepped::<70>),
        (80, stepped::<80>),
        (90, stepped::<90>),
        (100, stepped::<100>),
        (120, stepped::<120>),
    ] {
        let found = changes(6.0, 20.0, signal);
        assert!(
            found
                .iter()
                .all(|(name, _)| matches!(*name, "contact" | "release")),
            "{ms}: {found:?}"
        );
        assert!(
            found.iter().any(|(name, _)| *name == "release"),
            "{ms}: {found:?}"
        );
    }
    /// The step begins so many milliseconds after the lift, and goes back in three parts.
    fn stepped<const MS: u32>(t: f64, sign: f64, _: f64) -> f64 {
        let since_s = t - 3.0 - f64::from(MS) * 1e-3;
        let parts = [0.0, 0.11, 0.15, 0.19]
            .iter()
            .filter(|at_s| since_s >= **at_s)
            .count();
        // The skin creeps back.
        let load = if t < 3.0 {
            load(t, 3.0)
        } else {
            500.0 * (-(t - 3.0) / 0.03).exp()
        };
        sign * load + [0.0, 20_000.0, 14_000.0, 7_000.0, 0.0][parts]
    }
}

/// It is down again before its lift is detected. The slide begins after that.
#[test]
fn a_finger_that_lifts_for_a_moment_and_slides_on_slides_from_there_on() {
    let found = changes(8.0, 20.0, |t, sign, lag| {
        let is_down = (1.0..3.0).contains(&t) || (3.08..6.0).contains(&t);
        let tone = if (3.08..5.0).contains(&t) {
            500.0 * (TAU * (8.3 * t + lag)).sin()
        } else {
            0.0
        };
        sign * if is_down { 5000.0 + tone } else { 0.0 }
    });
    let start = found
        .iter()
        .find(|(name, _)| *name == "start")
        .expect("a slide");
    let end = found
        .iter()
        .find(|(name, _)| *name == "end")
        .expect("its end");
    assert!(
        (3.06..3.13).contains(&start.1) && (end.1 - 5.0).abs() < 0.02,
        "{found:?}"
    );
}

#[test]
fn a_finger_that_presses_more_and_less_does_not_slide() {
    let found = changes(8.0, 20.0, |t, sign, lag| {
        sign * (0.3 + lag)
            * load(t, 7.0)
            * (1.0 + 0.1 * (TAU * 2.0 * t).sin() * ((t - 1.0) / 0.3).clamp(0.0, 1.0))
    });
    assert_reported(&found, &[("contact", 1.0), ("release", 7.0)], 0.01);
}

/// The drift passes the load within half a second.
#[test]
fn a_drift_is_no_touch_and_hides_none() {
    let found = changes(12.0, 20.0, |t, sign, lag| {
        let tone = 500.0 * (TAU * (8.3 * (t - 3.0).clamp(0.0, 2.0) + lag)).sin();
        let touch = if (2.0..6.0).contains(&t) {
            5000.0 + tone
        } else {
            0.0
        };
        sign * touch
            + if lag < 0.5 {
                10_000.0 * t
            } else {
                -10_000.0 * t
            }
    });
    let expected = [
        ("contact", 2.0),
        ("start", 3.0),
        ("end", 5.0),
        ("release", 6.0),
    ];
    assert_reported(&found, &expected, 0.02);
}

/// The skin creeps by one and a half loads, and back after the release: that is where the load
/// falls.
#[test]
fn a_release_is_where_the_load_falls_though_the_skin_stays_behind() {
    let found = changes(9.0, 20.0, |t, sign, _| {
        let crept = |for_s: f64| 7500.0 * (1.0 - (-for_s.max(0.0) / 1.5).exp());
        sign * (load(t, 5.0)
            + if t < 5.0 {
                crept(t - 1.0)
            } else {
                crept(4.0) * (-(t - 5.0) / 1.5).exp()
            })
    });
    assert_reported(&found, &[("contact", 1.0), ("release", 5.0)], 0.02);
}

#[test]
fn half_of_a_load_less_is_no_release() {
    let found = changes(9.0, 20.0, |t, sign, _| {
        sign * load(t, 6.0) * if t < 3.0 { 1.0 } else { 0.5 }
    });
    assert_reported(&found, &[("contact", 1.0), ("release", 6.0)], 0.01);
}

/// A quarter of a cycle is all that a comparison over 0.25 s sees of it.
#[test]
fn a_tone_of_1_hz_as_strong_as_the_noise_is_one_slide() {
    let found = changes(12.0, 100.0, |t, sign, lag| {
        let tone = if load(t, 11.0) == 0.0 {
            0.0
        } else {
            141.0 * (TAU * ((t - 3.0).clamp(0.0, 5.0) + lag)).sin()
        };
        sign * (load(t, 11.0) + tone)
    });
    let expected = [
        ("contact", 1.0),
        ("start", 3.0),
        ("end", 8.0),
        ("release", 11.0),
    ];
    assert_reported(&found, &expected, 0.3);
}

/// In its trough more than half of the load is gone, as in a release, and fast comparisons see
/// little.
#[test]
fn a_slow_slide_almost_as_high_as_the_load_is_no_release() {
    let found = changes(8.0, 900.0, |t, _, lag| {
        let tone = if load(t, 6.5) == 0.0 {
            0.0
        } else {
            (TAU * (3.0 * (t - 2.0).clamp(0.0, 4.0) + 0.5 * lag)).sin()
        };
        load(t, 6.5) + 4000.0 * tone
    });
    let expected = [
        ("contact", 1.0),
        ("start", 2.0),
        ("end", 6.0),
        ("release", 6.5),
    ];
    assert_reported(&found, &expected, 0.05);
}
