//! The picture of a run: sixteen strips, the results, and the fitted tone close up.
//!
//! Place and label distinguish the channels, dots and line distinguish data and fit; colour only
//! helps.

mod recording;

pub use recording::Recording;

use crate::chart::{Anchor, Axis, STYLE, Svg, nice, spaced, thinned};
use crate::digits::{decimals, seconds, significant, uncertain};
use crate::names::name;
use crate::remarks::phrases;
use ridgetone_proto::settings::TAXELS;
use ridgetone_proto::telemetry::{Estimate, Status};
use std::f64::consts::TAU;

const STRIP: f64 = 46.0;
/// Baseline of the labels above the strips.
const LABELS_Y: f64 = 82.0;
/// Top of the first strip, and bottom of the last one.
const STRIPS_Y: f64 = 98.0;
const STRIPS_END_Y: f64 = STRIPS_Y + STRIP * TAXELS as f64;
/// Left and right edges of the whole run, and of a few periods of the slide.
const TIME: (f64, f64) = (64.0, 690.0);
const CLOSE: (f64, f64) = (730.0, 976.0);
const WIDTH: f64 = 1080.0;
const HEIGHT: f64 = STRIPS_END_Y + 78.0;

/// Periods of the tone in the close-up.
const CLOSE_PERIODS: f64 = 4.0;
/// Most samples of a channel in it that are drawn as dots.
const DOTS_MAX: usize = 240;

/// Draws a recording. `nominal_hz` is the true frequency where it is known.
pub fn draw(recording: &Recording, nominal_hz: Option<f64>) -> String {
    let fit = recording.slide_fit.as_ref();
    let (title, subtitle) = headline(fit, nominal_hz);
    let mut svg = Svg::new(WIDTH, HEIGHT, &format!("{title}. {subtitle}"), STYLE);
    svg.text([24.0, 30.0], Anchor::Start, "title", &title);
    svg.text([24.0, 50.0], Anchor::Start, "small", &subtitle);
    let time = Axis {
        range: recording.span_s(),
        at: TIME,
        is_log: false,
    };
    for taxel in 0..TAXELS {
        let top = STRIPS_Y + STRIP * taxel as f64;
        if taxel % 2 == 0 {
            svg.rect([24.0, top], [WIDTH - 48.0, STRIP], "odd");
        }
        svg.text(
            [TIME.0 - 8.0, top + 0.5 * STRIP + 4.0],
            Anchor::End,
            "label",
            &taxel.to_string(),
        );
    }
    svg.text([TIME.0 - 8.0, STRIPS_Y - 6.0], Anchor::End, "head", "taxel");
    phases(&mut svg, recording, &time);
    over_time(&mut svg, recording, &time);
    match fit.filter(|fit| fit.status.has_tone()) {
        Some(fit) => close_up(&mut svg, recording, fit),
        None => svg.text(
            [0.5 * (CLOSE.0 + CLOSE.1), STRIPS_Y - 6.0],
            Anchor::Middle,
            "small",
            "no tone was fitted over a whole slide",
        ),
    }
    svg.finish()
}

fn headline(fit: Option<&Estimate>, nominal_hz: Option<f64>) -> (String, String) {
    let Some(fit) = fit else {
        return ("Sixteen taxels".into(), "No slide was found.".into());
    };
    if !fit.status.has_tone() {
        return (
            "Sixteen taxels".into(),
            format!("The whole slide gave no tone: {}.", name(fit.status)),
        );
    }
    let found = uncertain(fit.frequency.into(), fit.sigma.into());
    let title = format!("Sixteen taxels, one tone: {found} Hz");
    let mut subtitle = format!(
        "Least squares over {} channels and {:.2} s of sliding",
        fit.channels.len(),
        fit.window_s
    );
    if fit.status != Status::Good {
        subtitle += &format!("; {}", name(fit.status));
    }
    for phrase in phrases(fit) {
        subtitle += &format!("; {phrase}");
    }
    if let Some(nominal_hz) = nominal_hz {
        let error = 100.0 * (f64::from(fit.frequency) / nominal_hz - 1.0);
        let decimals = decimals(100.0 * f64::from(fit.sigma / fit.frequency)).unwrap_or(3);
        subtitle += &format!("; nominal {nominal_hz:.4} Hz, error {error:+.decimals$} %");
    }
    (title, subtitle)
}

/// Contact, slide, fitted window and release: across all strips, with labels above that do not
/// overlap.
fn phases(svg: &mut Svg, recording: &Recording, time: &Axis) {
    let x = |t_s: f64| time.place(t_s);
    let mut labels = Vec::new();
    for (start_s, end_s) in &recording.slides_s {
        svg.rect(
            [x(*start_s), STRIPS_Y],
            [x(*end_s) - x(*start_s), STRIPS_END_Y - STRIPS_Y],
            "slide",
        );
    }
    for t_s in &recording.contacts_s {
        svg.line([(x(*t_s), STRIPS_Y - 2.0), (x(*t_s), STRIPS_END_Y)], "mark");
        labels.push((x(*t_s), format!("contact {t_s:.2} s")));
    }
    for (start_s, end_s) in &recording.slides_s {
        labels.push((
            0.5 * (x(*start_s) + x(*end_s)),
            format!("slide {start_s:.2} to {end_s:.2} s"),
        ));
    }
    for t_s in &recording.releases_s {
        svg.line([(x(*t_s), STRIPS_Y - 2.0), (x(*t_s), STRIPS_END_Y)], "mark");
        labels.push((x(*t_s), format!("release {t_s:.2} s")));
    }
    for (x, text) in spaced(labels, TIME.0, TIME.1) {
        svg.text([x, LABELS_Y], Anchor::Middle, "label", &text);
    }
    if let Some(fit) = &recording.slide_fit {
        let (start_s, end_s) = window(fit);
        svg.line(
            [(x(start_s), STRIPS_Y - 3.0), (x(end_s), STRIPS_Y - 3.0)],
            "window",
        );
        for t_s in [start_s, end_s] {
            svg.line([(x(t_s), STRIPS_Y - 8.0), (x(t_s), STRIPS_END_Y)], "edge");
        }
    }
}

fn window(fit: &Estimate) -> (f64, f64) {
    let end_s = seconds(fit.t_us);
    (end_s - f64::from(fit.window_s), end_s)
}

/// The run over time, all strips to one scale.
fn over_time(svg: &mut Svg, recording: &Recording, time: &Axis) {
    let (from_s, to_s) = time.range;
    let pixels_per_v = 0.9 * STRIP / recording.range_v(from_s, to_s).max(1e-9);
    for (taxel, channel) in recording.channels.iter().enumerate() {
        let (least, greatest) = recording::extremes(channel, from_s, to_s);
        let middle = STRIPS_Y + STRIP * (taxel as f64 + 0.5);
        let y = |volts: f64| middle - pixels_per_v * (volts - 0.5 * (least + greatest));
        let points: Vec<(f64, f64)> = channel
            .iter()
            .map(|(t_s, v)| (time.place(*t_s), y(*v)))
            .collect();
        svg.path(&thinned(&points), "data");
    }
    time_axis(svg, time);
    scale_bar(svg, TIME.0, pixels_per_v);
    let key_x = TIME.0 + 150.0;
    svg.line(
        [
            (key_x, STRIPS_END_Y + 56.0),
            (key_x + 24.0, STRIPS_END_Y + 56.0),
        ],
        "window",
    );
    svg.text(
        [key_x + 32.0, STRIPS_END_Y + 60.0],
        Anchor::Start,
        "small",
        "window of the fit",
    );
    svg.rect([key_x + 150.0, STRIPS_END_Y + 50.0], [24.0, 12.0], "slide");
    svg.text(
        [key_x + 182.0, STRIPS_END_Y + 60.0],
        Anchor::Start,
        "small",
        "sliding phase",
    );
    svg.line(
        [
            (key_x + 280.0, STRIPS_END_Y + 56.0),
            (key_x + 304.0, STRIPS_END_Y + 56.0),
        ],
        "mark",
    );
    svg.text(
        [key_x + 312.0, STRIPS_END_Y + 60.0],
        Anchor::Start,
        "small",
        "contact, release",
    );
}

/// A few periods around the window's centre: samples as dots, the fitted fundamental as a line.
fn close_up(svg: &mut Svg, recording: &Recording, fit: &Estimate) {
    let frequency_hz = f64::from(fit.frequency);
    let (start_s, end_s) = window(fit);
    let centre_s = 0.5 * (start_s + end_s);
    let half_s = (0.5 * CLOSE_PERIODS / frequency_hz).min(0.5 * (end_s - start_s));
    let (from_s, to_s) = (centre_s - half_s, centre_s + half_s);
    let time = Axis {
        range: (from_s, to_s),
        at: CLOSE,
        is_log: false,
    };
    let pixels_per_v = 0.9 * STRIP / recording.range_v(from_s, to_s).max(1e-9);
    svg.text(
        [CLOSE.0, STRIPS_Y - 6.0],
        Anchor::Start,
        "head",
        "close up, with the fitted fundamental",
    );
    svg.text(
        [WIDTH - 34.0, STRIPS_Y - 6.0],
        Anchor::End,
        "head",
        "amplitude",
    );
    for channel in &fit.channels {
        let taxel = usize::from(channel.taxel);
        let (Some(samples), Some(idle_v)) =
            (recording.channels.get(taxel), recording.idle_v.get(taxel))
        else {
            continue;
        };
        let middle = STRIPS_Y + STRIP * (taxel as f64 + 0.5);
        let (least, greatest) = recording::extremes(samples, from_s, to_s);
        let y = |volts: f64| middle - pixels_per_v * (volts - 0.5 * (least + greatest));
        let inside = samples
            .iter()
            .filter(|(t_s, _)| (from_s..=to_s).contains(t_s));
        let dots: Vec<(f64, f64)> = inside.map(|(t_s, v)| (time.place(*t_s), y(*v))).collect();
        // Dots that would run together are a line.
        if dots.len() > DOTS_MAX {
            svg.path(&thinned(&dots), "data");
        } else {
            svg.dots(&dots, "dot");
        }
        let (offset_v, amplitude_v) = (
            f64::from(channel.offset_v) - idle_v,
            f64::from(channel.amplitude_v),
        );
        let model = |t_s: f64| {
            offset_v
                + amplitude_v
                    * (TAU * frequency_hz * (t_s - centre_s) + f64::from(channel.phase_rad)).cos()
        };
        let steps = 100;
        let line: Vec<(f64, f64)> = (0..=steps)
            .map(|i| from_s + (to_s - from_s) * f64::from(i) / f64::from(steps))
            .map(|t_s| (time.place(t_s), y(model(t_s))))
            .collect();
        svg.path(&line, "fit");
        let label = format!("{} mV", significant(1e3 * amplitude_v, 3));
        svg.text([WIDTH - 34.0, middle + 4.0], Anchor::End, "label", &label);
    }
    time_axis(svg, &time);
    scale_bar(svg, CLOSE.0, pixels_per_v);
    let key_x = CLOSE.0 + 90.0;
    svg.dots(
        &[
            (key_x, STRIPS_END_Y + 56.0),
            (key_x + 8.0, STRIPS_END_Y + 56.0),
        ],
        "dot",
    );
    svg.text(
        [key_x + 18.0, STRIPS_END_Y + 60.0],
        Anchor::Start,
        "small",
        "samples",
    );
    svg.line(
        [
            (key_x + 84.0, STRIPS_END_Y + 56.0),
            (key_x + 108.0, STRIPS_END_Y + 56.0),
        ],
        "fit",
    );
    svg.text(
        [key_x + 116.0, STRIPS_END_Y + 60.0],
        Anchor::Start,
        "small",
        "fit",
    );
}

/// An axis with round times under a panel.
fn time_axis(svg: &mut Svg, time: &Axis) {
    let (left, right) = time.at;
    svg.line([(left, STRIPS_END_Y), (right, STRIPS_END_Y)], "axis");
    for (t_s, label) in time.ticks(4) {
        let x = time.place(t_s);
        svg.line([(x, STRIPS_END_Y), (x, STRIPS_END_Y + 5.0)], "axis");
        svg.text([x, STRIPS_END_Y + 18.0], Anchor::Middle, "small", &label);
    }
    let middle = 0.5 * (left + right);
    svg.text(
        [middle, STRIPS_END_Y + 34.0],
        Anchor::Middle,
        "small",
        "time, s",
    );
}

/// A bar of a round number of millivolts under a panel.
fn scale_bar(svg: &mut Svg, left: f64, pixels_per_v: f64) {
    let bar_v = nice(26.0 / pixels_per_v);
    let (x, bottom) = (left + 4.0, STRIPS_END_Y + 68.0);
    svg.line([(x, bottom), (x, bottom - bar_v * pixels_per_v)], "bar");
    let label = format!("{} mV", (bar_v * 1e6).round() * 1e-3);
    svg.text(
        [x + 8.0, STRIPS_END_Y + 60.0],
        Anchor::Start,
        "small",
        &label,
    );
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_empty_recording_is_a_picture_too() {
        let svg = draw(&Recording::default(), None);
        assert!(svg.starts_with("<svg") && svg.trim_end().ends_with("</svg>"));
        assert!(!svg.contains("NaN") && !svg.contains("inf"), "{svg}");
    }
}
