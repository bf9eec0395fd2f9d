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
use rig::{Board, ProcessorFault, Start};

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
        compare_with_the_pc(&run);
        println!("{board:?}: {} conversions", run.rig.readings().len());
    }
}

#[test]
#[ignore = "needs the boards' images: cargo xtask test"]
fn the_counter_may_wrap_while_the_grating_slides() {
    let scene = SlidingScene::new(Sliding::default()).expect("the default scene");
    let mut run = Run::new(Board::FeatherF405, scene, Start::default());
    // The firmware waits for the ADC's supply; the slide lasts from 1.5 to 3.5 s of the scene.
    run.run_s(0.1);
    run.rig.inject(ProcessorFault::Microseconds(u32::MAX - 2_500_000));
    run.run_s(6.0);
    let t_us: Vec<u32> = run.rig.readings().iter().map(|reading| reading.t_us).collect();
    assert!(t_us.windows(2).any(|pair| pair[1] < pair[0]), "it wraps");
    compare_with_the_pc(&run);
}

/// All but the health of a run is to the bit what the library gives on this PC for the conversions that the board has read.
fn compare_with_the_pc(run: &Run) {
    run.assert_rules();
    let mut pipeline = Pipeline::new(Settings::DEFAULT);
    let mut on_pc = Vec::new();
    for reading in run.rig.readings() {
        let conversion = Conversion::from_bytes(reading.bytes);
        pipeline.push(TimedConversion { t_us: reading.t_us, conversion }, &mut |event| on_pc.push(event));
    }
    let (there, here) = (touches_and_tones(&run.events), touches_and_tones(&on_pc));
    assert!(there.len() > 8, "{there:?}");
    assert_eq!(there, here, "to the bit");
    let whole = there.iter().find_map(|event| match event {
        Event::Estimate(estimate) if estimate.span == Span::Slide => Some(estimate),
        _ => None,
    });
    let estimate = whole.expect("an estimate of the whole slide");
    assert_eq!(estimate.status, Status::Good);
    // 3.6 mm at 30 mm/s.
    let off = (estimate.frequency - 30.0 / 3.6).abs() / estimate.sigma;
    assert!(off < 4.0, "{estimate:?}");
}

/// Contacts, slides, releases and images in their order, then estimates in theirs: a fit ends when it ends.
fn touches_and_tones(events: &[Event]) -> Vec<Event> {
    let is_kept = |event: &&Event| {
        matches!(event, Event::Estimate(_) | Event::Contact(_) | Event::Slide(_) | Event::Release(_) | Event::Image(_))
    };
    let mut kept: Vec<Event> = events.iter().filter(is_kept).cloned().collect();
    kept.sort_by_key(|event| matches!(event, Event::Estimate(_)));
    kept
}

#[test]
#[ignore = "needs the boards' images: cargo xtask test"]
fn times_of_edges_are_right_to_some_microseconds_also_while_bytes_arrive() {
    for board in BOARDS {
        for bytes in [0, 20_000] {
            let mut run = Run::new(board, Constant::default(), Start::default());
            run.run_to(1.0, hello);
            run.run_s(0.5);
            let from = run.rig.readings().len();
            run.rig.send(&vec![0x55; bytes]);
            run.run_s(0.25);
            // The counter starts after the power does.
            let late: Vec<i64> = (run.rig.readings().iter().skip(from))
                .map(|reading| i64::from(reading.t_us) - (reading.edge_ns / 1000) as i64)
                .collect();
            let (least, most) = (late.iter().min().expect("readings"), late.iter().max().expect("readings"));
            println!("{board:?}: with {bytes} bytes arriving time stamps jitter by {} us", most - least);
            assert!(most - least <= 3, "{board:?}: {least} to {most} us");
        }
    }
}
