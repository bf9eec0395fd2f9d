//! Tests the serial line while the chip scans.

mod common;

use common::{BOARDS, Run, health, reply_to, request};
use ridgetone_emulator::ProcessorFault;
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
                // Not a multiple of the conversion period.
                run.run_s(0.00037);
            }
            run.assert_rules();
            assert_eq!(run.emulator.received()[..2], [0, 0], "{board:?}: none lost");
        }
    }
}

/// If the task that takes requests is late, bytes that fit into the buffer are kept and later ones
/// lost. A loss of more than half a buffer must be counted, and the next request must arrive.
#[test]
#[ignore = "needs the boards' images: cargo xtask test --all"]
fn a_late_task_loses_no_byte_that_the_buffer_holds_and_counts_the_others() {
    /// Interrupt of `report`, OTG_HS_EP1_IN; `stream` is the interrupt of the board's DMA stream.
    const REPORT: u16 = 75;
    for (board, stream) in BOARDS.into_iter().zip([12, 16]) {
        for (bytes, losses) in [(100, 0..1), (1000, 129..1010)] {
            let mut run = Run::at_rest(board);
            let hold = |run: &mut Run, fault: fn(u16) -> ProcessorFault| {
                for irq in [REPORT, stream] {
                    run.emulator.inject(fault(irq));
                }
            };
            hold(&mut run, ProcessorFault::Mask);
            run.emulator.send(&vec![0x55; bytes]);
            run.emulator.send(&request(1, Command::Greet));
            run.run_s(0.02);
            hold(&mut run, ProcessorFault::Unmask);
            if losses.start == 0 {
                assert_eq!(run.run_to(0.1, reply_to(1)), Outcome::Done, "{board:?}");
            }
            run.run_s(0.001);
            assert_eq!(run.command(2, Command::Greet), Outcome::Done, "{board:?}");
            let report = run.run_to(3.0, health);
            let lost = report.bytes_overrun;
            assert!(losses.contains(&lost), "{board:?}: {lost} of {bytes}");
            assert_eq!(run.emulator.received()[0], 0, "{board:?}");
            run.assert_rules();
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
            let from = run.emulator.readings().len();
            run.emulator.send(&vec![0x55; bytes]);
            run.run_s(0.25);
            // The counter starts some time after power-up, so only the jitter is tested.
            let late: Vec<i64> = (run.emulator.readings().iter().skip(from))
                .map(|reading| i64::from(reading.t_us) - (reading.edge_ns / 1000) as i64)
                .collect();
            let (min, max) = (
                late.iter().min().expect("readings"),
                late.iter().max().expect("readings"),
            );
            println!(
                "{board:?}: with {bytes} bytes arriving time stamps jitter by {} us",
                max - min
            );
            assert!(max - min <= 3, "{board:?}: {min} to {max} us");
        }
    }
}

/// The processor stalls for 16 us per word of flash, longer than a byte takes (10.9 us), but the
/// DMA fetches the bytes. The scan must lose nothing either, and the settings must be kept.
#[test]
#[ignore = "needs the boards' images: cargo xtask test --all"]
fn no_byte_is_lost_while_settings_are_kept() {
    let settings = Settings {
        stride_s: 0.75,
        ..Settings::DEFAULT
    };
    // Vary the phase of the bytes relative to the tasks that read them.
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
        let before = run.emulator.received()[2];
        let sent = [request(1, keep), vec![0x55; 1000]].concat();
        run.emulator.send(&sent);
        assert_eq!(run.run_to(1.0, reply_to(1)), Outcome::Done, "{board:?}");
        run.run_s(0.1);
        let [overruns, unheard, taken] = run.emulator.received();
        assert_eq!(
            (overruns, unheard, taken - before),
            (0, 0, sent.len() as u64),
            "{board:?}, {phase}"
        );
        assert_eq!(run.command(2, Command::Greet), Outcome::Done, "{board:?}");
        let report = run.run_to(3.0, health);
        assert_eq!(report.bytes_overrun, 0, "{board:?}, {phase}");
        assert_eq!(report.conversions_lost, 0, "{board:?}");
        run.assert_rules();
    }
}

/// Requests wait in the buffer while settings are written. Meanwhile the buffer's half-full
/// interrupt, whose priority is above that of the task that takes requests, must not fire
/// repeatedly.
#[test]
#[ignore = "needs the boards' images: cargo xtask test --all"]
fn requests_that_wait_behind_another_keep_no_task_from_running() {
    let settings = Settings {
        stride_s: 0.75,
        ..Settings::DEFAULT
    };
    for board in BOARDS {
        let mut run = Run::at_rest(board);
        let keep = Command::Set {
            settings,
            keep: true,
        };
        let behind = (2..500).flat_map(|number| request(number, Command::Greet));
        let sent: Vec<u8> = request(1, keep).into_iter().chain(behind).collect();
        run.emulator.send(&sent);
        assert_eq!(run.run_to(1.0, reply_to(1)), Outcome::Done, "{board:?}");
        run.run_s(0.2);
        assert_eq!(run.command(600, Command::Greet), Outcome::Done, "{board:?}");
        let report = run.run_to(3.0, health);
        assert_eq!(report.conversions_lost, 0, "{board:?}");
        run.assert_rules();
    }
}
