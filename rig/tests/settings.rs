//! Settings that are kept: in the flash of the board, over losses of power and over an erasure.

mod common;

use common::{BOARDS, Run, hello, image};
use hal_mock::Constant;
use ridgetone_proto::boot::SettingsSource;
use ridgetone_proto::command::{Command, Outcome};
use ridgetone_proto::settings::Settings;
use rig::{Board, Start};

/// Bytes of the two sectors.
const STORE_BYTES: usize = 2 * 128 * 1024;

/// Settings that differ by their number.
fn settings(number: u16) -> Settings {
    Settings { hop_s: 0.25 + 0.01 * f32::from(number), ..Settings::DEFAULT }
}

fn keep(number: u16) -> Command {
    Command::Set { settings: settings(number), keep: true }
}

/// A board that has just greeted.
fn greeted(board: Board) -> Run {
    let mut run = Run::new(board, Constant::default(), Start::default());
    run.run_to(1.0, hello);
    run
}

/// The settings that the board starts with when its power is back.
fn after_power(run: &mut Run) -> (Settings, SettingsSource) {
    run.rig.cycle_power().expect("a reset");
    let greeting = run.run_to(1.0, hello);
    (greeting.settings, greeting.source)
}

#[test]
#[ignore = "needs the boards' images: cargo xtask test --all"]
fn kept_settings_survive_the_loss_of_power_at_any_word() {
    for board in BOARDS {
        let mut run = greeted(board);
        let before = run.rig.flash_counts();
        assert_eq!(run.command(1, keep(1)), Outcome::Done, "{board:?}");
        let words = run.rig.flash_counts().0 - before.0;
        assert_eq!(after_power(&mut run), (settings(1), SettingsSource::Stored), "{board:?}");
        let mut kept = settings(1);
        for cut in (0..=words).step_by(if board == Board::FeatherF405 { 1 } else { 7 }) {
            let number = 2 + cut as u16;
            run.run_s(0.1);
            run.rig.cut_flash_after(Some(cut));
            run.rig.send(&common::request(number, keep(number)));
            run.run_s(0.1);
            let (found, _) = after_power(&mut run);
            assert!(found == kept || found == settings(number), "{board:?}, cut behind word {cut}: {found:?}");
            assert!(cut < words || found == settings(number), "all {words} words are there: {found:?}");
            kept = found;
        }
        run.assert_rules();
        println!("{board:?}: {words} words");
    }
}

/// A board with settings number 1 in its first slot; all behind it, in both sectors, holds something.
fn with_a_full_store(board: Board) -> Run {
    let mut run = greeted(board);
    assert_eq!(run.command(1, keep(1)), Outcome::Done, "{board:?}");
    let first = image(board).symbol("_settings_start").expect("memory.x");
    let record = 4 * run.rig.flash_counts().0 as usize;
    run.rig.overwrite_flash(first + record as u32, 0, STORE_BYTES - record);
    run
}

#[test]
#[ignore = "needs the boards' images: cargo xtask test --all"]
fn a_full_store_is_erased_and_the_watchdog_lives_on() {
    for board in BOARDS {
        let mut run = with_a_full_store(board);
        assert_eq!(run.command(2, keep(2)), Outcome::DoneErased, "{board:?}");
        assert_eq!(run.rig.flash_counts().1, 1);
        run.run_s(2.0);
        assert!(run.rig.resets().is_empty(), "{:?}", run.rig.resets());
        assert_eq!(after_power(&mut run), (settings(2), SettingsSource::Stored), "{board:?}");
    }
}
