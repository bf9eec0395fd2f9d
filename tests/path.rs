//! Tests the whole path on a PC, from SPI bytes to telemetry, following the paper's protocol.

#[allow(dead_code, reason = "every test file uses a part of it")]
mod support;

use ads1258::Status as StatusByte;
use hal_mock::{Options, SimulatedBoard, Sliding, SlidingScene, TABLE_2, Trace, Truth, write_csv};
use ridgetone_proto::fault::FaultKind;
use ridgetone_proto::settings::{Settings, Slide, SlideRule};
use ridgetone_proto::telemetry::{Estimate, Event, Status};
use support::{Outcome, Rate, all, count, in_the_air, off, outcome, run, run_on};

fn scene(speed_mm_s: f64, period_mm: f64, snr_db: f64, seed: u64) -> SlidingScene {
    SlidingScene::new(Sliding {
        speed_mm_s,
        period_mm,
        snr_db: Some(snr_db),
        seed,
        ..Sliding::default()
    })
    .unwrap()
}

/// Asserts the limits of the emulated run (host/tests/emulated.rs), without an emulator. Tests for
/// competing tones reject a few right fits, so [`Rate`] limits how many estimates are not good.
fn assert_within_limits(what: &str, out: &Outcome, truth: &Truth, rate: &mut Rate) {
    out.assert_touch(what, truth, 0.020);
    let what = format!("{what}: {out:?} {truth:?}");
    assert!(
        (out.releases_s[0] - truth.release_s).abs() < 0.050,
        "{what}"
    );
    assert_eq!(out.slide_fits.len(), 1, "{what}");
    assert!(!out.window_fits.is_empty(), "{what}");
    for fit in out.fits() {
        rate.add(fit);
        assert!(off(fit, truth).abs() < 6.0, "{what}");
    }
    let fit = &out.slide_fits[0];
    assert_near(fit, truth);
    assert_eq!(fit.channels.len(), 16, "{what}");
    let health = &out.health;
    assert_eq!(
        (health.conversions_lost, health.conversions_doubtful),
        (0, 0),
        "{what}"
    );
}

/// Asserts that the frequency is right to 0.2 %.
#[track_caller]
fn assert_near(fit: &Estimate, truth: &Truth) {
    let off = f64::from(fit.frequency) / truth.frequency_hz - 1.0;
    assert!(off.abs() < 0.002, "{fit:?} {truth:?}");
}

/// Scenes of all combinations in Table 2, with four seeds each.
fn table_2() -> impl Iterator<Item = (String, SlidingScene)> {
    (0..40).map(|number| {
        let ((speed_mm_s, period_mm), seed) = (TABLE_2[number / 4], number % 4 + 1);
        let what = format!("{speed_mm_s} mm/s, {period_mm} mm, seed {seed}");
        let seed = (10 * (number / 4) + seed) as u64;
        (what, scene(speed_mm_s, period_mm, 20.0, seed))
    })
}

#[test]
fn all_of_table_2_within_its_bars() {
    let mut rate = Rate::default();
    for (what, scene) in table_2() {
        let truth = scene.truth();
        let out = outcome(&run(scene, Settings::default(), all));
        assert_within_limits(&what, &out, &truth, &mut rate);
    }
    rate.assert_good();
}

/// Runs Table 2 from recordings: rows are held, or resampled if their rate differs.
#[test]
fn all_of_table_2_from_recordings_of_any_rate() {
    let mut rate = Rate::default();
    for rate_hz in [200.0, 241.0, 241.14, 1000.0] {
        for (what, mut scene) in table_2() {
            let truth = scene.truth();
            let mut csv = Vec::new();
            write_csv(&mut scene, rate_hz, 0.0, &mut csv).unwrap();
            let scan_rate_hz = f64::from(ridgetone_proto::settings::FRAME_RATE_HZ);
            let trace = Trace::parse(&csv, "recording", scan_rate_hz).unwrap();
            let options = Options {
                clock_error_ppm: trace.clock_error_ppm(),
                ..Options::default()
            };
            let board = SimulatedBoard::new(trace, options);
            let out = outcome(&run_on(board, Settings::default(), all));
            assert_within_limits(&format!("{rate_hz} Hz, {what}"), &out, &truth, &mut rate);
        }
    }
    rate.assert_good();
}

#[test]
fn the_greeting_comes_first_and_health_once_a_second() {
    let scene = scene(30.0, 3.6, 20.0, 1);
    let end_s = scene.truth().end_s;
    let events = run(scene, Settings::default(), all);
    assert!(matches!(&events[0], Event::Hello(hello) if hello.settings == Settings::default()));
    assert_eq!(healths(&events), end_s as usize + 1);
    let last = outcome(&events).health;
    for (found, expected, within) in [
        (last.supply_v, 5.0, 1e-3),
        (last.reference_v, 4.096, 1e-3),
        (last.temperature_c, 25.0, 0.5),
        (last.gain, 1.0, 1e-4),
        // Frame rate from the datasheet's formula and the board's clock.
        (last.frame_rate_hz, 241.14, 0.01),
    ] {
        assert!((found - expected).abs() < within, "{last:?}");
    }
}

fn healths(events: &[Event]) -> usize {
    count(events, |event| matches!(event, Event::Health(_)))
}

/// If a taxel is missing, no frame is complete and nothing is detected, but health is still sent.
#[test]
fn without_a_taxel_health_is_sent_once_a_second() {
    let events = run(
        in_the_air(10.0),
        Settings::default(),
        |count, conversion| (count % 21 != 3).then_some(conversion),
    );
    assert!(
        (10..=11).contains(&healths(&events)),
        "{}",
        healths(&events)
    );
}

#[test]
fn the_slide_by_protocol_follows_the_paper() {
    let settings = Settings {
        slide: Slide {
            rule: SlideRule::Protocol,
            delay_s: 1.0,
            speed_mm_s: 30.0,
            length_mm: 55.0,
        },
        ..Settings::default()
    };
    let scene = scene(30.0, 3.6, 20.0, 3);
    let truth = scene.truth();
    let out = outcome(&run(scene, settings, all));
    let (start_s, end_s) = out.slides_s[0];
    // Start (after the spike) and length must agree with equations 4 and 5 to within a frame.
    assert!((start_s - (out.contacts_s[0] + 1.0)).abs() < 0.005);
    assert!((end_s - start_s - 55.0 / 30.0).abs() < 0.005);
    out.assert_one_slide("by protocol");
    assert_near(&out.slide_fits[0], &truth);
}

#[test]
fn a_finger_in_the_air_greets_again_and_says_nothing_else() {
    let events = run(in_the_air(21.0), Settings::default(), all);
    assert_eq!(count(&events, |event| matches!(event, Event::Hello(_))), 3);
    let out = outcome(&events);
    assert!(
        out.contacts_s.is_empty() && out.slides_s.is_empty() && out.window_fits.is_empty(),
        "{out:?}"
    );
}

/// If four scans are missing, the slide may have ended unnoticed, so its fit is doubtful.
#[test]
fn lost_conversions_are_counted_and_their_frames_left_out() {
    for (hole, status) in [
        (11_000..11_074, Status::Good),
        (11_000..11_115, Status::Doubtful),
    ] {
        let scene = scene(30.0, 3.6, 20.0, 2);
        let truth = scene.truth();
        let mut lost = 0;
        let events = run(scene, Settings::default(), |count, conversion| {
            // Lose one conversion in 997, and several scans in the middle of the slide.
            let gone = count % 997 == 500 || hole.contains(&count);
            lost += gone as u32;
            (!gone).then_some(conversion)
        });
        let out = outcome(&events);
        assert_eq!(out.health.conversions_lost, lost);
        let fit = &out.slide_fits[0];
        assert_eq!(fit.status, status, "{fit:?}");
        let is_silent = fit.faults.has(FaultKind::Silent);
        assert_eq!(is_silent, status == Status::Doubtful, "{fit:?}");
        assert!(
            fit.frames_missing > 5 && off(fit, &truth).abs() < 5.0,
            "{fit:?}"
        );
    }
}

/// A conversion's slot delays it. Without correction, the phases of taxels 0 and 15 would be 15 /
/// 21 of a frame apart.
#[test]
fn phases_are_those_of_one_moment() {
    struct Together;
    impl hal_mock::Scene for Together {
        fn volts(&mut self, _: u8, t_s: f64) -> f64 {
            let level = if t_s < 0.5 { 0.0 } else { 0.02 };
            let slid = if t_s > 1.5 { (t_s - 1.5).min(2.0) } else { 0.0 };
            2.5 + level + 1e-3 * (std::f64::consts::TAU * 40.0 * slid).sin()
        }
        fn end_s(&self) -> f64 {
            4.5
        }
    }
    let out = outcome(&run(Together, Settings::default(), all));
    let fit = &out.slide_fits[0];
    assert!((fit.frequency - 40.0).abs() < 1e-3, "{fit:?}");
    let first = fit.channels[0].phase_rad;
    for channel in &fit.channels {
        let apart = (channel.phase_rad - first + std::f32::consts::PI)
            .rem_euclid(std::f32::consts::TAU)
            - std::f32::consts::PI;
        assert!(apart.abs() < 2e-3, "{fit:?}");
        assert!((channel.amplitude_v - 1e-3).abs() < 1e-5, "{fit:?}");
        assert!((channel.offset_v - 2.52).abs() < 1e-4, "{fit:?}");
    }
}

/// A taxel whose conversion was lost has no value. Reading it as zero would look like a touch of
/// 2.5 V.
#[test]
fn a_conversion_lost_just_before_the_touch_changes_nothing() {
    let without = |gone| {
        let events = run(
            scene(30.0, 3.6, 20.0, 1),
            Settings::default(),
            |count, conversion| (Some(count) != gone).then_some(conversion),
        );
        outcome(&events)
    };
    let clean = without(None);
    for lost in 0..4 {
        // Lost in the frames just before the contact at 0.5 s.
        let out = without(Some((118 + lost) * 21 + 7));
        assert_eq!(out.health.conversions_lost, 1);
        out.assert_one_slide("one lost");
        let off_s = [
            out.contacts_s[0] - clean.contacts_s[0],
            out.slides_s[0].0 - clean.slides_s[0].0,
        ];
        assert!(off_s.iter().all(|off_s| off_s.abs() < 0.005), "{out:?}");
    }
}

/// A window that begins or ends in a gap of lost scans must use the right frame rate. Windows that
/// extend beyond the slide are excluded: they include a standstill with a different mean.
#[test]
fn holes_do_not_bend_the_frequency() {
    let settings = Settings {
        window_s: 0.5,
        stride_s: 0.05,
        ..Settings::DEFAULT
    };
    for scans in [1, 5, 30, 120] {
        for at_s in [2.0, 2.25, 2.5, 2.6, 2.75] {
            let first = (at_s * 241.14) as u32 * 21 + 4;
            let scene = scene(30.0, 3.6, 20.0, 2);
            let truth = scene.truth();
            let out = outcome(&run(scene, settings, |count, conversion| {
                (!(first..first + scans * 21).contains(&count)).then_some(conversion)
            }));
            let is_within = |fit: &&Estimate| (fit.t_us as f64) < 1e6 * truth.slide_end_s;
            for fit in out
                .fits()
                .filter(is_within)
                .filter(|fit| fit.status == Status::Good)
            {
                let off = fit.frequency as f64 / truth.frequency_hz - 1.0;
                assert!(off.abs() < 0.01, "{scans} scans lost at {at_s} s: {fit:?}");
            }
        }
    }
}

/// Conversions with SUPPLY low must not be trusted or used for touch detection.
#[test]
fn a_dip_of_the_supply_is_not_a_touch() {
    let events = run(
        in_the_air(4.0),
        Settings::default(),
        |count, mut conversion| {
            if (10_000..10_500).contains(&count) {
                let supply_low = StatusByte(conversion.status().0 | 1 << 5);
                conversion = conversion
                    .with_status(supply_low)
                    .with_code(conversion.code() / 3);
            }
            Some(conversion)
        },
    );
    let out = outcome(&events);
    assert!(
        out.contacts_s.is_empty() && out.releases_s.is_empty(),
        "{out:?}"
    );
    assert_eq!(out.health.conversions_doubtful, 500);
}
