//! `view`: a board on a page in a browser.

use super::lines::report;
use super::source::SourceOptions;
use crate::feed::{Feed, NoBoard};
use crate::view::guard::address;
use crate::view::{Options, RunFile};
use crate::{settings_form, stop, view};
use anyhow::Result;
use clap::Args;
use std::net::SocketAddr;
use std::path::PathBuf;

#[derive(Debug, Args)]
#[command(after_help = "\
It prints the page's address; open that in a browser, or give --open. Only this computer can reach it. With an address of this
computer that others reach, or 0.0.0.0 for all of them, --listen makes a token: the printed address has it, and the QR code is
that address for a phone. What travels is not encrypted. The emulated board waits while nobody looks.

Of a recording with raw frames, mark parts to fit. `ridgetone fit FILE.csv --svg picture.svg` draws a table.

Examples:
  ridgetone view
  ridgetone view --port /dev/ttyUSB0
  ridgetone view --emulated --open
  ridgetone view --emulated=hal-mock/scenes/c7.toml --listen 127.0.0.1:9000
  ridgetone view --file touch.rec
  ridgetone view --listen 0.0.0.0:8321")]
pub struct ViewArgs {
    #[command(flatten)]
    source: SourceOptions,
    /// Apply these settings first, without storing them.
    #[arg(long, value_name = "FILE.toml", conflicts_with = "recording")]
    settings: Option<PathBuf>,
    /// Where the page is served: an address of this computer and a port; port 0 is any free one. An
    /// address that others reach needs the token that is printed with it.
    #[arg(long, value_name = "ADDRESS:PORT", default_value = "127.0.0.1:8321", value_parser = address)]
    listen: SocketAddr,
    /// Open the page in the browser.
    #[arg(long)]
    open: bool,
}

impl ViewArgs {
    pub(super) fn run(self) -> Result<()> {
        let settings = self
            .settings
            .as_deref()
            .map(settings_form::load)
            .transpose()?;
        stop::on_signal()?;
        let run = self.source.run()?.map(|run| RunFile { settings, ..run });
        let alone = run.as_ref().filter(|run| run.is_alone);
        let feed = match alone {
            Some(run) => Feed::new(NoBoard(run.path.display().to_string())),
            None => self.source.open()?,
        };
        let is_alone = alone.is_some();
        let options = Options {
            address: self.listen,
            open: self.open,
            run,
        };
        let (feed, served) = view::run(feed, settings, &options);
        if !is_alone {
            report(feed.counts());
        }
        served
    }
}
