//! `command`: requests to a board.

use super::board::BoardOptions;
use super::lines::{LineOptions, print};
use crate::client::Client;
use crate::feed::Requester;
use crate::note;
use crate::profile::{Player, Profile};
use crate::stop;
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
    /// Send health, faults and the converter alone until `command start`.
    #[command(after_help = "\
Example:
  ridgetone command stop")]
    Stop(BoardOptions),
    /// Reset the board; stored settings stay.
    #[command(after_help = "\
Example:
  ridgetone command restart")]
    Restart(BoardOptions),
    /// Stream odometry to the board from a file of speeds, and print its telemetry: estimates come
    /// by place, in cycles per mm.
    #[command(after_help = "\
FILE.csv has the columns time_s (device time, as in the board's telemetry) and speed_mm_s, straight lines in between. One row is a
steady speed. It ends with the last of several rows, or with Ctrl-C; then estimates come by time again.

The board's time is known to some milliseconds. While the speed changes fast, a robot's own odometry is better: `listen --odometry`.

Examples:
  ridgetone command follow speed.csv
  ridgetone command follow stroke.csv --repeats --json")]
    Follow(FollowArgs),
}

#[derive(Debug, Args)]
pub struct FollowArgs {
    /// The speed profile.
    #[arg(value_name = "FILE.csv")]
    file: PathBuf,
    /// Repeat the profile when it ends, until Ctrl-C.
    #[arg(long)]
    repeats: bool,
    #[command(flatten)]
    lines: LineOptions,
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
                "it sends health, faults and the converter alone until `command start`",
            ),
            Self::Restart(board) => (board, Command::Restart, "it restarts"),
            Self::Follow(args) => {
                let profile = Profile::load(&args.file, args.repeats)?;
                stop::on_signal()?;
                let feed = args.board.open_for_request()?;
                let feed = feed.with_odometry(Player::new(profile));
                return print(feed, Requester::default(), args.lines);
            }
        };
        let mut feed = board.open_for_request()?;
        Client::new(&mut feed).request(request)?;
        note!("{}: {done}", feed.name());
        Ok(())
    }
}
