//! `export`: a recording of telemetry in other formats.

mod mcap;
mod packets;
mod table;

pub use table::Kind;

use crate::events::JsonLines;
use crate::live::Counts;
use anyhow::Result;
use clap::ValueEnum;
use packets::packets;
use std::io::Write;
use std::path::Path;

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Format {
    /// One table, of estimates, frames, health, or events `texture`.
    Csv,
    /// One JSON object per line for each packet, as with --json.
    Ndjson,
    /// For Foxglove and PlotJuggler: the topics of `serve`.
    Mcap,
}

impl Format {
    /// Returns the format for the extension of a file's name, if known.
    pub fn by_name(path: &Path) -> Option<Self> {
        Some(match path.extension()?.to_str()?.to_lowercase().as_str() {
            "csv" => Self::Csv,
            "ndjson" | "jsonl" => Self::Ndjson,
            "mcap" => Self::Mcap,
            _ => return None,
        })
    }
}

/// Writes a recording in a format; `kind` is the table for CSV. Returns the counts of packets.
pub fn run(path: &Path, format: Format, kind: Kind, out: &mut dyn Write) -> Result<Counts> {
    match format {
        Format::Csv => table::write(path, kind, out),
        Format::Mcap => mcap::write(path, out),
        Format::Ndjson => {
            let mut json = JsonLines::default();
            packets(path, &mut |packet, receipt| {
                Ok(writeln!(out, "{}", json.line(packet, receipt)?)?)
            })
        }
    }
}

#[cfg(test)]
mod tests;
