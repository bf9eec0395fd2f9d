//! Tests the messages to the pages, and the analysis of raw frames for them.

use super::{packets, recorded};
use ridgetone_host::analysis::{curves, spectrum};
use ridgetone_host::feed::{Feed, FeedEvent, Following, Source};
use ridgetone_host::live::{Live, Strips};
use ridgetone_host::recording::Recorded;
use ridgetone_host::utc::Receipt;
use ridgetone_host::view::hub::Hub;
use ridgetone_proto::telemetry::{Event, Packet, Raw, WIRE_MAX, encode};
use serde_json::Value;
use std::f64::consts::TAU;
use std::time::Duration;

/// Device time in the middle of the default scene's slide.
const SLIDING_S: f64 = 3.0;

fn live() -> Live {
    let mut live = Live::new("a test");
    packets(SLIDING_S)
        .iter()
        .for_each(|packet| live.take(packet));
    live
}

/// Returns `values` times cosine and sine of `frequency_hz`, summed, times 2 / n: the components of
/// a line.
fn line(t_s: &[f64], values: &[f64], frequency_hz: f64) -> (f64, f64) {
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    let sum = |wave: fn(f64) -> f64| -> f64 {
        t_s.iter()
            .zip(values)
            .map(|(t_s, value)| (value - mean) * wave(TAU * frequency_hz * t_s))
            .sum()
    };
    let scale = 2.0 / values.len() as f64;
    (scale * sum(f64::cos), scale * sum(f64::sin))
}

/// Returns the frames in a time range: times, and volts of each taxel.
fn window(strips: &Strips, from_s: f64, until_s: f64) -> (Vec<f64>, Vec<Vec<f64>>) {
    let inside = || {
        strips
            .iter()
            .filter(|frame| frame.t_s >= from_s && frame.t_s <= until_s)
    };
    let volts = |taxel: usize| {
        inside()
            .map(|frame| f64::from(frame.volts[taxel].expect("a value")))
            .collect()
    };
    (
        inside().map(|frame| frame.t_s).collect(),
        (0..16).map(volts).collect(),
    )
}

fn about_line(t_s: &[f64], values: &[f64]) -> Vec<f64> {
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
    let (level, middle) = (mean(values), mean(t_s));
    let both = || t_s.iter().map(|t| t - middle).zip(values);
    let slope =
        both().map(|(t, v)| t * (v - level)).sum::<f64>() / both().map(|(t, _)| t * t).sum::<f64>();
    both().map(|(t, v)| v - level - slope * t).collect()
}

fn squares(values: &[f64]) -> f64 {
    values.iter().map(|v| v * v).sum()
}

fn power(values: &[f64], angle: impl Fn(usize) -> f64) -> f64 {
    let sum = |wave: fn(f64) -> f64| -> f64 {
        let waves = (0..values.len()).map(|n| values[n] * wave(angle(n)));
        waves.sum()
    };
    sum(f64::cos).powi(2) + sum(f64::sin).powi(2)
}

#[test]
fn the_spectrum_is_that_of_a_plain_fourier_sum_over_the_latest_window() {
    let live = live();
    let found = spectrum(&live).expect("a spectrum");
    let estimate = live.estimate().expect("an estimate");
    assert!(found.of_estimate && (found.until_s - estimate.t_us as f64 / 1e6).abs() < 1e-4);
    let (t_s, volts) = window(&live.strips, found.from_s - 1e-4, found.until_s + 1e-4);
    assert_eq!(t_s.len(), 241);
    assert!((found.strongest_hz.expect("a line") - f64::from(estimate.frequency)).abs() < 0.1);
    let frames = t_s.len() as f64;
    for bin in [5, 8, 9, 18, 27, 50, 100] {
        let hz = bin as f64 * found.bin_hz;
        let fraction = |values: &Vec<f64>| {
            let rest = about_line(&t_s, values);
            power(&rest, |n| TAU * hz * (t_s[n] - t_s[0])) / squares(&rest)
        };
        let power = volts.iter().map(fraction).sum::<f64>() / (16.0 * 0.5 * frames);
        let db = 10.0 * power.log10();
        assert!(
            (f64::from(found.power_db[bin]) - db).abs() < 0.1,
            "bin {bin}: {} and {db}",
            found.power_db[bin]
        );
    }
    let peak = found
        .power_db
        .iter()
        .copied()
        .fold(f32::NEG_INFINITY, f32::max);
    assert!((-3.0..=0.0).contains(&peak), "{peak}");
    // The reported tone and its harmonics must be marked, and the noise next to it must be far
    // below.
    assert_eq!(found.lines.len(), usize::from(estimate.harmonics));
    for (line, k) in found.lines.iter().zip(1..) {
        assert!((line.frequency_hz / f64::from(estimate.frequency) - f64::from(k)).abs() < 1e-6);
    }
    let rest = curves(&live)
        .expect("curves")
        .residual_spectrum
        .expect("noise beside the line");
    assert!(
        (found.lines[0].power_db - peak).abs() < 1.0 && rest.power_db.len() == found.power_db.len()
    );
    let hz = f64::from(estimate.frequency);
    assert!(
        (rest.until_hz - hz - 5.0).abs() < 0.1 && (rest.from_hz - (hz - 5.0).max(0.0)).abs() < 0.1
    );
    // The scene's noise is white, so its fraction of the power, from the board's residuals, is
    // spread over 120 bins.
    let of = |power: f32| power.powi(2);
    let fraction = |c: &ridgetone_proto::telemetry::Channel| {
        of(c.residual_v) / (0.5 * of(c.amplitude_v) + of(c.residual_v))
    };
    let fractions = estimate.channels.iter().map(fraction).sum::<f32>() / 16.0;
    let expected_db = 10.0 * (fractions / 120.0).log10();
    assert!(
        (rest.noise_db - expected_db).abs() < 3.0,
        "{} and {expected_db}",
        rest.noise_db
    );
    // Compares with a plain Fourier sum over the residual of the curves.
    let curves = curves(&live).expect("curves");
    for bin in [3, 9, 40, 100] {
        let power: f64 = (0..16)
            .map(|taxel| {
                let (read, fit) = (
                    &curves.read_v[taxel],
                    curves.fit_v[taxel].as_ref().expect("a fit"),
                );
                let read: Vec<f64> = read
                    .iter()
                    .map(|v| f64::from(v.expect("a value")))
                    .collect();
                let left = read
                    .iter()
                    .zip(fit)
                    .map(|(read, fit)| read - f64::from(*fit));
                let left: Vec<f64> = left.collect();
                power(&left, |n| TAU * bin as f64 * n as f64 / 256.0)
                    / squares(&about_line(&t_s, &read))
            })
            .sum();
        let db = 10.0 * (power / (0.5 * frames * 16.0)).log10();
        assert!(
            (f64::from(rest.power_db[bin]) - db).abs() < 0.2,
            "bin {bin}: {} and {db}",
            rest.power_db[bin]
        );
    }
}

#[test]
fn the_curves_leave_nothing_of_the_fundamental_in_any_channel() {
    let live = live();
    let estimate = live.estimate().expect("an estimate");
    let curves = curves(&live).expect("curves");
    assert_eq!(curves.t_s.len(), 241);
    for channel in &estimate.channels {
        let taxel = usize::from(channel.taxel);
        // The curves include all harmonics and a curved baseline, so their residual must match the
        // board's.
        let residual_v = curves.residual_v[taxel].expect("a residual");
        let fraction = residual_v / channel.residual_v;
        assert!(
            (0.93..1.07).contains(&fraction),
            "taxel {taxel}: {fraction} of the board's residual"
        );
        let harmonics = curves.harmonics[taxel].as_ref().expect("harmonics");
        let fraction = harmonics[0].amplitude_v / channel.amplitude_v;
        assert!(
            harmonics.len() == usize::from(estimate.harmonics) && (fraction - 1.0).abs() < 0.01,
            "{fraction}"
        );
        let turn = f64::from(harmonics[0].phase_rad - channel.phase_rad) / TAU;
        assert!(
            (turn - turn.round()).abs() < 0.005,
            "taxel {taxel}: {turn} turns off the board's phase"
        );
        let tone = curves.tone_v[taxel].as_ref().expect("a curve");
        let rest: Vec<f64> = curves.read_v[taxel]
            .iter()
            .zip(tone)
            .map(|(read, tone)| f64::from(read.expect("a value")) - f64::from(*tone))
            .collect();
        let (cos, sin) = line(&curves.t_s, &rest, f64::from(estimate.frequency));
        let left = cos.hypot(sin) / f64::from(channel.amplitude_v);
        // If the curve ignored the scan's skew, a fifth of the tone would remain in the last taxel.
        assert!(left < 0.03, "taxel {taxel}: {left}");
    }
    // The first frames of a whole slide may already be gone.
    let mut over = Live::new("a test");
    packets(f64::INFINITY)
        .iter()
        .for_each(|packet| over.take(packet));
    let slide_s = over.whole_slide().expect("a slide").t_us as f64 / 1e6;
    let mut later = Strips::default();
    over.strips
        .iter()
        .filter(|frame| frame.t_s > slide_s - 0.5)
        .for_each(|frame| later.push(*frame));
    over.strips = later;
    let found = ridgetone_host::analysis::curves(&over).expect("those that are there");
    assert!(
        (119..123).contains(&found.t_s.len()) && found.t_s.iter().all(|t_s| *t_s < slide_s + 0.003)
    );
    assert!(!spectrum(&over).expect("of the latest frames").of_estimate);
}

#[test]
fn without_raw_frames_there_is_neither() {
    let mut live = Live::new("a test");
    packets(SLIDING_S)
        .iter()
        .filter(|packet| !matches!(packet.event, Event::Raw(_)))
        .for_each(|packet| live.take(packet));
    assert!(live.estimate().is_some() && spectrum(&live).is_none() && curves(&live).is_none());
}

fn json(text: &str) -> Value {
    serde_json::from_str(text).expect("JSON")
}

/// Applies an update as the page does (`host/assets/view/model.js`).
fn add(early: &mut Value, update: &Value) {
    let live = &mut early["live"];
    let extend = |to: &mut Value, new: &Value| {
        to.as_array_mut()
            .expect("a list")
            .extend(new.as_array().expect("a list").iter().cloned());
    };
    extend(&mut live["history"], &update["points"]);
    for name in ["t_s", "number"] {
        extend(&mut live["strips"][name], &update["strips"][name]);
    }
    for taxel in 0..16 {
        extend(
            &mut live["strips"]["volts"][taxel],
            &update["strips"]["volts"][taxel],
        );
    }
    if !update["log"].is_null() {
        live["log"] = update["log"].clone();
    }
    for (name, value) in update["live"].as_object().expect("an object") {
        if !["history", "strips", "log"].contains(&name.as_str()) {
            live[name.as_str()] = value.clone();
        }
    }
    early["update"] = update["update"].clone();
}

#[test]
fn updates_make_of_an_early_state_what_a_late_one_is() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = recorded(folder.path(), &packets(SLIDING_S));
    let source = Recorded::open(&path).expect("a recording");
    let mut following = Following::new(Feed::new(source), None);
    let hub = Hub::new(following.live());
    let (state, mut updates) = hub.join(0).expect("a state");
    let mut early = json(&state.json);
    assert_eq!(
        (
            state.kind,
            &early["status"]
                .as_str()
                .map(|status| status.starts_with("Nothing was received"))
        ),
        ("state", &Some(true))
    );
    let mut events = 0;
    loop {
        let event = following.next(Duration::ZERO).expect("a feed");
        hub.take(event.as_ref(), &mut following);
        events += 1;
        if events % 50 == 0 {
            hub.publish().expect("published");
        }
        while let Ok(message) = updates.try_recv() {
            assert_eq!(message.kind, "update");
            add(&mut early, &json(&message.json));
        }
        if event == Some(FeedEvent::Over) {
            break;
        }
    }
    hub.publish().expect("published");
    let last = json(&updates.try_recv().expect("an update").json);
    add(&mut early, &last);
    assert_eq!(last["live"]["connection"]["state"], "over");
    assert!(
        last["no_raw"]
            .as_str()
            .is_some_and(|why| why.contains("recording"))
    );
    let late = json(&hub.join(0).expect("a state").0.json);
    let frames = early["live"]["strips"]["number"]
        .as_array()
        .expect("a list")
        .len();
    assert!(frames > 650, "{frames}");
    for name in ["strips", "history", "log", "phase", "latest"] {
        assert_eq!(early["live"][name], late["live"][name], "{name}");
    }
    assert_eq!(late["places"][1], json("[3, 2, 7, 6]"));
}

/// A board whose frames come every 10 ms and are received without delay, except that the second
/// half is late by `late_s`.
struct Paused {
    next: u32,
    late_s: f64,
}

impl Paused {
    const HALF: u32 = 300;

    fn receipt_s(&self, number: u32) -> f64 {
        let late_s = if number < Self::HALF {
            0.0
        } else {
            self.late_s
        };
        1.7e9 + 0.01 * f64::from(number) + late_s
    }
}

impl Source for Paused {
    fn name(&self) -> String {
        "paused".into()
    }

    fn next(&mut self, _: Duration) -> anyhow::Result<Option<FeedEvent<Vec<u8>>>> {
        let number = self.next;
        self.next += 1;
        let raw = Raw {
            t_us: u64::from(number) * 10_000,
            number,
            present: 1,
            good: 1,
            codes: [0; 16],
        };
        let mut wire = [0; WIRE_MAX];
        let used = encode(
            &Packet {
                sequence: number as u16,
                event: Event::Raw(raw),
            },
            &mut wire,
        )?;
        Ok(Some(FeedEvent::Data(wire[..used].to_vec())))
    }

    fn receipt(&self) -> Option<Receipt> {
        Some(Receipt {
            utc_ns: (1e9 * self.receipt_s(self.next - 1)) as u64,
            byte_s: 0.0,
        })
    }

    fn send(&mut self, _: &[u8]) -> anyhow::Result<()> {
        Ok(())
    }
}

#[test]
fn after_a_pause_of_the_board_s_clock_its_times_are_not_those_of_before() {
    let late_s = 75.0;
    let mut following = Following::new(Feed::new(Paused { next: 0, late_s }), None);
    let hub = Hub::new(following.live());
    let (_, mut packets) = hub.join_packets();
    let mut dated = |count: u32| -> Vec<f64> {
        (0..count)
            .filter_map(|_| {
                let event = following.next(Duration::ZERO).expect("a feed");
                hub.take(event.as_ref(), &mut following);
                let line = json(&packets.try_recv().ok()?);
                Some(line["received_utc_s"].as_f64()? - line["utc_s"].as_f64()?)
            })
            .collect()
    };
    let before = dated(Paused::HALF);
    assert!(before.len() > 200 && before.iter().all(|apart_s| apart_s.abs() < 0.01));
    hub.forget_clock();
    let after = dated(Paused::HALF);
    assert!(
        after.len() > 200 && after.iter().all(|apart_s| apart_s.abs() < 0.01),
        "{:?}",
        after.last()
    );
}
