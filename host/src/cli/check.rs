//! `check`: a first power-up in one command.

use super::board::BoardOptions;
use super::parse::positive;
use crate::check::{Inputs, Plan, Report, gather};
use crate::output::{self, Progress};
use crate::port::{Ports, System};
use crate::stop;
use anyhow::{Result, bail};
use clap::Args;
use std::path::PathBuf;

#[derive(Debug, Args)]
#[command(after_help = "\
It takes a bit longer than --for. Do not touch the finger meanwhile. It restarts the board and restores
its settings; a stopped board starts. Exit status: 0 if nothing fails, 1 if a check fails.

Examples:
  ridgetone check
  ridgetone check --port /dev/ttyUSB0 -o check.txt
  ridgetone check --emulated --for 10 --json
  ridgetone check --inputs shorted --no-store")]
pub struct CheckArgs {
    #[command(flatten)]
    board: BoardOptions,
    /// Time to watch for losses, seconds of the board's clock.
    #[arg(long = "for", value_name = "S", default_value_t = 60.0, value_parser = positive)]
    length: f64,
    /// Connection of the analog inputs: noise is judged if they are shorted to AINCOM, pick-up
    /// unless they are open.
    #[arg(long, value_enum, value_name = "KIND", default_value_t = Inputs::InUse)]
    inputs: Inputs,
    /// Do not store settings, and do not restart the board.
    #[arg(long)]
    no_store: bool,
    /// One JSON object per line instead of text: each check, then a summary.
    #[arg(long)]
    json: bool,
    /// Also write the report here, as JSON if the name ends in .json; an existing file is kept
    /// unless --force.
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
}

impl CheckArgs {
    pub(super) fn run(self) -> Result<()> {
        self.output.as_deref().map_or(Ok(()), output::check_new)?;
        stop::on_signal()?;
        let mut feed = self.board.open_untouched()?;
        let plan = Plan {
            length_s: self.length,
            stores: !self.no_store,
            inputs: self.inputs,
        };
        let seen = gather(&mut feed, plan, &mut Progress::default());
        let report = Report::new(port_name(feed.name()), &seen);
        report.print(self.json)?;
        if let Some(path) = &self.output {
            report.write(path)?;
        }
        match (report.failed().as_slice(), seen.ended) {
            ([], None) => Ok(()),
            ([], Some(why)) => bail!("{why}"),
            (failed, _) => bail!("failed: {}", failed.join(", ")),
        }
    }
}

/// Returns the port with its USB name, if it has one.
fn port_name(name: String) -> String {
    let found = System.list().unwrap_or_default();
    found
        .iter()
        .find(|port| port.name == name)
        .map_or(name, ToString::to_string)
}
