//! Faults of a simulated chip, its bus and its line, as `check` reports them.

use super::bench::Bench;
use super::{Fail, Inputs, Plan, Skipped, Verdict, Warn, find, judge, wrong};
use crate::input::{Input, Opened};
use hal_mock::{Ads1258, Fault, Injection, Options, Scene};
use ridgetone_finger::tasks::Received;

/// Asserts which checks warn or fail, in their order, and a part of the first one's finding.
fn finds(change: impl FnOnce(&mut Bench), expected: &[(&str, Verdict)], words: &str) {
    let checks = judge(&Bench::with(change).observations());
    assert_eq!(wrong(&checks), expected, "{words}: {checks:#?}");
    let finding = &find(&checks, expected[0].0).finding;
    assert!(finding.contains(words), "{words}: {finding}");
}

/// A fault of the chip that happens once, two seconds into the watch.
fn happens(bench: &mut Bench, fault: Fault) {
    bench.input.options.injections.push(Injection {
        at_s: 4.0,
        lasts_s: 0.0,
        fault,
    });
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
    let options =
        |change: fn(&mut Options)| move |bench: &mut Bench| change(&mut bench.input.options);
    finds(
        options(|chip| chip.id = 0x9b),
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
        options(|chip| chip.analog.reference_v = 2.5),
        &wrong,
        "2.500 V",
    );
    let fast = [("frame_rate", Fail), ("faults", Fail)];
    finds(
        options(|chip| chip.clock_error_ppm = 8000.0),
        &fast,
        "+8000 ppm",
    );
    let dead = [("inputs", Fail)];
    finds(
        options(|chip| chip.noise = false),
        &dead,
        "dead, always the same",
    );
    // The register changes by itself and is set up again.
    let flip = Fault::RegisterFlip {
        address: 4,
        mask: 1,
    };
    let set_up_again = [("adc_restarts", Fail), ("losses", Fail), ("faults", Fail)];
    let words = "1 of them while it was watched";
    finds(|bench| happens(bench, flip), &set_up_again, words);
}

#[test]
fn faults_of_the_bus_are_found() {
    let lost = Fault::EdgesLost { count: 3 };
    let expected = [("losses", Fail), ("faults", Fail)];
    finds(
        |bench| happens(bench, lost),
        &expected,
        "3 conversions lost",
    );
    let flip = |bytes_ahead| Fault::DoutFlip {
        bytes_ahead,
        mask: 1,
    };
    finds(
        |bench| happens(bench, flip(2)),
        &[("faults", Fail)],
        "bus 1",
    );
    let on_start = |chip: &mut Ads1258| {
        chip.begin_fault(Fault::DoutFlip {
            bytes_ahead: 22,
            mask: 1,
        });
    };
    let earlier = [("faults", Warn)];
    finds(
        |bench| bench.on_start = on_start,
        &earlier,
        "earlier: bus 1",
    );
}

#[test]
fn a_dead_bus_says_which_wire() {
    let high: fn(&mut Ads1258) = |chip| chip.begin_fault(Fault::BusCut { high: true });
    let low: fn(&mut Ads1258) = |chip| chip.begin_fault(Fault::BusCut { high: false });
    let failed =
        "adc_id adc_registers adc_restarts frame_rate drdy_jitter inputs noise mains faults";
    let failed: Vec<_> = failed.split(' ').map(|name| (name, Fail)).collect();
    for (on_start, words) in [(high, "DOUT is always high"), (low, "DOUT is always low")] {
        finds(|bench| bench.on_start = on_start, &failed, words);
    }
}

#[test]
fn faults_of_the_line_are_found() {
    // A bit of each thousandth byte; a lost byte after each thousandth.
    let damaged =
        |number: u64, byte| Received::Byte(if number % 1000 == 500 { byte ^ 4 } else { byte });
    let expected = [("commands", Warn)];
    finds(
        |bench| bench.received = damaged,
        &expected,
        "arrived damaged",
    );
    let overrun = |number: u64, byte| match number % 1000 {
        500 => Received::Overrun(byte),
        _ => Received::Byte(byte),
    };
    let expected = [("commands", Fail)];
    finds(|bench| bench.received = overrun, &expected, "bytes overrun");
    // Packets number 1000 and 1001 of the line.
    let on_line = |number: u64, bytes: &mut Vec<u8>| match number {
        1000 => bytes.clear(),
        1001 => bytes[3] ^= 8,
        _ => {}
    };
    let words = "2 packets lost, 1 packets damaged";
    finds(
        |bench| bench.on_line = Box::new(on_line),
        &[("losses", Fail)],
        words,
    );
}

/// While a finger slides, mains and noise cannot be judged; all else can. Between touches they are.
#[test]
fn touches_are_not_mistaken_for_pick_up() {
    let plan = |length_s| Plan {
        length_s,
        stores: false,
        inputs: Inputs::InUse,
    };
    let touched = |input: Opened, length_s| {
        Bench::with(|bench| (bench.input, bench.plan) = (input, plan(length_s)))
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
