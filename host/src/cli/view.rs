//! `view`: a board on a page in a browser.

use super::lines::report;
use super::source::SourceOptions;
use crate::view::guard::loopback;
use crate::{settings_form, stop, view};
use anyhow::Result;
use clap::Args;
use std::net::SocketAddr;
use std::path::PathBuf;

#[derive(Debug, Args)]
#[command(after_help = "\
It prints the page's address; open that in a browser. Only this computer can reach it.

Examples:
  ridgetone view
  ridgetone view --port /dev/ttyUSB0
  ridgetone view --emulated
  ridgetone view --emulated --scene scenes/c7.toml --listen 127.0.0.1:9000
  ridgetone view --file touch.rec")]
pub struct ViewArgs {
    #[command(flatten)]
    source: SourceOptions,
    /// Put these settings into force first; they are not stored.
    #[arg(long, value_name = "FILE.toml", conflicts_with = "recording")]
    settings: Option<PathBuf>,
    /// Where the page is served: an address of this computer's own, 127.0.0.1 or `[::1]`, and a port; port 0 is any free one.
    #[arg(long, value_name = "ADDRESS:PORT", default_value = "127.0.0.1:8321", value_parser = loopback)]
    listen: SocketAddr,
}

impl ViewArgs {
    pub(super) fn run(self) -> Result<()> {
        let settings = self.settings.as_deref().map(settings_form::load).transpose()?;
        stop::on_signal()?;
        let (feed, served) = view::run(self.source.open()?, settings, self.listen);
        report(feed.counts());
        served
    }
}
