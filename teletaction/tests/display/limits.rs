//! Whatever is wanted, and whenever: within the limits, on a level, and no farther than the slew.

use proptest::prelude::*;
use ridgetone_teletaction::display::{Error, Limits, Pins, Steps};

const DISPLAY: Limits = Limits {
    force_n: 1.0,
    stroke_mm: 2.0,
    stiffness_n_mm: 0.5,
    update_hz: 20.0,
    levels: 10,
    slew_n_s: 4.0,
};

/// Anything that a line may bring.
fn anything() -> impl Strategy<Value = f32> {
    prop_oneof![4 => -1.0f32..3.0, 1 => any::<f32>(), 1 => Just(f32::NAN), 1 => Just(f32::MAX)]
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
        let greatest_n = force_n.min(stroke_mm * stiffness_n_mm);
        let quantum_n = greatest_n / f32::from(levels);
        let step_n = slew_n_s / update_hz;
        let mut forces = [7.0; 4];
        let mut pins = match Pins::new(limits, &mut forces) {
            Ok(pins) => pins,
            Err(error) => {
                prop_assert!(matches!(error, Error::Frozen { .. }) && step_n < quantum_n, "{error}");
                return Ok(());
            }
        };
        for (wanted, dt_s, releases) in frames {
            let before = pins.forces_n().to_vec();
            let is_wrong = wanted.iter().any(|n| !n.is_finite());
            let done = if releases { pins.release(dt_s).map(|()| None) } else { pins.advance(dt_s, &wanted) };
            prop_assert_eq!(done.is_err(), is_wrong && !releases);
            for (now, before) in pins.forces_n().iter().zip(before) {
                prop_assert!((0.0..=greatest_n * 1.000_001).contains(now), "{}", now);
                // A millionth more, so that a slew of just one level an update is possible.
                prop_assert!((now - before).abs() <= step_n * 1.000_002 + 1e-4 * quantum_n, "{} {}", now, before);
                prop_assert!(done.is_ok() || *now == before);
                let level = now / quantum_n;
                prop_assert!((level - level.round()).abs() < 1e-2, "{}", level);
            }
        }
    }
}

#[test]
fn a_step_takes_as_long_as_the_slew_says() {
    let mut forces = [0.0];
    let mut pins = Pins::new(DISPLAY, &mut forces).expect("a display");
    // 4 N/s at 20 Hz are 0.2 N an update; calls at 100 Hz make no more updates.
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
    // To the nearest level.
    pins.advance(0.05, &[0.16]).expect("forces");
    assert!((pins.forces_n()[0] - 0.2).abs() < 1e-5);
}

#[test]
fn the_stroke_bounds_the_force() {
    assert_eq!(
        Limits {
            stroke_mm: 0.5,
            ..DISPLAY
        }
        .greatest_n(),
        0.25
    );
    assert_eq!(DISPLAY.greatest_n(), 1.0);
}

#[test]
fn impossible_displays_are_refused() {
    let refused = |limits: Limits| Pins::new(limits, &mut [0.0]).expect_err("refused");
    for (limits, setting) in [
        (
            Limits {
                force_n: 0.0,
                ..DISPLAY
            },
            "force_n",
        ),
        (
            Limits {
                force_n: f32::NAN,
                ..DISPLAY
            },
            "force_n",
        ),
        (
            Limits {
                stroke_mm: -1.0,
                ..DISPLAY
            },
            "stroke_mm",
        ),
        (
            Limits {
                stiffness_n_mm: f32::INFINITY,
                ..DISPLAY
            },
            "stiffness_n_mm",
        ),
        (
            Limits {
                update_hz: 0.0,
                ..DISPLAY
            },
            "update_hz",
        ),
        (
            Limits {
                levels: 0,
                ..DISPLAY
            },
            "levels",
        ),
        (
            Limits {
                slew_n_s: 0.0,
                ..DISPLAY
            },
            "slew_n_s",
        ),
    ] {
        let Error::Setting { name, .. } = refused(limits) else {
            panic!("{setting}")
        };
        assert_eq!(name, setting);
    }
    // 0.05 N an update, and levels of 0.1 N.
    assert!(matches!(
        refused(Limits {
            slew_n_s: 1.0,
            ..DISPLAY
        }),
        Error::Frozen { .. }
    ));
    let mut forces = [0.0];
    let mut pins = Pins::new(DISPLAY, &mut forces).expect("a display");
    assert!(
        pins.advance(-0.1, &[0.0]).is_err()
            && pins.advance(f32::NAN, &[0.0]).is_err()
            && pins.release(f32::NAN).is_err()
    );
    assert!(matches!(
        pins.advance(0.1, &[0.0, 0.0]),
        Err(Error::Length { .. })
    ));
}

#[test]
fn a_step_of_levels_is_within_the_slew_even_towards_what_is_no_number() {
    // 0.2 N an update are two levels of 0.1 N.
    let steps = Steps::new(&DISPLAY);
    for (from, wanted_n, to) in [
        (0, 5.0, 2),
        (9, 5.0, 10),
        (5, 0.0, 3),
        (5, -1.0, 3),
        (5, f32::NAN, 3),
        (5, f32::INFINITY, 7),
        (5, f32::NEG_INFINITY, 3),
        (5, 0.52, 5),
        (1, f32::NAN, 0),
        // A level that is not there, of limits that have changed.
        (200, 5.0, 10),
        (200, 0.0, 8),
    ] {
        assert_eq!(steps.towards(from, wanted_n), to, "{from} {wanted_n}");
    }
}
