//! `demo`: a scene through the emulated firmware, and its results beside the truth.

use crate::digits::{decimals, plus_minus, seconds};
use crate::emulator::{self, Options, Outcome};
use crate::input::Input;
use crate::live::Counts;
use crate::names::name;
use crate::picture::{self, Recording};
use crate::static_image;
use anyhow::{Context, Result};
use hal_mock::{Sliding, Truth};
use ridgetone_finger::TimedConversion;
use ridgetone_proto::telemetry::{Event, Hold, Packet, Span, Status, TravelStatus};
use std::fmt;

/// A run of a scene, and its truth in device time.
#[derive(Clone, Debug)]
pub struct Demo {
    pub speed_mm_s: f64,
    pub period_mm: f64,
    pub truth: Truth,
    pub outcome: Outcome,
    pub packets: Vec<Packet>,
}

/// Runs a scene.
pub fn run(
    scene: Sliding,
    options: Options<'_>,
    progress: &mut dyn FnMut(f64, f64),
) -> Result<Demo> {
    let (speed_mm_s, period_mm, seed) = (scene.speed_mm_s, scene.period_mm, scene.seed);
    let input = Input { scene, seed }.open()?;
    let truth = input.truth.context("the scene has no truth")?;
    let mut packets = Vec::new();
    let mut sink = |packet: &Packet, _| {
        packets.push(packet.clone());
        Ok(())
    };
    let mut outcome = emulator::run(
        input,
        Options {
            keep_conversions: true,
            ..options
        },
        &mut sink,
        progress,
    )?;
    // The scene alone is drawn, and not what follows until the last message.
    let first_us = outcome.conversions.first().map_or(0, |first| first.t_us);
    let end_us = ((truth.end_s - outcome.zero_s()) * 1e6) as u32;
    let is_in = |one: &TimedConversion| one.t_us.wrapping_sub(first_us) < end_us;
    let until = outcome.conversions.partition_point(is_in) + 1;
    outcome.conversions.truncate(until);
    outcome.conversions_served = outcome.conversions.len() as u64;
    Ok(Demo {
        speed_mm_s,
        period_mm,
        truth: later(truth, -outcome.zero_s()),
        outcome,
        packets,
    })
}

impl Demo {
    pub fn svg(&self) -> String {
        let recording = Recording::new(&self.outcome.conversions, &self.packets);
        picture::draw(&recording, Some(self.truth.frequency_hz))
    }

    /// Greatest processor load, 0 to 1.
    pub fn load(&self) -> f32 {
        let loads = self.packets.iter().filter_map(|packet| match packet.event {
            Event::Health(health) => Some(health.load),
            _ => None,
        });
        loads.fold(0.0, f32::max)
    }

    /// The last event of a kind.
    fn last<'a, T>(&'a self, kind: impl Fn(&'a Event) -> Option<T>) -> Option<T> {
        self.packets
            .iter()
            .rev()
            .find_map(|packet| kind(&packet.event))
    }
}

/// A truth with all times later by `by_s` seconds.
pub fn later(truth: Truth, by_s: f64) -> Truth {
    Truth {
        contact_s: truth.contact_s + by_s,
        slide_start_s: truth.slide_start_s + by_s,
        slide_end_s: truth.slide_end_s + by_s,
        release_s: truth.release_s + by_s,
        end_s: truth.end_s + by_s,
        ..truth
    }
}

fn time(t_us: Option<u64>) -> String {
    t_us.map_or_else(
        || "not found".into(),
        |t_us| format!("{:.3} s", seconds(t_us)),
    )
}

impl fmt::Display for Demo {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            speed_mm_s,
            period_mm,
            truth,
            outcome,
            ..
        } = self;
        let contact_us = self.last(|event| match event {
            Event::Contact(contact) => Some(contact.t_us),
            _ => None,
        });
        let slide_us = self.last(|event| match event {
            Event::Slide(slide) => Some((slide.start_us, slide.end_us?)),
            _ => None,
        });
        let estimate = self.last(|event| match event {
            Event::Estimate(estimate) if estimate.span == Span::Slide => Some(estimate),
            _ => None,
        });
        let health = self.last(|event| match event {
            Event::Health(health) => Some(health),
            _ => None,
        });
        writeln!(
            f,
            "A grating of {period_mm} mm slides over the emulated fingertip at {speed_mm_s} mm/s.\n"
        )?;
        writeln!(f, "{:<16}{:>24}{:>14}", "", "firmware", "truth")?;
        let mut row = |name: &str, found: String, true_value: String| {
            writeln!(f, "{name:<16}{found:>24}{true_value:>14}")
        };
        row(
            "contact",
            time(contact_us),
            format!("{:.3} s", truth.contact_s),
        )?;
        row(
            "slide begins",
            time(slide_us.map(|(start_us, _)| start_us)),
            format!("{:.3} s", truth.slide_start_s),
        )?;
        row(
            "slide ends",
            time(slide_us.map(|(_, end_us)| end_us)),
            format!("{:.3} s", truth.slide_end_s),
        )?;
        match estimate {
            Some(e) if e.status.has_tone() => {
                row(
                    "tone",
                    plus_minus(e.frequency.into(), e.sigma.into()) + " Hz",
                    format!("{:.4} Hz", truth.frequency_hz),
                )?;
                if e.status != Status::Good {
                    row("status", name(e.status).into(), String::new())?;
                }
                let found_mm = speed_mm_s / f64::from(e.frequency);
                let sigma_mm = found_mm * f64::from(e.sigma / e.frequency);
                row(
                    "spatial period",
                    plus_minus(found_mm, sigma_mm) + " mm",
                    format!("{period_mm:.4} mm"),
                )?;
                if e.travel.is_known() {
                    let with_unit = |(value, sigma): (f32, f32), unit| {
                        format!("{} {unit}", plus_minus(value.into(), sigma.into()))
                    };
                    let period = (e.travel.spatial_period_mm, e.travel.spatial_period_sigma_mm);
                    row(
                        "period, by lags",
                        with_unit(period, "mm"),
                        format!("{period_mm:.4} mm"),
                    )?;
                    let speed = (e.travel.speed_mm_s, e.travel.speed_sigma_mm_s);
                    row(
                        "speed, by lags",
                        with_unit(speed, "mm/s"),
                        format!("{speed_mm_s:.4} mm/s"),
                    )?;
                }
            }
            Some(e) => row(
                "tone",
                name(e.status).into(),
                format!("{:.4} Hz", truth.frequency_hz),
            )?,
            None => row(
                "tone",
                "not found".into(),
                format!("{:.4} Hz", truth.frequency_hz),
            )?,
        }
        if estimate.is_some_and(|e| e.travel.status == TravelStatus::Uncalibrated) {
            writeln!(
                f,
                "\nBy lags is `uncalibrated`: its uncertainty is that of any finger. It is right here because the\n\
                 default constants were measured on this simulated finger; `ridgetone calibrate` measures yours."
            )?;
        }
        let map = |hold: Hold| {
            let image = self.last(|event| match event {
                Event::Image(image) if image.hold == hold => Some(static_image::text(image, "")),
                _ => None,
            });
            image.unwrap_or_else(|| "not found\n\n\n\n".into())
        };
        let [before, after] = [Hold::BeforeSlide, Hold::AfterSlide].map(map);
        writeln!(
            f,
            "\n{:<44}after the slide, mV",
            "static image before the slide, mV"
        )?;
        for (before, after) in before.lines().zip(after.lines()) {
            writeln!(f, "{before:<44}{after}")?;
        }
        writeln!(f)?;
        if let Some(e) = estimate.filter(|estimate| estimate.status.has_tone()) {
            let error = 100.0 * (f64::from(e.frequency) / truth.frequency_hz - 1.0);
            let decimals = decimals(100.0 * f64::from(e.sigma / e.frequency)).unwrap_or(3);
            writeln!(
                f,
                "error           {error:+.decimals$} % of the frequency, from {} channels and {:.3} s of sliding",
                e.channels.len(),
                e.window_s
            )?;
        }
        writeln!(f, "processor load  {:.1} % at most", 100.0 * self.load())?;
        let (read, lost) = (outcome.conversions_served, outcome.chip.lost);
        let (skipped, dropped) =
            health.map_or((0, 0), |health| (health.overruns, health.messages_dropped));
        writeln!(
            f,
            "conversions     {read} read, {lost} lost; {skipped} overruns"
        )?;
        let Counts {
            received,
            missing,
            damaged,
            ..
        } = outcome.counts;
        writeln!(
            f,
            "telemetry       {received} frames received, {missing} lost, {damaged} damaged; {dropped} dropped"
        )
    }
}
