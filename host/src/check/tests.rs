//! Runs each check on the fault that it must find, then whole runs against a simulated board.

mod bench;
mod runs;

use super::observations::Lent;
use super::signals::{Clock, line};
use super::table::TROUBLESHOOTING;
use super::{Check, Inputs, Kept, Observations, Plan, Verdict, Watched, judge};
use bench::Bench;
use ridgetone_proto::boot::{BrownOut, Oscillator, Record, ResetCause, SettingsSource};
use ridgetone_proto::plan::Plan as Scan;
use ridgetone_proto::settings::{FRAME_RATE_HZ, TAXELS};
use ridgetone_proto::telemetry::{ConverterState, Health, Hello, Raw};
use std::f64::consts::TAU;
use std::path::Path;

use Verdict::{Fail, Skipped, Warn};

/// A check, its verdict and part of its finding, and the change to the observations of a healthy
/// board with shorted inputs. No other check may warn or fail.
type Fault = (&'static str, Verdict, &'static str, fn(&mut Observations));

/// One line per fault: the observations to change, the check with its verdict and part of its
/// finding, and the change.
macro_rules! faults {
    ($($part:ident: $name:literal $verdict:ident $words:literal => $change:expr;)*) => {
        vec![$(($name, $verdict, $words, |seen| {
            let $part = $part(seen);
            $change;
        })),*]
    };
}

fn faults() -> Vec<Fault> {
    faults! {
        seen: "firmware" Fail "no greeting" => seen.hello = None;
        hello: "firmware" Warn "0.0.9" => hello.version = [0, 0, 9];
        hello: "reset" Warn "panic in tone/src/moments.rs:42" => hello.boot.record = Some(Record::of_panic(7, "tone/src/moments.rs", 42));
        hello: "reset" Warn "hard_fault at 0x08001234" => hello.boot.record = Some(Record::of_hard_fault(7, 0x0800_1234, 0));
        hello: "reset" Warn "oscillator stopped in the run before, 2.5 s" => hello.boot.record = Some(Record::of_oscillator(2_500_000));
        hello: "reset" Warn "watchdog" => hello.boot.cause = ResetCause::Watchdog;
        hello: "reset" Skipped "does not report" => hello.boot.cause = ResetCause::Unknown;
        hello: "brown_out" Warn "1.8 V" => hello.boot.brown_out = BrownOut::Off;
        hello: "brown_out" Warn "2.1 V" => hello.boot.brown_out = BrownOut::Level1;
        hello: "brown_out" Warn "2.4 V" => hello.boot.brown_out = BrownOut::Level2;
        hello: "brown_out" Skipped "" => hello.boot.brown_out = BrownOut::Unknown;
        hello: "oscillator" Fail "" => hello.boot.oscillator = Oscillator::Internal;
        hello: "oscillator" Skipped "" => hello.boot.oscillator = Oscillator::Unknown;
        health: "load" Warn "60.0 %" => health.load = 0.6;
        health: "load" Fail "90.0 %" => health.load = 0.9;
        health: "load" Skipped "" => health.load = 0.0;
        health: "stack" Warn "29000 of 32768 bytes" => health.stack_used_bytes = 29_000;
        health: "stack" Fail "" => health.stack_used_bytes = 32_000;
        health: "stack" Skipped "" => health.stack_bytes = 0;
        converter: "adc_id" Fail "9B: bit 4 is set" => converter.registers[9] = 0x9b;
        converter: "adc_registers" Fail "CONFIG1 83 instead of 31" => converter.registers[1] = 0x83;
        health: "adc_restarts" Fail "2 of them" => health.chip_restarts = 2;
        watched: "adc_restarts" Warn "0 of them" => (watched.before.chip_restarts, watched.after.chip_restarts) = (2, 2);
        health: "supply" Fail "4.700 V" => health.supply_v = 4.7;
        health: "supply" Fail "5.300 V" => health.supply_v = 5.3;
        health: "supply" Fail "NaN" => health.supply_v = f32::NAN;
        health: "reference" Warn "1.50 %" => health.reference_v *= 1.015;
        health: "reference" Fail "2.500 V" => health.reference_v = 2.5;
        health: "temperature" Warn "70.0 C" => health.temperature_c = 70.0;
        health: "temperature" Fail "-60.0 C" => health.temperature_c = -60.0;
        health: "offset" Warn "-400.0 uV" => health.offset_v = -400e-6;
        health: "offset" Fail "+2000.0 uV" => health.offset_v = 2e-3;
        health: "gain" Warn "0.99" => health.gain = 0.99;
        health: "gain" Fail "1.05" => health.gain = 1.05;
        health: "gain" Skipped "no scan" => health.frames = 0;
        watched: "frame_rate" Warn "-300 ppm" => late_us(watched, |t_us| 0.3e-3 * t_us);
        watched: "frame_rate" Fail "+800" => late_us(watched, |t_us| -7.94e-3 * t_us);
        watched: "drdy_jitter" Warn "us rms" => late_us(watched, |t_us| 60.0 * (t_us % 2.0));
        watched: "drdy_jitter" Fail "us rms" => late_us(watched, |t_us| 400.0 * (t_us % 2.0));
        watched: "drdy_jitter" Skipped "restart of the scan" => watched.frames.truncate(200);
        watched: "inputs" Fail "never read: AIN5" => watched.frames.iter_mut().for_each(|frame| frame.present &= !(1 << 5));
        watched: "inputs" Fail "dead, always the same code: AIN3" => watched.frames.iter_mut().for_each(|frame| frame.codes[3] = 7);
        watched: "inputs" Fail "at the end of the scale: AIN2" => watched.frames.iter_mut().for_each(|frame| frame.codes[2] = 0x7f_ffff);
        watched: "noise" Warn "on AIN6" => add_line(watched, 6, 6.0, 119.0);
        watched: "noise" Fail "on AIN6" => add_line(watched, 6, 60.0, 115.0);
        watched: "noise" Skipped "touched all the time" => watched.touches_us = vec![(0, None)];
        seen: "noise" Skipped "--inputs shorted only" => seen.inputs = Inputs::Open;
        watched: "mains" Warn "at 50 Hz on AIN11" => add_line(watched, 11, 12.0, 50.0);
        watched: "mains" Warn "at 60 Hz on AIN11" => add_line(watched, 11, 12.0, 60.0);
        watched: "mains" Fail "at 100 Hz on AIN11" => add_line(watched, 11, 3e3, 100.0);
        watched: "mains" Fail "at 120 Hz on AIN11" => add_line(watched, 11, 3e3, 120.0);
        watched: "mains" Skipped "two seconds without a touch" => watched.frames.truncate(300);
        seen: "mains" Skipped "not judged with open inputs" => seen.inputs = Inputs::Open;
        seen: "commands" Fail " answered" => seen.exchanged.as_mut().expect("commands").answered -= 1;
        watched: "commands" Fail "3 bytes overrun" => watched.before.bytes_overrun = 3;
        watched: "commands" Warn "2 arrived damaged" => watched.before.requests_damaged = 2;
        kept: "settings" Fail "stored settings are not in force" => kept.found = None;
        kept: "settings" Fail "not stored: worn" => kept.failed = Some("worn".into());
        kept: "settings" Fail "before is not restored: worn" => kept.not_restored = Some("worn".into());
        hello: "settings" Warn "stored anew; before: stored_before" => hello.source = SettingsSource::StoredBefore;
        seen: "settings" Warn "cannot be read; before: damaged" => (hello(seen).source, seen.kept) = (SettingsSource::Damaged, None);
        seen: "settings" Skipped "--no-store" => seen.kept = None;
        watched: "losses" Fail "2 packets lost" => watched.counts_after.missing += 2;
        watched: "losses" Fail "1 packets damaged" => watched.counts_after.damaged += 1;
        watched: "losses" Fail "1 steps back" => watched.counts_after.stepped_back += 1;
        health: "losses" Fail "3 conversions lost" => health.conversions_lost = 3;
        watched: "losses" Fail "4 conversions doubtful" => watched.after.conversions_doubtful = 4;
        health: "losses" Fail "2 messages dropped" => health.messages_dropped = 2;
        watched: "losses" Fail "1 overruns" => watched.after.overruns = 1;
        watched: "losses" Fail "1 restarts of the board" => watched.has_restarted = true;
        health: "faults" Fail "while watched: lost 1" => health.faults[0] = 1;
        watched: "faults" Warn "earlier: lost 1" => (watched.before.faults[0], watched.after.faults[0]) = (1, 1);
        seen: "plan" Fail "plan `hand` is not in force again, but `paper`: no answer" => seen.lent = Some(Lent { plan: Scan::HAND, failed: Some("no answer".into()) });
    }
}

fn seen(seen: &mut Observations) -> &mut Observations {
    seen
}

fn health(seen: &mut Observations) -> &mut Health {
    &mut watched(seen).after
}

fn converter(seen: &mut Observations) -> &mut ConverterState {
    seen.converter.as_mut().expect("a report of the converter")
}

fn hello(seen: &mut Observations) -> &mut Hello {
    seen.hello.as_mut().expect("a greeting")
}

fn watched(seen: &mut Observations) -> &mut Watched {
    seen.watched.as_mut().expect("a watch")
}

fn kept(seen: &mut Observations) -> &mut Kept {
    seen.kept.as_mut().expect("stored settings")
}

/// Delays each frame by a function of its time, both in microseconds.
fn late_us(watched: &mut Watched, late_us: fn(f64) -> f64) {
    for frame in &mut watched.frames {
        let late_us = late_us(frame.t_us as f64).round();
        frame.t_us = frame.t_us.saturating_add_signed(late_us as i64);
    }
}

fn add_line(watched: &mut Watched, input: usize, uv_rms: f64, hz: f64) {
    let amplitude = 2f64.sqrt() * uv_rms * 7_864_320.0 / 4.096e6;
    for frame in &mut watched.frames {
        let codes = amplitude * (TAU * hz * frame.t_us as f64 * 1e-6).sin();
        frame.codes[input] += codes.round() as i32;
    }
}

/// Returns names and verdicts of the checks that warn or fail.
fn wrong(checks: &[Check]) -> Vec<(&'static str, Verdict)> {
    let wrong = checks
        .iter()
        .filter(|check| matches!(check.verdict, Warn | Fail));
    wrong.map(|check| (check.name, check.verdict)).collect()
}

fn find<'a>(checks: &'a [Check], name: &str) -> &'a Check {
    checks.iter().find(|check| check.name == name).expect(name)
}

#[test]
fn each_check_finds_its_fault_and_no_other_one_does() {
    let healthy = Bench::with(|bench| bench.plan.stores = true).observations();
    let checks = judge(&healthy);
    assert!(
        checks.iter().all(|check| check.verdict == Verdict::Pass),
        "{checks:#?}"
    );
    let mut found = Vec::new();
    for (name, verdict, words, happens) in faults() {
        let mut seen = healthy.clone();
        happens(&mut seen);
        let checks = judge(&seen);
        let mut others = wrong(&checks);
        // A line of 50 Hz also raises the noise.
        others.retain(|other| other.0 != name && (name, other.0) != ("mains", "noise"));
        let check = find(&checks, name);
        let is_found = check.verdict == verdict && check.finding.contains(words);
        assert!(
            is_found && others.is_empty(),
            "{name}, {words:?}: {checks:#?}"
        );
        found.extend((verdict >= Warn).then_some(name));
    }
    for row in &super::table::TABLE {
        assert!(found.contains(&row.name), "{} has no fault", row.name);
    }
}

#[test]
fn every_page_exists_and_names_the_checks() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let file = |link: &str| root.join(link.split('#').next().unwrap_or_default());
    let troubleshooting = std::fs::read_to_string(file(TROUBLESHOOTING)).expect("a page");
    assert_eq!(judge(&Observations::default()).len(), 23);
    for row in &super::table::TABLE {
        assert!(file(row.page).is_file(), "{}", row.page);
        assert!(
            troubleshooting.contains(&format!("`{}`", row.name)),
            "{}",
            row.name
        );
    }
}

fn simulated_frames(codes: impl Fn(f64) -> f64) -> Vec<Raw> {
    let raw = |number: u32| {
        let t_s = f64::from(number) / f64::from(FRAME_RATE_HZ);
        Raw {
            t_us: (t_s * 1e6).round() as u64,
            number,
            present: u16::MAX,
            good: u16::MAX,
            codes: [codes(t_s).round() as i32; TAXELS],
        }
    };
    (0..1500).map(raw).collect()
}

/// A line is measured with its RMS value at any phase; drifts and tones 2 Hz away do not count.
#[test]
fn a_line_is_measured_next_to_drifts_and_other_tones() {
    let rate_hz = f64::from(FRAME_RATE_HZ);
    for phase in [0.0, 1.0, 2.5] {
        let line_at = |t_s: f64| 1000.0 * (TAU * 50.0 * t_s + phase).sin();
        let others_at = |t_s: f64| 5000.0 * t_s + 3000.0 * (TAU * 8.3 * t_s).sin();
        let frames = simulated_frames(|t_s| line_at(t_s) + others_at(t_s));
        let rms = line(&[&frames], 0, 50.0, rate_hz).expect("a line");
        assert!((rms - 1000.0 / 2f64.sqrt()).abs() < 2.0, "{rms}");
        for hz in [60.0, 100.0, 120.0] {
            let rms = line(&[&frames], 0, hz, rate_hz).expect("a line");
            assert!(rms < 2.0, "{rms} at {hz} Hz");
        }
    }
    assert_eq!(
        line(&[&simulated_frames(|_| 0.0)[..400]], 0, 50.0, rate_hz),
        None
    );
}

#[test]
fn jitter_is_what_a_straight_line_leaves() {
    let mut frames = simulated_frames(|_| 0.0);
    let clock = Clock::of(&frames).expect("a clock");
    let off = clock.frame_rate_hz / f64::from(FRAME_RATE_HZ) - 1.0;
    assert!(off.abs() < 1e-6 && clock.jitter_rms_us < 0.4, "{clock:?}");
    for pair in frames.chunks_exact_mut(2) {
        pair[1].t_us += 20;
    }
    let clock = Clock::of(&frames).expect("a clock");
    assert!((clock.jitter_rms_us - 10.0).abs() < 0.1, "{clock:?}");
    assert!((clock.jitter_worst_us - 10.0).abs() < 1.0, "{clock:?}");
}
