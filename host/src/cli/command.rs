//! `command`: requests to a board.

use super::board::BoardOptions;
use crate::client::Client;
use crate::speed;
use anyhow::Result;
use clap::{Args, Subcommand};
use ridgetone_proto::command::Command;
use std::path::PathBuf;

#[derive(Debug, Subcommand)]
#[command(after_help = "\
`ridgetone settings` changes settings. `ridgetone record --raw` records raw frames.

Examples:
  ridgetone command stop
  ridgetone command follow speed.csv --port /dev/ttyUSB0")]
pub enum BoardCommand {
    /// Start over, as after power-up: the board learns its level without touch again, so nothing
    /// should touch the finger.
    #[command(after_help = "\
Example:
  ridgetone command start")]
    Start(BoardOptions),
    /// Send nothing but health until `command start`.
    #[command(after_help = "\
Example:
  ridgetone command stop")]
    Stop(BoardOptions),
    /// Reset the board; stored settings stay, a speed profile does not.
    #[command(after_help = "\
Example:
  ridgetone command restart")]
    Restart(BoardOptions),
    /// Estimate by place from now on, in cycles per mm, with this speed over the surface.
    #[command(after_help = "\
FILE.csv has the columns time_s (device time, as in the board's telemetry) and speed_mm_s, at most 32 rows, straight
lines in between. One row is a steady speed.

Example:
  ridgetone command follow speed.csv")]
    Follow(FollowArgs),
    /// Estimate by time again, in hertz.
    #[command(after_help = "\
Example:
  ridgetone command unfollow")]
    Unfollow(BoardOptions),
}

#[derive(Debug, Args)]
pub struct FollowArgs {
    /// The speed profile.
    #[arg(value_name = "FILE.csv")]
    file: PathBuf,
    /// Repeat the profile when it ends [default: its last speed goes on].
    #[arg(long)]
    repeats: bool,
    #[command(flatten)]
    board: BoardOptions,
}

impl BoardCommand {
    pub(super) fn run(self) -> Result<()> {
        let (board, request, done) = match self {
            Self::Start(board) => (board, Command::Start, "it starts over"),
            Self::Stop(board) => (
                board,
                Command::Stop,
                "it sends nothing but health until `command start`",
            ),
            Self::Restart(board) => (board, Command::Restart, "it restarts"),
            Self::Unfollow(board) => (board, Command::Unfollow, "estimates come by time"),
            Self::Follow(args) => {
                let after = speed::after(args.repeats);
                let (knots, _) = speed::knots(&args.file, after)?;
                let mut feed = args.board.open_for_request()?;
                Client::new(&mut feed).follow(&knots, after)?;
                eprintln!(
                    "ridgetone: {}: estimates come by place, in cycles per mm",
                    feed.name()
                );
                return Ok(());
            }
        };
        let mut feed = board.open_for_request()?;
        Client::new(&mut feed).request(request)?;
        eprintln!("ridgetone: {}: {done}", feed.name());
        Ok(())
    }
}
