//! The picture of a fit: each channel with the fitted tone and what it leaves, and the spectra of
//! both.
//!
//! | step | file |
//! |---|---|
//! | what was fitted, channel by channel | `channels` |
//! | the strips | `strips` |
//! | the spectra | `spectrum` |

mod channels;
mod spectrum;
mod strips;

use crate::chart::{Anchor, CHART_WIDTH, Panel, STYLE, Svg};
use crate::digits::{significant, uncertain};
use crate::fit_report::part_name;
use crate::names::name;
use crate::remarks::remarks;
use crate::samples::Samples;
use crate::table_fit::{Selection, TableFit};
use crate::tone::Domain;
use anyhow::Result;
use channels::Fitted;
use ridgetone_proto::telemetry::Status;
use std::path::Path;
use strips::{STRIPS_Y, strips};

/// Draws a fit of these samples with this selection. They are read once more.
pub fn draw(samples: &Samples, selection: &Selection, fit: &TableFit) -> Result<String> {
    let fitted = Fitted::read(samples, selection, fit)?;
    Ok(drawing(samples.name(), &fitted, fit))
}

fn drawing(file: &str, fitted: &Fitted, fit: &TableFit) -> String {
    let (title, subtitle) = headline(file, fit);
    let panel = spectrum::panel(fitted, fit);
    let strips_height = strips::height(fitted.channels.len());
    let height = STRIPS_Y + strips_height + panel.as_ref().map_or(0.0, Panel::height);
    let mut svg = Svg::new(CHART_WIDTH, height, &format!("{title}. {subtitle}"), STYLE);
    svg.text([24.0, 30.0], Anchor::Start, "title", &title);
    svg.text([24.0, 50.0], Anchor::Start, "small", &subtitle);
    if let Some(word) = clipped_word(fitted) {
        svg.text([24.0, 67.0], Anchor::Start, "head", &word);
    }
    strips(&mut svg, fitted, fit);
    if let Some(panel) = panel {
        panel.draw(&mut svg, STRIPS_Y + strips_height);
    }
    svg.finish()
}

fn headline(file: &str, fit: &TableFit) -> (String, String) {
    let file = Path::new(file)
        .file_name()
        .map_or_else(|| file.into(), |name| name.to_string_lossy());
    let title = match (fit.tone.frequency(), fit.domain) {
        (Some(found), Domain::Time) => {
            format!("{file}: {} Hz", uncertain(found.value, found.sigma))
        }
        (Some(found), Domain::Position) => {
            let period = found.inverse();
            format!("{file}: {} mm", uncertain(period.value, period.sigma))
        }
        (None, _) => format!("{file}: no tone"),
    };
    let mut subtitle = format!(
        "{}; {}, {} to {} s; {} rows at {} Hz",
        name(fit.status),
        part_name(fit.part),
        significant(fit.from_s, 5),
        significant(fit.to_s, 5),
        fit.rows,
        significant(fit.rate_hz, 5)
    );
    if fit.status == Status::Good && fit.harmonics > 1 {
        subtitle += &format!("; {} harmonics", fit.harmonics);
    }
    for (name, value) in remarks(fit.status, fit.domain, &fit.tone) {
        subtitle += &format!("; {name} {value}");
    }
    (title, subtitle)
}

/// What to know of channels whose readings end at a limit.
fn clipped_word(fitted: &Fitted) -> Option<String> {
    let clipped = fitted.channels.iter().filter(|channel| channel.is_clipped);
    match (clipped.count(), fitted.channels.len()) {
        (0, _) => None,
        (1, 1) => Some("The channel is clipped: its readings end at a limit.".into()),
        (all, count) if all == count => {
            Some("All channels are clipped: their readings end at a limit.".into())
        }
        (some, count) => Some(format!("{some} of {count} channels are clipped.")),
    }
}

#[cfg(test)]
mod tests;
