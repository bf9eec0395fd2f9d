//! Every check on a board that is well, and on one with a fault that it must find.

mod bench;
mod conversation;

use super::signals::{Clock, line};
use super::{Check, Inputs, Plan, Verdict};
use crate::input::{Input, Opened};
use bench::Bench;
use hal_mock::{Ads1258, Fault, Injection, Options, Scene};
use ridgetone::tasks::line::Received;
use ridgetone_proto::boot::{Boot, BrownOut, Oscillator, Record, ResetCause};
use ridgetone_proto::settings::{FRAME_RATE_HZ, TAXELS};
use ridgetone_proto::telemetry::{Event, Health, Raw};
use std::f64::consts::TAU;
use std::path::Path;

use Verdict::{Fail, Skipped, Warn};

/// The checks that do not pass are these, in their order; the first one's finding has these words.
fn finds(bench: Bench, expected: &[(&str, Verdict)], words: &[&str]) {
    let findings: Vec<Check> = bench.findings().into_iter().filter(|check| check.name != "settings").collect();
    let named: Vec<_> = findings.iter().map(|check| (check.name, check.verdict)).collect();
    assert_eq!(named, expected, "{findings:#?}");
    for word in words {
        assert!(findings[0].finding.contains(word), "{word:?}: {}", findings[0].finding);
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
    chip(|options| options.injections.push(Injection { at_s: 4.0, lasts_s: 0.0, fault }))
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
    Bench { health: altered, ..Bench::default() }
}

#[test]
fn a_board_that_is_well_passes_every_check() {
    finds(Bench::default(), &[], &[]);
}

/// While a finger slides, mains and noise cannot be judged; all else can. Between touches they are.
#[test]
fn touches_are_not_taken_for_pick_up() {
    let touched = |input: Opened| Bench { input, inputs: Inputs::InUse, ..Bench::default() };
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
    input.scene = Box::new(Volts(move |at, t_s| if (0.5..end_s).contains(&t_s) { touch.volts(at, t_s) } else { 0.0 }));
    input.end_s = f64::INFINITY;
    let bench = Bench { plan: Plan { length_s: 10.0, stores: false }, ..touched(input) };
    finds(bench, &[("noise", Skipped)], &[]);
}

#[test]
fn the_start_of_the_processor_is_judged() {
    let crashed = |boot: &mut Boot| boot.record = Some(Record::of_panic(7, "tone/src/moments.rs", 42));
    finds(booted(crashed), &[("reset", Warn)], &["panic in tone/src/moments.rs:42"]);
    let hard = |boot: &mut Boot| boot.record = Some(Record::of_hard_fault(7, 0x0800_1234, 0));
    finds(booted(hard), &[("reset", Warn)], &["hard_fault at 0x08001234"]);
    finds(booted(|boot| boot.cause = ResetCause::Watchdog), &[("reset", Warn)], &["watchdog"]);
    finds(booted(|boot| boot.cause = ResetCause::Unknown), &[("reset", Skipped)], &[]);
    for (level, words) in [(BrownOut::Off, "1.8 V"), (BrownOut::Level1, "2.1 V"), (BrownOut::Level2, "2.4 V")] {
        finds(booted(|boot| boot.brown_out = level), &[("brown_out", Warn)], &[words, "2.7 V"]);
    }
    finds(booted(|boot| boot.brown_out = BrownOut::Unknown), &[("brown_out", Skipped)], &[]);
    finds(booted(|boot| boot.oscillator = Oscillator::Internal), &[("oscillator", Fail)], &["internal"]);
    finds(booted(|boot| boot.oscillator = Oscillator::Unknown), &[("oscillator", Skipped)], &[]);
}

#[test]
fn load_and_stack_are_judged() {
    finds(reports(|health| health.load = 0.6), &[("load", Warn)], &["60.0 %"]);
    finds(reports(|health| health.load = 0.9), &[("load", Fail)], &[]);
    finds(reports(|health| health.load = 0.0), &[("load", Skipped)], &[]);
    finds(reports(|health| health.stack_used_bytes = 29_000), &[("stack", Warn)], &["29000 of 32768 bytes"]);
    finds(reports(|health| health.stack_used_bytes = 32_000), &[("stack", Fail)], &[]);
    finds(reports(|health| health.stack_bytes = 0), &[("stack", Skipped)], &[]);
}

#[test]
fn a_chip_that_is_another_one_or_has_other_registers_is_found() {
    finds(chip(|options| options.id = 0x9b), &[("adc_id", Fail)], &["9B", "ADS1158"]);
    let other = |health: &mut Health| health.adc_registers[1] = 0x83;
    finds(reports(other), &[("adc_registers", Fail)], &["CONFIG1 83 instead of 31"]);
    finds(reports(|health| health.chip_restarts = 2), &[("adc_restarts", Warn)], &["2 times", "0 of them"]);
    // The register changes by itself and is set up again.
    let flips = happens(Fault::RegisterFlip { address: 4, mask: 1 });
    let expected =
        [("adc_restarts", Fail), ("frame_rate", Skipped), ("drdy_jitter", Skipped), ("losses", Fail), ("faults", Fail)];
    finds(flips, &expected, &["1 of them while it was watched"]);
}

#[test]
fn a_dead_bus_says_which_wire() {
    for (high, words) in [(true, "DOUT is always high"), (false, "DOUT is always low")] {
        let cut: fn(&mut Ads1258) = match high {
            true => |chip| chip.begin_fault(Fault::BusCut { high: true }),
            false => |chip| chip.begin_fault(Fault::BusCut { high: false }),
        };
        let findings = Bench { on_start: cut, ..Bench::default() }.findings();
        let failed: Vec<_> = findings.iter().filter(|check| check.verdict == Fail).map(|check| check.name).collect();
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
    finds(supply(4.70), &[("supply", Fail), ("faults", Fail)], &["4.700 V"]);
    finds(supply(5.30), &[("supply", Fail), ("faults", Fail)], &["5.300 V"]);
    let reference = |volts| chip(|options| options.analog.reference_v = volts);
    finds(reference(4.096 * 1.015), &[("reference", Warn)], &["1.50 %"]);
    // The temperature is measured against the reference.
    let wrong = [("reference", Fail), ("temperature", Fail), ("noise", Warn), ("faults", Fail)];
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
fn the_scans_rate_and_the_times_of_its_edges_are_judged() {
    let off = |ppm| chip(|options| options.clock_error_ppm = ppm);
    finds(off(-300.0), &[("frame_rate", Warn)], &["-300 ppm"]);
    finds(off(8000.0), &[("frame_rate", Fail), ("faults", Fail)], &["+8000 ppm"]);
    // 150 us and 300 us late in one frame of seven.
    let late = |us: u64| {
        move |event: &mut Event| {
            if let Event::Raw(raw) = event
                && raw.number.is_multiple_of(7)
            {
                raw.t_us += us;
            }
        }
    };
    finds(Bench { altered: Box::new(late(110)), ..Bench::default() }, &[("drdy_jitter", Warn)], &["us rms"]);
    finds(Bench { altered: Box::new(late(400)), ..Bench::default() }, &[("drdy_jitter", Fail)], &[]);
}

#[test]
fn inputs_that_are_dead_or_at_a_rail_are_named() {
    let railed = |input, _| if input == 3 || input == 9 { 4.5 } else { 0.0 };
    let findings = feels(railed).findings();
    let inputs = findings.iter().find(|check| check.name == "inputs").expect("a finding");
    assert_eq!(inputs.verdict, Fail);
    assert!(inputs.finding.contains("at the end of the scale: AIN3, AIN9"), "{}", inputs.finding);
    let absent = |event: &mut Event| {
        if let Event::Raw(raw) = event {
            raw.present &= !(1 << 5);
        }
    };
    finds(Bench { altered: Box::new(absent), ..Bench::default() }, &[("inputs", Fail)], &["never read: AIN5"]);
    // Without any noise every input is dead.
    finds(chip(|options| options.noise = false), &[("inputs", Fail)], &["dead, always the same code: AIN0, AIN1"]);
}

#[test]
fn noise_is_compared_with_the_datasheet_where_the_inputs_are_shorted() {
    // 4.5 uV of the chip and a square wave of so many more.
    let noisy = |uv: f64| {
        feels(move |input, t_s| if input == 6 && ((t_s * 1e4) as u64).is_multiple_of(2) { uv * 2e-6 } else { 0.0 })
    };
    for (uv, verdict) in [(8.0, Warn), (40.0, Fail)] {
        let findings = noisy(uv).findings();
        let noise = findings.iter().find(|check| check.name == "noise").expect("a finding");
        assert_eq!(noise.verdict, verdict, "{}", noise.finding);
        assert!(noise.finding.contains("AIN6"), "{}", noise.finding);
    }
    for inputs in [Inputs::Open, Inputs::InUse] {
        let findings = Bench { inputs, ..noisy(40.0) }.findings();
        let noise = findings.iter().find(|check| check.name == "noise").expect("a finding");
        assert_eq!(noise.verdict, Skipped);
    }
}

#[test]
fn mains_is_found_and_the_worst_input_named() {
    for (hz, uv, verdict) in [(50.0, 20.0, Warn), (60.0, 20.0, Warn), (100.0, 3000.0, Fail), (120.0, 3000.0, Fail)] {
        let hum = move |input, t_s: f64| {
            let share = if input == 11 { 1.0 } else { 0.3 };
            share * uv * 1e-6 * std::f64::consts::SQRT_2 * (TAU * hz * t_s + 1.0).sin()
        };
        let findings = Bench { inputs: Inputs::InUse, ..feels(hum) }.findings();
        let mains = findings.iter().find(|check| check.name == "mains").expect("a finding");
        assert_eq!(mains.verdict, verdict, "{}", mains.finding);
        assert!(mains.finding.contains(&format!("at {hz:.0} Hz on AIN11")), "{}", mains.finding);
        let most = mains.values[format!("uv_rms_at_{hz:.0}_hz")][11].as_f64().expect("a figure");
        assert!((most / uv - 1.0).abs() < 0.1, "{most} uV of {uv}");
        let open = Bench { inputs: Inputs::Open, ..feels(hum) }.findings();
        assert!(open.iter().any(|check| check.name == "mains" && check.verdict == Skipped));
    }
}

#[test]
fn commands_that_arrive_damaged_or_lose_bytes_are_counted() {
    // A bit of each thousandth byte; a lost byte behind each thousandth.
    let flips = |number: u64, byte| Received::Byte(if number % 1000 == 500 { byte ^ 4 } else { byte });
    finds(
        Bench { received: flips, ..Bench::default() },
        &[("commands", Warn)],
        &["71 of 71 answered", "arrived damaged"],
    );
    let overrun = |number: u64, byte| if number % 1000 == 500 { Received::Overrun(byte) } else { Received::Byte(byte) };
    finds(Bench { received: overrun, ..Bench::default() }, &[("commands", Fail)], &["bytes overrun"]);
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
    let bench = Bench { on_line: Box::new(on_line), ..Bench::default() };
    finds(bench, &[("losses", Fail)], &["2 packets lost", "1 packets damaged"]);
    finds(happens(Fault::EdgesLost { count: 3 }), &[("losses", Fail), ("faults", Fail)], &["3 conversions lost"]);
    let dropped = |health: &mut Health| {
        if health.frames > 900 {
            (health.messages_dropped, health.hops_skipped) = (2, 1)
        }
    };
    finds(reports(dropped), &[("losses", Fail)], &["2 messages dropped", "1 hops skipped"]);
    let bus = |chip: &mut Ads1258| chip.begin_fault(Fault::DoutFlip { bytes_ahead: 22, mask: 1 });
    finds(Bench { on_start: bus, ..Bench::default() }, &[("faults", Warn)], &["earlier: bus 1"]);
    finds(happens(Fault::DoutFlip { bytes_ahead: 2, mask: 1 }), &[("faults", Fail)], &["bus 1"]);
}

#[test]
fn every_page_exists_and_names_what_the_checks_are_called() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let checks = super::judge(&Default::default(), Inputs::InUse);
    assert_eq!(checks.len(), 23);
    let troubleshooting = std::fs::read_to_string(root.join(super::verdict::TROUBLESHOOTING)).expect("a page");
    for check in checks {
        assert!(root.join(check.page).is_file(), "{}", check.page);
        assert!(troubleshooting.contains(&format!("`{}`", check.name)), "{}", check.name);
    }
}

fn frames(codes: impl Fn(f64) -> f64) -> Vec<Raw> {
    let raw = |number: u32| {
        let t_s = f64::from(number) / f64::from(FRAME_RATE_HZ);
        let codes = [codes(t_s).round() as i32; TAXELS];
        Raw { t_us: (t_s * 1e6).round() as u64, number, present: u16::MAX, good: u16::MAX, codes }
    };
    (0..1500).map(raw).collect()
}

/// A tone has its rms, whatever its phase; drifts and tones 2 Hz away have none.
#[test]
fn a_line_is_measured_beside_drifts_and_other_tones() {
    let rate_hz = f64::from(FRAME_RATE_HZ);
    for phase in [0.0, 1.0, 2.5] {
        let frames =
            frames(|t_s| 1000.0 * (TAU * 50.0 * t_s + phase).sin() + 5000.0 * t_s + 3000.0 * (TAU * 8.3 * t_s).sin());
        let rms = line(&[&frames], 0, 50.0, rate_hz).expect("a line");
        assert!((rms - 1000.0 / 2f64.sqrt()).abs() < 2.0, "{rms}");
        for hz in [60.0, 100.0, 120.0] {
            let rms = line(&[&frames], 0, hz, rate_hz).expect("a line");
            assert!(rms < 2.0, "{rms} at {hz} Hz");
        }
    }
    assert_eq!(line(&[&frames(|_| 0.0)[..400]], 0, 50.0, rate_hz), None);
}

#[test]
fn jitter_is_what_a_straight_line_leaves() {
    let mut frames = frames(|_| 0.0);
    let clock = Clock::of(&frames).expect("a clock");
    assert!((clock.frame_rate_hz / f64::from(FRAME_RATE_HZ) - 1.0).abs() < 1e-6 && clock.jitter_rms_us < 0.4);
    for pair in frames.chunks_exact_mut(2) {
        pair[1].t_us += 20;
    }
    let clock = Clock::of(&frames).expect("a clock");
    assert!((clock.jitter_rms_us - 10.0).abs() < 0.1 && (clock.jitter_worst_us - 10.0).abs() < 1.0, "{clock:?}");
}
