//! Each check with the fault that it must find, then whole runs against a simulated board.

mod bench;
mod board;
mod conversation;

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

/// A check, its verdict and words of its finding, and the change to what a healthy board with
/// shorted inputs shows that causes it. No other check may warn or fail.
type Fault<T> = (&'static str, Verdict, &'static str, fn(&mut T));

/// Faults in the greeting.
const STARTS: [Fault<Hello>; 11] = [
    ("firmware", Warn, "0.0.9", |hello| hello.version = [0, 0, 9]),
    ("reset", Warn, "panic in tone/src/moments.rs:42", |hello| {
        hello.boot.record = Some(Record::of_panic(7, "tone/src/moments.rs", 42))
    }),
    ("reset", Warn, "hard_fault at 0x08001234", |hello| {
        hello.boot.record = Some(Record::of_hard_fault(7, 0x0800_1234, 0))
    }),
    ("reset", Warn, "watchdog", |hello| {
        hello.boot.cause = ResetCause::Watchdog
    }),
    ("reset", Skipped, "emulated", |hello| {
        hello.boot.cause = ResetCause::Unknown
    }),
    ("brown_out", Warn, "1.8 V", |hello| {
        hello.boot.brown_out = BrownOut::Off
    }),
    ("brown_out", Warn, "2.1 V", |hello| {
        hello.boot.brown_out = BrownOut::Level1
    }),
    ("brown_out", Warn, "2.4 V", |hello| {
        hello.boot.brown_out = BrownOut::Level2
    }),
    ("brown_out", Skipped, "", |hello| {
        hello.boot.brown_out = BrownOut::Unknown
    }),
    ("oscillator", Fail, "", |hello| {
        hello.boot.oscillator = Oscillator::Internal
    }),
    ("oscillator", Skipped, "", |hello| {
        hello.boot.oscillator = Oscillator::Unknown
    }),
];

/// Faults in the latest report of the board's health.
const REPORTS: [Fault<Health>; 22] = [
    ("load", Warn, "60.0 %", |health| health.load = 0.6),
    ("load", Fail, "90.0 %", |health| health.load = 0.9),
    ("load", Skipped, "", |health| health.load = 0.0),
    ("stack", Warn, "29000 of 32768 bytes", |health| {
        health.stack_used_bytes = 29_000
    }),
    ("stack", Fail, "", |health| health.stack_used_bytes = 32_000),
    ("stack", Skipped, "", |health| health.stack_bytes = 0),
    ("adc_restarts", Fail, "2 of them", |health| {
        health.chip_restarts = 2
    }),
    ("supply", Fail, "4.700 V", |health| health.supply_v = 4.7),
    ("supply", Fail, "5.300 V", |health| health.supply_v = 5.3),
    ("supply", Fail, "NaN", |health| health.supply_v = f32::NAN),
    ("reference", Warn, "1.50 %", |health| {
        health.reference_v *= 1.015
    }),
    ("reference", Fail, "2.500 V", |health| {
        health.reference_v = 2.5
    }),
    ("temperature", Warn, "70.0 C", |health| {
        health.temperature_c = 70.0
    }),
    ("temperature", Fail, "-60.0 C", |health| {
        health.temperature_c = -60.0
    }),
    ("offset", Warn, "-400.0 uV", |health| {
        health.offset_v = -400e-6
    }),
    ("offset", Fail, "+2000.0 uV", |health| {
        health.offset_v = 2e-3
    }),
    ("gain", Warn, "0.99", |health| health.gain = 0.99),
    ("gain", Fail, "1.05", |health| health.gain = 1.05),
    ("gain", Skipped, "no scan", |health| health.frames = 0),
    ("losses", Fail, "3 conversions lost", |health| {
        health.conversions_lost = 3
    }),
    ("losses", Fail, "2 messages dropped", |health| {
        health.messages_dropped = 2
    }),
    ("faults", Fail, "while watched: lost 1", |health| {
        health.faults[0] = 1
    }),
];

/// Faults in the time in which the board was only listened to, whose frames are among it.
const LISTENING: [Fault<Watched>; 26] = [
    ("adc_restarts", Warn, "0 of them", |watched| {
        (watched.before.chip_restarts, watched.after.chip_restarts) = (2, 2)
    }),
    ("frame_rate", Warn, "-300 ppm", |watched| {
        late_us(watched, |t_us| 0.3e-3 * t_us)
    }),
    ("frame_rate", Fail, "+800", |watched| {
        late_us(watched, |t_us| -7.94e-3 * t_us)
    }),
    ("drdy_jitter", Warn, "us rms", |watched| {
        late_us(watched, |t_us| 60.0 * (t_us % 2.0))
    }),
    ("drdy_jitter", Fail, "us rms", |watched| {
        late_us(watched, |t_us| 400.0 * (t_us % 2.0))
    }),
    ("drdy_jitter", Skipped, "restart of the scan", |watched| {
        watched.frames.truncate(200)
    }),
    ("inputs", Fail, "never read: AIN5", |watched| {
        watched
            .frames
            .iter_mut()
            .for_each(|frame| frame.present &= !(1 << 5))
    }),
    (
        "inputs",
        Fail,
        "dead, always the same code: AIN3",
        |watched| {
            watched
                .frames
                .iter_mut()
                .for_each(|frame| frame.codes[3] = 7)
        },
    ),
    ("inputs", Fail, "at the end of the scale: AIN2", |watched| {
        watched
            .frames
            .iter_mut()
            .for_each(|frame| frame.codes[2] = 0x7f_ffff)
    }),
    ("noise", Warn, "on AIN6", |watched| {
        add_line(watched, 6, 6.0, 119.0)
    }),
    ("noise", Fail, "on AIN6", |watched| {
        add_line(watched, 6, 60.0, 115.0)
    }),
    ("noise", Skipped, "touched all the time", |watched| {
        watched.touches_us = vec![(0, None)]
    }),
    ("mains", Warn, "at 50 Hz on AIN11", |watched| {
        add_line(watched, 11, 12.0, 50.0)
    }),
    ("mains", Warn, "at 60 Hz on AIN11", |watched| {
        add_line(watched, 11, 12.0, 60.0)
    }),
    ("mains", Fail, "at 100 Hz on AIN11", |watched| {
        add_line(watched, 11, 3e3, 100.0)
    }),
    ("mains", Fail, "at 120 Hz on AIN11", |watched| {
        add_line(watched, 11, 3e3, 120.0)
    }),
    ("mains", Skipped, "two seconds without a touch", |watched| {
        watched.frames.truncate(300)
    }),
    ("commands", Fail, "3 bytes overrun", |watched| {
        watched.before.bytes_overrun = 3
    }),
    ("commands", Warn, "2 arrived damaged", |watched| {
        watched.before.requests_damaged = 2
    }),
    ("losses", Fail, "2 packets lost", |watched| {
        watched.counts_after.missing += 2
    }),
    ("losses", Fail, "1 packets damaged", |watched| {
        watched.counts_after.damaged += 1
    }),
    ("losses", Fail, "1 steps back", |watched| {
        watched.counts_after.stepped_back += 1
    }),
    ("losses", Fail, "4 conversions doubtful", |watched| {
        watched.after.conversions_doubtful = 4
    }),
    ("losses", Fail, "1 overruns", |watched| {
        watched.after.overruns = 1
    }),
    ("losses", Fail, "1 restarts of the board", |watched| {
        watched.has_restarted = true
    }),
    ("faults", Warn, "earlier: lost 1", |watched| {
        (watched.before.faults[0], watched.after.faults[0]) = (1, 1)
    }),
];

/// Faults elsewhere in the run.
const RUNS: [Fault<Observations>; 13] = [
    ("firmware", Fail, "no greeting", |seen| seen.hello = None),
    ("noise", Skipped, "--inputs shorted only", |seen| {
        seen.inputs = Inputs::Open
    }),
    ("mains", Skipped, "not judged with open inputs", |seen| {
        seen.inputs = Inputs::Open
    }),
    ("commands", Fail, " answered", |seen| {
        seen.exchanged.as_mut().expect("commands").answered -= 1
    }),
    (
        "settings",
        Fail,
        "stored settings are not in force",
        |seen| kept(seen).found = None,
    ),
    ("settings", Fail, "not stored: worn", |seen| {
        kept(seen).failed = Some("worn".into())
    }),
    ("settings", Fail, "before is not restored: worn", |seen| {
        kept(seen).not_restored = Some("worn".into())
    }),
    (
        "settings",
        Warn,
        "stored anew; before: stored_before",
        |seen| hello(seen).source = SettingsSource::StoredBefore,
    ),
    (
        "settings",
        Warn,
        "cannot be read; before: damaged",
        |seen| (hello(seen).source, seen.kept) = (SettingsSource::Damaged, None),
    ),
    ("settings", Skipped, "--no-store", |seen| seen.kept = None),
    ("adc_id", Fail, "9B: bit 4 is set", |seen| {
        converter(seen).registers[9] = 0x9b
    }),
    ("adc_registers", Fail, "CONFIG1 83 instead of 31", |seen| {
        converter(seen).registers[1] = 0x83
    }),
    (
        "plan",
        Fail,
        "plan `hand` is not in force again, but `paper`: no answer",
        |seen| {
            let failed = Some("no answer".into());
            seen.lent = Some(Lent {
                plan: Scan::HAND,
                failed,
            })
        },
    ),
];

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

/// Adds a line of so many microvolts rms to an input.
fn add_line(watched: &mut Watched, input: usize, uv_rms: f64, hz: f64) {
    let amplitude = 2f64.sqrt() * uv_rms * 7_864_320.0 / 4.096e6;
    for frame in &mut watched.frames {
        let codes = amplitude * (TAU * hz * frame.t_us as f64 * 1e-6).sin();
        frame.codes[input] += codes.round() as i32;
    }
}

/// Names and verdicts of what warns or fails.
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
    let plan = Plan {
        stores: true,
        ..Bench::default().plan
    };
    let healthy = Bench {
        plan,
        ..Bench::default()
    }
    .observations();
    let checks = judge(&healthy);
    assert!(
        checks.iter().all(|check| check.verdict == Verdict::Pass),
        "{checks:#?}"
    );
    let mut found = Vec::new();
    let mut expect = |(name, verdict, words): (&'static str, _, _), seen: Observations| {
        let checks = judge(&seen);
        let mut others = wrong(&checks);
        // A line of 50 Hz is noise, too.
        others.retain(|other| other.0 != name && (name, other.0) != ("mains", "noise"));
        let check = find(&checks, name);
        let is_found = check.verdict == verdict && check.finding.contains(words);
        assert!(
            is_found && others.is_empty(),
            "{name}, {words:?}: {checks:#?}"
        );
        found.extend((verdict >= Warn).then_some(name));
    };
    let with = |happens: &dyn Fn(&mut Observations)| {
        let mut seen = healthy.clone();
        happens(&mut seen);
        seen
    };
    for (name, verdict, words, happens) in STARTS {
        expect((name, verdict, words), with(&|seen| happens(hello(seen))));
    }
    for (name, verdict, words, happens) in REPORTS {
        expect(
            (name, verdict, words),
            with(&|seen| happens(&mut watched(seen).after)),
        );
    }
    for (name, verdict, words, happens) in LISTENING {
        expect((name, verdict, words), with(&|seen| happens(watched(seen))));
    }
    for (name, verdict, words, happens) in RUNS {
        expect((name, verdict, words), with(&happens));
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

/// A line has its rms, whatever its phase; drifts and tones 2 Hz away have none.
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
