//! `export`: a recording of telemetry in other formats.

mod mcap;
mod packets;
mod schema;
mod table;

pub use table::Kind;

use crate::events::JsonLines;
use crate::live::Counts;
use crate::teleplot::Teleplot;
use anyhow::Result;
use clap::ValueEnum;
use packets::packets;
use std::io::Write;
use std::path::Path;

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Format {
    /// One table, of estimates, frames or health.
    Csv,
    /// One JSON object a line for each packet, as with --json.
    Ndjson,
    /// For Foxglove and PlotJuggler: a channel for each kind of packet.
    Mcap,
    /// Lines for Teleplot.
    Teleplot,
}

/// Writes a recording in a format; for CSV the table `kind`. Gives the counts of packets.
pub fn run(path: &Path, format: Format, kind: Kind, out: &mut dyn Write) -> Result<Counts> {
    match format {
        Format::Csv => table::write(path, kind, out),
        Format::Mcap => mcap::write(path, out),
        Format::Ndjson => {
            let mut json = JsonLines::default();
            packets(path, &mut |packet| Ok(writeln!(out, "{}", json.line(packet)?)?))
        }
        Format::Teleplot => {
            let mut teleplot = Teleplot::default();
            packets(path, &mut |packet| match teleplot.lines(packet).as_str() {
                "" => Ok(()),
                lines => Ok(writeln!(out, "{lines}")?),
            })
        }
    }
}

#[cfg(test)]
mod tests;
