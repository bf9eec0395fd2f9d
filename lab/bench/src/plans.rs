//! Measures load and latency of the scan plans with the Feather's image on the emulator during a
//! slide.

use hal_mock::{Sliding, SlidingScene};
use ridgetone_emulator::{Board, Emulator, Image, Start};
use ridgetone_proto::command::{Command, Outcome, REQUEST_WIRE_MAX, Request};
use ridgetone_proto::framing;
use ridgetone_proto::plan::{Converters, Plan};
use ridgetone_proto::settings::Settings;
use ridgetone_proto::telemetry::{Decoder, Event, Span};
use serde_json::{Value, json};
use std::error::Error;

/// Window lengths, seconds. Each plan uses those that it allows, and its own maximum if this is
/// shorter than the last of them.
const WINDOWS_S: [f64; 5] = [0.032, 0.064, 0.128, 0.4, 1.0];
/// Frequency of the tone, Hz, within the band of every plan.
const TONE_HZ: f64 = 100.0;
/// Measuring time, seconds: enough for a few windows at any stride.
const WATCHED_S: f64 = 1.5;
/// Time from the report of the slide to the first window that counts, in addition to the window's
/// length, seconds: the scan and its strides may start late.
const SETTLED_S: f64 = 0.4;
/// Interval at which bytes are taken off the line, nanoseconds.
const STEP_NS: u64 = 10_000;
const CLOCK_HZ: f64 = 168e6;

struct Run {
    emulator: Emulator,
    decoder: Decoder,
}

impl Run {
    /// Runs for `seconds`. Returns the events, each with the time of its last byte in nanoseconds
    /// since power-up.
    fn run_s(&mut self, seconds: f64) -> Result<Vec<(u64, Event)>, Box<dyn Error>> {
        let end_ns = self.emulator.now_ns() + (seconds * 1e9) as u64;
        let mut events = Vec::new();
        while self.emulator.now_ns() < end_ns {
            self.emulator.run_ns(STEP_NS)?;
            let now_ns = self.emulator.now_ns();
            for byte in self.emulator.take_sent() {
                events.extend(self.decoder.push(byte).map(|packet| (now_ns, packet.event)));
            }
        }
        Ok(events)
    }

    fn run_to(
        &mut self,
        what: &str,
        limit_s: f64,
        is_it: impl Fn(&Event) -> bool,
    ) -> Result<(), Box<dyn Error>> {
        let end_ns = self.emulator.now_ns() + (limit_s * 1e9) as u64;
        while self.emulator.now_ns() < end_ns {
            if self.run_s(1e-3)?.iter().any(|(_, event)| is_it(event)) {
                return Ok(());
            }
        }
        Err(format!("no {what} within {limit_s} s").into())
    }
}

pub fn measure(image: &Image, fit_irq: u16) -> Result<Vec<Value>, Box<dyn Error>> {
    let mut rows = Vec::new();
    for (name, plan) in Plan::usual(Converters::ADS1258) {
        let longest_s = (f64::from(plan.window_max_s()) * 1e3).round() * 1e-3;
        let shortest_s = f64::from(plan.window_min_s());
        let last_s = longest_s.min(WINDOWS_S[WINDOWS_S.len() - 1]);
        let allowed = WINDOWS_S
            .into_iter()
            .filter(|window_s| (shortest_s..last_s).contains(window_s));
        for window_s in allowed.chain([last_s]) {
            let row = watch(image, fit_irq, plan, window_s);
            let [load, late_s] = row.map_err(|why| format!("{name}, {window_s} s: {why}"))?;
            rows.push(json!({
                "plan": name, "window_s": window_s, "channels": plan.channels(),
                "frame_rate_hz": plan.frame_rate_hz(), "load": load, "latency_s": window_s + late_s,
            }));
        }
    }
    Ok(rows)
}

/// Returns the fraction of time that the processor is awake, and the maximum time in seconds from a
/// window's end to the last byte of its estimate.
fn watch(
    image: &Image,
    fit_irq: u16,
    plan: Plan,
    window_s: f64,
) -> Result<[f64; 2], Box<dyn Error>> {
    let window = window_s as f32;
    let settings = Settings {
        window_s: window,
        stride_s: plan.default_stride(window),
        ..Settings::DEFAULT.with_plan(plan)
    };
    let slide_s = window_s + SETTLED_S + WATCHED_S + 1.0;
    let scene = Sliding {
        speed_mm_s: TONE_HZ,
        period_mm: 1.0,
        slide_mm: TONE_HZ * slide_s,
        snr_db: Some(20.0),
        overtones: [0.0; 3],
        hold_before_s: 1.0,
        ..Sliding::default()
    };
    let emulator = Emulator::new(
        Board::FeatherF405,
        image,
        SlidingScene::new(scene)?,
        Start::default(),
    )?;
    let mut run = Run {
        emulator,
        decoder: Decoder::new(),
    };
    run.run_to("greeting", 1.0, |event| matches!(event, Event::Hello(_)))?;
    // Device time starts at the first reading, and continues if the plan changes.
    let first = run.emulator.readings().first().map(|one| one.edge_ns);
    let zero_ns = first.ok_or("no conversion is read")?;
    let command = Command::Set {
        settings,
        keep: false,
    };
    let mut wire = [0; REQUEST_WIRE_MAX];
    let request = Request { number: 1, command };
    let length = framing::encode(&request, &mut wire).map_err(|_| "the request is too long")?;
    run.emulator.send(&wire[..length]);
    run.run_to(
        "reply",
        0.4,
        |event| matches!(event, Event::Reply(reply) if reply.outcome == Outcome::Done),
    )?;
    run.run_to("slide", 3.0, |event| matches!(event, Event::Slide(_)))?;
    run.run_s(window_s + SETTLED_S)?;
    let (before, lost) = (run.emulator.cycles(), run.emulator.adc().counters().lost);
    run.emulator.forget_served();
    let events = run.run_s(WATCHED_S)?;
    let after = run.emulator.cycles();
    let late_s = events.iter().filter_map(|(at_ns, event)| match event {
        Event::Estimate(one) if one.span == Span::Window => {
            Some((at_ns - zero_ns) as f64 * 1e-9 - one.t_us as f64 * 1e-6)
        }
        _ => None,
    });
    let late_s: Vec<f64> = late_s.collect();
    // A stride at either end may be incomplete.
    let strides = (WATCHED_S / f64::from(settings.stride_s)) as usize;
    if late_s.len() + 1 < strides {
        return Err(format!("{} estimates in {strides} strides", late_s.len()).into());
    }
    if run.emulator.adc().counters().lost != lost || !run.emulator.findings().is_empty() {
        return Err(format!("conversions are lost, or {:?}", run.emulator.findings()).into());
    }
    let longest_s = run.emulator.served(fit_irq).longest_run_cycles as f64 / CLOCK_HZ;
    if longest_s <= 0.0 {
        return Err("no fit ran".into());
    }
    let (cycles, asleep) = (after.0 - before.0, after.1 - before.1);
    let load = (cycles - asleep) as f64 / cycles as f64;
    Ok([load, late_s.into_iter().fold(0.0, f64::max)])
}
