//! Tests the detector when it starts with the finger already pressed on something.

use crate::{all_changes, assert_reported, changes, during, load, names};
use ridgetone_proto::settings::{Slide, SlideRule};
use std::f64::consts::TAU;

/// The detector takes the initial level for a hold, so it reports no contact, and learns the idle
/// level only at the release.
#[test]
fn a_finger_that_is_on_something_at_the_start_slides_and_lifts() {
    for hz in [1.3, 8.3, 60.3] {
        let found = changes(14.0, 20.0, &|t, sign, lag| {
            let spike = during(7.0..12.0, t, load(t - 6.0, 99.0) - 1000.0);
            sign * (two_touches(t, hz, lag) + spike)
        });
        let first = [("start", 2.0), ("end", 4.0), ("release", 5.0)];
        let second = [
            ("contact", 7.0),
            ("start", 9.0),
            ("end", 11.0),
            ("release", 12.0),
        ];
        assert_reported(&found, &[&first[..], &second].concat(), 0.03);
    }
}

/// Without a slide, the release from a loaded start is taken for a contact. The next slide shows
/// which level is idle.
#[test]
fn a_loaded_start_without_a_slide_is_set_right_by_the_next_one() {
    let mut found = changes(14.0, 20.0, &|t, sign, lag| {
        let tone = 500.0 * (TAU * (8.3 * (t - 5.0).clamp(0.0, 2.0) + lag)).sin();
        let first = during(0.0..1.0, t, 1000.0 + tone) + during(3.0..8.0, t, 1000.0 + tone);
        sign * (first + during(10.0..12.0, t, load(t - 9.0, 99.0)))
    });
    found.retain(|(_, at_s)| *at_s > 4.5);
    let slide = [("start", 5.0), ("end", 7.0), ("release", 8.0)];
    let touch = [("contact", 10.0), ("release", 12.0)];
    assert_reported(&found, &[&slide[..], &touch].concat(), 0.03);
}

/// A slow contact changes the levels as slowly as a slide, but in one direction only.
#[test]
fn a_gentle_first_contact_is_no_slide() {
    let found = changes(8.0, 20.0, &|t, sign, lag| {
        let pressed = 0.5 - 0.5 * (TAU * (t - 1.0).clamp(0.0, 0.5)).cos();
        sign * during(0.0..5.0, t, (0.4 + lag) * 3000.0 * pressed)
    });
    assert!(names(&found).eq(["contact", "release"]), "{found:?}");
    assert!(
        (1.0..1.6).contains(&found[0].1) && (found[1].1 - 5.0).abs() < 0.01,
        "{found:?}"
    );
}

const PLANNED: Slide = Slide {
    rule: SlideRule::Protocol,
    delay_s: 0.5,
    speed_mm_s: 20.0,
    length_mm: 20.0,
};

/// The finger is loaded until 5 s, and again from 7 s to 12 s. Both times it slides for two
/// seconds.
fn two_touches(t: f64, hz: f64, lag: f64) -> f64 {
    let tone = |from_s: f64| 500.0 * (TAU * (hz * (t - from_s).clamp(0.0, 2.0) + lag)).sin();
    during(0.0..5.0, t, 1000.0 + tone(2.0)) + during(7.0..12.0, t, 1000.0 + tone(9.0))
}

const SLIDES_HZ: [f64; 3] = [1.0, 8.0, 60.0];

/// Slides are only scheduled, so the first motion and the first lift count as contacts, and the
/// touch that restores the initial level counts as a release. The detector must carry on.
#[test]
fn by_the_protocol_a_loaded_start_does_not_stop_the_detector() {
    for hz in SLIDES_HZ {
        let found = all_changes(14.0, 20.0, |_| PLANNED, &|t, sign, lag| {
            sign * two_touches(t, hz, lag)
        });
        assert_eq!(found[0].0, "contact", "{found:?}");
        let start = ("start", found[0].1 + 0.5);
        for (name, expected_s) in [start, ("contact", 5.0), ("release", 7.0), ("contact", 12.0)] {
            let is_it =
                |(found, at_s): &(&str, f64)| *found == name && (at_s - expected_s).abs() < 0.02;
            assert!(found.iter().any(is_it), "{name}: {found:?}");
        }
    }
}

/// The rule changes in the hold after the slide, before the idle level is known or a pressure map
/// of that hold is taken.
#[test]
fn a_change_to_the_protocol_in_a_hold_of_a_loaded_start_hides_no_release() {
    for hz in SLIDES_HZ {
        let rule = |t| if t < 4.5 { Slide::DEFAULT } else { PLANNED };
        let mut found = all_changes(14.0, 20.0, rule, &|t, sign, lag| {
            sign * two_touches(t, hz, lag)
        });
        found.retain(|(_, at_s)| *at_s < 7.2);
        let expected = [
            ("start", 2.0),
            ("end", 4.0),
            ("release", 5.0),
            ("contact", 7.0),
        ];
        assert_reported(&found, &expected, 0.03);
    }
}
