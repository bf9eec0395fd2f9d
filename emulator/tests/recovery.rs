//! Tests crashes, hangs and resets of a board, and the report in its next greeting.

mod common;

use common::{BOARDS, Run, estimate_of, fault_of, health, hello, image, request};
use hal_mock::{Constant, Fault, Sliding, SlidingScene};
use ridgetone_emulator::{ProcessorFault, Rule, Start};
use ridgetone_proto::boot::{Death, ResetCause};
use ridgetone_proto::command::Command;
use ridgetone_proto::fault::FaultKind;
use ridgetone_proto::telemetry::{Span, Status};

#[test]
#[ignore = "needs the boards' images: cargo xtask test --all"]
fn the_watchdog_bites_when_a_task_hangs_and_the_greeting_says_so() {
    // EXTI4, OTG_HS_EP1_OUT and OTG_HS_WKUP belong to the tasks `drdy`, `detect` and `fit`. All
    // other tasks continue. `fit` is due only during a slide.
    let [feather, nucleo] = BOARDS;
    let at_work = |board| {
        let mut run = Run::sliding(board);
        run.run_s(2.5);
        run
    };
    for (board, irq, mut run) in [
        (feather, 10, Run::at_rest(feather)),
        (nucleo, 74, Run::at_rest(nucleo)),
        (feather, 76, at_work(feather)),
    ] {
        run.emulator.inject(ProcessorFault::Mask(irq));
        let from_ns = run.emulator.now_ns();
        // Skip greetings that are only repeated, every ten seconds.
        run.run_to(10.0, |event| {
            hello(event).filter(|greeting| greeting.boot.cause == ResetCause::Watchdog)
        });
        let [reset] = run.emulator.resets() else {
            panic!("{:?}", run.emulator.resets())
        };
        let bites_s = (reset.at_ns - from_ns) as f64 * 1e-9;
        println!("{board:?}: it bites {bites_s:.2} s after interrupt {irq} stands still");
        assert!(bites_s < 9.0, "{board:?}");
        assert!(
            run.emulator
                .findings()
                .iter()
                .any(|finding| finding.rule == Rule::Watchdog)
        );
    }
}

/// Makes the unmodified image jump to one of its functions that is otherwise unused and panics.
#[test]
#[ignore = "needs the boards' images: cargo xtask test --all"]
fn a_panic_leaves_a_record() {
    for board in BOARDS {
        let mut run = Run::at_rest(board);
        let panics = image(board)
            .function("embedded_hal_bus3spi14no_delay_panic")
            .expect("a function that panics");
        let before_us = run.emulator.now_ns() / 1000;
        run.emulator.inject(ProcessorFault::JumpTo(panics));
        let boot = run.run_to(2.0, hello).boot;
        assert_eq!(boot.cause, ResetCause::Software, "{board:?}");
        let record = boot.record.expect("a record");
        assert_eq!(
            (record.death, record.pc, record.lr),
            (Death::Panic, 0, 0),
            "{record:?}"
        );
        assert!(
            record.file.ends_with("/src/spi/mod.rs") && record.line > 0,
            "{record:?}"
        );
        // The counter starts some milliseconds after power-up.
        assert!(
            before_us.abs_diff(record.t_us.into()) < 20_000,
            "{before_us} us, {record:?}"
        );
        run.emulator.press_reset().expect("a reset");
        assert_eq!(
            run.run_to(1.0, hello).boot.record,
            None,
            "{board:?}: it is reported once"
        );
    }
}

#[test]
#[ignore = "needs the boards' images: cargo xtask test --all"]
fn a_hard_fault_leaves_a_record() {
    for board in BOARDS {
        let mut run = Run::at_rest(board);
        run.emulator.inject(ProcessorFault::JumpTo(0x6000_0000));
        let greeting = run.run_to(2.0, hello);
        assert_eq!(greeting.boot.cause, ResetCause::Software, "{board:?}");
        let record = greeting.boot.record.expect("a record");
        assert_eq!(
            (record.death, record.pc),
            (Death::HardFault, 0x6000_0000),
            "{record:?}"
        );
    }
}

#[test]
#[ignore = "needs the boards' images: cargo xtask test --all"]
fn a_stack_overflow_leaves_a_record() {
    for board in BOARDS {
        let mut run = Run::at_rest(board);
        // Start below the end of the stack: slightly above it, the next instruction could pop
        // instead of push.
        run.emulator.inject(ProcessorFault::StackPointer(
            image(board).symbol("_stack_end").expect("memory.x") - 8,
        ));
        let greeting = run.run_to(2.0, hello);
        assert_eq!(greeting.boot.cause, ResetCause::Software, "{board:?}");
        let record = greeting.boot.record.expect("a record");
        assert_eq!(record.death, Death::HardFault, "{record:?}");
        assert!(
            run.emulator
                .findings()
                .iter()
                .any(|finding| finding.rule == Rule::StackEnd),
            "{:?}",
            run.emulator.findings()
        );
    }
}

#[test]
#[ignore = "needs the boards' images: cargo xtask test --all"]
fn a_restart_by_command_differs_from_the_reset_button() {
    for board in BOARDS {
        let mut run = Run::at_rest(board);
        run.emulator.send(&request(1, Command::Restart));
        let greeting = run.run_to(3.0, hello);
        assert_eq!(
            (greeting.boot.cause, greeting.boot.record),
            (ResetCause::Software, None),
            "{board:?}"
        );
        run.emulator.press_reset().expect("a reset");
        assert_eq!(
            run.run_to(1.0, hello).boot.cause,
            ResetCause::Pin,
            "{board:?}"
        );
    }
}

#[test]
#[ignore = "needs the boards' images: cargo xtask test --all"]
fn a_reset_within_a_packet_costs_no_greeting() {
    for (board, irq) in BOARDS.into_iter().zip([39, 38]) {
        let mut run = Run::at_rest(board);
        let (seen, before) = (run.events.len(), run.emulator.served(irq).times);
        run.emulator.send(&request(1, Command::Greet));
        // The request takes 0.1 ms, and the greeting in reply more than 1 ms.
        run.run_s(0.001);
        assert!(
            run.events.len() == seen && run.emulator.served(irq).times > before + 30,
            "{board:?}: a part of it has left"
        );
        run.emulator.press_reset().expect("a reset");
        assert_eq!(
            run.run_to(1.0, hello).boot.cause,
            ResetCause::Pin,
            "{board:?}"
        );
    }
}

#[test]
#[ignore = "needs the boards' images: cargo xtask test --all"]
fn a_board_without_an_adc_greets_and_says_what_is_missing() {
    for board in BOARDS {
        for high in [false, true] {
            let mut run = Run::new(board, Constant::default(), Start::default());
            run.emulator.adc_fault(Fault::BusCut { high }, true);
            run.run_to(2.0, hello);
            let report = run.run_to(3.0, health);
            assert!(
                report.faults[FaultKind::NoAnswer as usize] > 0,
                "{board:?}: {report:?}"
            );
            run.run_s(3.0);
            run.assert_rules();
            assert!(run.emulator.resets().is_empty(), "{board:?}");
        }
    }
}

#[test]
#[ignore = "needs the boards' images: cargo xtask test --all"]
fn a_bus_that_dies_for_two_seconds_is_reported_and_the_next_touch_is_right() {
    for (board, high) in BOARDS.into_iter().zip([false, true]) {
        let scene = SlidingScene::new(Sliding {
            idle_s: 7.0,
            ..Sliding::default()
        })
        .expect("a scene");
        let mut run = Run::new(board, scene, Start::default());
        run.run_s(1.0);
        run.emulator.adc_fault(Fault::BusCut { high }, true);
        let begun = run.run_to(1.0, fault_of);
        assert!(
            begun.until_us.is_none() && begun.kind != FaultKind::Lost,
            "{board:?}: {begun:?}"
        );
        run.run_s(2.0);
        run.emulator.adc_fault(Fault::BusCut { high }, false);
        let whole = run.run_to(10.0, |event| {
            estimate_of(event).filter(|one| one.span == Span::Slide)
        });
        // 3.6 mm at 30 mm/s.
        let off = (whole.frequency - 30.0 / 3.6).abs() / whole.sigma;
        assert!(
            whole.status == Status::Good && off < 4.0,
            "{board:?}: {whole:?}"
        );
        let report = run.run_to(2.0, health);
        // A frame has 21 conversions. Conversions that were not read must be reported as lost.
        let accounted = f64::from(report.frames) * 21.0 + f64::from(report.conversions_lost);
        let made = f64::from(report.frame_rate_hz) * 21.0 * report.t_us as f64 * 1e-6;
        assert!(
            (accounted / made - 1.0).abs() < 0.005,
            "{board:?}: {accounted} of {made}"
        );
        assert!(
            run.emulator.resets().is_empty(),
            "{board:?}: no reset of the board mends it"
        );
        run.assert_rules();
    }
}

#[test]
#[ignore = "needs the boards' images: cargo xtask test --all"]
fn the_next_debugger_finds_the_bits_that_the_last_one_cleared() {
    const SLEEP_STOP_STANDBY: u32 = 0b111;
    for board in BOARDS {
        let mut run = Run::at_rest(board);
        assert_eq!(run.emulator.debug_control(), Some(SLEEP_STOP_STANDBY));
        run.emulator.inject(ProcessorFault::Debugger(0));
        run.run_s(0.6);
        assert_eq!(
            run.emulator.debug_control(),
            Some(SLEEP_STOP_STANDBY),
            "{board:?}"
        );
        run.assert_rules();
    }
}
