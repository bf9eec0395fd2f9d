//! Tests starts in faulty conditions.

mod common;

use common::{BOARDS, Run, converter, estimate_of, estimates, fault_of, health, hello};
use hal_mock::{Constant, Repeated, Sliding, SlidingScene};
use ridgetone_emulator::{Board, ProcessorFault, Start};
use ridgetone_proto::boot::{BrownOut, Death, Oscillator, ResetCause};
use ridgetone_proto::fault::FaultKind;
use ridgetone_proto::telemetry::{Event, Status};

#[test]
#[ignore = "needs the boards' images: cargo xtask test --all"]
fn the_image_copes_with_what_the_rom_loader_leaves() {
    for board in BOARDS {
        let start = Start {
            after_rom_loader: true,
            ..Start::default()
        };
        let mut run = Run::new(board, Constant::default(), start);
        assert_eq!(
            run.run_to(1.0, hello).boot.oscillator,
            Oscillator::External,
            "{board:?}"
        );
        run.run_s(0.5);
        run.assert_rules();
    }
}

#[test]
#[ignore = "needs the boards' images: cargo xtask test --all"]
fn the_board_greets_without_its_crystal_and_says_so() {
    for board in BOARDS {
        let start = Start {
            hse_is_dead: true,
            ..Start::default()
        };
        let mut run = Run::new(board, Constant::default(), start);
        assert_eq!(
            run.run_to(1.0, hello).boot.oscillator,
            Oscillator::Internal,
            "{board:?}"
        );
        run.run_s(0.5);
        run.assert_rules();
        assert!(run.emulator.readings().len() > 2000, "{board:?}: it scans");
    }
}

#[test]
#[ignore = "needs the boards' images: cargo xtask test --all"]
fn a_crystal_that_dies_before_a_warm_start_is_reported() {
    for board in BOARDS {
        let mut run = Run::new(board, Constant::default(), Start::default());
        assert_eq!(
            run.run_to(1.0, hello).boot.oscillator,
            Oscillator::External,
            "{board:?}"
        );
        run.emulator.inject(ProcessorFault::OscillatorDies);
        run.emulator.press_reset().expect("a reset");
        let boot = run.run_to(1.0, hello).boot;
        assert_eq!(
            (boot.cause, boot.oscillator),
            (ResetCause::Pin, Oscillator::Internal),
            "{board:?}"
        );
        run.assert_rules();
    }
}

#[test]
#[ignore = "needs the boards' images: cargo xtask test --all"]
fn the_brown_out_level_is_that_of_the_option_bytes() {
    // BOR_LEV is in bits 3 and 2: 00 means level 3, 11 means off (RM0090, 3.9.10).
    let levels = [
        (0x0FFF_AAED, BrownOut::Off),
        (0x0FFF_AAE9, BrownOut::Level1),
        (0x0FFF_AAE5, BrownOut::Level2),
        (0x0FFF_AAE1, BrownOut::Level3),
    ];
    for board in BOARDS {
        for (option_bytes, level) in levels {
            let start = Start {
                option_bytes,
                ..Start::default()
            };
            let greeting = Run::new(board, Constant::default(), start).run_to(1.0, hello);
            assert_eq!(
                greeting.boot.brown_out, level,
                "{board:?}: {option_bytes:#x}"
            );
        }
    }
}

#[test]
#[ignore = "needs the boards' images: cargo xtask test --all"]
fn the_converter_is_reported_with_the_id_of_another_chip() {
    // An ID with bit 4 set, which is zero on an ADS1258 (SBAS297G, ID register).
    const OTHER: u8 = 0x9B;
    for board in BOARDS {
        let mut start = Start::default();
        start.adc.id = OTHER;
        let mut run = Run::new(board, Constant::default(), start);
        run.run_to(1.0, hello);
        let report = run.run_to(1.0, converter);
        assert_eq!(
            (report.answers, report.registers[9]),
            (true, OTHER),
            "{board:?}"
        );
        run.assert_rules();
    }
}

#[test]
#[ignore = "needs the boards' images: cargo xtask test --all"]
fn chip_select_waits_for_the_last_bit_where_bsy_clears_early() {
    for board in BOARDS {
        let start = Start {
            bsy_is_early: true,
            ..Start::default()
        };
        let mut run = Run::new(board, Constant::default(), start);
        let found = run.run_to(2.0, health);
        assert_eq!(found.conversions_lost, 0, "{board:?}: {found:?}");
        run.assert_rules();
    }
}

/// The processor's oscillator has an error, and the time stamps must have the same relative error.
#[test]
#[ignore = "needs the boards' images: cargo xtask test --all"]
fn an_internal_oscillator_that_is_off_stretches_the_time_stamps() {
    for (board, hsi_ppm) in BOARDS.into_iter().zip([4_000, -10_000]) {
        let start = Start {
            hse_is_dead: true,
            hsi_ppm,
            ..Start::default()
        };
        let mut run = Run::new(board, Constant::default(), start);
        run.run_s(1.5);
        let [first, .., last] = run.emulator.readings() else {
            panic!("{board:?}: it scans");
        };
        let passed_us = (last.edge_ns - first.edge_ns) as f64 * 1e-3;
        let off_ppm = (f64::from(last.t_us - first.t_us) / passed_us - 1.0) * 1e6;
        assert!(
            (off_ppm - f64::from(hsi_ppm)).abs() < 10.0,
            "{board:?}: {off_ppm} ppm"
        );
        run.assert_rules();
    }
}

/// Asserts that there are estimates, and that all have the clock fault and none is `good` or
/// `unsteady`.
#[track_caller]
fn assert_all_doubted(events: &[Event], board: Board) {
    let found = estimates(events);
    assert!(found.len() > 3, "{board:?}: {} estimates", found.len());
    for one in &found {
        let is_flagged = one.status != Status::Good && one.status != Status::Unsteady;
        assert!(
            is_flagged && one.faults.has(FaultKind::Clock),
            "{board:?}: {one:?}"
        );
    }
}

/// The frame rate cannot reveal a clock error of the on-chip ADC, because the same clock counts the
/// time stamps, or an error of 0.4 % with an ADS1258.
#[test]
#[ignore = "needs the boards' images: cargo xtask test --all"]
fn no_estimate_is_good_on_an_internal_oscillator() {
    let boards = BOARDS.into_iter().chain(Board::OWN_ADC);
    for (board, hsi_ppm) in boards.flat_map(|board| [(board, 4_000), (board, -10_000)]) {
        let start = Start {
            hse_is_dead: true,
            hsi_ppm,
            ..Start::default()
        };
        let scene = SlidingScene::new(Sliding::default()).expect("a scene");
        let mut run = Run::new(board, scene, start);
        run.run_s(7.0);
        assert_all_doubted(&run.events, board);
        // There must be one episode, which never ends.
        let faults: Vec<_> = run.events.iter().filter_map(fault_of).collect();
        assert!(
            faults[0].kind == FaultKind::Clock && faults.iter().all(|one| one.until_us.is_none()),
            "{board:?}, {hsi_ppm}: {faults:?}"
        );
        run.assert_rules();
    }
}

/// The clock security system detects the stop. The board must restart at once and report the cause.
#[test]
#[ignore = "needs the boards' images: cargo xtask test --all"]
fn a_crystal_that_stops_within_a_slide_is_reported_and_no_estimate_is_good_after_it() {
    for (board, hsi_ppm) in BOARDS
        .into_iter()
        .chain(Board::OWN_ADC)
        .zip([4_000, -10_000].repeat(2))
    {
        let start = Start {
            hsi_ppm,
            ..Start::default()
        };
        let scene = Repeated(SlidingScene::new(Sliding::default()).expect("a scene"));
        let mut run = Run::new(board, scene, start);
        run.run_to(4.0, estimate_of);
        let (stopped_ns, seen) = (run.emulator.now_ns(), run.events.len());
        run.emulator.inject(ProcessorFault::OscillatorStops);
        let boot = run.run_to(0.5, hello).boot;
        let silent_s = (run.emulator.now_ns() - stopped_ns) as f64 * 1e-9;
        println!("{board:?}: it greets again after {silent_s:.3} s");
        assert_eq!(
            (boot.cause, boot.oscillator),
            (ResetCause::Software, Oscillator::Internal),
            "{board:?}"
        );
        let record = boot.record.expect("a record");
        assert_eq!(record.death, Death::Oscillator, "{board:?}");
        run.run_s(9.0);
        assert_all_doubted(&run.events[seen..], board);
        assert_eq!(run.emulator.resets().len(), 1, "{board:?}");
        run.assert_rules();
    }
}
