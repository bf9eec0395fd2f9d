//! The link with a stylus' board at its end: the library of its image behind a pseudo-terminal, in
//! real time.

use super::common::{directory, json_lines, ridgetone, text};
use super::stylus_board::{StylusBoard, Trace};
use super::{SPEED_MM_S, counts, recorded_touch};
use ridgetone_host::port::{self, System, Wanted};
use ridgetone_teletaction::link::network::Impairments;
use ridgetone_teletaction::link::run::Report;
use ridgetone_teletaction::link::{BoardEnd, Ends, Hand, Link, Options};
use ridgetone_teletaction::stimulus::{Actuator, Texture};
use ridgetone_teletaction::stylus::SAMPLE_HZ;
use ridgetone_teletaction::stylus::gate::State;
use ridgetone_teletaction::stylus::parameters::Parameters;
use ridgetone_teletaction::touch::Output;
use std::thread::sleep;
use std::time::{Duration, Instant};

/// Other limits than the default's, to see that they arrive.
const ACTUATOR: Actuator = Actuator {
    voltage_v: 120.0,
    ..Actuator::PIEZO
};

/// The converter's rest.
const REST_CODE: u16 = 2048;

struct Bench {
    board: StylusBoard,
    link: Link,
    begun: Instant,
}

impl Bench {
    fn new(impairments: Impairments) -> Self {
        let board = StylusBoard::new(counts);
        let output = Output::new(ACTUATOR, None).expect("an output");
        let options = Options {
            delay_ms: (40.0, 5.0),
            impairments,
            seed: 5,
            run: 70_000,
            hand: Hand::OKAMOTO,
            output,
            follows: false,
        };
        let line = port::Link::open(System, Wanted::Name(board.name.clone())).expect("a line");
        let end = BoardEnd::new(Box::new(line), output, Parameters::DEFAULT, options.run)
            .expect("an end");
        let link = Link::new(&options, Ends::Here, Some(end)).expect("a link");
        Self {
            board,
            link,
            begun: Instant::now(),
        }
    }

    /// Runs for a time; gives the report of it.
    fn pass(&mut self, seconds: f64) -> Report {
        let until_s = self.begun.elapsed().as_secs_f64() + seconds;
        loop {
            let t_s = self.begun.elapsed().as_secs_f64();
            self.link.step(t_s).expect("a step");
            if t_s >= until_s {
                return self.link.report(t_s);
            }
            sleep(Duration::from_millis(1));
        }
    }

    fn report(&mut self) -> Report {
        self.link.report(self.begun.elapsed().as_secs_f64())
    }

    fn trace(&self) -> Trace {
        self.board.trace()
    }
}

/// No step is steeper than the actuator allows, one code of rounding included.
fn assert_soft(trace: &Trace) {
    let code_v = f64::from(ACTUATOR.voltage_v) / 4095.0;
    // From 0 V to its rest the board goes before it knows the actuator's slew, with that of the
    // default.
    let slew_v_s = f64::from(ACTUATOR.slew_v_s.max(Actuator::PIEZO.slew_v_s));
    let most = slew_v_s / f64::from(SAMPLE_HZ) / code_v + 1.0;
    let step = trace
        .codes
        .windows(2)
        .map(|pair| pair[0].abs_diff(pair[1]))
        .max()
        .expect("codes");
    assert!(
        f64::from(step) <= most,
        "a step of {step} codes, allowed are {most}"
    );
}

/// Times that the codes rise through the rest in the last second.
fn rises(trace: &Trace) -> usize {
    let last = &trace.codes[trace.codes.len() - SAMPLE_HZ as usize..];
    last.windows(2)
        .filter(|pair| pair[0] < REST_CODE && pair[1] >= REST_CODE)
        .count()
}

#[test]
#[ignore = "looks at a clock: cargo xtask test"]
fn textures_and_parameters_go_to_the_board_and_its_hand_to_the_finger() {
    let mut bench = Bench::new(Impairments {
        loss: 0.05,
        ..Impairments::default()
    });
    bench.link.finger.found(Some(Texture::new(1.4)));
    bench.pass(1.0);
    let from_mm = bench.link.finger.position_mm.expect("a position");
    let before = bench.report();
    let report = bench.pass(2.0);
    println!("{}", report.text());
    let moved_mm = bench.link.finger.position_mm.expect("a position") - from_mm;
    // A busy computer is late by more than the passes say; what it counts and reads in a pass may be
    // off by a tenth of a second.
    let passed_s = report.t_s - before.t_s;
    assert!(
        (moved_mm / SPEED_MM_S - passed_s).abs() < 0.1,
        "{moved_mm} mm in {passed_s} s"
    );
    let positions = (report.positions_sent - before.positions_sent) as f64;
    assert!(
        (225.0..275.0).contains(&(positions / passed_s)),
        "{positions} positions in {passed_s} s: {report:?}"
    );
    assert!(
        report.positions.received > 500 && report.positions.lost > 5,
        "{report:?}"
    );
    assert!(
        report.behind_mm.is_some_and(|mm| (1.0..20.0).contains(&mm)),
        "40 ms and what is lost: {report:?}"
    );
    assert_eq!(
        (report.is_felt, report.period_mm, report.error_percent),
        (true, Some(1.4), None)
    );
    let stylus = report.stylus.expect("a board");
    assert_eq!(
        (stylus.state, stylus.packets_damaged, stylus.silences),
        (Some(State::Vibrating), 0, 0)
    );
    let trace = bench.trace();
    // The actuator's limits are in force before anything vibrates.
    assert_eq!(
        trace
            .parameters
            .last()
            .map(|parameters| parameters.actuator),
        Some(ACTUATOR)
    );
    // 100 mm/s over 1.4 mm is 71.4 Hz.
    assert!((70..=73).contains(&rises(&trace)), "{}", rises(&trace));
    assert_soft(&trace);
    bench.link.finger.found(Some(Texture::new(0.8)));
    assert_eq!(bench.pass(1.5).period_mm, Some(0.8));
    assert!(
        (123..=127).contains(&rises(&bench.trace())),
        "{}",
        rises(&bench.trace())
    );
    assert_soft(&bench.trace());
}

/// Neither a finger that is silent nor a network that is dead leaves a vibration; it stops softly,
/// and comes again.
#[test]
#[ignore = "looks at a clock: cargo xtask test"]
fn without_the_finger_the_board_rests() {
    let mut bench = Bench::new(Impairments::default());
    bench.link.finger.found(Some(Texture::new(1.4)));
    assert!(bench.pass(1.0).is_felt);
    bench.link.finger.found(None);
    let report = bench.pass(0.5);
    let stylus = report.stylus.expect("a board");
    assert_eq!(
        (report.is_felt, report.period_mm, stylus.state),
        (false, None, Some(State::Disabled))
    );
    assert_eq!(bench.trace().codes.last(), Some(&REST_CODE));
    bench.link.finger.found(Some(Texture::new(1.4)));
    assert!(bench.pass(0.5).is_felt);
    bench.link.to_stylus.impairments.loss = 1.0;
    let report = bench.pass(1.5);
    assert_eq!(
        (
            report.is_felt,
            report.stylus.and_then(|stylus| stylus.state)
        ),
        (false, Some(State::Disabled))
    );
    assert_eq!(bench.trace().codes.last(), Some(&REST_CODE));
    bench.link.to_stylus.impairments.loss = 0.0;
    assert!(bench.pass(1.0).is_felt);
    assert_soft(&bench.trace());
}

/// Nobody knows what a board does that says nothing: it is reported, disabled, and set up again
/// when it is back.
#[test]
#[ignore = "looks at a clock: cargo xtask test"]
fn a_board_that_is_silent_is_reported_and_stops_softly() {
    let mut bench = Bench::new(Impairments::default());
    bench.link.finger.found(Some(Texture::new(1.4)));
    assert!(bench.pass(1.0).is_felt);
    bench.board.mute(true);
    let report = bench.pass(2.0);
    let stylus = report.stylus.expect("a board");
    assert_eq!(
        (
            report.is_felt,
            report.period_mm,
            stylus.state,
            stylus.silences
        ),
        (false, None, None, 1)
    );
    assert!(report.text().contains("stylus silent"), "{}", report.text());
    let trace = bench.trace();
    assert_eq!(
        (trace.states.last(), trace.codes.last()),
        (Some(&State::Disabled), Some(&REST_CODE))
    );
    bench.board.mute(false);
    let report = bench.pass(1.0);
    assert_eq!(
        (report.is_felt, report.period_mm),
        (true, Some(1.4)),
        "{report:?}"
    );
    assert_soft(&bench.trace());
}

#[test]
#[ignore = "looks at a clock: cargo xtask test"]
fn a_board_that_has_started_again_gets_all_again() {
    let mut bench = Bench::new(Impairments::default());
    bench.link.finger.found(Some(Texture::new(1.4)));
    assert!(bench.pass(1.0).is_felt);
    let position_mm = bench.link.finger.position_mm.expect("a position");
    bench.board.restart();
    let report = bench.pass(1.5);
    assert_eq!(
        (report.is_felt, report.period_mm),
        (true, Some(1.4)),
        "{report:?}"
    );
    let trace = bench.trace();
    let greeted: Vec<f32> = trace
        .parameters
        .iter()
        .map(|parameters| parameters.actuator.voltage_v)
        .collect();
    assert_eq!(
        greeted,
        [
            Actuator::PIEZO.voltage_v,
            120.0,
            Actuator::PIEZO.voltage_v,
            120.0
        ]
    );
    // A restart is no way back to where the hand began.
    let moved_mm = bench.link.finger.position_mm.expect("a position") - position_mm;
    assert!(
        (moved_mm / SPEED_MM_S - 1.5).abs() < 0.1,
        "{moved_mm} mm in 1.5 s"
    );
}

/// A recorded finger and a board: the command ends with the recording, and leaves the board at
/// rest.
#[test]
#[ignore = "looks at a clock: cargo xtask test"]
fn the_command_leaves_the_board_at_rest() {
    let folder = directory();
    let path = recorded_touch(&folder);
    let board = StylusBoard::new(counts);
    let run = ridgetone()
        .args([
            "link",
            "--finger",
            text(&path),
            "--stylus",
            &board.name,
            "--voltage-v",
            "120",
            "--json",
        ])
        .output()
        .expect("the command runs");
    let reports = json_lines(&run);
    let felt = reports
        .iter()
        .rfind(|report| report["is_felt"] == true)
        .unwrap_or_else(|| panic!("{reports:?}"));
    assert_eq!(felt["stylus"]["state"], "vibrating", "{felt}");
    assert!(
        (felt["period_mm"].as_f64().expect("a number") - 3.6).abs() < 0.4,
        "{felt}"
    );
    let trace = board.trace();
    assert!(trace.states.contains(&State::Vibrating));
    // By a request: a line that was silent would say so.
    assert!(!trace.states.contains(&State::LineSilent));
    assert_eq!(trace.states.last(), Some(&State::Disabled));
    assert_soft(&trace);
}
