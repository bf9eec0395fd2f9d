//! Tests settings stored in the board's flash, across power losses and an erase.

mod common;

use common::{BOARDS, Run, hello, image};
use hal_mock::Constant;
use ridgetone_emulator::{Board, Start};
use ridgetone_proto::boot::SettingsSource;
use ridgetone_proto::command::{Command, Outcome};
use ridgetone_proto::settings::Settings;
use ridgetone_proto::store::RECORD_BYTES;

fn settings(number: u16) -> Settings {
    Settings {
        stride_s: 0.25 + 0.01 * f32::from(number % 50),
        ..Settings::DEFAULT
    }
}

fn keep(number: u16) -> Command {
    Command::Set {
        settings: settings(number),
        keep: true,
    }
}

fn greeted(board: Board) -> Run {
    let mut run = Run::new(board, Constant::default(), Start::default());
    run.run_to(1.0, hello);
    run
}

/// Cycles the power and returns the settings that the board starts with.
fn after_power(run: &mut Run) -> (Settings, SettingsSource) {
    run.emulator.cycle_power().expect("a reset");
    let greeting = run.run_to(1.0, hello);
    (greeting.settings, greeting.source)
}

#[test]
#[ignore = "needs the boards' images: cargo xtask test --all"]
fn kept_settings_survive_the_loss_of_power_at_any_word() {
    for board in BOARDS {
        let mut run = greeted(board);
        let before = run.emulator.flash_counts();
        assert_eq!(run.command(1, keep(1)), Outcome::Done, "{board:?}");
        let words = run.emulator.flash_counts().0 - before.0;
        assert_eq!(
            after_power(&mut run),
            (settings(1), SettingsSource::Stored),
            "{board:?}"
        );
        let mut kept = settings(1);
        for cut in (0..=words).step_by(if board == Board::FeatherF405 { 1 } else { 7 }) {
            let number = 2 + cut as u16;
            run.run_s(0.1);
            run.emulator.cut_flash_after(cut);
            run.emulator.send(&common::request(number, keep(number)));
            run.run_s(0.1);
            let (found, _) = after_power(&mut run);
            assert!(
                found == kept || found == settings(number),
                "{board:?}, cut behind word {cut}: {found:?}"
            );
            assert!(
                cut < words || found == settings(number),
                "all {words} words are there: {found:?}"
            );
            kept = found;
        }
        run.assert_rules();
        println!("{board:?}: {words} words");
    }
}

/// Error flags that are set at power-up must not make the first write fail.
#[test]
#[ignore = "needs the boards' images: cargo xtask test --all"]
fn settings_are_kept_though_the_flash_has_old_error_flags() {
    for board in BOARDS {
        let start = Start {
            flash_has_errors: true,
            ..Start::default()
        };
        let mut run = Run::new(board, Constant::default(), start);
        run.run_to(1.0, hello);
        assert_eq!(run.command(1, keep(1)), Outcome::Done, "{board:?}");
        let found = after_power(&mut run);
        assert_eq!(found, (settings(1), SettingsSource::Stored), "{board:?}");
        run.assert_rules();
    }
}

const RECORDS: u16 = (128 * 1024 / RECORD_BYTES) as u16;

/// Content of a sector after a power loss during its erase: half of it blank; all bits programmed,
/// as when an erase begins; some bits of every byte erased; all blank except one bit at the end.
const REMAINS: [fn(usize, u8) -> u8; 4] = [
    |at, byte| if at < 64 * 1024 { 0xFF } else { byte },
    |_, _| 0,
    |at, byte| byte | (at as u32).wrapping_mul(0x9E37_79B9).to_be_bytes()[0],
    |at, _| if at + 1 == 128 * 1024 { 0x7F } else { 0xFF },
];

/// Returns both sectors of a board after it has filled them with settings.
fn full_store() -> Vec<u8> {
    let mut run = greeted(Board::FeatherF405);
    for number in 1..=2 * RECORDS {
        assert_eq!(run.command(number, keep(number)), Outcome::Done, "{number}");
    }
    run.emulator
        .flash(store_address(Board::FeatherF405))
        .to_vec()
}

fn store_address(board: Board) -> u32 {
    image(board).symbol("_settings_start").expect("memory.x")
}

/// Starts a board with these sectors, and waits until it has greeted.
fn with_store(board: Board, store: &[u8]) -> Run {
    let mut run = greeted(board);
    run.emulator.overwrite_flash(store_address(board), store);
    assert_eq!(
        after_power(&mut run),
        (settings(2 * RECORDS), SettingsSource::Stored),
        "{board:?}"
    );
    run
}

#[test]
#[ignore = "needs the boards' images: cargo xtask test --all"]
fn a_full_store_is_erased_and_survives_the_loss_of_power_meanwhile() {
    let (store, last) = (full_store(), 2 * RECORDS);
    for board in BOARDS {
        let mut run = with_store(board, &store);
        assert_eq!(
            run.command(1, keep(last + 1)),
            Outcome::DoneErased,
            "{board:?}"
        );
        assert_eq!(run.emulator.flash_counts().1, 1);
        // The watchdog must still be fed.
        run.run_s(2.0);
        assert!(
            run.emulator.resets().len() == 1,
            "{:?}",
            run.emulator.resets()
        );
        assert_eq!(
            after_power(&mut run),
            (settings(last + 1), SettingsSource::Stored),
            "{board:?}"
        );
        run.assert_rules();
        for (way, remains) in REMAINS.into_iter().enumerate() {
            let mut run = with_store(board, &store);
            run.emulator.cut_erase(remains);
            assert_eq!(
                run.command(1, keep(last + 1)),
                Outcome::NotStored,
                "{board:?}, {way}: the power is gone"
            );
            let (found, source) = after_power(&mut run);
            assert_eq!(found, settings(last), "{board:?}, {way}: {source:?}");
            let again = run.command(1, keep(last + 2));
            assert!(
                [Outcome::Done, Outcome::DoneErased].contains(&again),
                "{board:?}, {way}: {again:?}"
            );
            assert_eq!(
                after_power(&mut run),
                (settings(last + 2), SettingsSource::Stored),
                "{board:?}, {way}"
            );
        }
    }
}
