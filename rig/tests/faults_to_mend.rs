//! What part A of the issue is to mend: each of these fails until it is mended, and belongs to `boards.rs` then.

mod common;

use common::{BOARDS, KNOWN, Run, hello, image, reply_to, request};
use hal_mock::{Constant, Fault};
use ridgetone_proto::boot::SettingsSource;
use ridgetone_proto::command::{Command, Outcome};
use ridgetone_proto::settings::Settings;
use rig::{Board, Start};

/// Sends requests while the chip scans; gives how many were answered, how many bytes each has, and the bytes that were lost
/// in overruns.
fn answered(run: &mut Run, requests: u16, command: &Command) -> (usize, usize, u64) {
    let before = run.rig.received()[0];
    let (mut answers, mut bytes) = (0, 0);
    for number in 1..=requests {
        let sent = request(number, command.clone());
        bytes = sent.len();
        run.rig.send(&sent);
        let seen = run.events.len();
        run.run_s(0.03);
        answers += usize::from(run.events[seen..].iter().any(|event| reply_to(number)(event).is_some()));
    }
    (answers, bytes, run.rig.received()[0] - before)
}

#[test]
#[ignore = "A.1 of issue 15 is not mended"]
fn commands_of_every_length_arrive_while_the_chip_scans() {
    let mut all = Vec::new();
    for board in BOARDS {
        for command in [Command::Greet, Command::Set { settings: Settings::DEFAULT, keep: false }] {
            let mut run = Run::new(board, Constant::default(), Start::default());
            run.run_to(1.0, hello);
            let (answers, bytes, lost) = answered(&mut run, 200, &command);
            println!("{board:?}: of 200 requests of {bytes} bytes {answers} are answered, {lost} bytes are lost");
            all.push((answers, lost));
        }
    }
    assert!(all.iter().all(|one| *one == (200, 0)), "{all:?}");
}

#[test]
#[ignore = "A.5 of issue 15 is not mended"]
fn no_conversion_is_lost_at_the_start() {
    for board in BOARDS {
        let mut run = Run::new(board, Constant::default(), Start::default());
        run.run_s(1.0);
        let start_ms = run.rig.started_ns().expect("START") as f64 * 1e-6;
        let first_ms = run.rig.readings()[0].edge_ns as f64 * 1e-6;
        let lost = run.rig.adc().counters().lost;
        println!("{board:?}: START at {start_ms:.3} ms, first edge read at {first_ms:.3} ms, {lost} conversions lost");
        assert_eq!(lost, 0, "{board:?}");
    }
}

#[test]
#[ignore = "A.3 of issue 15 is not mended"]
fn the_image_copes_with_what_the_rom_loader_leaves() {
    for board in BOARDS {
        let start = Start { after_rom_loader: true, ..Start::default() };
        println!("{board:?}");
        Run::new(board, Constant::default(), start).run_to(2.0, hello);
    }
}

#[test]
#[ignore = "A.6 of issue 15 is not mended"]
fn the_board_greets_without_its_crystal() {
    for board in BOARDS {
        let start = Start { hse_is_dead: true, ..Start::default() };
        println!("{board:?}");
        Run::new(board, Constant::default(), start).run_to(5.0, hello);
    }
}

#[test]
#[ignore = "A.2 and A.6 of issue 15 are not mended"]
fn no_rule_is_known_to_be_broken() {
    for board in BOARDS {
        let mut run = Run::new(board, Constant::default(), Start::default());
        run.run_s(1.0);
        let broken: Vec<String> = run.rig.findings().iter().map(ToString::to_string).collect();
        assert!(broken.is_empty() && KNOWN.is_empty(), "{board:?}: {broken:#?}");
    }
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
#[ignore = "the write that chooses PG or SER in FLASH_CR also sets LOCK"]
fn kept_settings_survive_the_loss_of_power_at_any_word() {
    for board in BOARDS {
        let settings = |number: u16| Settings { hop_s: 0.25 + 0.01 * f32::from(number), ..Settings::DEFAULT };
        let mut run = Run::new(board, Constant::default(), Start::default());
        run.run_to(1.0, hello);
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
    }
}

#[test]
#[ignore = "the write that chooses PG or SER in FLASH_CR also sets LOCK"]
fn a_full_store_is_erased_and_the_watchdog_lives_on() {
    for board in BOARDS {
        let keep = |hop_s| Command::Set { settings: Settings { hop_s, ..Settings::DEFAULT }, keep: true };
        let mut run = Run::new(board, Constant::default(), Start::default());
        run.run_to(1.0, hello);
        assert_eq!(command(&mut run, 1, keep(0.3)), Outcome::Done, "{board:?}");
        // All behind the first record, in both sectors, holds something.
        let first = image(board).symbol("_settings_start").expect("memory.x");
        let record = 4 * run.rig.flash_counts().0 as u32;
        run.rig.overwrite_flash(first + record, 0, 2 * 128 * 1024 - record as usize);
        assert_eq!(command(&mut run, 2, keep(0.4)), Outcome::DoneErased, "{board:?}");
        assert_eq!(run.rig.flash_counts().1, 1);
        run.run_s(2.0);
        assert!(run.rig.resets().is_empty(), "{:?}", run.rig.resets());
        run.rig.cycle_power().expect("a reset");
        let greeting = run.run_to(1.0, hello);
        assert_eq!((greeting.settings.hop_s, greeting.source), (0.4, SettingsSource::Stored), "{board:?}");
    }
}
