//! Tests that forces are within the limits, on a level and within the slew, for any target at any
//! time.

use proptest::prelude::*;
use ridgetone_teletaction::pins::{Error, Limits, Pins};

const DISPLAY: Limits = Limits {
    force_n: 1.0,
    stroke_mm: 2.0,
    stiffness_n_mm: 0.5,
    update_hz: 20.0,
    levels: 10,
    slew_n_s: 4.0,
};

/// Any value that a line may transmit.
fn anything() -> impl Strategy<Value = f64> {
    prop_oneof![4 => -1.0..3.0, 1 => any::<f64>(), 1 => Just(f64::NAN), 1 => Just(f64::MAX)]
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 2000, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn limits_hold_whatever_is_wanted(
        limits in (0.01f32..20.0, 0.01f32..10.0, 0.01f32..10.0, 1.0f32..100.0, 1u16..300, 0.01f32..1000.0),
        frames in prop::collection::vec((prop::array::uniform4(anything()), 0.0f32..0.3, any::<bool>()), 1..60),
    ) {
        let (force_n, stroke_mm, stiffness_n_mm, update_hz, levels, slew_n_s) = limits;
        let limits = Limits { force_n, stroke_mm, stiffness_n_mm, update_hz, levels, slew_n_s };
        let max_n = force_n.min(stroke_mm * stiffness_n_mm);
        let level_n = max_n / f32::from(levels);
        let step_n = slew_n_s / update_hz;
        let mut pins = match Pins::new(limits, 4) {
            Ok(pins) => pins,
            Err(error) => {
                prop_assert!(matches!(error, Error::Frozen { .. }) && step_n < level_n, "{error}");
                return Ok(());
            }
        };
        for (wanted, dt_s, releases) in frames {
            let before = pins.forces_n().to_vec();
            let is_wrong = wanted.iter().any(|n| !n.is_finite());
            let done = if releases { pins.release(dt_s).map(|()| None) } else { pins.advance(dt_s, &wanted) };
            prop_assert_eq!(done.is_err(), is_wrong && !releases);
            for (now, before) in pins.forces_n().iter().zip(before) {
                prop_assert!((0.0..=max_n * 1.000_001).contains(now), "{}", now);
                // Allow a millionth more, for a slew of exactly one level per update.
                prop_assert!((now - before).abs() <= step_n * 1.000_002 + 1e-4 * level_n, "{} {}", now, before);
                prop_assert!(done.is_ok() || *now == before);
                let level = now / level_n;
                prop_assert!((level - level.round()).abs() < 1e-2, "{}", level);
            }
        }
    }
}

#[test]
fn a_step_takes_as_long_as_the_slew_says() {
    let mut pins = Pins::new(DISPLAY, 1).expect("a display");
    // 4 N/s at 20 Hz are 0.2 N per update. Calls at 100 Hz must not add updates.
    let mut n = Vec::new();
    for _ in 0..30 {
        let done = pins.advance(0.01, &[5.0]).expect("forces");
        assert!(done.is_none() || done == Some(1));
        n.push(pins.forces_n()[0]);
    }
    let expected = |frame: usize| (0.2 * (1 + frame / 5) as f32).min(1.0);
    for (frame, n) in n.iter().enumerate() {
        assert!((n - expected(frame)).abs() < 1e-5, "{frame}: {n}");
    }
    for step in [0.8, 0.6, 0.4, 0.2, 0.0, 0.0] {
        pins.release(0.05).expect("time");
        assert!((pins.forces_n()[0] - step).abs() < 1e-5);
    }
    // Forces are rounded to the nearest level.
    pins.advance(0.05, &[0.16]).expect("forces");
    assert!((pins.forces_n()[0] - 0.2).abs() < 1e-5);
}

#[test]
fn impossible_displays_are_refused() {
    type Change = fn(&mut Limits);
    let refused = |change: Change| {
        let mut limits = DISPLAY;
        change(&mut limits);
        Pins::new(limits, 1).expect_err("refused")
    };
    let cases: [(Change, &str); 7] = [
        (|limits| limits.force_n = 0.0, "force_n"),
        (|limits| limits.force_n = f32::NAN, "force_n"),
        (|limits| limits.stroke_mm = -1.0, "stroke_mm"),
        (
            |limits| limits.stiffness_n_mm = f32::INFINITY,
            "stiffness_n_mm",
        ),
        (|limits| limits.update_hz = 0.0, "update_hz"),
        (|limits| limits.levels = 0, "levels"),
        (|limits| limits.slew_n_s = 0.0, "slew_n_s"),
    ];
    for (change, setting) in cases {
        let Error::Setting(error) = refused(change) else {
            panic!("{setting}")
        };
        assert_eq!(error.name, setting);
    }
    // An update changes at most 0.05 N, but a level is 0.1 N.
    let frozen = refused(|limits| limits.slew_n_s = 1.0);
    assert!(matches!(frozen, Error::Frozen { .. }));
    let mut pins = Pins::new(DISPLAY, 1).expect("a display");
    assert!(
        pins.advance(-0.1, &[0.0]).is_err()
            && pins.advance(f32::NAN, &[0.0]).is_err()
            && pins.release(f32::NAN).is_err()
    );
}
