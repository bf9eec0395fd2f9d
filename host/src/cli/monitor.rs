//! `monitor`, and `listen`, which is its plain form for a board on a serial line.

use super::lines::{LineOptions, print, report};
use super::source::SourceOptions;
use crate::feed::{Feed, Requester};
use crate::monitor::Monitor;
use crate::port::{Link, System, Wanted};
use crate::{settings_form, stop};
use anyhow::Result;
use clap::{ArgGroup, Args};
use std::io::IsTerminal;
use std::path::PathBuf;

#[derive(Debug, Args)]
#[command(after_help = "\
The last line of the screen lists the keys. Where standard output is no terminal, and with --plain or --json,
it prints lines.

Examples:
  ridgetone monitor
  ridgetone monitor --port /dev/ttyUSB0
  ridgetone monitor --emulated
  ridgetone monitor --emulated --scene hal-mock/scenes/c7.toml
  ridgetone monitor --file touch.rec
  ridgetone monitor --emulated --once --plain
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
    /// Request every raw frame of a board and print it; with --json with volts beside the codes.
    /// The screen has them anyway.
    #[arg(long)]
    raw: bool,
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

#[derive(Debug, Args)]
#[command(after_help = "\
A board that is unplugged is recognised by its USB serial number when it comes back, under any port name; one without a
number, by its port's name. Ctrl-C ends it.

Examples:
  ridgetone listen --port /dev/ttyUSB0
  ridgetone listen --usb-serial A50285BI --json > events.jsonl")]
#[command(group(ArgGroup::new("board").required(true)))]
pub struct ListenArgs {
    /// The serial port's name.
    #[arg(long, value_name = "NAME", group = "board")]
    port: Option<String>,
    /// The USB serial number of the board, or of the adapter on its line.
    #[arg(long, value_name = "NUMBER", group = "board")]
    usb_serial: Option<String>,
    /// Request every raw frame and print it; with --json with volts beside the codes.
    #[arg(long)]
    raw: bool,
    #[command(flatten)]
    lines: LineOptions,
}

impl ListenArgs {
    pub(super) fn run(self) -> Result<()> {
        stop::on_signal()?;
        let wanted = Wanted::new(self.port, self.usb_serial);
        let mut requester = Requester::default();
        requester.want_raw_if(self.raw);
        print(
            Feed::new(Link::open(System, wanted)?),
            requester,
            self.lines,
        )
    }
}
