//! `view`: a board on a page in a browser.

use super::lines::report;
use super::source::SourceOptions;
use super::table::{OF_A_FILE, TableOptions};
use crate::feed::{Feed, NoBoard};
use crate::usage::UsageError;
use crate::view::{Options, RunFile};
use crate::{note, settings_form, stop, view};
use anyhow::Result;
use clap::Args;
use std::path::PathBuf;

#[derive(Debug, Args)]
#[command(after_help = "\
It prints the page's address, http://127.0.0.1:8321/, or one with another port if this one is taken; open it in a browser, or
give --open. Only this computer can reach it. To see it on another computer, type there:
  ssh -L 8321:localhost:8321 THIS_COMPUTER
and open http://localhost:8321/ in its browser. The emulated board waits while nobody looks.

A file, any that `ridgetone fit` reads, is shown over all of its length, with its touches and the fit: drag across the channels
to fit a part. More files can be dropped on the page. With --pace a recording of telemetry is played as a board would send it.

Examples:
  ridgetone view                        # the board, or a page that lists the ports
  ridgetone view --port /dev/ttyUSB0
  ridgetone view --emulated --open
  ridgetone view --emulated=hal-mock/scenes/c7.toml
  ridgetone view touch.rec
  ridgetone view recording.csv
  ridgetone view slist.txt --rate 200 --flatten")]
#[command(mut_arg("file", |arg| arg.help("A recording of telemetry, or any file that `ridgetone fit` reads")))]
pub struct ViewArgs {
    #[command(flatten)]
    source: SourceOptions,
    #[command(flatten)]
    table: TableOptions,
    /// Apply these settings first, without storing them.
    #[arg(long, value_name = "FILE.toml", conflicts_with = "recording")]
    settings: Option<PathBuf>,
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
        let run = self.source.run()?;
        if run.is_none() && self.table.is_given() {
            return Err(UsageError(OF_A_FILE.into()).into());
        }
        let run = run.map(|run| RunFile {
            settings,
            rate_hz: self.table.rate,
            form: self.table.form(),
            ..run
        });
        let alone = run.as_ref().filter(|run| run.is_alone);
        let feed = match alone {
            Some(run) => Feed::new(NoBoard(run.path.display().to_string())),
            // Show the page even without a board: it lists the ports.
            None if self.source.is_unnamed() => self.source.open().unwrap_or_else(|error| {
                note!("{error:#}; the page lists the ports");
                Feed::new(NoBoard("no board".into()))
            }),
            None => self.source.open()?,
        };
        let is_alone = alone.is_some();
        let options = Options {
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
