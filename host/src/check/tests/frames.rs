//! Frames: their rate and times, dead inputs, noise, mains.

use super::bench::Bench;
use super::{Fail, Skipped, Warn, chip, feels, finds};
use crate::check::Inputs;
use crate::check::signals::{Clock, line};
use ridgetone_proto::settings::{FRAME_RATE_HZ, TAXELS};
use ridgetone_proto::telemetry::{Event, Raw};
use std::f64::consts::TAU;

#[test]
fn the_scans_rate_and_the_times_of_its_edges_are_judged() {
    let off = |ppm| chip(|options| options.clock_error_ppm = ppm);
    finds(off(-300.0), &[("frame_rate", Warn)], &["-300 ppm"]);
    finds(
        off(8000.0),
        &[("frame_rate", Fail), ("faults", Fail)],
        &["+8000 ppm"],
    );
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
    finds(
        Bench {
            altered: Box::new(late(110)),
            ..Bench::default()
        },
        &[("drdy_jitter", Warn)],
        &["us rms"],
    );
    finds(
        Bench {
            altered: Box::new(late(400)),
            ..Bench::default()
        },
        &[("drdy_jitter", Fail)],
        &[],
    );
}

#[test]
fn inputs_that_are_dead_or_at_a_rail_are_named() {
    let railed = |input, _| if input == 3 || input == 9 { 4.5 } else { 0.0 };
    let findings = feels(railed).findings();
    let inputs = findings
        .iter()
        .find(|check| check.name == "inputs")
        .expect("a finding");
    assert_eq!(inputs.verdict, Fail);
    assert!(
        inputs
            .finding
            .contains("at the end of the scale: AIN3, AIN9"),
        "{}",
        inputs.finding
    );
    let absent = |event: &mut Event| {
        if let Event::Raw(raw) = event {
            raw.present &= !(1 << 5);
        }
    };
    finds(
        Bench {
            altered: Box::new(absent),
            ..Bench::default()
        },
        &[("inputs", Fail)],
        &["never read: AIN5"],
    );
    // Without any noise every input is dead.
    finds(
        chip(|options| options.noise = false),
        &[("inputs", Fail)],
        &["dead, always the same code: AIN0, AIN1"],
    );
}

#[test]
fn noise_is_compared_with_the_datasheet_where_the_inputs_are_shorted() {
    // 4.5 uV of the chip, and a square wave of `uv` microvolts.
    let noisy = |uv: f64| {
        feels(move |input, t_s| {
            if input == 6 && ((t_s * 1e4) as u64).is_multiple_of(2) {
                uv * 2e-6
            } else {
                0.0
            }
        })
    };
    for (uv, verdict) in [(8.0, Warn), (40.0, Fail)] {
        let findings = noisy(uv).findings();
        let noise = findings
            .iter()
            .find(|check| check.name == "noise")
            .expect("a finding");
        assert_eq!(noise.verdict, verdict, "{}", noise.finding);
        assert!(noise.finding.contains("AIN6"), "{}", noise.finding);
    }
    for inputs in [Inputs::Open, Inputs::InUse] {
        let findings = Bench {
            inputs,
            ..noisy(40.0)
        }
        .findings();
        let noise = findings
            .iter()
            .find(|check| check.name == "noise")
            .expect("a finding");
        assert_eq!(noise.verdict, Skipped);
    }
}

#[test]
fn mains_is_found_and_the_worst_input_named() {
    for (hz, uv, verdict) in [
        (50.0, 20.0, Warn),
        (60.0, 20.0, Warn),
        (100.0, 3000.0, Fail),
        (120.0, 3000.0, Fail),
    ] {
        let hum = move |input, t_s: f64| {
            let share = if input == 11 { 1.0 } else { 0.3 };
            share * uv * 1e-6 * std::f64::consts::SQRT_2 * (TAU * hz * t_s + 1.0).sin()
        };
        let findings = Bench {
            inputs: Inputs::InUse,
            ..feels(hum)
        }
        .findings();
        let mains = findings
            .iter()
            .find(|check| check.name == "mains")
            .expect("a finding");
        assert_eq!(mains.verdict, verdict, "{}", mains.finding);
        assert!(
            mains.finding.contains(&format!("at {hz:.0} Hz on AIN11")),
            "{}",
            mains.finding
        );
        let most = mains.values[format!("uv_rms_at_{hz:.0}_hz")][11]
            .as_f64()
            .expect("a figure");
        assert!((most / uv - 1.0).abs() < 0.1, "{most} uV of {uv}");
        let open = Bench {
            inputs: Inputs::Open,
            ..feels(hum)
        }
        .findings();
        assert!(
            open.iter()
                .any(|check| check.name == "mains" && check.verdict == Skipped)
        );
    }
}

fn frames(codes: impl Fn(f64) -> f64) -> Vec<Raw> {
    let raw = |number: u32| {
        let t_s = f64::from(number) / f64::from(FRAME_RATE_HZ);
        let codes = [codes(t_s).round() as i32; TAXELS];
        Raw {
            t_us: (t_s * 1e6).round() as u64,
            number,
            present: u16::MAX,
            good: u16::MAX,
            codes,
        }
    };
    (0..1500).map(raw).collect()
}

/// A tone has its rms, whatever its phase; drifts and tones 2 Hz away have none.
#[test]
fn a_line_is_measured_beside_drifts_and_other_tones() {
    let rate_hz = f64::from(FRAME_RATE_HZ);
    for phase in [0.0, 1.0, 2.5] {
        let frames = frames(|t_s| {
            1000.0 * (TAU * 50.0 * t_s + phase).sin()
                + 5000.0 * t_s
                + 3000.0 * (TAU * 8.3 * t_s).sin()
        });
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
    assert!(
        (clock.frame_rate_hz / f64::from(FRAME_RATE_HZ) - 1.0).abs() < 1e-6
            && clock.jitter_rms_us < 0.4
    );
    for pair in frames.chunks_exact_mut(2) {
        pair[1].t_us += 20;
    }
    let clock = Clock::of(&frames).expect("a clock");
    assert!(
        (clock.jitter_rms_us - 10.0).abs() < 0.1 && (clock.jitter_worst_us - 10.0).abs() < 1.0,
        "{clock:?}"
    );
}
