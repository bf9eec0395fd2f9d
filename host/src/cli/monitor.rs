//! `monitor`: a board live on the terminal, or line by line.

use super::lines::{LineOptions, plot, print, report};
use super::source::SourceOptions;
use crate::feed::Requester;
use crate::monitor::Monitor;
use crate::{settings_form, stop};
use anyhow::Result;
use clap::Args;
use std::io::IsTerminal;
use std::path::PathBuf;

#[derive(Debug, Args)]
#[command(after_help = "\
The last line of the screen lists the keys. Where standard output is no terminal, and with --plain or --json,
it prints lines. A board that is unplugged is recognised by its USB serial number when it comes back, under any port
name; one without a number, by its port's name. Ctrl-C ends it.

Examples:
  ridgetone monitor
  ridgetone monitor --port /dev/ttyUSB0
  ridgetone monitor --emulated
  ridgetone monitor --emulated=hal-mock/scenes/c7.toml
  ridgetone monitor touch.rec
  ridgetone monitor --emulated --once --plain
  ridgetone monitor --plain --usb-serial A50285BI
  ridgetone monitor --plotter
  ridgetone monitor --raw --json | head")]
pub struct MonitorArgs {
    #[command(flatten)]
    source: SourceOptions,
    /// Apply these settings first, without storing them.
    #[arg(long, value_name = "FILE.toml", conflicts_with = "recording")]
    settings: Option<PathBuf>,
    /// Print lines instead of a screen.
    #[arg(long)]
    plain: bool,
    /// Request every raw frame of a board and print it; with --json, volts are next to the codes.
    /// The screen shows raw frames anyway.
    #[arg(long)]
    raw: bool,
    /// Print `Hz:8.3333,sigma:0.0002` for each good estimate, and nothing else: lines that the
    /// Arduino plotter and Serial Studio draw.
    #[arg(long, conflicts_with_all = ["plain", "raw", "json"])]
    plotter: bool,
    #[command(flatten)]
    lines: LineOptions,
}

impl MonitorArgs {
    pub(super) fn run(self) -> Result<()> {
        let settings = self
            .settings
            .as_deref()
            .map(settings_form::load)
            .transpose()?;
        stop::on_signal()?;
        let feed = self.source.open()?;
        if self.plotter {
            return plot(feed, Requester::with_settings(settings));
        }
        if self.plain || self.lines.json || !std::io::stdout().is_terminal() {
            let mut requester = Requester::with_settings(settings);
            requester.want_raw_if(self.raw);
            return print(feed, requester, self.lines);
        }
        let (feed, shown) = Monitor::new(feed, settings).run();
        report(feed.counts());
        shown
    }
}
