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
use crate::table_fit::{ChannelResult, Selection, TableFit};
use anyhow::Result;
use channels::{Channel, Fitted};
use ridgetone_proto::telemetry::{Abscissa, Status};
use std::path::Path;

/// Draws a fit of these samples with this selection. They are read once more.
pub fn draw(samples: &Samples, selection: &Selection, fit: &TableFit) -> Result<String> {
    let fitted = Fitted::read(samples, selection, fit)?;
    let (title, subtitle) = headline(samples.name(), fit);
    let channels = fitted.channels.iter().zip(&fit.channels);
    let strips = Strips {
        title,
        subtitle,
        warning: clipped_words(&fitted.channels),
        row: "channel",
        headings: ["each to its own scale", "close up, with the fit"],
        axis: match fit.abscissa {
            Abscissa::Time => "time, s",
            Abscissa::Place => "position, mm",
        },
        range: fitted.range(),
        close: fitted.close.clone(),
        is_in_volts: false,
        phases: None,
        strips: channels
            .map(|(channel, found)| strip(&fitted.at, channel, found))
            .collect(),
    };
    Ok(strips.picture(spectrum::panel(&fitted, fit).as_ref()))
}

fn strip(at: &[f64], channel: &Channel, found: &ChannelResult) -> Strip {
    let known = |values: &[f64]| {
        let rows = at.iter().zip(&channel.readings).zip(values);
        // Zero, where a reading is missing, is not a residual.
        let known = rows.filter(|((_, reading), _)| reading.is_some());
        known.map(|((at, _), value)| (*at, *value)).collect()
    };
    let readings = at.iter().zip(&channel.readings);
    Strip {
        name: channel.name.clone(),
        note: match (found.usable, channel.is_clipped) {
            (false, _) => "not usable",
            (true, true) => "clipped",
            (true, false) => "",
        },
        readings: readings
            .filter_map(|(at, value)| Some((*at, f64::from((*value)?))))
            .collect(),
        residual: channel.residual.as_deref().map(known).unwrap_or_default(),
        curve: channel.curve.clone(),
        amplitude: found
            .amplitude
            .map_or_else(String::new, |value| significant(value, 3)),
        explained: channel.explained,
    }
}

fn headline(file: &str, fit: &TableFit) -> (String, String) {
    let file = Path::new(file)
        .file_name()
        .map_or_else(|| file.into(), |name| name.to_string_lossy());
    let title = match (fit.tone.frequency(), fit.abscissa) {
        (Some(found), Abscissa::Time) => {
            format!("{file}: {} Hz", uncertain(found.value, found.sigma))
        }
        (Some(found), Abscissa::Place) => {
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
    for (name, value) in remarks(fit.status, fit.abscissa, &fit.tone) {
        subtitle += &format!("; {name} {value}");
    }
    (title, subtitle)
}

/// A warning of channels whose readings end at a limit.
fn clipped_words(channels: &[Channel]) -> Option<String> {
    let clipped = channels.iter().filter(|channel| channel.is_clipped).count();
    match (clipped, channels.len()) {
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
