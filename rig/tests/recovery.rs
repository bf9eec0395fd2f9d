//! What happens to a board, and what its next greeting says of it.

mod common;

use common::{BOARDS, Run, health, hello, image, request};
use hal_mock::{Constant, Fault};
use ridgetone_proto::boot::{Death, ResetCause};
use ridgetone_proto::command::Command;
use ridgetone_proto::fault::FaultKind;
use rig::{ProcessorFault, Rule, Start};

#[test]
#[ignore = "needs the boards' images: cargo xtask test --all"]
fn the_watchdog_bites_when_a_task_hangs_and_the_greeting_says_so() {
    // EXTI4 and CAN1_RX0: the tasks `drdy` and `detect`; all others go on.
    for (board, irq) in BOARDS.into_iter().zip([10, 20]) {
        let mut run = Run::at_rest(board);
        run.rig.inject(ProcessorFault::Mask(irq));
        let from_ns = run.rig.now_ns();
        let greeting = run.run_to(10.0, hello);
        assert_eq!(greeting.boot.cause, ResetCause::Watchdog, "{board:?}");
        let [reset] = run.rig.resets() else { panic!("{:?}", run.rig.resets()) };
        println!("{board:?}: it bites {:.2} s after the task stands still", (reset.at_ns - from_ns) as f64 * 1e-9);
        assert!(run.rig.findings().iter().any(|finding| finding.rule == Rule::Watchdog));
    }
}

#[test]
#[ignore = "needs the boards' images: cargo xtask test --all"]
fn a_hard_fault_leaves_a_record() {
    for board in BOARDS {
        let mut run = Run::at_rest(board);
        run.rig.inject(ProcessorFault::JumpTo(0x6000_0000));
        let greeting = run.run_to(2.0, hello);
        assert_eq!(greeting.boot.cause, ResetCause::Software, "{board:?}");
        let record = greeting.boot.record.expect("a record");
        assert_eq!((record.death, record.pc), (Death::HardFault, 0x6000_0000), "{record:?}");
    }
}

#[test]
#[ignore = "needs the boards' images: cargo xtask test --all"]
fn a_stack_overflow_leaves_a_record() {
    for board in BOARDS {
        let mut run = Run::at_rest(board);
        run.rig.inject(ProcessorFault::StackPointer(image(board).symbol("_stack_end").expect("memory.x") + 8));
        let greeting = run.run_to(2.0, hello);
        assert_eq!(greeting.boot.cause, ResetCause::Software, "{board:?}");
        let record = greeting.boot.record.expect("a record");
        assert_eq!(record.death, Death::HardFault, "{record:?}");
        assert!(run.rig.findings().iter().any(|finding| finding.rule == Rule::StackEnd), "{:?}", run.rig.findings());
    }
}

#[test]
#[ignore = "needs the boards' images: cargo xtask test --all"]
fn a_restart_by_command_differs_from_the_reset_button() {
    for board in BOARDS {
        let mut run = Run::at_rest(board);
        run.rig.send(&request(1, Command::Restart));
        let greeting = run.run_to(3.0, hello);
        assert_eq!((greeting.boot.cause, greeting.boot.record), (ResetCause::Software, None), "{board:?}");
        run.rig.press_reset().expect("a reset");
        assert_eq!(run.run_to(1.0, hello).boot.cause, ResetCause::Pin, "{board:?}");
    }
}

#[test]
#[ignore = "needs the boards' images: cargo xtask test --all"]
fn a_board_without_an_adc_greets_and_says_what_is_missing() {
    for board in BOARDS {
        for high in [false, true] {
            let mut run = Run::new(board, Constant::default(), Start::default());
            run.rig.adc_fault(Fault::BusCut { high }, true);
            run.run_to(2.0, hello);
            let report = run.run_to(3.0, health);
            assert!(report.faults[FaultKind::NoAnswer as usize] > 0, "{board:?}: {report:?}");
            run.run_s(3.0);
            run.assert_rules();
            assert!(run.rig.resets().is_empty(), "{board:?}");
        }
    }
}
