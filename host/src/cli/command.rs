//! `command`: requests to a board.

use super::board::BoardOptions;
use crate::client::Client;
use crate::note;
use anyhow::Result;
use clap::Subcommand;
use ridgetone_proto::command::Command;

#[derive(Debug, Subcommand)]
#[command(after_help = "\
`ridgetone settings` changes settings. `ridgetone record --raw` records raw frames.

Example:
  ridgetone command stop")]
pub enum BoardCommand {
    /// Start over, as after power-up: the board learns its level without touch again, so nothing
    /// should touch the finger.
    #[command(after_help = "\
Example:
  ridgetone command start")]
    Start(BoardOptions),
    /// Send only health, faults and the converter until `command start`.
    #[command(after_help = "\
Example:
  ridgetone command stop")]
    Stop(BoardOptions),
    /// Reset the board; stored settings stay.
    #[command(after_help = "\
Example:
  ridgetone command restart")]
    Restart(BoardOptions),
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
        };
        let mut feed = board.open_for_request()?;
        Client::new(&mut feed).request(request)?;
        note!("{}: {done}", feed.name());
        Ok(())
    }
}
