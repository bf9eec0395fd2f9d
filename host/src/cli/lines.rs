//! Packets printed as lines, of one of three kinds.

use crate::events::JsonLines;
use crate::feed::{Feed, Requester};
use crate::live::Counts;
use crate::teleplot::Teleplot;
use crate::{events, listen, output};
use anyhow::Result;
use clap::Args;
use ridgetone_proto::telemetry::Packet;
use std::ops::ControlFlow;

#[derive(Args, Clone, Copy, Debug)]
pub struct LineOptions {
    /// One JSON object a line instead of text.
    #[arg(long, conflicts_with = "teleplot")]
    pub json: bool,
    /// Numbers as Teleplot reads them, >NAME:TIME_MS:VALUE|g, instead of text.
    #[arg(long)]
    pub teleplot: bool,
}

/// Prints all packets of a feed, and at the end the counts.
pub fn print(feed: Feed, requester: Requester, lines: LineOptions) -> Result<()> {
    let mut print = printer(lines);
    let (feed, ended) = listen::run(feed, requester, &mut |packet| print(packet).map(ControlFlow::Continue));
    report(feed.counts());
    ended
}

pub fn printer(lines: LineOptions) -> impl FnMut(&Packet) -> Result<()> {
    let mut teleplot = lines.teleplot.then(Teleplot::default);
    let mut json = JsonLines::default();
    move |packet| match teleplot.as_mut().map(|teleplot| teleplot.lines(packet)) {
        Some(lines) if lines.is_empty() => Ok(()),
        Some(lines) => output::line(&lines),
        None if lines.json => output::line(&json.line(packet)?),
        None => output::line(&events::text(packet)),
    }
}

/// Writes the counts to standard error.
pub fn report(counts: Counts) {
    let Counts { received, missing, damaged, .. } = counts;
    eprintln!("ridgetone: {received} telemetry frames received, {missing} lost, {damaged} damaged");
}
