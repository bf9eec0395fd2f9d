//! Packets printed as lines of text or of JSON.

use crate::digits::time_s;
use crate::events::{Columns, JsonLines};
use crate::feed::{Feed, Requester};
use crate::frame::Frame;
use crate::live::Counts;
use crate::note;
use crate::utc::Receipt;
use crate::{events, listen, output};
use anyhow::Result;
use clap::Args;
use ratatui::crossterm::terminal;
use ridgetone_proto::settings::Settings;
use ridgetone_proto::telemetry::{Event, Packet, Starts, Status};
use std::collections::VecDeque;
use std::io::IsTerminal;
use std::ops::ControlFlow;

#[derive(Args, Clone, Copy, Debug)]
pub struct LineOptions {
    /// One JSON object per line instead of text.
    #[arg(long)]
    pub json: bool,
}

/// Prints all packets of a feed, then the counts. Text of a recording is sorted by time; text of a
/// live board is printed at once.
pub fn print(feed: Feed, requester: Requester, lines: LineOptions) -> Result<()> {
    let mut printer = Printer::new(lines, !feed.has_board());
    let (feed, ended) = listen::run(feed, requester, &mut |packet, receipt| {
        printer.print(packet, receipt).map(ControlFlow::Continue)
    });
    drop(printer);
    report(feed.counts());
    ended
}

/// Prints the good estimates of a feed for a serial plotter, then the counts.
pub fn plot(feed: Feed, requester: Requester) -> Result<()> {
    let (feed, ended) = listen::run(feed, requester, &mut |packet, _| {
        plotted(&packet.event).map_or(Ok(()), |line| output::line(&line))?;
        Ok(ControlFlow::Continue(()))
    });
    report(feed.counts());
    ended
}

/// Formats a good estimate as names and values. Returns `None` for all other events, because a
/// plotter would draw them too.
fn plotted(event: &Event) -> Option<String> {
    match event {
        Event::Estimate(one) if one.status == Status::Good => {
            Some(format!("Hz:{},sigma:{}", one.frequency, one.sigma))
        }
        _ => None,
    }
}

/// Maximum delay of a line behind lines with later times, in seconds of device time: the estimate
/// of a whole slide comes after the slide's end.
const LATE_S: f64 = 0.5;

/// Prints packets as lines. When dropped, prints the lines that are still held.
pub struct Printer {
    json: Option<JsonLines>,
    vref_v: f32,
    /// Lines that wait for earlier ones, sorted by time; `None` if lines are not sorted.
    held: Option<VecDeque<(f64, String)>>,
    now_s: f64,
    starts: Starts,
    /// Columns of a table, in place of taxels.
    columns: Option<Columns>,
}

impl Printer {
    pub fn new(lines: LineOptions, in_order: bool) -> Self {
        let json = lines.json.then(JsonLines::default);
        // Keep JSON lines in the order of their numbers.
        let held = (in_order && json.is_none()).then(VecDeque::new);
        Self {
            json,
            vref_v: Settings::DEFAULT.vref_v,
            held,
            now_s: 0.0,
            starts: Starts::new(),
            columns: None,
        }
    }

    /// Names a table's columns instead of taxels.
    #[must_use]
    pub fn of_columns(mut self, columns: Option<Columns>) -> Self {
        self.columns = columns;
        self
    }

    pub fn print(&mut self, packet: &Packet, receipt: Option<Receipt>) -> Result<()> {
        if let Some(json) = &mut self.json {
            return output::line(&json.line(packet, receipt)?);
        }
        if let Event::Hello(hello) = &packet.event {
            self.vref_v = hello.settings.vref_v;
        }
        let volts = match &packet.event {
            Event::Raw(raw) => format!("; mV {}", millivolts(&Frame::new(raw, self.vref_v))),
            _ => String::new(),
        };
        let text = match &self.columns {
            Some(columns) => events::text_of_columns(packet, columns),
            None => events::text(packet),
        };
        let text = fitted(&(text + &volts));
        if self.starts.take(&packet.event) {
            self.flush(f64::INFINITY)?;
            self.now_s = 0.0;
        }
        let Some(held) = &mut self.held else {
            return output::line(&text);
        };
        let t_s = time_s(&packet.event).unwrap_or(self.now_s);
        self.now_s = self.now_s.max(t_s);
        let place = held.partition_point(|(held_s, _)| *held_s <= t_s);
        held.insert(place, (t_s, text));
        self.flush(self.now_s - LATE_S)
    }

    /// Prints the held lines up to this time.
    fn flush(&mut self, until_s: f64) -> Result<()> {
        let Some(held) = &mut self.held else {
            return Ok(());
        };
        let due = held.partition_point(|(t_s, _)| *t_s <= until_s);
        held.drain(..due)
            .try_for_each(|(_, text)| output::line(&text))
    }
}

impl Drop for Printer {
    fn drop(&mut self) {
        // If this fails, the reader has closed the output and does not want more lines.
        let _ = self.flush(f64::INFINITY);
    }
}

/// Formats a frame in millivolts, with a dash where a code cannot be trusted.
fn millivolts(frame: &Frame) -> String {
    let value =
        |volts: &Option<f32>| volts.map_or("-".to_owned(), |volts| format!("{:+.3}", 1e3 * volts));
    frame.volts.iter().map(value).collect::<Vec<_>>().join(" ")
}

/// Cuts lines that are wider than the terminal, if there is one.
fn fitted(text: &str) -> String {
    let width = match std::io::stdout().is_terminal() {
        true => terminal::size().map_or(usize::MAX, |(columns, _)| columns.into()),
        false => usize::MAX,
    };
    let cut = |line: &str| match line.char_indices().nth(width).is_some() {
        true => line
            .chars()
            .take(width.saturating_sub(1))
            .chain(['\u{2026}'])
            .collect(),
        false => line.to_owned(),
    };
    text.lines().map(cut).collect::<Vec<String>>().join("\n")
}

/// Writes the counts to standard error.
pub fn report(counts: Counts) {
    let Counts {
        received,
        missing,
        damaged,
        stepped_back,
    } = counts;
    let repeated = match stepped_back {
        0 => String::new(),
        _ => format!(", {stepped_back} repeated or out of order"),
    };
    note!("{received} packets received, {missing} lost, {damaged} damaged{repeated}");
}
