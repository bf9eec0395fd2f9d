//! Picture of a run on the chip: sixteen strips, the results, and a close-up of the fitted tone.

mod recording;

pub use recording::Recording;

use crate::chart::strips::{Phases, Strip, Strips};
use crate::digits::{decimals, seconds, significant, uncertain};
use crate::harmonics;
use crate::names::name;
use crate::remarks::phrases;
use ridgetone_proto::telemetry::{Estimate, Status};
use std::ops::RangeInclusive;

/// Numbers of periods and of points on the fitted curve in the close-up.
const CLOSE_PERIODS: f64 = 4.0;
const CURVE_POINTS: u32 = 100;

/// Draws a recording. `nominal_hz` is the true frequency, if known.
pub fn draw(recording: &Recording, nominal_hz: Option<f64>) -> String {
    let fit = recording.slide_fit.as_ref();
    let (title, subtitle) = headline(fit, nominal_hz);
    let close = fit.filter(|fit| fit.status.has_tone()).map(|fit| {
        let slide = window(fit);
        let centre_s = 0.5 * (slide.start() + slide.end());
        let half_s = (0.5 * CLOSE_PERIODS / f64::from(fit.frequency)).min(slide.end() - centre_s);
        (fit, centre_s - half_s..=centre_s + half_s)
    });
    let (from_s, to_s) = recording.span_s();
    let mut strips: Vec<Strip> = (0..)
        .zip(&recording.channels)
        .map(|(taxel, channel)| Strip {
            name: format!("{taxel}"),
            readings: channel.clone(),
            ..Strip::default()
        })
        .collect();
    for channel in fit.iter().flat_map(|fit| &fit.channels) {
        let taxel = usize::from(channel.taxel);
        if let (Some((fit, range)), Some(strip)) = (&close, strips.get_mut(taxel)) {
            let amplitude_mv = 1e3 * f64::from(channel.amplitude_v);
            strip.amplitude = format!("{} mV", significant(amplitude_mv, 3));
            strip.curve = curve(fit, &recording.channels[taxel], range);
        }
    }
    let strips = Strips {
        title,
        subtitle,
        warning: None,
        row: "taxel",
        headings: ["", "close up, with the fit"],
        axis: "time, s",
        range: from_s..=to_s,
        strips,
        close: close.map(|(_, range)| range),
        is_in_volts: true,
        phases: Some(phases(recording)),
    };
    strips.picture(None)
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

fn phases(recording: &Recording) -> Phases {
    let contacts = recording.contacts_s.iter().map(|t_s| (t_s, "contact"));
    let releases = recording.releases_s.iter().map(|t_s| (t_s, "release"));
    let labelled = |(t_s, what): (&f64, &str)| (*t_s, format!("{what} {t_s:.2} s"));
    let slides = recording.slides_s.iter();
    Phases {
        marks: contacts.chain(releases).map(labelled).collect(),
        slides: slides.map(|(from, to)| *from..=*to).collect(),
        window: recording.slide_fit.as_ref().map(window),
    }
}

fn window(fit: &Estimate) -> RangeInclusive<f64> {
    let end_s = seconds(fit.t_us);
    end_s - f64::from(fit.window_s)..=end_s
}

/// Evaluates the fit to a channel's readings in the window, with all harmonics, over the range of
/// the close-up.
fn curve(fit: &Estimate, readings: &[(f64, f64)], range: &RangeInclusive<f64>) -> Vec<(f64, f64)> {
    let window = window(fit);
    let centre_s = 0.5 * (window.start() + window.end());
    let step_s = (range.end() - range.start()) / f64::from(CURVE_POINTS);
    let points_s = (0..=CURVE_POINTS).map(|step| range.start() + step_s * f64::from(step));
    // The points of the curve have no reading, so they do not affect the fit.
    let known = readings.iter().filter(|(t_s, _)| window.contains(t_s));
    let known = known.map(|(t_s, v)| (*t_s, Some(*v as f32)));
    let points = points_s.clone().map(|t_s| (t_s, None));
    let (t_s, volts): (Vec<f64>, Vec<Option<f32>>) = points
        .chain(known)
        .map(|(t_s, v)| (t_s - centre_s, v))
        .unzip();
    let hum_hz = fit.interferer_hz.map(f64::from);
    let found = harmonics::fit(&t_s, &volts, fit.frequency.into(), fit.harmonics, hum_hz);
    found.map_or_else(Vec::new, |found| {
        points_s
            .zip(found.fit_v)
            .map(|(t_s, v)| (t_s, f64::from(v)))
            .collect()
    })
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
