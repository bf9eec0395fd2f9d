//! The serial line while the chip scans.

mod common;

use common::{BOARDS, Run, health, reply_to, request};
use ridgetone_emulator::{ProcessorFault, Rule};
use ridgetone_proto::command::{Command, Outcome};
use ridgetone_proto::settings::Settings;

#[test]
#[ignore = "needs the boards' images: cargo xtask test --all"]
fn short_commands_and_usual_settings_arrive_while_the_chip_scans() {
    for board in BOARDS {
        for command in [
            Command::Greet,
            Command::Set {
                settings: Settings::DEFAULT,
                keep: false,
            },
        ] {
            let mut run = Run::at_rest(board);
            for number in 1..=200 {
                assert_eq!(
                    run.command(number, command.clone()),
                    Outcome::Done,
                    "{board:?}: request {number}"
                );
                // Not in step with the conversions.
                run.run_s(0.00037);
            }
            run.assert_rules();
            assert_eq!(run.emulator.received()[..2], [0, 0], "{board:?}: none lost");
        }
    }
}

/// The line's task is late by three bytes at the end of a request: the end is kept, the byte behind
/// it is lost and counted, and the next request arrives.
#[test]
#[ignore = "needs the boards' images: cargo xtask test --all"]
fn an_overrun_keeps_the_byte_before_it_and_is_counted() {
    for (board, irq) in BOARDS.into_iter().zip([39, 38]) {
        let mut run = Run::at_rest(board);
        // No telemetry leaves for a while, so nothing else starts the task.
        run.run_to(3.0, health);
        let sent = request(1, Command::Greet);
        let (end, begin) = sent.split_last().expect("bytes");
        run.emulator.send(begin);
        run.run_s(0.001);
        run.emulator.inject(ProcessorFault::Mask(irq));
        run.emulator.send(&[*end, 0x55]);
        run.run_s(40e-6);
        run.emulator.inject(ProcessorFault::Unmask(irq));
        assert_eq!(
            run.run_to(0.1, reply_to(1)),
            Outcome::Done,
            "{board:?}: the zero that ends it is kept"
        );
        assert_eq!(run.command(2, Command::Greet), Outcome::Done, "{board:?}");
        let report = run.run_to(3.0, health);
        assert_eq!(
            (report.bytes_overrun, run.emulator.received()[0]),
            (1, 1),
            "{board:?}"
        );
        let [finding] = run.emulator.findings() else {
            panic!("{:#?}", run.emulator.findings())
        };
        assert_eq!(
            (finding.rule, finding.times),
            (Rule::UsartOverrun, 1),
            "{board:?}"
        );
    }
}

#[test]
#[ignore = "needs the boards' images: cargo xtask test --all"]
fn times_of_edges_are_right_to_some_microseconds_also_while_bytes_arrive() {
    for board in BOARDS {
        for bytes in [0, 20_000] {
            let mut run = Run::at_rest(board);
            run.run_s(0.3);
            let from = run.emulator.readings().len();
            run.emulator.send(&vec![0x55; bytes]);
            run.run_s(0.25);
            // The counter starts after the power does.
            let late: Vec<i64> = (run.emulator.readings().iter().skip(from))
                .map(|reading| i64::from(reading.t_us) - (reading.edge_ns / 1000) as i64)
                .collect();
            let (least, most) = (
                late.iter().min().expect("readings"),
                late.iter().max().expect("readings"),
            );
            println!(
                "{board:?}: with {bytes} bytes arriving time stamps jitter by {} us",
                most - least
            );
            assert!(most - least <= 3, "{board:?}: {least} to {most} us");
        }
    }
}

/// The processor stands still for 16 us a word of flash, a byte lasts 10.9: bytes that follow at once
/// are lost, counted and reported. Nothing of the scan is lost, and the settings are kept.
#[test]
#[ignore = "needs the boards' images: cargo xtask test --all"]
fn bytes_back_to_back_while_settings_are_kept_are_lost_and_counted() {
    let settings = Settings {
        stride_s: 0.75,
        ..Settings::DEFAULT
    };
    // Bytes arrive at any moment of the task that reads them.
    for (board, phase) in BOARDS
        .into_iter()
        .flat_map(|board| (0..12).map(move |at| (board, at)))
    {
        let mut run = Run::at_rest(board);
        let keep = Command::Set {
            settings,
            keep: true,
        };
        run.run_s(f64::from(phase) * 0.91e-6);
        run.emulator.send(&request(1, keep));
        run.emulator.send(&vec![0x55; 1000]);
        assert_eq!(run.run_to(1.0, reply_to(1)), Outcome::Done, "{board:?}");
        run.run_s(0.1);
        let [overruns, unheard, _] = run.emulator.received();
        assert!(
            overruns > 0 && unheard == 0,
            "{board:?}, {phase}: {overruns}"
        );
        let broken: Vec<Rule> = run.emulator.findings().iter().map(|one| one.rule).collect();
        assert!(broken.iter().all(|rule| *rule == Rule::UsartOverrun));
        assert_eq!(run.command(2, Command::Greet), Outcome::Done, "{board:?}");
        let report = run.run_to(3.0, health);
        assert_eq!(
            u64::from(report.bytes_overrun),
            overruns,
            "{board:?}, {phase}"
        );
        assert_eq!(report.conversions_lost, 0, "{board:?}");
    }
}
