//! The picture of a fit: each channel with the fitted tone and its residual, and the spectra of
//! both.
//!
//! | step | file |
//! |---|---|
//! | rows that were fitted, and the tone in each channel | `channels` |
//! | the spectra | `spectrum` |

mod channels;
mod spectrum;

use crate::chart::strips::{Strip, Strips};
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

/// Draws a fit of these samples with this selection. Reads the samples again.
pub fn draw(samples: &Samples, selection: &Selection, fit: &TableFit) -> Result<String> {
    let fitted = Fitted::read(samples, selection, fit)?;
    let panel = spectrum::panel(&fitted, fit);
    let (title, subtitle) = headline(samples.name(), fit);
    let strips = Strips {
        title,
        subtitle,
        warning: clipped_words(&fitted.strips),
        row: "channel",
        headings: ["each to its own scale", "close up, with the fit"],
        axis: match fit.domain {
            Domain::Time => "time, s",
            Domain::Position => "position, mm",
        },
        range: fitted.range,
        close: fitted.close,
        is_in_volts: false,
        phases: None,
        strips: fitted.strips,
    };
    Ok(strips.picture(panel.as_ref()))
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

/// Warns of channels whose readings end at a limit.
fn clipped_words(strips: &[Strip]) -> Option<String> {
    let clipped = strips
        .iter()
        .filter(|strip| strip.note == "clipped")
        .count();
    match (clipped, strips.len()) {
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
