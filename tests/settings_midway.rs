//! Tests a change of settings during a slide, as by a command: no window may mix old and new
//! settings.

#[path = "support/touch.rs"]
#[allow(dead_code, reason = "a part of it is used here")]
mod touch;

use ridgetone_finger::{
    Detector, Diagnostics, Estimator, Outputs, Ring, TimedConversion, WindowFit,
};
use ridgetone_proto::boot::SettingsSource;
use ridgetone_proto::settings::{FRAME_RATE_HZ, Settings, Slide, SlideRule};
use ridgetone_proto::telemetry::{Estimate, Event, Span, Status};
use ridgetone_tone::Fitter;
use touch::{SCANS, TONE_HZ};

const SLIDE_START_S: f32 = 0.8;

/// End of the slide, seconds. A window that extends beyond it, before the hold is detected, may
/// find no tone.
const SLIDE_END_S: f32 = 2.8;

struct Board {
    detector: Detector,
    estimator: Estimator,
    fitter: Fitter,
    ring: Ring,
    diagnostics: Diagnostics,
    /// Estimates, each preceded by true if the settings had changed by then.
    estimates: Vec<(bool, Estimate)>,
    is_changed: bool,
}

impl Board {
    /// Pushes a conversion; `None` ends the signal.
    fn push(&mut self, conversion: Option<TimedConversion>) {
        let mut due = Vec::new();
        let mut wait = |window| due.push(window);
        let Self {
            detector,
            ring,
            diagnostics,
            ..
        } = self;
        match conversion {
            Some(conversion) => {
                let outputs = &mut Outputs {
                    emit: &mut |_| (),
                    due: &mut wait,
                };
                detector.push(conversion, ring, diagnostics, outputs);
            }
            None => detector.finish(ring, diagnostics, &mut |_| (), &mut wait),
        }
        for window in due {
            let fit = self
                .estimator
                .run(&mut self.fitter, &window, &mut &self.ring);
            match fit.expect("its frames are there") {
                WindowFit::Done(estimate) => self.estimates.push((self.is_changed, estimate)),
                WindowFit::Growing => {}
            }
        }
    }
}

/// Returns the estimates of a touch in which settings change from `before` to `after` at scan
/// `changed`.
fn touch(before: Settings, after: Settings, changed: u64) -> Vec<(bool, Estimate)> {
    let mut board = Box::new(Board {
        detector: Detector::new(before),
        estimator: Estimator::new(before),
        fitter: Fitter::new(),
        ring: Ring::new(),
        diagnostics: Diagnostics::new(),
        estimates: Vec::new(),
        is_changed: false,
    });
    for number in 0..SCANS {
        if number == changed {
            board.detector.change(&after, SettingsSource::Sent);
            board.estimator.change(&after);
            board.is_changed = true;
        }
        touch::scan(number, number, 0).for_each(|conversion| board.push(Some(conversion)));
    }
    board.push(None);
    board.estimates
}

#[test]
fn every_window_is_of_one_length_within_the_slide_and_right() {
    let of = |window_s, stride_s| Settings {
        window_s,
        stride_s,
        ..Settings::DEFAULT
    };
    let (long, short) = (of(1.0, 0.25), of(0.4, 0.1));
    for (before, after) in [(long, short), (short, long)] {
        // Change the settings at frames from before the slide until after it.
        for changed in (150..700).step_by(37) {
            let changed_s = changed as f32 / FRAME_RATE_HZ;
            let estimates = touch(before, after, changed);
            let what = format!(
                "{} s to {} s at {changed_s} s",
                before.window_s, after.window_s
            );
            let (windows, whole): (Vec<_>, Vec<_>) = estimates
                .iter()
                .partition(|(_, estimate)| estimate.span == Span::Window);
            let mut lengths_s = [0; 2];
            for (is_after, window) in windows {
                let end_s = window.t_us as f32 * 1e-6;
                let due_s = [before, after][usize::from(*is_after)].window_s;
                lengths_s[*is_after as usize] += 1;
                let is_due = (window.window_s - due_s).abs() < 1.0 / FRAME_RATE_HZ;
                assert!(is_due, "{what}: {window:?}");
                assert!(
                    end_s - window.window_s > SLIDE_START_S - 0.03,
                    "{what}: {window:?}"
                );
                if end_s > SLIDE_END_S {
                    continue;
                }
                let off = f64::from(window.frequency) - TONE_HZ;
                assert!(
                    window.status == Status::Good && off.abs() < 6.0 * f64::from(window.sigma),
                    "{what}: {window:?}"
                );
            }
            // There must be a window before the change and one after it, wherever there was time
            // for one.
            assert!(
                changed_s < 0.85 + before.window_s || lengths_s[0] > 0,
                "{what}: {lengths_s:?}"
            );
            assert!(
                changed_s > 2.7 || lengths_s[1] > 0 || changed_s + after.window_s > 2.7,
                "{what}: {lengths_s:?}"
            );
            assert!(
                matches!(whole[..], [(_, fit)] if fit.status == Status::Good && fit.window_s > 1.9),
                "{what}: {whole:?}"
            );
        }
    }
}

/// When the rule `always` is replaced, its slide ends, and touches are then found as usual. When it
/// starts to apply, it ends a hold or slide in progress.
#[test]
fn a_slide_that_lasts_always_ends_with_its_rule() {
    let by_rule = |rule| Settings {
        slide: Slide {
            rule,
            ..Slide::DEFAULT
        },
        ..Settings::DEFAULT
    };
    let (always, found) = (by_rule(SlideRule::Always), by_rule(SlideRule::Found));
    let slides = |before: Settings, after: Settings, changed: u64| {
        let (mut ring, diagnostics) = (Box::new(Ring::new()), Diagnostics::new());
        let mut detector = Box::new(Detector::new(before));
        let mut slides = Vec::new();
        let mut emit = |event| {
            if let Event::Slide(slide) = event {
                let s = |us: u64| us as f64 * 1e-6;
                slides.push((s(slide.start_us), slide.end_us.map(s)));
            }
        };
        for number in 0..SCANS {
            if number == changed {
                detector.change(&after, SettingsSource::Sent);
            }
            for conversion in touch::scan(number, number, 0) {
                let outputs = &mut Outputs {
                    emit: &mut emit,
                    due: &mut |_| (),
                };
                detector.push(conversion, &mut ring, &diagnostics, outputs);
            }
        }
        detector.finish(&mut ring, &diagnostics, &mut emit, &mut |_| ());
        slides
    };
    let end_s = SCANS as f64 / f64::from(FRAME_RATE_HZ);
    let is_near = |found: (f64, Option<f64>), start_s: f64, expected_s: Option<f64>| {
        (found.0 - start_s).abs() < 0.03
            && found.1.is_some() == expected_s.is_some()
            && (found.1.unwrap_or(0.0) - expected_s.unwrap_or(0.0)).abs() < 0.03
    };
    let check = |slides: &[(f64, Option<f64>)], expected: &[(f64, f64)]| {
        let reports = expected
            .iter()
            .flat_map(|(start_s, end_s)| [(*start_s, None), (*start_s, Some(*end_s))]);
        assert_eq!(slides.len(), 2 * expected.len(), "{slides:?}");
        for (found, (start_s, end_s)) in slides.iter().zip(reports) {
            assert!(is_near(*found, start_s, end_s), "{slides:?}");
        }
    };
    let at_s = |scan: u64| scan as f64 / f64::from(FRAME_RATE_HZ);
    check(&slides(always, always, 0), &[(0.0, end_s)]);
    check(&slides(always, found, 30), &[(0.0, at_s(30)), (0.8, 2.8)]);
    check(
        &slides(found, always, 400),
        &[(0.8, at_s(400)), (at_s(400), end_s)],
    );
    // The rule changes in the hold before the slide, and without contact.
    for changed in [150, 50] {
        check(&slides(found, always, changed), &[(at_s(changed), end_s)]);
    }
}
