//! `demo`: runs the firmware on a scene and prints its results next to the true values.

use crate::digits::{decimals, plus_minus, seconds};
use crate::emulator::{self, Options, Outcome};
use crate::input::Input;
use crate::live::Counts;
use crate::names::name;
use crate::picture::{self, Recording};
use crate::static_image;
use anyhow::{Context, Result};
use hal_mock::{Sliding, Truth};
use ridgetone_emulator::Board;
use ridgetone_finger::TimedConversion;
use ridgetone_proto::telemetry::{Estimate, Event, Hold, Packet, Span, Status, TravelStatus};
use std::fmt;

/// A run of a scene, with the true values in device time.
#[derive(Clone, Debug)]
pub struct Demo {
    pub speed_mm_s: f64,
    pub period_mm: f64,
    /// Power of the tone over that of the noise, dB; `None` if finger and converter are the only
    /// noise.
    pub snr_db: Option<f64>,
    pub truth: Truth,
    pub board: Board,
    pub outcome: Outcome,
    pub packets: Vec<Packet>,
}

pub fn run(
    scene: Sliding,
    options: Options<'_>,
    progress: &mut dyn FnMut(f64, f64),
) -> Result<Demo> {
    let (speed_mm_s, period_mm, snr_db) = (scene.speed_mm_s, scene.period_mm, scene.snr_db);
    let seed = scene.seed;
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
    // Draw only the scene, and not the time from its end to the last message.
    let first_us = outcome.conversions.first().map_or(0, |first| first.t_us);
    let end_us = ((truth.end_s - outcome.zero_s()) * 1e6) as u32;
    let is_in = |one: &TimedConversion| one.t_us.wrapping_sub(first_us) < end_us;
    let until = outcome.conversions.partition_point(is_in) + 1;
    outcome.conversions.truncate(until);
    outcome.conversions_served = outcome.conversions.len() as u64;
    Ok(Demo {
        board: options.firmware.board,
        speed_mm_s,
        period_mm,
        truth: later(truth, -outcome.zero_s()),
        outcome,
        packets,
        snr_db,
    })
}

impl Demo {
    pub fn svg(&self) -> String {
        let recording = Recording::new(&self.outcome.conversions, &self.packets);
        picture::draw(&recording, Some(self.truth.frequency_hz))
    }

    /// Returns the mean processor load during the slide, 0 to 1, from the health reports in it;
    /// `None` without any.
    pub fn sliding_load(&self) -> Option<f32> {
        let (mut sum, mut count) = (0.0, 0.0);
        for packet in &self.packets {
            if let Event::Health(health) = packet.event {
                // A report covers the preceding second.
                let slide_s = self.truth.slide_start_s + 1.0..=self.truth.slide_end_s;
                if slide_s.contains(&seconds(health.t_us)) {
                    sum += health.load;
                    count += 1.0;
                }
            }
        }
        (count > 0.0).then_some(sum / count)
    }

    fn last<'a, T>(&'a self, kind: impl Fn(&'a Event) -> Option<T>) -> Option<T> {
        self.packets
            .iter()
            .rev()
            .find_map(|packet| kind(&packet.event))
    }
}

/// Derives the processor from the board's name: `STM32F405` from `feather-f405`.
fn processor(board: Board) -> String {
    let mut words = board.name().split('-');
    let family = words.find_map(|word| word.strip_prefix("f4"));
    format!(
        "STM32F4{}",
        family.and_then(|family| family.get(..2)).unwrap_or("xx")
    )
}

/// Shifts all times by `by_s` seconds.
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

struct Row {
    name: &'static str,
    found: String,
    truth: String,
    remark: String,
}

impl fmt::Display for Row {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            name,
            found,
            truth,
            remark,
        } = self;
        let line = format!("{name:<14}{found:>24}{truth:>14}   {remark}");
        f.write_str(line.trim_end())
    }
}

/// Compares a measured value with the true one, in standard deviations.
fn compared(name: &'static str, found: f64, sigma: f64, truth: f64, unit: &str) -> Row {
    let decimals = decimals(sigma).unwrap_or(4);
    Row {
        name,
        found: format!("{} {unit}", plus_minus(found, sigma)),
        truth: format!("{truth:.decimals$} {unit}"),
        remark: format!("{:.1} sigma off", ((found - truth) / sigma).abs()),
    }
}

impl Demo {
    fn rows(&self, estimate: Option<&Estimate>) -> Vec<Row> {
        let truth = &self.truth;
        let contact_us = self.last(|event| match event {
            Event::Contact(contact) => Some(contact.t_us),
            _ => None,
        });
        let slide_us = self.last(|event| match event {
            Event::Slide(slide) => Some((slide.start_us, slide.end_us?)),
            _ => None,
        });
        let time = |name, t_us: Option<u64>, truth_s: f64| Row {
            name,
            found: time(t_us),
            truth: format!("{truth_s:.3} s"),
            remark: String::new(),
        };
        let mut rows = vec![
            time("contact", contact_us, truth.contact_s),
            time(
                "slide begins",
                slide_us.map(|(start_us, _)| start_us),
                truth.slide_start_s,
            ),
            time(
                "slide ends",
                slide_us.map(|(_, end_us)| end_us),
                truth.slide_end_s,
            ),
        ];
        let Some(e) = estimate.filter(|e| e.status.has_tone()) else {
            rows.push(Row {
                name: "frequency",
                found: estimate.map_or("not found".into(), |e| name(e.status).into()),
                truth: format!("{:.4} Hz", truth.frequency_hz),
                remark: String::new(),
            });
            return rows;
        };
        let row = |name, (found, sigma): (f32, f32), truth, unit| {
            compared(name, found.into(), sigma.into(), truth, unit)
        };
        rows.push(row(
            "frequency",
            (e.frequency, e.sigma),
            truth.frequency_hz,
            "Hz",
        ));
        if e.travel.is_known() {
            let period = (e.travel.spatial_period_mm, e.travel.spatial_period_sigma_mm);
            rows.push(row("ridge spacing", period, self.period_mm, "mm"));
            let speed = (e.travel.speed_mm_s, e.travel.speed_sigma_mm_s);
            rows.push(row("speed", speed, self.speed_mm_s, "mm/s"));
        }
        rows
    }
}

impl fmt::Display for Demo {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            speed_mm_s,
            period_mm,
            outcome,
            ..
        } = self;
        let estimate = self.last(|event| match event {
            Event::Estimate(estimate) if estimate.span == Span::Slide => Some(estimate),
            _ => None,
        });
        let noise = match self.snr_db {
            Some(snr_db) => format!("noise {snr_db} dB below the tone"),
            None => "no noise but the converter's".into(),
        };
        writeln!(
            f,
            "Simulated: a fingertip that slides over ridges {period_mm} mm apart at {speed_mm_s} mm/s, {noise}.\n\
             Emulated: an {} that runs the firmware's image, with {} on its pins.\n",
            processor(self.board),
            match Board::OWN_ADC.contains(&self.board) {
                true => "the sensors",
                false => "an ADS1258",
            }
        )?;
        writeln!(f, "{:<14}{:>24}{:>14}", "", "firmware", "truth")?;
        for row in self.rows(estimate) {
            writeln!(f, "{row}")?;
        }
        if let Some(e) = estimate.filter(|e| e.status != Status::Good) {
            writeln!(f, "\nThe frequency is `{}`.", name(e.status))?;
        }
        if estimate.is_some_and(|e| e.travel.status == TravelStatus::Uncalibrated) {
            writeln!(
                f,
                "\nRidge spacing and speed follow from the delay between the two columns of sensors. Their error\n\
                 bars cover any finger until `ridgetone calibrate` has measured this one."
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
            "\nEach sensor's change while the finger is pressed and still, mV:\n\n{:<44}after it",
            "before the slide"
        )?;
        for (before, after) in before.lines().zip(after.lines()) {
            writeln!(f, "{before:<44}{after}")?;
        }
        let health = self.last(|event| match event {
            Event::Health(health) => Some(health),
            _ => None,
        });
        if let Some(e) = estimate {
            writeln!(
                f,
                "\nfit           {} channels, {:.2} s",
                e.channels.len(),
                e.window_s
            )?;
        }
        if let Some(load) = self.sliding_load() {
            writeln!(
                f,
                "processor     {:.0} % busy while the finger slides",
                100.0 * load
            )?;
        }
        let (read, lost) = (outcome.conversions_served, outcome.chip.lost);
        let (skipped, dropped) =
            health.map_or((0, 0), |health| (health.overruns, health.messages_dropped));
        writeln!(
            f,
            "converter     {read} conversions read, {lost} lost; {skipped} windows skipped"
        )?;
        let Counts {
            received,
            missing,
            damaged,
            ..
        } = outcome.counts;
        writeln!(
            f,
            "serial line   {received} messages received, {missing} lost, {damaged} damaged, {dropped} dropped"
        )?;
        writeln!(
            f,
            "\nNext, the same firmware live in a browser: ridgetone view --emulated"
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn boards_have_their_processors() {
        for (board, expected) in [
            (Board::FeatherF405, "STM32F405"),
            (Board::NucleoF446reAdc, "STM32F446"),
            (Board::BlackpillF411, "STM32F411"),
        ] {
            assert_eq!(processor(board), expected);
        }
    }
}
