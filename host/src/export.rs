//! `export`: a recording of telemetry in other formats.

mod mcap;
mod schema;
mod table;

pub use table::Kind;

use crate::events;
use crate::feed::{Feed, FeedEvent, Source};
use crate::live::Counts;
use crate::output::Progress;
use crate::recording::Recorded;
use crate::stop;
use crate::teleplot::Teleplot;
use anyhow::{Result, bail};
use clap::ValueEnum;
use ridgetone_proto::telemetry::Packet;
use std::io::Write;
use std::path::Path;
use std::time::Duration;

/// Formats.
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
        Format::Ndjson => packets(path, &mut |packet| Ok(writeln!(out, "{}", events::json(packet)?)?)),
        Format::Teleplot => {
            let mut teleplot = Teleplot::default();
            packets(path, &mut |packet| match teleplot.lines(packet).as_str() {
                "" => Ok(()),
                lines => Ok(writeln!(out, "{lines}")?),
            })
        }
    }
}

/// Gives every packet of a recording to `sink`, and shows the progress.
fn packets(path: &Path, sink: &mut dyn FnMut(&Packet) -> Result<()>) -> Result<Counts> {
    let recorded = Recorded::open(path)?;
    let bytes = recorded.bytes();
    let mut feed = Feed::new(recorded);
    let mut progress = Progress::default();
    loop {
        match feed.next(Duration::ZERO)? {
            Some(FeedEvent::Data(packet)) => sink(&packet)?,
            Some(FeedEvent::Over) => break,
            _ => {}
        }
        progress.show_count("bytes", feed.source().done(), bytes);
        if stop::is_requested() {
            progress.end();
            bail!("{}: interrupted, nothing is written", feed.source().name());
        }
    }
    progress.end();
    Ok(feed.counts())
}

#[cfg(test)]
mod tests;
