//! Faults of a simulated chip, its bus and its line, as `check` reports them.

use super::bench::Bench;
use super::{Fail, Inputs, Plan, Skipped, Verdict, Warn, find, judge, wrong};
use crate::input::{Input, Opened};
use hal_mock::{Ads1258, Fault, Injection, Options, Scene};
use ridgetone_finger::tasks::Received;

/// Asserts which checks warn or fail, in their order, and words of the first one's finding.
fn finds(bench: Bench, expected: &[(&str, Verdict)], words: &str) {
    let checks = judge(&bench.observations());
    assert_eq!(wrong(&checks), expected, "{words}: {checks:#?}");
    if let [(name, _), ..] = expected {
        let finding = &find(&checks, name).finding;
        assert!(finding.contains(words), "{words}: {finding}");
    }
}

fn chip(change: impl FnOnce(&mut Options)) -> Bench {
    let mut bench = Bench::default();
    change(&mut bench.input.options);
    bench
}

/// A fault of the chip that happens once, two seconds into the watch.
fn happens(fault: Fault) -> Bench {
    let injection = Injection {
        at_s: 4.0,
        lasts_s: 0.0,
        fault,
    };
    chip(|options| options.injections.push(injection))
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

#[test]
fn faults_of_the_chip_are_found() {
    finds(
        chip(|options| options.id = 0x9b),
        &[("adc_id", Fail)],
        "ADS1158",
    );
    // Temperature and noise are measured against the reference.
    let wrong = [
        ("reference", Fail),
        ("temperature", Fail),
        ("noise", Warn),
        ("faults", Fail),
    ];
    finds(
        chip(|options| options.analog.reference_v = 2.5),
        &wrong,
        "2.500 V",
    );
    let fast = [("frame_rate", Fail), ("faults", Fail)];
    finds(
        chip(|options| options.clock_error_ppm = 8000.0),
        &fast,
        "+8000 ppm",
    );
    finds(
        chip(|options| options.noise = false),
        &[("inputs", Fail)],
        "dead, always the same",
    );
    // The register changes by itself and is set up again.
    let changed = happens(Fault::RegisterFlip {
        address: 4,
        mask: 1,
    });
    let set_up_again = [("adc_restarts", Fail), ("losses", Fail), ("faults", Fail)];
    finds(changed, &set_up_again, "1 of them while it was watched");
}

#[test]
fn faults_of_the_bus_are_found() {
    let lost = happens(Fault::EdgesLost { count: 3 });
    finds(
        lost,
        &[("losses", Fail), ("faults", Fail)],
        "3 conversions lost",
    );
    let flip = happens(Fault::DoutFlip {
        bytes_ahead: 2,
        mask: 1,
    });
    finds(flip, &[("faults", Fail)], "bus 1");
    let on_start = |chip: &mut Ads1258| {
        chip.begin_fault(Fault::DoutFlip {
            bytes_ahead: 22,
            mask: 1,
        });
    };
    finds(
        Bench {
            on_start,
            ..Bench::default()
        },
        &[("faults", Warn)],
        "earlier: bus 1",
    );
}

#[test]
fn a_dead_bus_says_which_wire() {
    let high: fn(&mut Ads1258) = |chip| chip.begin_fault(Fault::BusCut { high: true });
    let low: fn(&mut Ads1258) = |chip| chip.begin_fault(Fault::BusCut { high: false });
    for (on_start, words) in [(high, "DOUT is always high"), (low, "DOUT is always low")] {
        let failed = [
            "adc_id",
            "adc_registers",
            "adc_restarts",
            "frame_rate",
            "drdy_jitter",
            "inputs",
            "noise",
            "mains",
            "faults",
        ];
        finds(
            Bench {
                on_start,
                ..Bench::default()
            },
            &failed.map(|name| (name, Fail)),
            words,
        );
    }
}

#[test]
fn faults_of_the_line_are_found() {
    // A bit of each thousandth byte; a lost byte after each thousandth.
    let received =
        |number: u64, byte| Received::Byte(if number % 1000 == 500 { byte ^ 4 } else { byte });
    finds(
        Bench {
            received,
            ..Bench::default()
        },
        &[("commands", Warn)],
        "arrived damaged",
    );
    let received = |number: u64, byte| match number % 1000 {
        500 => Received::Overrun(byte),
        _ => Received::Byte(byte),
    };
    finds(
        Bench {
            received,
            ..Bench::default()
        },
        &[("commands", Fail)],
        "bytes overrun",
    );
    // Packets number 1000 and 1001 of the line.
    let on_line = |number: u64, bytes: &mut Vec<u8>| match number {
        1000 => bytes.clear(),
        1001 => bytes[3] ^= 8,
        _ => {}
    };
    let bench = Bench {
        on_line: Box::new(on_line),
        ..Bench::default()
    };
    finds(
        bench,
        &[("losses", Fail)],
        "2 packets lost, 1 packets damaged",
    );
}

/// While a finger slides, mains and noise cannot be judged; all else can. Between touches they are.
#[test]
fn touches_are_not_mistaken_for_pick_up() {
    let touched = |input: Opened, length_s| Bench {
        input,
        plan: Plan {
            length_s,
            stores: false,
            inputs: Inputs::InUse,
        },
        ..Bench::default()
    };
    let once = || Input::default().open().expect("a scene");
    let checks = judge(&touched(once().repeated(), 5.0).observations());
    assert_eq!(
        (wrong(&checks), find(&checks, "mains").verdict),
        (vec![], Skipped)
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
    let checks = judge(&touched(input, 10.0).observations());
    assert_eq!(
        (wrong(&checks), find(&checks, "mains").verdict),
        (vec![], Verdict::Pass)
    );
}
