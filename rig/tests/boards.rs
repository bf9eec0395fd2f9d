//! Both boards' images from reset to the greeting, and over the demo's grating.

mod common;

use ads1258::Conversion;
use common::{BOARDS, Run, hello};
use hal_mock::{Constant, Sliding, SlidingScene};
use ridgetone::frame::TimedConversion;
use ridgetone::pipeline::Pipeline;
use ridgetone_proto::boot::ResetCause;
use ridgetone_proto::settings::Settings;
use ridgetone_proto::telemetry::{Event, Span, Status};
use rig::Start;

#[test]
#[ignore = "needs the boards' images: cargo xtask test"]
fn both_boards_start_and_greet() {
    for board in BOARDS {
        let mut run = Run::new(board, Constant::default(), Start::default());
        let greeting = run.run_to(1.0, hello);
        assert_eq!(greeting.boot.cause, ResetCause::Power, "{board:?}");
        assert!(greeting.boot.record.is_none());
        run.run_s(1.0);
        run.assert_rules();
        assert!(run.rig.resets().is_empty());
        let seconds = run.rig.now_ns() as f64 * 1e-9;
        assert!(seconds < 1.5, "{board:?}: {seconds}");
    }
}

#[test]
#[ignore = "needs the boards' images: cargo xtask test"]
fn the_demo_is_the_same_on_both_boards_and_on_the_pc() {
    for board in BOARDS {
        let scene = SlidingScene::new(Sliding::default()).expect("the default scene");
        let mut run = Run::new(board, scene, Start::default());
        run.run_s(6.0);
        run.assert_rules();

        let mut pipeline = Pipeline::new(Settings::DEFAULT);
        let mut on_pc = Vec::new();
        for reading in run.rig.readings() {
            let conversion = Conversion::from_bytes(reading.bytes);
            pipeline.push(TimedConversion { t_us: reading.t_us, conversion }, &mut |event| on_pc.push(event));
        }
        let same = |events: &[Event]| -> Vec<Event> {
            let kinds = |event: &&Event| {
                matches!(
                    event,
                    Event::Estimate(_) | Event::Contact(_) | Event::Slide(_) | Event::Release(_) | Event::Image(_)
                )
            };
            let mut kept: Vec<Event> = events.iter().filter(kinds).cloned().collect();
            // A fit ends when it ends: an estimate may be reported behind an event that is younger.
            kept.sort_by_key(|event| (matches!(event, Event::Estimate(_)), event.t_us()));
            kept
        };
        let (there, here) = (same(&run.events), same(&on_pc));
        assert!(there.len() > 8, "{board:?}: {there:?}");
        assert_eq!(there, here, "{board:?}: to the bit");
        let whole = there.iter().find_map(|event| match event {
            Event::Estimate(estimate) if estimate.span == Span::Slide => Some(estimate),
            _ => None,
        });
        let estimate = whole.expect("an estimate of the whole slide");
        assert_eq!(estimate.status, Status::Good);
        let off = (estimate.frequency - 30.0 / 3.6).abs() / estimate.sigma;
        assert!(off < 4.0, "{board:?}: {estimate:?}");
        println!("{board:?}: {} conversions, {} events the same", run.rig.readings().len(), there.len());
    }
}

#[test]
#[ignore = "needs the boards' images: cargo xtask test"]
fn times_of_edges_are_right_to_some_microseconds() {
    for board in BOARDS {
        let mut run = Run::new(board, Constant::default(), Start::default());
        run.run_s(3.0);
        // The counter starts after the power does. Behind the start's backlog the time stamps follow the edges.
        let late: Vec<i64> = (run.rig.readings().iter().skip(100))
            .map(|reading| i64::from(reading.t_us) - (reading.edge_ns / 1000) as i64)
            .collect();
        let (least, most) = (late.iter().min().expect("readings"), late.iter().max().expect("readings"));
        println!("{board:?}: time stamps jitter by {} us", most - least);
        assert!(most - least <= 3, "{board:?}: {least} to {most} us");
    }
}
