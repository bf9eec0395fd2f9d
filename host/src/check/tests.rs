//! Every check on a board that is well, and on one with a fault that it must find.

mod bench;
mod conversation;
mod frames;

use super::{Check, Inputs, Plan, Verdict};
use crate::input::{Input, Opened};
use bench::Bench;
use hal_mock::{Ads1258, Fault, Injection, Options, Scene};
use ridgetone::tasks::line::Received;
use ridgetone_proto::boot::{Boot, BrownOut, Oscillator, Record, ResetCause};
use ridgetone_proto::telemetry::Health;
use std::path::Path;

use Verdict::{Fail, Skipped, Warn};

/// The checks that do not pass are these, in their order; the first one's finding has these words.
fn finds(bench: Bench, expected: &[(&str, Verdict)], words: &[&str]) {
    let findings: Vec<Check> = bench
        .findings()
        .into_iter()
        .filter(|check| check.name != "settings")
        .collect();
    let named: Vec<_> = findings
        .iter()
        .map(|check| (check.name, check.verdict))
        .collect();
    assert_eq!(named, expected, "{findings:#?}");
    for word in words {
        assert!(
            findings[0].finding.contains(word),
            "{word:?}: {}",
            findings[0].finding
        );
    }
}

fn chip(change: impl FnOnce(&mut Options)) -> Bench {
    let mut bench = Bench::default();
    change(&mut bench.input.options);
    bench
}

fn booted(change: impl FnOnce(&mut Boot)) -> Bench {
    let mut bench = Bench::default();
    change(&mut bench.boot);
    bench
}

/// A fault of the chip that happens once, two seconds into the watch.
fn happens(fault: Fault) -> Bench {
    chip(|options| {
        options.injections.push(Injection {
            at_s: 4.0,
            lasts_s: 0.0,
            fault,
        })
    })
}

/// Voltages at the inputs.
struct Volts<F>(F);

impl<F: FnMut(u8, f64) -> f64 + Send> Scene for Volts<F> {
    fn volts(&mut self, input: u8, t_s: f64) -> f64 {
        (self.0)(input, t_s)
    }

    fn end_s(&self) -> f64 {
        f64::INFINITY
    }
}

fn feels(volts: impl FnMut(u8, f64) -> f64 + Send + 'static) -> Bench {
    let mut bench = Bench::default();
    bench.input.scene = Box::new(Volts(volts));
    bench
}

/// The board reports another health.
fn reports(altered: fn(&mut Health)) -> Bench {
    Bench {
        health: altered,
        ..Bench::default()
    }
}

#[test]
fn a_board_that_is_well_passes_every_check() {
    finds(Bench::default(), &[], &[]);
}

/// While a finger slides, mains and noise cannot be judged; all else can. Between touches they are.
#[test]
fn touches_are_not_taken_for_pick_up() {
    let touched = |input: Opened| Bench {
        input,
        inputs: Inputs::InUse,
        ..Bench::default()
    };
    let once = || Input::default().open().expect("a scene");
    finds(
        touched(once().repeated()),
        &[("noise", Skipped), ("mains", Skipped)],
        &["judged with --inputs shorted only"],
    );
    let mut input = once();
    let mut touch = std::mem::replace(&mut input.scene, Opened::untouched().scene);
    let end_s = input.end_s;
    // The finger's own noise before the touch would be judged too.
    input.scene = Box::new(Volts(move |at, t_s| {
        if (0.5..end_s).contains(&t_s) {
            touch.volts(at, t_s)
        } else {
            0.0
        }
    }));
    input.end_s = f64::INFINITY;
    let bench = Bench {
        plan: Plan {
            length_s: 10.0,
            stores: false,
        },
        ..touched(input)
    };
    finds(bench, &[("noise", Skipped)], &[]);
}

#[test]
fn the_start_of_the_processor_is_judged() {
    let crashed =
        |boot: &mut Boot| boot.record = Some(Record::of_panic(7, "tone/src/moments.rs", 42));
    finds(
        booted(crashed),
        &[("reset", Warn)],
        &["panic in tone/src/moments.rs:42"],
    );
    let hard = |boot: &mut Boot| boot.record = Some(Record::of_hard_fault(7, 0x0800_1234, 0));
    finds(
        booted(hard),
        &[("reset", Warn)],
        &["hard_fault at 0x08001234"],
    );
    finds(
        booted(|boot| boot.cause = ResetCause::Watchdog),
        &[("reset", Warn)],
        &["watchdog"],
    );
    finds(
        booted(|boot| boot.cause = ResetCause::Unknown),
        &[("reset", Skipped)],
        &[],
    );
    for (level, words) in [
        (BrownOut::Off, "1.8 V"),
        (BrownOut::Level1, "2.1 V"),
        (BrownOut::Level2, "2.4 V"),
    ] {
        finds(
            booted(|boot| boot.brown_out = level),
            &[("brown_out", Warn)],
            &[words, "2.7 V"],
        );
    }
    finds(
        booted(|boot| boot.brown_out = BrownOut::Unknown),
        &[("brown_out", Skipped)],
        &[],
    );
    finds(
        booted(|boot| boot.oscillator = Oscillator::Internal),
        &[("oscillator", Fail)],
        &["internal"],
    );
    finds(
        booted(|boot| boot.oscillator = Oscillator::Unknown),
        &[("oscillator", Skipped)],
        &[],
    );
}

#[test]
fn load_and_stack_are_judged() {
    finds(
        reports(|health| health.load = 0.6),
        &[("load", Warn)],
        &["60.0 %"],
    );
    finds(reports(|health| health.load = 0.9), &[("load", Fail)], &[]);
    finds(
        reports(|health| health.load = 0.0),
        &[("load", Skipped)],
        &[],
    );
    finds(
        reports(|health| health.stack_used_bytes = 29_000),
        &[("stack", Warn)],
        &["29000 of 32768 bytes"],
    );
    finds(
        reports(|health| health.stack_used_bytes = 32_000),
        &[("stack", Fail)],
        &[],
    );
    finds(
        reports(|health| health.stack_bytes = 0),
        &[("stack", Skipped)],
        &[],
    );
}

#[test]
fn a_chip_that_is_another_one_or_has_other_registers_is_found() {
    finds(
        chip(|options| options.id = 0x9b),
        &[("adc_id", Fail)],
        &["9B", "ADS1158"],
    );
    let other = |health: &mut Health| health.adc_registers[1] = 0x83;
    finds(
        reports(other),
        &[("adc_registers", Fail)],
        &["CONFIG1 83 instead of 31"],
    );
    finds(
        reports(|health| health.chip_restarts = 2),
        &[("adc_restarts", Warn)],
        &["2 times", "0 of them"],
    );
    // The register changes by itself and is set up again.
    let changed = happens(Fault::RegisterFlip {
        address: 4,
        mask: 1,
    });
    let expected = [
        ("adc_restarts", Fail),
        ("frame_rate", Skipped),
        ("drdy_jitter", Skipped),
        ("losses", Fail),
        ("faults", Fail),
    ];
    finds(changed, &expected, &["1 of them while it was watched"]);
}

#[test]
fn a_dead_bus_says_which_wire() {
    for (high, words) in [(true, "DOUT is always high"), (false, "DOUT is always low")] {
        let cut: fn(&mut Ads1258) = match high {
            true => |chip| chip.begin_fault(Fault::BusCut { high: true }),
            false => |chip| chip.begin_fault(Fault::BusCut { high: false }),
        };
        let findings = Bench {
            on_start: cut,
            ..Bench::default()
        }
        .findings();
        let failed: Vec<_> = findings
            .iter()
            .filter(|check| check.verdict == Fail)
            .map(|check| check.name)
            .collect();
        assert_eq!(
            failed,
            [
                "adc_id",
                "adc_registers",
                "adc_restarts",
                "frame_rate",
                "drdy_jitter",
                "inputs",
                "noise",
                "mains",
                "faults"
            ],
            "{findings:#?}"
        );
        assert!(findings[0].finding.contains(words), "{findings:#?}");
    }
}

#[test]
fn the_chips_own_readings_are_judged() {
    let supply = |volts| chip(|options| options.analog.avdd_v = volts);
    finds(
        supply(4.70),
        &[("supply", Fail), ("faults", Fail)],
        &["4.700 V"],
    );
    finds(
        supply(5.30),
        &[("supply", Fail), ("faults", Fail)],
        &["5.300 V"],
    );
    let reference = |volts| chip(|options| options.analog.reference_v = volts);
    finds(
        reference(4.096 * 1.015),
        &[("reference", Warn)],
        &["1.50 %"],
    );
    // The temperature is measured against the reference.
    let wrong = [
        ("reference", Fail),
        ("temperature", Fail),
        ("noise", Warn),
        ("faults", Fail),
    ];
    finds(reference(2.5), &wrong, &["2.500 V"]);
    let temperature = |celsius| chip(|options| options.analog.temperature_c = celsius);
    finds(temperature(70.0), &[("temperature", Warn)], &["70.0 C"]);
    finds(temperature(-60.0), &[("temperature", Fail)], &[]);
    let offset = |volts| chip(|options| options.analog.offset_v = volts);
    finds(offset(-400e-6), &[("offset", Warn)], &["-40"]);
    finds(offset(2e-3), &[("offset", Fail)], &[]);
    let gain = |gain| chip(|options| options.analog.gain = gain);
    finds(gain(0.99), &[("gain", Warn)], &["0.98"]);
    finds(gain(1.05), &[("gain", Fail)], &[]);
}

#[test]
fn commands_that_arrive_damaged_or_lose_bytes_are_counted() {
    // A bit of each thousandth byte; a lost byte behind each thousandth.
    let damaged =
        |number: u64, byte| Received::Byte(if number % 1000 == 500 { byte ^ 4 } else { byte });
    finds(
        Bench {
            received: damaged,
            ..Bench::default()
        },
        &[("commands", Warn)],
        &["94 of 94 answered", "arrived damaged"],
    );
    let overrun = |number: u64, byte| {
        if number % 1000 == 500 {
            Received::Overrun(byte)
        } else {
            Received::Byte(byte)
        }
    };
    finds(
        Bench {
            received: overrun,
            ..Bench::default()
        },
        &[("commands", Fail)],
        &["bytes overrun"],
    );
}

#[test]
fn losses_and_faults_are_counted_by_name() {
    // Packets number 1000 and 1001 of the line.
    let on_line = |number: u64, bytes: &mut Vec<u8>| {
        if number == 1000 {
            bytes.clear()
        } else if number == 1001 {
            bytes[3] ^= 8
        }
    };
    let bench = Bench {
        on_line: Box::new(on_line),
        ..Bench::default()
    };
    finds(
        bench,
        &[("losses", Fail)],
        &["2 packets lost", "1 packets damaged"],
    );
    finds(
        happens(Fault::EdgesLost { count: 3 }),
        &[("losses", Fail), ("faults", Fail)],
        &["3 conversions lost"],
    );
    let dropped = |health: &mut Health| {
        if health.frames > 900 {
            (health.messages_dropped, health.hops_skipped) = (2, 1)
        }
    };
    finds(
        reports(dropped),
        &[("losses", Fail)],
        &["2 messages dropped", "1 hops skipped"],
    );
    let bus = |chip: &mut Ads1258| {
        chip.begin_fault(Fault::DoutFlip {
            bytes_ahead: 22,
            mask: 1,
        })
    };
    finds(
        Bench {
            on_start: bus,
            ..Bench::default()
        },
        &[("faults", Warn)],
        &["earlier: bus 1"],
    );
    finds(
        happens(Fault::DoutFlip {
            bytes_ahead: 2,
            mask: 1,
        }),
        &[("faults", Fail)],
        &["bus 1"],
    );
}

#[test]
fn every_page_exists_and_names_what_the_checks_are_called() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let checks = super::judge(&Default::default(), Inputs::InUse);
    assert_eq!(checks.len(), 23);
    let troubleshooting =
        std::fs::read_to_string(root.join(super::verdict::TROUBLESHOOTING)).expect("a page");
    for check in checks {
        assert!(root.join(check.page).is_file(), "{}", check.page);
        assert!(
            troubleshooting.contains(&format!("`{}`", check.name)),
            "{}",
            check.name
        );
    }
}
