//! The four runs of `cargo xtask test`, on both boards: from reset to the greeting, the demo's
//! grating, the longest command while the chip scans, a speed profile while the finger slides.

mod common;

use common::{
    BOARDS, Run, estimate_of, estimates, hello, on_pc, reply_to, request, touches_and_tones,
};
use hal_mock::{Constant, Sliding, SlidingScene, Stimulator};
use ridgetone::surface::profile::Profile;
use ridgetone_proto::boot::{Oscillator, ResetCause};
use ridgetone_proto::command::{Command, KNOTS_A_COMMAND, Outcome, Part};
use ridgetone_proto::profile::{After, KNOTS_MAX, Knot};
use ridgetone_proto::settings::{Array, Settings, Slide, SlideRule};
use ridgetone_proto::telemetry::{Abscissa, Span, Status};
use rig::Start;

#[test]
#[ignore = "needs the boards' images: cargo xtask test"]
fn both_boards_start_and_greet_and_lose_nothing() {
    for board in BOARDS {
        let mut run = Run::new(board, Constant::default(), Start::default());
        let greeting = run.run_to(1.0, hello);
        assert_eq!(
            (greeting.boot.cause, greeting.boot.record),
            (ResetCause::Power, None),
            "{board:?}"
        );
        assert_eq!(greeting.boot.oscillator, Oscillator::External, "{board:?}");
        run.run_s(1.0);
        run.assert_rules();
        assert!(run.rig.resets().is_empty());
        let seconds = run.rig.now_ns() as f64 * 1e-9;
        assert!(seconds < 1.5, "{board:?}: {seconds}");
        let (read, counters) = (run.rig.readings().len() as u64, run.rig.adc().counters());
        assert_eq!(counters.lost, 0, "{board:?}: {counters:?}");
        assert!(
            read > 4000 && counters.conversions - read <= 1,
            "{board:?}: {read} of {counters:?}"
        );
    }
}

#[test]
#[ignore = "needs the boards' images: cargo xtask test"]
fn the_demo_is_the_same_on_both_boards_and_on_the_pc() {
    for board in BOARDS {
        let mut run = Run::sliding(board);
        run.run_s(6.0);
        run.assert_rules();
        let there = touches_and_tones(&run.events);
        assert!(there.len() > 8, "{there:?}");
        assert!(
            there == touches_and_tones(&on_pc(&run, 0, None)),
            "{board:?}: to the bit: {there:?}"
        );
        let whole = estimates(&there)
            .into_iter()
            .find(|one| one.span == Span::Slide);
        let estimate = whole.expect("an estimate of the whole slide");
        assert_eq!(estimate.status, Status::Good);
        // 3.6 mm at 30 mm/s.
        let off = (estimate.frequency - 30.0 / 3.6).abs() / estimate.sigma;
        assert!(off < 4.0, "{estimate:?}");
        println!("{board:?}: {} conversions", run.rig.readings().len());
    }
}

#[test]
#[ignore = "needs the boards' images: cargo xtask test"]
fn the_longest_command_arrives_two_hundred_times_while_the_chip_scans() {
    let slide = Slide {
        rule: SlideRule::Protocol,
        delay_s: 1.0,
        speed_mm_s: 30.0,
        length_mm: 55.0,
    };
    let array = Array {
        alike: [0x8001, 0x4002, 0x2004, 0x1008],
        ..Array::DEFAULT
    };
    let set = Command::Set {
        settings: Settings {
            slide,
            array,
            ..Settings::DEFAULT
        },
        keep: false,
    };
    for board in BOARDS {
        let mut run = Run::at_rest(board);
        let sent = request(u16::MAX, set.clone());
        assert!(sent.len() > 80, "{} bytes", sent.len());
        for number in 1..=200 {
            run.rig.send(&request(u16::MAX - number, set.clone()));
            let seen = run.events.len();
            run.run_s(0.03);
            let reply = run.events[seen..]
                .iter()
                .find_map(reply_to(u16::MAX - number));
            assert_eq!(reply, Some(Outcome::Done), "{board:?}: request {number}");
        }
        run.assert_rules();
        assert_eq!(run.rig.received()[..2], [0, 0], "{board:?}: none lost");
    }
}

/// The speed swings, the PC sends it in parts while the finger slides. Estimates in hertz before it
/// is whole, and in cycles per millimetre from then on, are the library's on this PC.
#[test]
#[ignore = "needs the boards' images: cargo xtask test"]
fn a_speed_profile_sent_while_sliding_gives_estimates_by_place() {
    for board in BOARDS {
        let stimulator = Stimulator {
            ripple_percent: 40.0,
            ripple_hz: 1.0,
            ..Stimulator::IDEAL
        };
        let parameters = Sliding {
            stimulator,
            slide_mm: 120.0,
            ..Sliding::default()
        };
        let scene = SlidingScene::new(parameters.clone()).expect("a scene");
        let mut run = Run::new(
            board,
            SlidingScene::new(parameters).expect("a scene"),
            Start::default(),
        );
        run.run_s(0.5);
        // The board counts from the edge of the first conversion.
        let zero_ns = run.rig.adc().scene_zero_ns().expect("it scans");
        let first_us = (run.rig.readings()[0].edge_ns - zero_ns) as f64 * 1e-3;
        let (from_s, to_s) = (scene.truth().slide_start_s, scene.truth().slide_end_s);
        let knots: Vec<Knot> = (0..KNOTS_MAX)
            .map(|knot| {
                let t_s = from_s + (to_s - from_s) * (knot as f64 + 0.5) / KNOTS_MAX as f64;
                let t_us = (t_s * 1e6 - first_us) as u32;
                Knot {
                    t_us,
                    speed_mm_s: scene.speed_mm_s(t_s) as f32,
                }
            })
            .collect();
        run.run_s(3.0);
        let parts = knots.chunks(KNOTS_A_COMMAND);
        let last = parts.len() - 1;
        for (at, knots) in parts.enumerate() {
            let last = (at == last).then_some(After::Hold);
            let part = Part {
                first: (at * KNOTS_A_COMMAND) as u8,
                knots: knots.iter().copied().collect(),
                last,
            };
            assert_eq!(
                run.command(at as u16 + 1, Command::Follow(part)),
                Outcome::Done,
                "{board:?}"
            );
        }
        run.run_to(10.0, |event| {
            estimate_of(event).filter(|one| one.span == Span::Slide)
        });
        run.assert_rules();
        let there = estimates(&run.events);
        let by_time = there
            .iter()
            .take_while(|one| one.abscissa == Abscissa::Time)
            .count();
        let profile = Profile::new(&knots, After::Hold).expect("a profile");
        let here = estimates(&on_pc(&run, by_time, Some(&profile)));
        assert!(there == here, "{board:?}: to the bit: {there:?} {here:?}");
        let by_place = &there[by_time..];
        assert!(by_time > 2 && by_place.len() > 4, "{by_time}, {by_place:?}");
        for estimate in by_place {
            // Eight knots in a swing: chords cost a percent.
            let off = estimate.frequency * 3.6 - 1.0;
            assert!(
                estimate.abscissa == Abscissa::Place && off.abs() < 0.02,
                "{board:?}: {estimate:?}"
            );
        }
    }
}
