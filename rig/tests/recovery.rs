//! What happens to a board, and what its next greeting says of it.

mod common;

use common::{BOARDS, Run, health, hello, image, reply_to, request};
use hal_mock::{Constant, Fault};
use ridgetone_proto::boot::{Death, ResetCause};
use ridgetone_proto::command::{Command, Outcome};
use ridgetone_proto::fault::FaultKind;
use ridgetone_proto::settings::Settings;
use ridgetone_proto::boot::SettingsSource;
use rig::{Board, Breakage, Rule, Start};

/// A board that has greeted and scans.
fn running(board: Board) -> Run {
    let mut run = Run::new(board, Constant::default(), Start::default());
    run.run_to(1.0, hello);
    run.run_s(0.2);
    run
}

/// Sends a request while DRDY is silent: commands of more than a few bytes do not arrive otherwise (A.1 of the issue).
fn command(run: &mut Run, number: u16, command: Command) -> Outcome {
    run.rig.adc_fault(Fault::DrdyStuck { high: true }, true);
    run.rig.send(&request(number, command));
    let outcome = run.run_to(5.0, reply_to(number));
    run.rig.adc_fault(Fault::DrdyStuck { high: true }, false);
    outcome
}

#[test]
#[ignore = "needs the boards' images: cargo xtask test"]
fn the_watchdog_bites_when_a_task_hangs_and_the_greeting_says_so() {
    for board in BOARDS {
        let mut run = running(board);
        // CAN1_RX0: the task `detect`.
        run.rig.suffer(Breakage::Mask(20));
        let from_ns = run.rig.now_ns();
        let greeting = run.run_to(10.0, hello);
        assert_eq!(greeting.boot.cause, ResetCause::Watchdog, "{board:?}");
        let [reset] = run.rig.resets() else { panic!("{:?}", run.rig.resets()) };
        println!("{board:?}: it bites {:.2} s after the task stands still", (reset.at_ns - from_ns) as f64 * 1e-9);
        assert!(run.rig.findings().iter().any(|finding| finding.rule == Rule::Watchdog));
    }
}

#[test]
#[ignore = "needs the boards' images: cargo xtask test"]
fn a_hard_fault_leaves_a_record() {
    for board in BOARDS {
        let mut run = running(board);
        run.rig.suffer(Breakage::JumpTo(0x6000_0000));
        let greeting = run.run_to(2.0, hello);
        assert_eq!(greeting.boot.cause, ResetCause::Software, "{board:?}");
        let record = greeting.boot.record.expect("a record");
        assert_eq!((record.death, record.pc), (Death::HardFault, 0x6000_0000), "{record:?}");
    }
}

#[test]
#[ignore = "needs the boards' images: cargo xtask test"]
fn a_stack_overflow_leaves_a_record() {
    for board in BOARDS {
        let mut run = running(board);
        run.rig.suffer(Breakage::StackPointer(image(board).symbol("_stack_end").expect("memory.x") + 8));
        let greeting = run.run_to(2.0, hello);
        assert_eq!(greeting.boot.cause, ResetCause::Software, "{board:?}");
        let record = greeting.boot.record.expect("a record");
        assert_eq!(record.death, Death::HardFault, "{record:?}");
        assert!(run.rig.findings().iter().any(|finding| finding.rule == Rule::StackEnd), "{:?}", run.rig.findings());
    }
}

#[test]
#[ignore = "needs the boards' images: cargo xtask test"]
fn a_restart_by_command_and_the_reset_button_are_told_apart() {
    for board in BOARDS {
        let mut run = running(board);
        run.rig.adc_fault(Fault::DrdyStuck { high: true }, true);
        run.rig.send(&request(1, Command::Restart));
        let greeting = run.run_to(3.0, hello);
        assert_eq!((greeting.boot.cause, greeting.boot.record), (ResetCause::Software, None), "{board:?}");
        run.rig.press_reset().expect("a reset");
        assert_eq!(run.run_to(1.0, hello).boot.cause, ResetCause::Pin, "{board:?}");
    }
}

#[test]
#[ignore = "needs the boards' images: cargo xtask test"]
fn kept_settings_survive_the_loss_of_power_at_any_word() {
    for board in BOARDS {
        let settings = |number: u16| Settings { hop_s: 0.25 + 0.01 * f32::from(number), ..Settings::DEFAULT };
        let mut run = running(board);
        let before = run.rig.flash_counts();
        let outcome = command(&mut run, 1, Command::Set { settings: settings(1), keep: true });
        assert_eq!(outcome, Outcome::Done, "{:?}", (run.rig.findings(), run.rig.flash_counts()));
        let words = run.rig.flash_counts().0 - before.0;
        run.rig.cycle_power().expect("a reset");
        let greeting = run.run_to(1.0, hello);
        assert_eq!((greeting.settings, greeting.source), (settings(1), SettingsSource::Stored), "{board:?}");
        let mut kept = settings(1);
        for cut in (0..=words).step_by(if board == Board::FeatherF405 { 1 } else { 7 }) {
            let number = 2 + cut as u16;
            run.run_s(0.1);
            run.rig.cut_flash_after(Some(cut));
            run.rig.adc_fault(Fault::DrdyStuck { high: true }, true);
            run.rig.send(&request(number, Command::Set { settings: settings(number), keep: true }));
            run.run_s(0.1);
            run.rig.adc_fault(Fault::DrdyStuck { high: true }, false);
            run.rig.cycle_power().expect("a reset");
            let found = run.run_to(1.0, hello).settings;
            assert!(found == kept || found == settings(number), "{board:?}, cut behind word {cut}: {found:?}");
            assert!(cut < words || found == settings(number), "all {words} words are there: {found:?}");
            kept = found;
        }
        println!("{board:?}: {words} words");
        run.assert_rules();
    }
}

#[test]
#[ignore = "needs the boards' images: cargo xtask test"]
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
