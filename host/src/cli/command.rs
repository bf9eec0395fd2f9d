//! `order`: what a board can be told to do.

use super::BoardOptions;
use clap::{Args, Subcommand};
use std::path::PathBuf;

/// `order`
#[derive(Debug, Subcommand)]
#[command(after_help = "\
Settings have a command of their own: `ridgetone settings`. Raw frames come with `ridgetone record --raw`.

Examples:
  ridgetone command stop
  ridgetone command follow speed.csv --port /dev/ttyUSB0")]
pub enum BoardCommand {
    /// Begin anew, as after power-up: the level without touch is learnt again, so nothing should touch the finger.
    #[command(after_help = "\
Example:
  ridgetone command start")]
    Start(BoardOptions),
    /// Tell nothing but health until `command start`.
    #[command(after_help = "\
Example:
  ridgetone command stop")]
    Stop(BoardOptions),
    /// Reset the board; what is stored stays, a speed profile does not.
    #[command(after_help = "\
Example:
  ridgetone command restart")]
    Restart(BoardOptions),
    /// Estimate by place from now on, in cycles per mm, with this speed over the surface.
    #[command(after_help = "\
FILE.csv has the columns time_s (device time, as the board tells it) and speed_mm_s, at most 32 rows, straight lines in
between. One row is a steady speed.

Example:
  ridgetone command follow speed.csv")]
    Follow(FollowArgs),
    /// Estimate by time again, in hertz.
    #[command(after_help = "\
Example:
  ridgetone command unfollow")]
    Unfollow(BoardOptions),
}

/// `order follow`
#[derive(Debug, Args)]
pub struct FollowArgs {
    /// The speed profile.
    #[arg(value_name = "FILE.csv")]
    pub file: PathBuf,
    /// It begins again where it ends [default: its last speed goes on].
    #[arg(long)]
    pub repeats: bool,
    /// Which board.
    #[command(flatten)]
    pub board: BoardOptions,
}
