//! Any scan that compiles works: the whole path with the scan of this build, and builds with other ones.

mod support;

use hal_mock::{Sliding, SlidingScene};
use ridgetone_proto::scan::{FRAME_RATE_HZ, INPUTS};
use ridgetone_proto::settings::Settings;
use ridgetone_proto::telemetry::{Event, Status};
use std::process::{Command, Output};
use support::{all, outcome, run};

#[test]
fn the_scan_of_this_build_finds_slides_and_their_frequencies() {
    for (speed_mm_s, period_mm) in [(15.0, 2.6), (30.0, 3.1), (48.0, 3.6)] {
        let scene = Sliding { speed_mm_s, period_mm, snr_db: Some(20.0), seed: 3, ..Sliding::default() };
        let scene = SlidingScene::new(scene).unwrap();
        let truth = scene.truth();
        let events = run(scene, Settings::default(), all);
        let out = outcome(&events);
        let what = format!("{INPUTS} inputs, {FRAME_RATE_HZ} Hz, {speed_mm_s} mm/s, {period_mm} mm: {out:?} {truth:?}");
        assert!(matches!(&events[0], Event::Hello(hello) if hello.frame_rate_hz == FRAME_RATE_HZ), "{what}");
        assert!((out.health.frame_rate_hz / FRAME_RATE_HZ - 1.0).abs() < 1e-4, "{what}");
        assert_eq!((out.contacts_s.len(), out.slides_s.len(), out.slide_fits.len()), (1, 1, 1), "{what}");
        // Ends are dated to a few blocks of four frames.
        let bar_s = 0.020_f64.max(8.0 / f64::from(FRAME_RATE_HZ));
        assert!((out.slides_s[0].0 - truth.slide_start_s).abs() < bar_s, "{what}");
        assert!((out.slides_s[0].1 - truth.slide_end_s).abs() < bar_s, "{what}");
        assert!(!out.window_fits.is_empty(), "{what}");
        for fit in out.slide_fits.iter().chain(&out.window_fits) {
            let off_hz = f64::from(fit.frequency) - truth.frequency_hz;
            assert_eq!((fit.status, fit.channels.len()), (Status::Good, INPUTS), "{what}");
            assert!(off_hz.abs() < 6.0 * f64::from(fit.sigma), "{what}");
        }
        let slide = &out.slide_fits[0];
        assert!((f64::from(slide.frequency) / truth.frequency_hz - 1.0).abs() < 0.002, "{what}");
        assert_eq!((out.health.conversions_lost, out.health.conversions_doubtful), (0, 0), "{what}");
    }
}

/// Runs cargo with another scan, in a target directory of its own.
fn cargo(scan: &[(&str, &str)], arguments: &[&str]) -> Output {
    let target = concat!(env!("CARGO_MANIFEST_DIR"), "/target/scan");
    let mut cargo = Command::new(env!("CARGO"));
    cargo.args(arguments).args(["--target-dir", target]).current_dir(env!("CARGO_MANIFEST_DIR"));
    cargo.envs(scan.iter().copied()).output().unwrap()
}

#[test]
#[ignore = "builds the path three times"]
fn builds_with_other_scans_find_them_too() {
    for scan in [
        &[("RIDGETONE_INPUTS", "8")][..],
        &[("RIDGETONE_DRATE", "2")],
        &[("RIDGETONE_DRATE", "0"), ("RIDGETONE_INPUTS", "4")],
    ] {
        let arguments = ["test", "-p", "ridgetone-firmware", "--test", "scan", "the_scan_of_this_build"];
        let Output { status, stdout, stderr } = cargo(scan, &arguments);
        let text = String::from_utf8_lossy(&stdout) + String::from_utf8_lossy(&stderr);
        assert!(status.success() && text.contains("1 passed"), "{scan:?}: {text}");
    }
}

#[test]
#[ignore = "compiles the protocol six times"]
fn a_scan_that_cannot_work_is_refused_with_a_sentence() {
    for (scan, sentence) in [
        (&[("RIDGETONE_INPUTS", "0")][..], "choose 1 to 16"),
        (&[("RIDGETONE_INPUTS", "17")], "choose 1 to 16"),
        (&[("RIDGETONE_INPUTS", "eight")], "choose 1 to 16"),
        (&[("RIDGETONE_DRATE", "3")], "choose 0, 1 or 2"),
        (&[("RIDGETONE_DRATE", "0")], "choose fewer inputs or a higher data rate"),
        (&[("RIDGETONE_DRATE", "2"), ("RIDGETONE_INPUTS", "4")], "choose more inputs or a lower data rate"),
    ] {
        let Output { status, stderr, .. } = cargo(scan, &["check", "-p", "ridgetone-proto"]);
        let text = String::from_utf8_lossy(&stderr);
        assert!(!status.success() && text.contains(sentence), "{scan:?}: {text}");
    }
}
