//! Tests every scan plan on the whole path, from SPI bytes to telemetry.

#[allow(dead_code, reason = "every test file uses a part of it")]
mod support;

use hal_mock::{Sliding, SlidingScene};
use ridgetone_finger::converter::Ads1258Plan;
use ridgetone_proto::plan::{HealthReadings, Plan};
use ridgetone_proto::settings::Settings;
use ridgetone_proto::telemetry::{Event, Status};
use support::{Outcome, Rate, all, off, outcome, run};

/// Runs a touch with one slide. Returns events, outcome and truth.
fn touch(plan: Plan, speed_mm_s: f64, period_mm: f64) -> (Vec<Event>, Outcome, hal_mock::Truth) {
    let scene = Sliding {
        speed_mm_s,
        period_mm,
        snr_db: Some(20.0),
        seed: 3,
        ..Sliding::default()
    };
    let scene = SlidingScene::new(scene).unwrap();
    let truth = scene.truth();
    let events = run(scene, Settings::DEFAULT.with_plan(plan), all);
    let out = outcome(&events);
    (events, out, truth)
}

fn finds(what: &str, plan: Plan, tones: &[(f64, f64)], rate: &mut Rate) {
    for (speed_mm_s, period_mm) in tones {
        let (events, out, truth) = touch(plan, *speed_mm_s, *period_mm);
        let rate_hz = f64::from(plan.frame_rate_hz());
        // Touch detection finds starts and ends only to a few blocks of averaged frames.
        let limit_s = 0.020_f64.max(8.0 * f64::from(plan.frames_averaged()) / rate_hz);
        let what = format!("{what}, {rate_hz} Hz, {speed_mm_s} mm/s, {period_mm} mm");
        out.assert_slide(&what, &truth, limit_s);
        let what = format!("{what}: {out:?} {truth:?}");
        assert!(
            matches!(&events[0], Event::Hello(hello) if f64::from(hello.frame_rate_hz) == rate_hz),
            "{what}"
        );
        let health = &out.health;
        assert!(
            (f64::from(health.frame_rate_hz) / rate_hz - 1.0).abs() < 1e-4,
            "{what}"
        );
        let lost = (
            health.conversions_lost,
            health.conversions_doubtful,
            health.overruns,
        );
        assert_eq!((lost, out.slide_fits.len()), ((0, 0, 0), 1), "{what}");
        for fit in out.fits() {
            rate.add(fit);
            assert_eq!(fit.channels.len(), plan.channels(), "{what}");
            let is_input = |taxel: u8| plan.inputs >> taxel & 1 == 1;
            assert!(
                fit.channels.iter().all(|channel| is_input(channel.taxel)),
                "{what}"
            );
            assert!(off(fit, &truth).abs() < 6.0, "{what}");
        }
        let off = f64::from(out.slide_fits[0].frequency) / truth.frequency_hz - 1.0;
        assert!(off.abs() < 0.002, "{what}");
    }
}

#[test]
fn the_papers_plan_and_others_as_slow_find_slides_and_their_frequencies() {
    let mut rate = Rate::default();
    let tones = &[(15.0, 2.6), (30.0, 3.1), (48.0, 3.6)];
    let own = |change: fn(&mut Ads1258Plan)| {
        let mut own = Ads1258Plan::PAPER;
        change(&mut own);
        own.plan()
    };
    let chopped = |own: &mut Ads1258Plan| {
        (own.data_rate, own.delay, own.chop) = (2, 4, true);
        own.health = HealthReadings::BetweenTouches;
    };
    for (what, plan) in [
        ("the paper's", Plan::PAPER),
        ("eight inputs", own(|own| own.inputs = 0x00ff)),
        ("an oscillator", Plan::PAPER.with_clock(16_000_000)),
        ("168 MHz / 11", Plan::PAPER.with_clock(15_272_727)),
        ("others than the first", own(|own| own.inputs = 0xe0c1)),
        ("a higher data rate", own(|own| own.data_rate = 2)),
        (
            "a lower one",
            own(|own| (own.data_rate, own.inputs) = (0, 0x000f)),
        ),
        ("chopped", own(chopped)),
    ] {
        finds(what, plan, tones, &mut rate);
    }
    rate.assert_good();
}

#[test]
fn fast_plans_find_tones_that_the_papers_cannot() {
    let mut rate = Rate::default();
    // The scene's overtones are below half the frame rate, or too weak to matter.
    for (what, plan, tones) in [
        (
            "hand",
            Plan::HAND,
            &[(150.0, 0.6), (200.0, 1.0), (48.0, 1.6), (30.0, 0.2)][..],
        ),
        ("texture", Plan::TEXTURE, &[(120.0, 0.3), (200.0, 0.25)]),
        (
            "vibration",
            Plan::VIBRATION,
            &[(150.0, 0.2), (200.0, 0.125)],
        ),
        ("single", Plan::SINGLE, &[(150.0, 0.2), (200.0, 0.1)]),
    ] {
        finds(what, plan, tones, &mut rate);
    }
    rate.assert_good();
}

/// Aliased overtones may fit the harmonic comb of a lower tone. Such tones may be ambiguous, but
/// must not be wrong.
#[test]
fn tones_whose_overtones_alias_are_never_called_good_at_another_frequency() {
    for (plan, speed_mm_s, period_mm) in [
        (Plan::HAND, 200.0, 0.4),
        (Plan::HAND, 200.0, 0.5),
        (Plan::HAND, 100.0, 0.2),
        (Plan::TEXTURE, 200.0, 0.1),
        (Plan::VIBRATION, 200.0, 0.05),
        (Plan::SINGLE, 200.0, 0.04),
    ] {
        let (_, out, truth) = touch(plan, speed_mm_s, period_mm);
        out.assert_one_slide(&format!("{truth:?}"));
        for fit in out.fits().filter(|fit| fit.status == Status::Good) {
            assert!(off(fit, &truth).abs() < 6.0, "{truth:?}: {fit:?}");
        }
    }
}
