//! Tests the detection of a touch's phases in synthetic frames.

mod loaded;

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use ridgetone_finger::Ring;
use ridgetone_finger::internals::{Averager, Averages, Change, ContactDetector, Observed};
use ridgetone_proto::plan::Plan;
use ridgetone_proto::settings::{FRAME_RATE_HZ, Slide};
use std::f64::consts::TAU;

/// Code of one channel without noise, as a function of time (seconds) and the channel's `sign` and
/// `lag`.
type Signal<'a> = &'a dyn Fn(f64, f64, f64) -> f64;

/// Returns all events except the pressure maps of holds.
fn changes(seconds: f64, noise: f64, signal: Signal<'_>) -> Vec<(&'static str, f64)> {
    let mut found = all_changes(seconds, noise, |_| Slide::DEFAULT, signal);
    found.retain(|(name, _)| *name != "image");
    found
}

/// Returns all events; `rule` returns the slide rule that applies at a time in seconds.
fn all_changes(
    seconds: f64,
    noise: f64,
    rule: fn(f64) -> Slide,
    signal: Signal<'_>,
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
            Change::HoldEnd(hold) => found.push(("image", at(hold.span.1))),
            Change::SlideStart(frame) => found.push(("start", at(frame))),
            Change::SlideEnd(_, frame) => found.push(("end", at(frame))),
            Change::Release(frame) => found.push(("release", at(frame))),
            Change::Moving(_) => {}
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

fn names<'a>(found: &'a [(&str, f64)]) -> impl Iterator<Item = &'a str> {
    found.iter().map(|(name, _)| *name)
}

fn assert_reported(found: &[(&str, f64)], expected: &[(&str, f64)], within_s: f64) {
    assert!(
        names(found).eq(names(expected)),
        "{found:?} instead of {expected:?}"
    );
    for (found, expected) in found.iter().zip(expected) {
        assert!(
            (found.1 - expected.1).abs() < within_s,
            "{found:?} instead of {expected:?}"
        );
    }
}

/// Load that starts at 1 s with a decaying spike and ends at `off_s`.
fn load(t: f64, off_s: f64) -> f64 {
    if t < 1.0 || t >= off_s {
        0.0
    } else {
        5000.0 + 4000.0 * (-(t - 1.0) / 0.03).exp()
    }
}

/// Expected events: contact at 1 s, one slide and the release.
fn slid(from_s: f64, to_s: f64, off_s: f64) -> [(&'static str, f64); 4] {
    [
        ("contact", 1.0),
        ("start", from_s),
        ("end", to_s),
        ("release", off_s),
    ]
}

fn touched(off_s: f64) -> [(&'static str, f64); 2] {
    [("contact", 1.0), ("release", off_s)]
}

/// Sine of `turns` cycles while the finger is loaded, until `off_s`.
fn tone(t: f64, off_s: f64, turns: f64) -> f64 {
    if load(t, off_s) == 0.0 {
        0.0
    } else {
        (TAU * turns).sin()
    }
}

/// `value` within a range of times, and zero outside.
fn during(range: std::ops::Range<f64>, t: f64, value: f64) -> f64 {
    if range.contains(&t) { value } else { 0.0 }
}

#[test]
fn what_only_loads_the_finger_does_not_slide() {
    let plain: Signal<'_> = &|t, sign, _| sign * load(t, 3.0);
    // A fifth of the load creeps in over a second, as in a Kelvin body.
    let creeps: Signal<'_> = &|t, sign, _| {
        let crept = 1000.0 * (1.0 - (-(t - 1.0) / 0.8).exp());
        sign * (load(t, 5.0) + during(1.0..5.0, t, crept))
    };
    // A spike whose square is more than twelve times the hold's is not a tap, because the finger
    // stays down.
    let high_spike: Signal<'_> =
        &|t, sign, _| sign * during(1.0..4.0, t, 1000.0 + 5000.0 * (-(t - 1.0) / 0.04).exp());
    let presses_more_and_less: Signal<'_> = &|t, sign, lag| {
        let swing = 0.1 * (TAU * 2.0 * t).sin() * ((t - 1.0) / 0.3).clamp(0.0, 1.0);
        sign * (0.3 + lag) * load(t, 7.0) * (1.0 + swing)
    };
    // The skin creeps by one and a half times the load, and creeps back after the load is removed.
    let stays_behind: Signal<'_> = &|t, sign, _| {
        let crept = |for_s: f64| 7500.0 * (1.0 - (-for_s.max(0.0) / 1.5).exp());
        let back = crept(4.0) * (-(t - 5.0) / 1.5).exp();
        sign * (load(t, 5.0) + if t < 5.0 { crept(t - 1.0) } else { back })
    };
    let half_is_lifted: Signal<'_> =
        &|t, sign, _| sign * load(t, 6.0) * if t < 3.0 { 1.0 } else { 0.5 };
    for (what, seconds, off_s, within_s, signal) in [
        ("a touch", 5.0, 3.0, 0.01, plain),
        ("a skin that creeps", 6.0, 5.0, 0.01, creeps),
        ("a high spike", 6.0, 4.0, 0.01, high_spike),
        (
            "pressing more and less",
            8.0,
            7.0,
            0.01,
            presses_more_and_less,
        ),
        ("a skin that stays behind", 9.0, 5.0, 0.02, stays_behind),
        ("half of the load less", 9.0, 6.0, 0.01, half_is_lifted),
    ] {
        println!("{what}");
        assert_reported(&changes(seconds, 20.0, signal), &touched(off_s), within_s);
    }
    println!("hum");
    let hum: Signal<'_> = &|t, sign, lag| sign * 100.0 * (TAU * (50.0 * t + lag)).sin();
    assert_reported(&changes(30.0, 20.0, hum), &[], 0.0);
    println!("a quiet signal of whole codes");
    assert_reported(&changes(10.0, 0.0, &|_, _, _| 3.0), &[], 0.0);
}

/// Touches with one slide; its start and end must be found.
#[test]
fn slides_are_found_where_they_begin_and_end() {
    for frequency in [0.7, 7.53, 30.1, 60.3, 100.0] {
        println!("{frequency} Hz");
        let found = changes(8.0, 20.0, &|t, sign, lag| {
            let turns = frequency * (t - 2.0).clamp(0.0, 4.0) + lag;
            sign * (load(t, 7.0) + 500.0 * tone(t, 7.0, turns))
        });
        assert_reported(&found, &slid(2.0, 6.0, 7.0), 0.03);
    }
    for off_s in [3.06, 3.2, 3.7] {
        println!("lifted at {off_s} s, soon after the slide");
        let found = changes(6.0, 20.0, &|t, sign, lag| {
            let turns = 8.3 * (t - 2.0).clamp(0.0, 1.0) + lag;
            sign * (load(t, off_s) + 500.0 * tone(t, off_s, turns))
        });
        assert_reported(&found, &slid(2.0, 3.0, off_s), 0.02);
    }
    let endless = |t: f64, off_s, lag| 500.0 * tone(t, off_s, 6.3 * (t - 2.0).max(0.0) + lag);
    let lifts_off: Signal<'_> = &|t, sign, lag| sign * (load(t, 4.0) + endless(t, 4.0, lag));
    // A knock in each hold shakes the finger for 100 ms, which is shorter than any slide.
    let knocks: Signal<'_> = &|t, sign, lag| {
        let knock = |from_s| during(from_s..from_s + 0.1, t, (TAU * 40.0 * (t - from_s)).sin());
        let tone = tone(t, 7.0, 3.1 * (t - 3.0).clamp(0.0, 2.0) + lag);
        sign * (load(t, 7.0) + 500.0 * (tone + knock(2.0) + knock(6.0)))
    };
    // A tone as strong as the noise, at 60 Hz: averaging four frames removes most of it.
    let of_60_hz: Signal<'_> = &|t, sign, lag| {
        let tone = during(2.0..10.0, t, 141.0 * (TAU * (60.0 * (t - 2.0) + lag)).sin());
        sign * load(t, 11.0) + tone
    };
    // A comparison over 0.25 s sees only a quarter of a cycle of the 1 Hz tone.
    let of_1_hz: Signal<'_> = &|t, sign, lag| {
        sign * (load(t, 11.0) + 141.0 * tone(t, 11.0, (t - 3.0).clamp(0.0, 5.0) + lag))
    };
    // In the tone's trough more than half of the load is gone, as in a release, and fast
    // comparisons see little change.
    let almost_as_high_as_the_load: Signal<'_> = &|t, _, lag| {
        let tone = tone(t, 6.5, 3.0 * (t - 2.0).clamp(0.0, 4.0) + 0.5 * lag);
        load(t, 6.5) + 4000.0 * tone
    };
    for (what, seconds, noise, expected, within_s, signal) in [
        (
            "lifted off in the slide",
            5.0,
            20.0,
            slid(2.0, 4.0, 4.0),
            0.02,
            lifts_off,
        ),
        (
            "knocks in the holds",
            8.0,
            20.0,
            slid(3.0, 5.0, 7.0),
            0.02,
            knocks,
        ),
        ("60 Hz", 12.0, 100.0, slid(2.0, 10.0, 11.0), 0.02, of_60_hz),
        ("1 Hz", 12.0, 100.0, slid(3.0, 8.0, 11.0), 0.3, of_1_hz),
        (
            "a strong tone",
            8.0,
            900.0,
            slid(2.0, 6.0, 6.5),
            0.05,
            almost_as_high_as_the_load,
        ),
    ] {
        println!("{what}");
        assert_reported(&changes(seconds, noise, signal), &expected, within_s);
    }
    println!("a record that ends in the slide");
    let found = changes(4.0, 20.0, &|t, sign, lag| {
        sign * (load(t, 99.0) + endless(t, 99.0, lag))
    });
    assert_reported(&found, &slid(2.0, 4.0, 0.0)[..3], 0.03);
}

#[test]
fn two_slides_in_one_touch() {
    let found = changes(8.0, 20.0, &|t, sign, lag| {
        let slid = (t - 2.0).clamp(0.0, 1.0) + (t - 4.0).clamp(0.0, 1.0);
        sign * (load(t, 7.0) + 500.0 * tone(t, 7.0, 6.3 * slid + lag))
    });
    let first = slid(2.0, 3.0, 7.0);
    let expected = [&first[..3], &slid(4.0, 5.0, 7.0)[1..]].concat();
    assert_reported(&found, &expected, 0.02);
}

/// A quarter of the load remains after the lift and decays within seconds. The second touch must
/// still be found.
#[test]
fn a_skin_that_creeps_back_after_the_touch_is_in_the_air() {
    let found = changes(16.0, 20.0, &|t, sign, _| {
        let touch = |from: f64, to: f64| {
            let back = 1250.0 * (-(t - to) / 0.8).exp();
            during(from..to, t, 5000.0) + during(to..f64::INFINITY, t, back)
        };
        sign * (touch(1.0, 3.0) + touch(10.0, 12.0))
    });
    assert!(
        names(&found).eq(["contact", "release", "contact", "release"]),
        "{found:?}"
    );
    assert!((found[2].1 - 10.0).abs() < 0.02, "{found:?}");
}

#[test]
fn a_slide_ends_with_the_touch_even_if_something_shakes_the_finger_for_good() {
    let found = changes(14.0, 20.0, &|t, sign, lag| {
        let shake = if t > 3.0 {
            150.0 * (TAU * (23.0 * t + 3.0 * lag)).sin()
        } else {
            0.0
        };
        sign * (during(1.0..5.0, t, 5000.0) + during(9.0..11.0, t, 5000.0)) + shake
    });
    let has = |what, range: std::ops::Range<f64>| {
        found
            .iter()
            .any(|(name, at)| *name == what && range.contains(at))
    };
    assert!(has("release", 4.9..5.5), "{found:?}");
    assert!(has("contact", 8.9..9.2), "{found:?}");
    assert_eq!(names(&found).last(), Some("release"), "{found:?}");
}

/// A disturbed reference scales all levels soon after the lift; there is no slide.
#[test]
fn a_lift_and_then_a_step_of_all_levels_is_no_slide() {
    for ms in [40, 50, 60, 70, 80, 90, 100, 120] {
        // The step begins `ms` milliseconds after the lift, and returns in three parts.
        let found = changes(6.0, 20.0, &|t, sign, _| {
            let since_s = t - 3.0 - f64::from(ms) * 1e-3;
            let parts = [0.0, 0.11, 0.15, 0.19]
                .iter()
                .filter(|at_s| since_s >= **at_s)
                .count();
            // The skin creeps back.
            let back = 500.0 * (-(t - 3.0) / 0.03).exp();
            let load = if t < 3.0 { load(t, 3.0) } else { back };
            sign * load + [0.0, 20_000.0, 14_000.0, 7_000.0, 0.0][parts]
        });
        let only_touches = names(&found).all(|name| matches!(name, "contact" | "release"));
        assert!(only_touches, "{ms}: {found:?}");
        assert!(
            names(&found).any(|name| name == "release"),
            "{ms}: {found:?}"
        );
    }
}

/// The finger is down again before its lift is detected, and slides only then.
#[test]
fn a_finger_that_lifts_for_a_moment_and_slides_on_slides_from_there_on() {
    let found = changes(8.0, 20.0, &|t, sign, lag| {
        let tone = during(3.08..5.0, t, 500.0 * (TAU * (8.3 * t + lag)).sin());
        sign * (during(1.0..3.0, t, 5000.0) + during(3.08..6.0, t, 5000.0) + tone)
    });
    let at = |what| found.iter().find(|(name, _)| *name == what).expect(what).1;
    assert!(
        (3.06..3.13).contains(&at("start")) && (at("end") - 5.0).abs() < 0.02,
        "{found:?}"
    );
}

/// The drift exceeds the load within half a second. It must not be taken for a touch or hide one.
#[test]
fn a_drift_is_no_touch_and_hides_none() {
    let found = changes(12.0, 20.0, &|t, sign, lag| {
        let tone = 500.0 * (TAU * (8.3 * (t - 3.0).clamp(0.0, 2.0) + lag)).sin();
        let drift = if lag < 0.5 {
            10_000.0 * t
        } else {
            -10_000.0 * t
        };
        sign * during(2.0..6.0, t, 5000.0 + tone) + drift
    });
    let mut expected = slid(3.0, 5.0, 6.0);
    expected[0].1 = 2.0;
    assert_reported(&found, &expected, 0.02);
}
