//! `demo`: a scene through the emulated firmware, and its results beside the truth.

use crate::digits::{decimals, with_sigma};
use crate::emulator::{self, Options, Outcome};
use crate::input::{Input, Source};
use crate::live::Counts;
use crate::names::name;
use crate::picture::{self, Recording};
use crate::static_image;
use anyhow::{Context, Result};
use hal_mock::{Sliding, Truth};
use ridgetone_proto::telemetry::{Contact, Estimate, Event, Health, Hold, Image, Packet, Slide, Span};
use std::fmt;

#[derive(Clone, Debug)]
pub struct Demo {
    pub summary: Summary,
    pub outcome: Outcome,
    pub packets: Vec<Packet>,
}

/// The results beside the truth. Times are device times in seconds.
#[derive(Clone, Debug)]
pub struct Summary {
    pub speed_mm_s: f64,
    pub period_mm: f64,
    /// The truth, in device time.
    pub truth: Truth,
    pub contact: Option<Contact>,
    /// The last slide that has ended.
    pub slide: Option<Slide>,
    /// The fit over it.
    pub estimate: Option<Estimate>,
    /// The latest static images, before a slide and after one.
    pub images: [Option<Image>; 2],
    /// Greatest processor load, 0 to 1.
    pub load: f32,
    pub health: Option<Health>,
}

impl Summary {
    /// Error of the frequency, percent of the nominal one.
    pub fn error_percent(&self) -> Option<f64> {
        let found = self.estimate.as_ref().filter(|estimate| estimate.status.has_tone())?;
        Some(100.0 * (f64::from(found.frequency) / self.truth.frequency_hz - 1.0))
    }
}

/// Runs a scene; the default one is 3.6 mm at 30 mm/s, 20 dB.
pub fn run(scene: Sliding, options: Options<'_>, progress: &mut dyn FnMut(f64, f64)) -> Result<Demo> {
    let (speed_mm_s, period_mm, seed) = (scene.speed_mm_s, scene.period_mm, scene.seed);
    let input = Input { source: Source::Scene(scene), seed, ..Input::default() }.open()?;
    let truth = input.truth.context("the scene has no truth")?;
    let mut packets = Vec::new();
    let mut sink = |packet: &Packet| {
        packets.push(packet.clone());
        Ok(())
    };
    let outcome = emulator::run(input, Options { keep_conversions: true, ..options }, &mut sink, progress)?;
    let summary = summary((speed_mm_s, period_mm), truth, &outcome, &packets);
    Ok(Demo { summary, outcome, packets })
}

impl Demo {
    pub fn svg(&self) -> String {
        let recording = Recording::new(&self.outcome.conversions, &self.packets);
        picture::draw(&recording, Some(self.summary.truth.frequency_hz))
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

fn summary((speed_mm_s, period_mm): (f64, f64), truth: Truth, outcome: &Outcome, packets: &[Packet]) -> Summary {
    // Scene time begins when the board starts the chip, device time with the first result.
    let zero_s = (outcome.start_us as f64 - outcome.first_edge_us as f64) / 1e6;
    let truth = later(truth, zero_s);
    let mut summary = Summary {
        speed_mm_s,
        period_mm,
        truth,
        contact: None,
        slide: None,
        estimate: None,
        images: [None, None],
        load: 0.0,
        health: None,
    };
    for packet in packets {
        match &packet.event {
            Event::Contact(contact) => summary.contact = Some(*contact),
            Event::Slide(slide) if slide.end_us.is_some() => summary.slide = Some(*slide),
            Event::Estimate(estimate) if estimate.span == Span::Slide => summary.estimate = Some(estimate.clone()),
            Event::Image(image) => summary.images[(image.hold == Hold::AfterSlide) as usize] = Some(image.clone()),
            Event::Health(health) => {
                summary.load = summary.load.max(health.load);
                summary.health = Some(*health);
            }
            _ => {}
        }
    }
    summary
}

fn time(t_us: Option<u64>) -> String {
    t_us.map_or_else(|| "not found".into(), |t_us| format!("{:.3} s", t_us as f64 / 1e6))
}

impl fmt::Display for Demo {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (summary, outcome) = (&self.summary, &self.outcome);
        let Summary { speed_mm_s, period_mm, truth, contact, slide, .. } = summary;
        writeln!(f, "A grating of {period_mm} mm slides over the emulated fingertip at {speed_mm_s} mm/s.\n")?;
        writeln!(f, "{:<16}{:>24}{:>14}", "", "firmware", "truth")?;
        let mut row =
            |name: &str, found: String, true_value: String| writeln!(f, "{name:<16}{found:>24}{true_value:>14}");
        row("contact", time(contact.map(|c| c.t_us)), format!("{:.3} s", truth.contact_s))?;
        row("slide begins", time(slide.map(|s| s.start_us)), format!("{:.3} s", truth.slide_start_s))?;
        row("slide ends", time(slide.and_then(|s| s.end_us)), format!("{:.3} s", truth.slide_end_s))?;
        match &summary.estimate {
            Some(e) if e.status.has_tone() => {
                let (hz, sigma_hz) = with_sigma(e.frequency.into(), e.sigma.into());
                row("tone", format!("{hz} +- {sigma_hz} Hz"), format!("{:.4} Hz", truth.frequency_hz))?;
                let period_mm = speed_mm_s / f64::from(e.frequency);
                let (mm, sigma_mm) = with_sigma(period_mm, period_mm * f64::from(e.sigma / e.frequency));
                row("spatial period", format!("{mm} +- {sigma_mm} mm"), format!("{:.4} mm", period_mm))?;
            }
            Some(e) => row("tone", name(e.status).into(), format!("{:.4} Hz", truth.frequency_hz))?,
            None => row("tone", "not found".into(), format!("{:.4} Hz", truth.frequency_hz))?,
        }
        let map = |image: &Option<Image>| match image {
            Some(image) => static_image::text(image, ""),
            None => "not found\n\n\n\n".into(),
        };
        let [before, after] = summary.images.each_ref().map(map);
        writeln!(f, "\n{:<44}after the slide, mV", "static image before the slide, mV")?;
        for (before, after) in before.lines().zip(after.lines()) {
            writeln!(f, "{before:<44}{after}")?;
        }
        writeln!(f)?;
        if let (Some(error), Some(e)) = (summary.error_percent(), &summary.estimate) {
            let decimals = decimals(100.0 * f64::from(e.sigma / e.frequency), 3);
            writeln!(
                f,
                "error           {error:+.decimals$} % of the frequency, from {} channels and {:.3} s of sliding",
                e.channels.len(),
                e.window_s
            )?;
        }
        writeln!(f, "processor load  {:.1} % at most (instructions of 8 ns)", 100.0 * summary.load)?;
        let (read, lost) = (outcome.conversions_served, outcome.chip.lost);
        let (skipped, dropped) = summary.health.map_or((0, 0), |health| (health.hops_skipped, health.messages_dropped));
        writeln!(f, "conversions     {read} read, {lost} lost; {skipped} hops skipped")?;
        let Counts { received, missing, damaged, .. } = outcome.counts;
        writeln!(f, "telemetry       {received} frames received, {missing} lost, {damaged} damaged; {dropped} dropped")
    }
}
