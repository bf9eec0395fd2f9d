//! `settings`: the settings of a board.

use super::board::BoardOptions;
use crate::client::Client;
use crate::note;
use crate::{events, names, output, settings_form};
use anyhow::Result;
use clap::{Args, Subcommand};
use ridgetone_proto::command::Command;
use ridgetone_proto::plan::Gives;
use std::path::PathBuf;

#[derive(Debug, Subcommand)]
#[command(after_help = "\
Examples:
  ridgetone settings get > finger.toml
  ridgetone settings set window_s=0.5 --keep
  ridgetone replay trace.csv --settings finger.toml")]
pub enum SettingsCommand {
    /// Print the settings in force as TOML, and their origin.
    #[command(after_help = "\
Examples:
  ridgetone settings get
  ridgetone settings get --port /dev/ttyUSB0 > finger.toml")]
    Get(BoardOptions),
    /// Put settings into force, from the next window on.
    #[command(after_help = "\
A setting that is not named keeps its value on the board, or with --settings its value in that file.

Examples:
  ridgetone settings set window_s=0.5 stride_s=0.1
  ridgetone settings set plan=hand
  ridgetone settings set --settings finger.toml --keep
  ridgetone settings set array.period_max_mm=3.5 slide.rule=found")]
    Set(SetArgs),
    /// Erase the settings stored on the board, and use its defaults.
    #[command(after_help = "\
Example:
  ridgetone settings forget")]
    Forget(BoardOptions),
}

#[derive(Debug, Args)]
pub struct SetArgs {
    /// Settings by their names in the file, such as window_s=0.5.
    #[arg(value_name = "NAME=VALUE", required_unless_present = "settings")]
    changes: Vec<String>,
    /// All settings of this file; a setting that is not in it gets its default.
    #[arg(long, value_name = "FILE.toml")]
    settings: Option<PathBuf>,
    /// Store them, so that they are in force after the next start too.
    #[arg(long)]
    keep: bool,
    #[command(flatten)]
    board: BoardOptions,
}

impl SettingsCommand {
    pub(super) fn run(self) -> Result<()> {
        match self {
            Self::Get(board) => {
                let mut feed = board.open_for_request()?;
                let hello = Client::new(&mut feed).hello()?;
                note!("{}: settings {}", feed.name(), names::name(hello.source));
                return output::line(settings_form::toml(&hello.settings)?.trim_end());
            }
            Self::Set(args) => {
                let (erased, gives) = args.set()?;
                let kept = if args.keep {
                    "in force and stored"
                } else {
                    "in force until the next start"
                };
                let gives = gives.map_or(String::new(), |gives| {
                    format!(": {}", events::given(&gives))
                });
                report(&format!("{kept}{gives}"), erased);
            }
            Self::Forget(board) => {
                let erased =
                    Client::new(&mut board.open_for_request()?).request(Command::Forget)?;
                report("erased: the defaults are in force", erased);
            }
        }
        Ok(())
    }
}

impl SetArgs {
    /// Returns whether the board has erased flash, and the rates and windows of the plan.
    fn set(&self) -> Result<(bool, Option<Gives>)> {
        let from_file = self
            .settings
            .as_deref()
            .map(settings_form::load)
            .transpose()?;
        // Refuse a wrong name or value before a board is opened.
        settings_form::change(&from_file.unwrap_or_default(), &self.changes)?;
        let mut feed = self.board.open_for_request()?;
        let mut board = Client::new(&mut feed);
        let base = match from_file {
            Some(settings) => settings,
            None => board.hello()?.settings,
        };
        let settings = settings_form::change(&base, &self.changes)?;
        let erased = board.request(Command::Set {
            settings,
            keep: self.keep,
        })?;
        Ok((erased, board.gives))
    }
}

fn report(what: &str, erased: bool) {
    let erased = if erased {
        "; the flash was erased for it, which cost a second or two of conversions"
    } else {
        ""
    };
    note!("{what}{erased}");
}
