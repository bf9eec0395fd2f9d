//! Tests strides much shorter than the time to detect a slide: many windows are due at once.

#[path = "support/touch.rs"]
#[allow(dead_code, reason = "a part of it is used here")]
mod touch;

use ridgetone_finger::{Detector, Diagnostics, Outputs, Pipeline, Ring, TimedConversion};
use ridgetone_proto::settings::{Declared, FRAME_RATE_HZ, Settings};
use ridgetone_proto::telemetry::{Estimate, Event, Span, Status, Track};
use touch::TONE_HZ;

fn conversions() -> impl Iterator<Item = TimedConversion> {
    (0..touch::SCANS).flat_map(|scan| touch::scan(scan, scan, 0))
}

/// Number of windows due in the touch, including whole slides.
fn windows_due(settings: Settings) -> usize {
    let (mut detector, mut ring) = (Box::new(Detector::new(settings)), Box::new(Ring::new()));
    let (diagnostics, mut due) = (Diagnostics::new(), 0);
    for conversion in conversions() {
        detector.push(
            conversion,
            &mut ring,
            &diagnostics,
            &mut Outputs {
                emit: &mut |_| (),
                due: &mut |_| due += 1,
            },
        );
    }
    detector.finish(&mut ring, &diagnostics, &mut |_| (), &mut |_| due += 1);
    due
}

/// Settings with windows of 0.3 s (2.5 cycles) in the lean scene, which is quick to fit.
fn with_stride(stride_s: f32) -> Settings {
    let scene = Declared::LEAN;
    Settings {
        window_s: 0.3,
        stride_s,
        scene,
        ..Settings::DEFAULT
    }
}

/// Returns the tracks, the estimates and the number of overruns of the touch.
fn run(settings: Settings) -> (Vec<Track>, Vec<Estimate>, usize) {
    let mut pipeline = Box::new(Pipeline::new(settings));
    let (mut tracks, mut estimates, mut overruns) = (Vec::new(), Vec::new(), 0);
    let mut take = |event| match event {
        Event::Track(track) => tracks.push(track),
        Event::Estimate(estimate) => estimates.push(estimate),
        Event::Health(health) => overruns = health.overruns as usize,
        _ => {}
    };
    conversions().for_each(|conversion| pipeline.push(conversion, &mut take));
    pipeline.finish(&mut take);
    (tracks, estimates, overruns)
}

#[test]
fn every_window_that_is_due_is_fitted_or_counted_as_skipped() {
    for stride_s in [0.05, 0.1, 0.5] {
        let settings = with_stride(stride_s);
        let (tracks, estimates, overruns) = run(settings);
        assert!(tracks.is_empty() && estimates.len() > 4, "{stride_s}");
        assert_eq!(estimates.len() + overruns, windows_due(settings));
    }
}

#[test]
fn below_fifty_milliseconds_each_window_is_a_track_and_twenty_a_second_are_estimates() {
    let frame_s = 1.0 / FRAME_RATE_HZ;
    for (stride_s, frames) in [(0.0041, 1.0), (0.02, 5.0), (0.045, 11.0)] {
        let settings = with_stride(stride_s);
        assert_eq!(settings.validate(), Ok(()));
        let (tracks, estimates, overruns) = run(settings);
        let (whole, windows): (Vec<_>, Vec<_>) = estimates
            .iter()
            .partition(|estimate| estimate.span == Span::Slide);
        assert_eq!((overruns, whole.len()), (0, 1));
        assert_eq!(tracks.len() + whole.len(), windows_due(settings));
        for pair in tracks.windows(2) {
            let passed = (pair[1].t_us - pair[0].t_us) as f32 * 1e-6 / frame_s;
            assert!((passed - frames).abs() < 0.01, "{stride_s}: {passed}");
        }
        for pair in windows.windows(2) {
            assert!(pair[1].t_us - pair[0].t_us >= 50_000, "{stride_s}");
        }
        assert!(windows.len() > 20, "{stride_s}: {}", windows.len());
        for estimate in windows {
            let same = tracks.iter().find(|track| track.t_us == estimate.t_us);
            assert_eq!(same, Some(&Track::from(estimate)));
        }
        // Windows that extend beyond the slide's end are not good.
        let good = tracks.iter().filter(|track| track.status == Status::Good);
        let mut count = 0;
        for track in good {
            let off = f64::from(track.frequency) - TONE_HZ;
            assert!(off.abs() < 5.0 * f64::from(track.sigma), "{track:?}");
            count += 1;
        }
        assert!(5 * count > 3 * tracks.len(), "{count} of {}", tracks.len());
    }
}

#[test]
fn a_stride_that_the_plan_cannot_provide_is_refused_with_those_that_it_can() {
    for stride_s in [0.0, 0.004, 4.0, f32::NAN] {
        let error = with_stride(stride_s).validate().unwrap_err();
        assert_eq!((error.field.as_str(), error.min), ("stride_s", 0.0041));
        assert_eq!(
            error.to_string(),
            format!("stride_s = {stride_s}: choose a value from 0.0041 to 3.9")
        );
    }
}

/// The touch starts at time zero, so the conversions' times are device times.
#[test]
fn events_say_how_long_after_their_time_they_were_reported() {
    let mut pipeline = Box::new(Pipeline::new(Settings::DEFAULT));
    let mut reported = Vec::new();
    for conversion in conversions() {
        let now_us = u64::from(conversion.t_us);
        pipeline.push(conversion, &mut |event| {
            let (name, t_us, after_us) = match event {
                Event::Contact(one) => ("contact", one.t_us, one.reported_after_us),
                Event::Moving(one) => ("moving", one.t_us, one.reported_after_us),
                Event::Slide(one) => (
                    "slide",
                    one.end_us.unwrap_or(one.start_us),
                    one.reported_after_us,
                ),
                Event::Release(one) => ("release", one.t_us, one.reported_after_us),
                _ => return,
            };
            // Event times follow the nominal scan, but `now_us` is the conversion's own time.
            let off_us = (t_us + u64::from(after_us)).abs_diff(now_us);
            assert!(off_us <= 2, "{name}: {off_us} us");
            reported.push((name, after_us));
        });
    }
    let names: Vec<_> = reported.iter().map(|(name, _)| *name).collect();
    assert_eq!(names, ["contact", "moving", "slide", "slide", "release"]);
    for (name, after_us) in reported {
        let max_us = if name == "moving" { 60_000 } else { 500_000 };
        assert!((4_000..max_us).contains(&after_us), "{name}: {after_us}");
    }
}
