//! The picture of a run: sixteen strips, the results, and the fitted tone close up.
//!
//! Place and label distinguish the channels, dots and line distinguish data and fit; colour only
//! helps.

pub mod layout;
mod recording;

pub use recording::Recording;

use crate::digits::{decimals, seconds, significant, with_sigma};
use crate::names::name;
use crate::remarks::phrases;
use crate::svg::{Anchor, Svg};
use layout::{LABELS_Y, Panel, STRIP, STRIPS_END_Y, STRIPS_Y, nice, spaced};
use ridgetone_proto::settings::TAXELS;
use ridgetone_proto::telemetry::{Estimate, Status};
use std::f64::consts::TAU;

const STYLE: &str = "text{font:12px system-ui,'Helvetica Neue',Arial,'DejaVu Sans',sans-serif;fill:#222}\
.title{font-size:17px;font-weight:600}.small{font-size:11px;fill:#555}.head{font-size:11px;fill:#222;font-weight:600}\
path{fill:none}.card{fill:#fff;stroke:#bbb}.odd{fill:#f4f5f7}.axis{stroke:#555}.grid{stroke:#ddd}\
.slide{fill:#cfe3f5;fill-opacity:.55}.mark{stroke:#8a1c4a;stroke-width:1.2;stroke-dasharray:4 3}\
.window{stroke:#1b5e8c;stroke-width:3}.edge{stroke:#1b5e8c;stroke-width:1;stroke-dasharray:1 3}\
.data{stroke:#33475b;stroke-width:.8;stroke-linejoin:round}.dot{stroke:#33475b;stroke-width:2.6;stroke-linecap:round}\
.fit{stroke:#d1490c;stroke-width:1.6}.bar{stroke:#222;stroke-width:2}";

const TIME: Panel = Panel {
    left: 64.0,
    right: 690.0,
};
/// A few periods of the slide.
const CLOSE: Panel = Panel {
    left: 730.0,
    right: 976.0,
};
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
    svg.text(24.0, 30.0, Anchor::Start, "title", &title);
    svg.text(24.0, 50.0, Anchor::Start, "small", &subtitle);
    let (from_s, to_s) = recording.span_s();
    for taxel in 0..TAXELS {
        let top = STRIPS_Y + STRIP * taxel as f64;
        if taxel % 2 == 0 {
            svg.rect(24.0, top, WIDTH - 48.0, STRIP, "odd");
        }
        svg.text(
            TIME.left - 8.0,
            top + 0.5 * STRIP + 4.0,
            Anchor::End,
            "label",
            &taxel.to_string(),
        );
    }
    svg.text(
        TIME.left - 8.0,
        STRIPS_Y - 6.0,
        Anchor::End,
        "head",
        "taxel",
    );
    phases(&mut svg, recording, from_s, to_s);
    over_time(&mut svg, recording, from_s, to_s);
    match fit.filter(|fit| fit.status.has_tone()) {
        Some(fit) => close_up(&mut svg, recording, fit),
        None => svg.text(
            CLOSE.middle(),
            STRIPS_Y - 6.0,
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
    let (hz, sigma_hz) = with_sigma(fit.frequency.into(), fit.sigma.into());
    let title = format!("Sixteen taxels, one tone: {hz} \u{b1} {sigma_hz} Hz");
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
        let decimals = decimals(100.0 * f64::from(fit.sigma / fit.frequency), 3);
        subtitle += &format!("; nominal {nominal_hz:.4} Hz, error {error:+.decimals$} %");
    }
    (title, subtitle)
}

/// Contact, slide, fitted window and release: across all strips, with labels above that do not
/// overlap.
fn phases(svg: &mut Svg, recording: &Recording, from_s: f64, to_s: f64) {
    let x = |t_s: f64| TIME.x(t_s, from_s, to_s);
    let mut labels = Vec::new();
    for (start_s, end_s) in &recording.slides_s {
        svg.rect(
            x(*start_s),
            STRIPS_Y,
            x(*end_s) - x(*start_s),
            STRIPS_END_Y - STRIPS_Y,
            "slide",
        );
    }
    for t_s in &recording.contacts_s {
        svg.line((x(*t_s), STRIPS_Y - 2.0), (x(*t_s), STRIPS_END_Y), "mark");
        labels.push((x(*t_s), format!("contact {t_s:.2} s")));
    }
    for (start_s, end_s) in &recording.slides_s {
        labels.push((
            0.5 * (x(*start_s) + x(*end_s)),
            format!("slide {start_s:.2} to {end_s:.2} s"),
        ));
    }
    for t_s in &recording.releases_s {
        svg.line((x(*t_s), STRIPS_Y - 2.0), (x(*t_s), STRIPS_END_Y), "mark");
        labels.push((x(*t_s), format!("release {t_s:.2} s")));
    }
    for (x, text) in spaced(labels, TIME) {
        svg.text(x, LABELS_Y, Anchor::Middle, "label", &text);
    }
    if let Some(fit) = &recording.slide_fit {
        let (start_s, end_s) = window(fit);
        svg.line(
            (x(start_s), STRIPS_Y - 3.0),
            (x(end_s), STRIPS_Y - 3.0),
            "window",
        );
        for t_s in [start_s, end_s] {
            svg.line((x(t_s), STRIPS_Y - 8.0), (x(t_s), STRIPS_END_Y), "edge");
        }
    }
}

fn window(fit: &Estimate) -> (f64, f64) {
    let end_s = seconds(fit.t_us);
    (end_s - f64::from(fit.window_s), end_s)
}

/// The run over time, all strips to one scale.
fn over_time(svg: &mut Svg, recording: &Recording, from_s: f64, to_s: f64) {
    let pixels_per_v = 0.9 * STRIP / recording.range_v(from_s, to_s).max(1e-9);
    for (taxel, channel) in recording.channels.iter().enumerate() {
        let (least, greatest) = recording::extremes(channel, from_s, to_s);
        let middle = STRIPS_Y + STRIP * (taxel as f64 + 0.5);
        let y = |volts: f64| middle - pixels_per_v * (volts - 0.5 * (least + greatest));
        let points: Vec<(f64, f64)> = channel
            .iter()
            .map(|(t_s, v)| (TIME.x(*t_s, from_s, to_s), y(*v)))
            .collect();
        svg.path(&layout::thinned(&points), "data");
    }
    layout::axis(svg, TIME, from_s, to_s, "time, s");
    scale_bar(svg, TIME, pixels_per_v);
    let key_x = TIME.left + 150.0;
    svg.line(
        (key_x, STRIPS_END_Y + 56.0),
        (key_x + 24.0, STRIPS_END_Y + 56.0),
        "window",
    );
    svg.text(
        key_x + 32.0,
        STRIPS_END_Y + 60.0,
        Anchor::Start,
        "small",
        "window of the fit",
    );
    svg.rect(key_x + 150.0, STRIPS_END_Y + 50.0, 24.0, 12.0, "slide");
    svg.text(
        key_x + 182.0,
        STRIPS_END_Y + 60.0,
        Anchor::Start,
        "small",
        "sliding phase",
    );
    svg.line(
        (key_x + 280.0, STRIPS_END_Y + 56.0),
        (key_x + 304.0, STRIPS_END_Y + 56.0),
        "mark",
    );
    svg.text(
        key_x + 312.0,
        STRIPS_END_Y + 60.0,
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
    let pixels_per_v = 0.9 * STRIP / recording.range_v(from_s, to_s).max(1e-9);
    svg.text(
        CLOSE.left,
        STRIPS_Y - 6.0,
        Anchor::Start,
        "head",
        "close up, with the fitted fundamental",
    );
    svg.text(
        WIDTH - 34.0,
        STRIPS_Y - 6.0,
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
        let dots: Vec<(f64, f64)> = inside
            .map(|(t_s, v)| (CLOSE.x(*t_s, from_s, to_s), y(*v)))
            .collect();
        // Dots that would run together are a line.
        if dots.len() > DOTS_MAX {
            svg.path(&layout::thinned(&dots), "data");
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
            .map(|t_s| (CLOSE.x(t_s, from_s, to_s), y(model(t_s))))
            .collect();
        svg.path(&line, "fit");
        let label = format!("{} mV", significant(1e3 * amplitude_v, 3));
        svg.text(WIDTH - 34.0, middle + 4.0, Anchor::End, "label", &label);
    }
    layout::axis(svg, CLOSE, from_s, to_s, "time, s");
    scale_bar(svg, CLOSE, pixels_per_v);
    let key_x = CLOSE.left + 90.0;
    svg.dots(
        &[
            (key_x, STRIPS_END_Y + 56.0),
            (key_x + 8.0, STRIPS_END_Y + 56.0),
        ],
        "dot",
    );
    svg.text(
        key_x + 18.0,
        STRIPS_END_Y + 60.0,
        Anchor::Start,
        "small",
        "samples",
    );
    svg.line(
        (key_x + 84.0, STRIPS_END_Y + 56.0),
        (key_x + 108.0, STRIPS_END_Y + 56.0),
        "fit",
    );
    svg.text(
        key_x + 116.0,
        STRIPS_END_Y + 60.0,
        Anchor::Start,
        "small",
        "fit",
    );
}

/// A bar of a round number of millivolts under a panel.
fn scale_bar(svg: &mut Svg, panel: Panel, pixels_per_v: f64) {
    let bar_v = nice(26.0 / pixels_per_v);
    let (x, bottom) = (panel.left + 4.0, STRIPS_END_Y + 68.0);
    svg.line((x, bottom), (x, bottom - bar_v * pixels_per_v), "bar");
    let label = format!("{} mV", (bar_v * 1e6).round() * 1e-3);
    svg.text(x + 8.0, STRIPS_END_Y + 60.0, Anchor::Start, "small", &label);
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
