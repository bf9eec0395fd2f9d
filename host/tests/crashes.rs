//! What comes after the emulated firmware died: it starts anew, says why in its greeting, and
//! measures again. `cargo xtask test` builds the image and runs these.
#![cfg(target_os = "linux")]

use hal_mock::Sliding;
use hal_mock::bridge::Crash;
use ridgetone_finger::tasks::WATCHDOG_S;
use ridgetone_host::emulator::{self, Options, Outcome};
use ridgetone_host::input::Input;
use ridgetone_proto::boot::{Death, ResetCause};
use ridgetone_proto::telemetry::{Event, Health, Hello, Packet, Span, Status};
use std::path::{Path, PathBuf};
use std::sync::Mutex;

/// Board time at which it happens, microseconds.
const AT_US: u64 = 200_000;

fn run(elf: &Path, scene: Sliding, crash: Option<Crash>) -> (Outcome, Vec<Packet>) {
    let options = Options {
        crash: crash.map(|crash| (AT_US, crash)),
        ..Options::new(elf)
    };
    let mut packets = Vec::new();
    let mut sink = |packet: &Packet| {
        packets.push(packet.clone());
        Ok(())
    };
    let input = Input {
        scene,
        ..Input::default()
    }
    .open()
    .expect("an input");
    let outcome = emulator::run(input, options, &mut sink, &mut |_, _| {}).expect("a run");
    (outcome, packets)
}

/// The greetings that a run begins with.
fn greetings(packets: &[Packet]) -> Vec<&Hello> {
    let first = packets.iter().filter(|packet| packet.sequence == 0);
    first
        .map(|packet| match &packet.event {
            Event::Hello(hello) => hello,
            other => panic!("a run begins with {other:?}"),
        })
        .collect()
}

#[test]
#[ignore = "needs the emulator: cargo xtask test"]
fn after_every_crash_it_restarts_reports_the_cause_and_measures_again() {
    let elf = emulator::image::find().expect("an image");
    for crash in Crash::ALL {
        // The touch is well after the watchdog, which takes longest.
        let idle_s = if crash == Crash::Hang {
            f64::from(WATCHDOG_S) + 1.5
        } else {
            0.8
        };
        let (outcome, packets) = run(
            &elf,
            Sliding {
                idle_s,
                ..Sliding::default()
            },
            Some(crash),
        );
        assert_eq!(outcome.counts.damaged, 0, "{crash:?}");
        let hellos = greetings(&packets);
        let [before, after] = hellos[..] else {
            panic!("{crash:?}: {hellos:?}")
        };
        assert_eq!(
            (before.boot.cause, &before.boot.record),
            (ResetCause::Unknown, &None),
            "{crash:?}"
        );

        let cause = if crash == Crash::Hang {
            ResetCause::Watchdog
        } else {
            ResetCause::Software
        };
        assert_eq!(after.boot.cause, cause, "{crash:?}");
        let record = after.boot.record.as_ref();
        let at_us = || u64::from(record.expect("a record").t_us);
        match crash {
            Crash::Panic => {
                let record = record.expect("a record");
                // The end of the path, as much as a record holds.
                assert_eq!(
                    (record.death, record.file.as_str()),
                    (Death::Panic, "c/board/emulated/link.rs")
                );
                let source = include_str!("../../src/board/emulated/link.rs")
                    .lines()
                    .nth(record.line as usize - 1);
                assert!(
                    source.is_some_and(|line| line.contains("panic!(")),
                    "{record:?}: {source:?}"
                );
                assert!((AT_US..AT_US + 20_000).contains(&at_us()), "{record:?}");
            }
            Crash::HardFault => {
                let record = record.expect("a record");
                assert_eq!(record.death, Death::HardFault);
                // In flash, whose beginning the vector table is.
                assert!(
                    (0x0800_0400..0x0810_0000).contains(&record.pc),
                    "{record:?}"
                );
                assert!((AT_US..AT_US + 20_000).contains(&at_us()), "{record:?}");
            }
            Crash::StackOverflow => {
                let record = record.expect("a record");
                assert_eq!(
                    (record.death, record.pc, record.lr),
                    (Death::HardFault, 0, 0)
                );
                assert!((AT_US..AT_US + 20_000).contains(&at_us()), "{record:?}");
            }
            Crash::Hang | Crash::Restart => {
                assert_eq!(record, None, "{crash:?}: nothing could be kept")
            }
        }

        let good = packets.iter().filter(|packet| match &packet.event {
            Event::Estimate(fit) => fit.span == Span::Slide && fit.status == Status::Good,
            _ => false,
        });
        assert_eq!(good.count(), 1, "{crash:?}: the touch after it is measured");
    }
}

/// The stack's depth in `health` beside what the board finds when it leaves; a fit has been in
/// between.
#[test]
#[ignore = "needs the emulator: cargo xtask test"]
fn the_stack_s_depth_is_reported_once_a_second() {
    let elf = emulator::image::find().expect("an image");
    let (outcome, packets) = run(&elf, Sliding::default(), None);
    let healths: Vec<&Health> = packets
        .iter()
        .filter_map(|packet| match &packet.event {
            Event::Health(health) => Some(health),
            _ => None,
        })
        .collect();
    let message = outcome
        .messages
        .lines()
        .find_map(|line| line.strip_prefix("stack: "))
        .expect("the stack's depth");
    let (deepest, size) = message.split_once(" of ").expect("two numbers");
    let deepest: u32 = deepest.parse().expect("a number");
    assert!(size.starts_with("17408 bytes"), "{message}");
    let reported: Vec<u32> = healths
        .iter()
        .map(|health| health.stack_used_bytes)
        .collect();
    assert!(reported.is_sorted() && reported[0] > 0, "{reported:?}");
    assert!(healths.iter().all(|health| health.stack_bytes == 17408));
    // The last is sent with the end of the slide, before its fit; but windows like it were fitted
    // before.
    let last = reported[reported.len() - 1];
    assert!(
        last <= deepest && last + 1024 > deepest,
        "{last} reported, {deepest} at the end"
    );
}

/// Arithmetic wraps silently in the release image and panics in this one. A touch gives equal bits
/// in both.
#[test]
#[ignore = "needs the emulator and an image in RIDGETONE_CHECKED_ELF: cargo xtask test"]
fn no_arithmetic_overflows_in_a_touch() {
    let events = |elf: &Path| {
        let (outcome, packets) = run(elf, Sliding::default(), None);
        assert_eq!(
            (
                outcome.counts.missing,
                outcome.counts.damaged,
                outcome.chip.lost
            ),
            (0, 0, 0)
        );
        // Health says how busy the processor is, and the converter when it was looked at, which
        // differ; and other messages overtake a slower fit.
        let all = packets
            .into_iter()
            .map(|packet| packet.event)
            .filter(|event| !matches!(event, Event::Health(_) | Event::Converter(_)));
        let (fits, others): (Vec<_>, Vec<_>) =
            all.partition(|event| matches!(event, Event::Estimate(_)));
        assert!(fits.len() > 1 && !others.is_empty());
        (fits, others)
    };
    let checked =
        PathBuf::from(std::env::var_os("RIDGETONE_CHECKED_ELF").expect("RIDGETONE_CHECKED_ELF"));
    assert_eq!(
        events(&checked),
        events(&emulator::image::find().expect("an image"))
    );
}

/// Lines of the log; a function takes them, for the options can be copied.
static LINES: Mutex<Vec<String>> = Mutex::new(Vec::new());

#[test]
#[ignore = "needs the emulator: cargo xtask test"]
fn the_log_and_the_greeting_agree() {
    let elf = emulator::image::find().expect("an image");
    let keep = |line: &str| {
        LINES
            .lock()
            .expect("nobody has died with it")
            .push(line.to_owned())
    };
    let options = Options {
        crash: Some((AT_US, Crash::Panic)),
        log: Some(keep),
        ..Options::new(&elf)
    };
    let mut packets = Vec::new();
    let mut sink = |packet: &Packet| {
        packets.push(packet.clone());
        Ok(())
    };
    let scene = Sliding {
        idle_s: 0.8,
        ..Sliding::default()
    };
    let input = Input {
        scene,
        ..Input::default()
    }
    .open()
    .expect("an input");
    emulator::run(input, options, &mut sink, &mut |_, _| {}).expect("a run");
    let hellos = greetings(&packets);
    let record = hellos[1].boot.record.as_ref().expect("a record");

    // Each run sets the chip up; the second says first what the first has died of.
    let lines = LINES.lock().expect("nobody has died with it");
    let [first, died, second] = &lines[..] else {
        panic!("{lines:?}")
    };
    assert!(
        first.ends_with("INFO the ADS1258 is set up and scans"),
        "{first}"
    );
    assert!(
        died.contains(&format!(
            "ERROR the run before died at {}:{}",
            record.file, record.line
        )),
        "{died}"
    );
    assert!(
        second.ends_with("INFO the ADS1258 is set up and scans"),
        "{second}"
    );
    // The log has the board's time, which goes on over a reset.
    let seconds = |line: &str| {
        line.split(' ')
            .next()
            .and_then(|word| word.parse::<f64>().ok())
            .expect("a time")
    };
    assert!(
        seconds(first) < AT_US as f64 * 1e-6 && seconds(died) >= AT_US as f64 * 1e-6,
        "{first}, {died}"
    );
}
