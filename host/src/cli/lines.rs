//! Packets printed as lines, of one of three kinds.

use crate::events::JsonLines;
use crate::feed::{Feed, Requester};
use crate::live::{Counts, Frame};
use crate::teleplot::Teleplot;
use crate::utc::Receipt;
use crate::{events, listen, output};
use anyhow::Result;
use clap::Args;
use ratatui::crossterm::terminal;
use ridgetone_proto::settings::Settings;
use ridgetone_proto::telemetry::{Event, Packet};
use std::io::IsTerminal;
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
    let (feed, ended) =
        listen::run(feed, requester, &mut |packet, receipt| print(packet, receipt).map(ControlFlow::Continue));
    report(feed.counts());
    ended
}

pub fn printer(lines: LineOptions) -> impl FnMut(&Packet, Option<Receipt>) -> Result<()> {
    let mut teleplot = lines.teleplot.then(Teleplot::default);
    let mut json = JsonLines::default();
    let mut vref_v = Settings::DEFAULT.vref_v;
    move |packet, receipt| match teleplot.as_mut().map(|teleplot| teleplot.lines(packet)) {
        Some(lines) if lines.is_empty() => Ok(()),
        Some(lines) => output::line(&lines),
        None if lines.json => output::line(&json.line(packet, receipt)?),
        None => {
            if let Event::Hello(hello) = &packet.event {
                vref_v = hello.settings.vref_v;
            }
            let volts = match &packet.event {
                Event::Raw(raw) => format!("; mV {}", millivolts(&Frame::new(raw, vref_v))),
                _ => String::new(),
            };
            output::line(&fitted(&(events::text(packet) + &volts)))
        }
    }
}

/// What a frame's codes are in millivolts; a dash where they cannot be trusted.
fn millivolts(frame: &Frame) -> String {
    let value = |volts: &Option<f32>| volts.map_or("-".to_owned(), |volts| format!("{:+.3}", 1e3 * volts));
    frame.volts.iter().map(value).collect::<Vec<_>>().join(" ")
}

/// A text whose lines are no wider than the terminal, if there is one.
fn fitted(text: &str) -> String {
    let width = match std::io::stdout().is_terminal() {
        true => terminal::size().map_or(usize::MAX, |(columns, _)| columns.into()),
        false => usize::MAX,
    };
    let cut = |line: &str| match line.char_indices().nth(width).is_some() {
        true => line.chars().take(width.saturating_sub(1)).chain(['\u{2026}']).collect(),
        false => line.to_owned(),
    };
    text.lines().map(cut).collect::<Vec<String>>().join("\n")
}

/// Writes the counts to standard error.
pub fn report(counts: Counts) {
    let Counts { received, missing, damaged, .. } = counts;
    eprintln!("ridgetone: {received} telemetry frames received, {missing} lost, {damaged} damaged");
}
