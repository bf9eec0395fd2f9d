//! Strides that are much shorter than the time until a slide is noticed: many windows are due at once.

#[path = "support/touch.rs"]
#[allow(dead_code, reason = "a part of it is used here")]
mod touch;

use ridgetone_finger::{Detector, Diagnostics, Outputs, Pipeline, Ring, TimedConversion};
use ridgetone_proto::settings::Settings;
use ridgetone_proto::telemetry::Event;

fn conversions() -> impl Iterator<Item = TimedConversion> {
    (0..touch::SCANS).flat_map(|scan| touch::scan(scan, scan, 0))
}

/// Windows that are due in the touch, whole slides included.
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

#[test]
fn every_window_that_is_due_is_fitted_or_counted_as_skipped() {
    let settings = Settings {
        window_s: 0.1,
        stride_s: 0.02,
        ..Settings::DEFAULT
    };
    let mut pipeline = Box::new(Pipeline::new(settings));
    let (mut estimates, mut overruns) = (0, 0);
    let mut count = |event| match event {
        Event::Estimate(_) => estimates += 1,
        Event::Health(health) => overruns = health.overruns as usize,
        _ => {}
    };
    conversions().for_each(|conversion| pipeline.push(conversion, &mut count));
    pipeline.finish(&mut count);
    assert!(overruns > 0, "the slide is noticed too early for this test");
    assert!(estimates > 50, "{estimates}");
    assert_eq!(estimates + overruns, windows_due(settings));
}
