//! Runs the example, which must measure the grating's frequency.

#[path = "../examples/drdy_loop.rs"]
#[allow(dead_code, reason = "its main is not used here")]
mod drdy_loop;

use ridgetone_proto::telemetry::{Span, Status};

#[test]
fn the_loop_measures_the_grating_in_windows_and_as_a_whole() {
    let estimates = drdy_loop::run().expect("the example runs");
    assert!(
        estimates.len() >= 4
            && estimates
                .iter()
                .any(|estimate| estimate.span == Span::Slide),
        "{estimates:?}"
    );
    for estimate in estimates {
        let off_hz = estimate.frequency - 30.0 / 3.1;
        assert!(
            estimate.status == Status::Good && off_hz.abs() < 4.0 * estimate.sigma,
            "{estimate:?}"
        );
    }
}
