//! The link in virtual time.

use ridgetone_stimulus::{Actuator, Texture};
use ridgetone_teletaction::link::network::Impairments;
use ridgetone_teletaction::link::run::Report;
use ridgetone_teletaction::link::{Ends, Link, Options};
use ridgetone_teletaction::touch::{Hand, Output};

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
    let output = Output::new(Actuator::PIEZO, None).expect("an output");
    let options = Options {
        delay_ms: (delay_ms.mean, delay_ms.deviation),
        impairments,
        seed: 5,
        run: 1,
        hand: Hand::OKAMOTO,
        output,
    };
    Link::new(&options, Ends::Here, None).expect("a link")
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
        places,
        places_sent,
        textures_sent,
        ..
    } = &report;
    assert_eq!(*places_sent, 2500);
    // 5 %, each with its standard deviation of 11; what is under way, up to 0.28 s, is neither.
    let under_way = places_sent - places.received - places.lost - places.late;
    assert!(
        (80..175).contains(&places.lost) && under_way <= 75 && places.damaged == 0,
        "{report:?}"
    );
    assert!((38..43).contains(textures_sent), "{report:?}");
    // The mean speed over the mean delay is 15 mm.
    assert!(report.behind_mm.expect("a place") < 60.0, "{report:?}");
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
    for (counts, sent) in [(&report.places, 5000.0), (&report.textures, 80.0)] {
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
