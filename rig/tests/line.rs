//! The serial line while the chip scans.

mod common;

use common::{BOARDS, Run};
use ridgetone_proto::command::{Command, Outcome};
use ridgetone_proto::settings::Settings;

#[test]
#[ignore = "needs the boards' images: cargo xtask test --all"]
fn short_commands_and_usual_settings_arrive_while_the_chip_scans() {
    for board in BOARDS {
        for command in [Command::Greet, Command::Set { settings: Settings::DEFAULT, keep: false }] {
            let mut run = Run::at_rest(board);
            for number in 1..=200 {
                assert_eq!(run.command(number, command.clone()), Outcome::Done, "{board:?}: request {number}");
                // Not in step with the conversions.
                run.run_s(0.00037);
            }
            run.assert_rules();
            assert_eq!(run.rig.received()[..2], [0, 0], "{board:?}: none lost");
        }
    }
}

#[test]
#[ignore = "needs the boards' images: cargo xtask test --all"]
fn times_of_edges_are_right_to_some_microseconds_also_while_bytes_arrive() {
    for board in BOARDS {
        for bytes in [0, 20_000] {
            let mut run = Run::at_rest(board);
            run.run_s(0.3);
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
