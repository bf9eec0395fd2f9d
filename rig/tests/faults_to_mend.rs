//! What part A of the issue is to mend: each of these fails until it is mended, and belongs to `boards.rs` then.

mod common;

use common::{BOARDS, KNOWN, Run, hello, reply_to, request};
use hal_mock::Constant;
use ridgetone_proto::command::Command;
use ridgetone_proto::settings::Settings;
use rig::Start;

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
    for board in BOARDS {
        for command in [Command::Greet, Command::Set { settings: Settings::DEFAULT, keep: false }] {
            let mut run = Run::new(board, Constant::default(), Start::default());
            run.run_to(1.0, hello);
            let (answers, bytes, lost) = answered(&mut run, 200, &command);
            println!("{board:?}: of 200 requests of {bytes} bytes {answers} are answered, {lost} bytes are lost");
            assert_eq!((answers, lost), (200, 0), "{board:?}");
        }
    }
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
        Run::new(board, Constant::default(), start).run_to(2.0, hello);
    }
}

#[test]
#[ignore = "A.6 of issue 15 is not mended"]
fn the_board_greets_without_its_crystal() {
    for board in BOARDS {
        let start = Start { hse_is_dead: true, ..Start::default() };
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
