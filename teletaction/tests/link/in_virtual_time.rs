//! The link in virtual time.

use hal_mock::Sliding;
use ridgetone_host::input::Input;
use ridgetone_host::replay;
use ridgetone_proto::settings::Settings;
use ridgetone_proto::telemetry::{Event, Packet, Status};
use ridgetone_teletaction::link::finger::PeriodBy;
use ridgetone_teletaction::link::network::Impairments;
use ridgetone_teletaction::link::run::Report;
use ridgetone_teletaction::link::{Ends, Hand, Link, Options};
use ridgetone_teletaction::stimulus::{Actuator, Texture};
use ridgetone_teletaction::touch::Output;
use std::f64::consts::FRAC_PI_2;

/// Mean delay and its standard deviation, milliseconds.
#[derive(Clone, Copy)]
struct Delay {
    mean: f64,
    deviation: f64,
}

const STEADY: Delay = Delay {
    mean: 120.0,
    deviation: 0.0,
};

fn link(delay_ms: Delay, impairments: Impairments) -> Link {
    Link::new(&options(delay_ms, impairments), Ends::Here, None).expect("a link")
}

fn options(delay_ms: Delay, impairments: Impairments) -> Options {
    let output = Output::new(Actuator::PIEZO, None).expect("an output");
    Options {
        delay_ms: (delay_ms.mean, delay_ms.deviation),
        impairments,
        seed: 5,
        run: 1,
        hand: Hand::OKAMOTO,
        output,
        follows: false,
    }
}

/// Steps of a millisecond; gives the report of the last second.
fn pass(link: &mut Link, from_s: f64, to_s: f64) -> Report {
    for n in (1000.0 * from_s) as u64..(1000.0 * to_s) as u64 {
        let t_s = 0.001 * n as f64;
        if (t_s - (to_s - 1.0)).abs() < 1e-6 {
            let _ = link.report(t_s);
        }
        link.step(t_s).expect("a step");
        assert!(
            link.stylus.steepest <= 1.0 + 1e-4 && link.stylus.level().abs() <= 1.0,
            "{t_s}"
        );
    }
    link.report(to_s)
}

const PAPER: Delay = Delay {
    mean: 120.0,
    deviation: 40.0,
};

/// The delay is not felt: below 1 % of the amplitude and 0.02 cycles, where a vibration that
/// travels would be nothing like the surface.
#[test]
fn neither_delay_nor_jitter_nor_loss_is_felt() {
    let mut link = link(
        PAPER,
        Impairments {
            loss: 0.05,
            ..Impairments::default()
        },
    );
    link.finger.found(Some(Texture::new(1.4)));
    let report = pass(&mut link, 0.0, 10.0);
    println!("{}", report.text());
    let error_percent = report.error_percent.expect("felt");
    assert!(
        error_percent < 1.0 && report.error_cycles.expect("felt") < 0.02,
        "{report:?}"
    );
    assert!(
        report.as_vibration_percent.expect("felt") > 50.0,
        "{report:?}"
    );
    let Report {
        positions,
        positions_sent,
        textures_sent,
        ..
    } = &report;
    assert_eq!(*positions_sent, 2500);
    // 5 %, each with its standard deviation of 11; what is under way, up to 0.28 s, is neither.
    let under_way = positions_sent - positions.received - positions.lost - positions.late;
    assert!(
        (80..175).contains(&positions.lost) && under_way <= 75 && positions.damaged == 0,
        "{report:?}"
    );
    assert!((38..43).contains(textures_sent), "{report:?}");
    // The mean speed over the mean delay is 15 mm.
    assert!(report.behind_mm.expect("a position") < 60.0, "{report:?}");
}

#[test]
fn a_new_texture_arrives_and_is_felt() {
    let mut link = link(PAPER, Impairments::default());
    link.finger.found(Some(Texture::new(1.4)));
    pass(&mut link, 0.0, 3.0);
    link.finger.found(Some(Texture::new(0.9)));
    let while_it_travels = pass(&mut link, 3.0, 4.0);
    let after = pass(&mut link, 4.0, 5.0);
    assert!(
        while_it_travels.error_percent > Some(5.0),
        "{while_it_travels:?}"
    );
    assert_eq!(after.period_mm, Some(0.9));
    assert!(
        after.error_percent < Some(1.0) && after.error_cycles < Some(0.02),
        "{after:?}"
    );
}

#[test]
fn damaged_and_doubled_messages_are_counted_and_do_no_harm() {
    let mut link = link(
        PAPER,
        Impairments {
            loss: 0.1,
            doubled: 0.2,
            damaged: 0.2,
        },
    );
    link.finger.found(Some(Texture::new(1.4)));
    let report = pass(&mut link, 0.0, 20.0);
    for (counts, sent) in [(&report.positions, 5000.0), (&report.textures, 80.0)] {
        // 0.9 of 1.2 copies arrive, and a fifth of them is damaged.
        let (damaged, doubled) = (counts.damaged as f64 / sent, counts.doubled as f64 / sent);
        assert!(
            (0.12..0.32).contains(&damaged) && (0.04..0.22).contains(&doubled),
            "{report:?}"
        );
    }
    assert!(
        report.error_percent < Some(1.0) && report.error_cycles < Some(0.02),
        "{report:?}"
    );
}

/// The vibration fades, within the slew, as soon as a second without a message is over; and comes
/// again with the link.
#[test]
fn a_dead_link_stops_softly() {
    let mut link = link(STEADY, Impairments::default());
    link.finger.found(Some(Texture::new(1.4)));
    assert!(pass(&mut link, 0.0, 3.0).is_felt);
    link.to_stylus.impairments.loss = 1.0;
    // What is under way still arrives.
    assert!(pass(&mut link, 3.0, 3.6).is_felt);
    let dead = pass(&mut link, 3.6, 5.0);
    assert!(
        !dead.is_felt && dead.period_mm.is_none() && link.stylus.level() == 0.0,
        "{dead:?} {}",
        link.stylus.level()
    );
    link.to_stylus.impairments.loss = 0.0;
    assert!(pass(&mut link, 5.0, 7.0).error_percent < Some(1.0));
    // A finger that is silent itself says so.
    link.finger.found(None);
    assert!(!pass(&mut link, 7.0, 8.0).is_felt && link.stylus.level() == 0.0);
}

/// A robot that follows the hand slides a simulated finger to and fro over a grating of 3.6 mm, and
/// the firmware's library fits it: the period comes from the path of the hand, and from no window
/// in which the hand turns.
#[test]
fn the_period_is_the_hands_path_over_the_windows_cycles() {
    const PERIOD_MM: f64 = 3.6;
    // 60 mm/s at most, and 2 s from turn to turn.
    let scene_hand = hal_mock::sliding::Hand {
        peak_mm_s: 60.0,
        swing_hz: 0.25,
        swings: 3.0,
    };
    let input = Input {
        scene: Sliding {
            period_mm: PERIOD_MM,
            hand: Some(scene_hand),
            ..Sliding::physical()
        },
        ..Input::default()
    };
    let opened = input.open().expect("a scene");
    let slide_start_s = opened.truth.as_ref().expect("a scene").slide_start_s;
    let mut events = Vec::new();
    let mut sink = |packet: &Packet| {
        events.push(packet.event.clone());
        Ok(())
    };
    let settings = Settings {
        window_s: 0.8,
        ..Settings::DEFAULT
    };
    replay::run(opened, settings, &mut sink, &mut |_, _| {}).expect("a run");

    // The hand of the link begins to move at 0 s, and the finger a delay later.
    let delay_s = STEADY.mean / 1e3;
    let linked_s = |device_us: u64| device_us as f64 * 1e-6 - slide_start_s + delay_s;
    let options = Options {
        hand: Hand {
            speed_mm_s: scene_hand.peak_mm_s / FRAC_PI_2,
            turns_hz: scene_hand.swing_hz,
        },
        follows: true,
        ..options(
            STEADY,
            Impairments {
                loss: 0.05,
                ..Impairments::default()
            },
        )
    };
    let mut link = Link::new(&options, Ends::Here, None).expect("a link");
    let (mut now_ms, mut straight, mut turning, mut by_lags) = (0u64, Vec::new(), 0, None);
    for event in &events {
        let Event::Estimate(estimate) = event else {
            if let Event::Texture(texture) = event {
                by_lags = by_lags.or(Some((texture.period_mm, texture.period_sigma_mm)));
            }
            continue;
        };
        let end_s = linked_s(estimate.t_us);
        let begin_s = end_s - f64::from(estimate.window_s);
        // Only windows of the slide, not the fit of the whole of it.
        if begin_s < delay_s || estimate.window_s > 1.0 {
            continue;
        }
        // The estimate arrives 60 ms after its window.
        while (now_ms as f64) < 1e3 * (end_s + 0.06) {
            link.step(1e-3 * now_ms as f64).expect("a step");
            now_ms += 1;
        }
        let found = link.finger.window(end_s, estimate);
        let swing = |t_s: f64| ((t_s - delay_s) * 2.0 * scene_hand.swing_hz).floor();
        if swing(begin_s) != swing(end_s) {
            turning += 1;
            assert_eq!(found, None, "{begin_s} to {end_s} s");
        } else if estimate.status == Status::Good {
            let found = found.unwrap_or_else(|| panic!("{begin_s} to {end_s} s"));
            let off_mm = found.mm - PERIOD_MM;
            assert!(off_mm.abs() < 4.0 * found.sigma_mm, "{found:?}");
            straight.push((off_mm, found.sigma_mm));
        } else {
            assert_eq!(found, None, "{:?}", estimate.status);
        }
    }
    let count = straight.len() as f64;
    let rms = |values: &mut dyn Iterator<Item = f64>| {
        (values.map(|mm| mm * mm).sum::<f64>() / count).sqrt()
    };
    let off_mm = rms(&mut straight.iter().map(|(off_mm, _)| *off_mm));
    let sigma_mm = rms(&mut straight.iter().map(|(_, sigma_mm)| *sigma_mm));
    let texture = link.finger.texture().expect("a texture");
    println!(
        "{count} windows without a turn, {turning} with one: rms error {off_mm:.4} mm, sigma {sigma_mm:.4} mm; \
         last {:.4} +- {:.4} mm; by the lags {by_lags:?}",
        texture.period_mm, texture.period_sigma_mm
    );
    assert!(count >= 10.0 && turning >= 3, "{count} {turning}");
    // The lags of an array that nobody has calibrated are known to 7 %.
    assert!(
        off_mm < 0.02 * PERIOD_MM && sigma_mm < 0.03 * PERIOD_MM,
        "{off_mm} {sigma_mm}"
    );
    assert!(
        (f64::from(texture.period_mm) - PERIOD_MM).abs() < 4.0 * f64::from(texture.period_sigma_mm)
    );
    assert_eq!(link.finger.period_by(), Some(PeriodBy::Path));
}
