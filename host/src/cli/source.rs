//! The source of packets: a board, the emulated board, or a recording.

use super::board::{BoardOptions, misplaced};
use super::input::InputOptions;
use super::parse::number;
use crate::feed::{Feed, Pace};
use crate::recording::Recorded;
use crate::view::RunFile;
use anyhow::Result;
use clap::Args;
use std::path::PathBuf;

#[derive(Args, Clone, Debug)]
pub struct SourceOptions {
    /// A recording of telemetry, as `record` writes it.
    #[arg(long = "file", value_name = "RECORDING", conflicts_with_all = ["port", "usb_serial", "emulated"])]
    recording: Option<PathBuf>,
    #[command(flatten)]
    board: BoardOptions,
    #[command(flatten)]
    input: InputOptions,
    /// Speed of the emulated board or of a recording, device time over wall time; 0: as fast as
    /// possible.
    #[arg(long, value_name = "FACTOR", default_value_t = 1.0, value_parser = pace, allow_negative_numbers = true)]
    pace: f64,
    /// Play the emulated touch once instead of repeating it.
    #[arg(long, requires = "emulated", conflicts_with = "recording")]
    once: bool,
}

fn pace(text: &str) -> Result<f64, String> {
    let pace = number(text)?;
    if pace >= 0.0 {
        Ok(pace)
    } else {
        Err("must be 0, as fast as possible, or greater".into())
    }
}

impl SourceOptions {
    /// The file to look back at: a recording, or a file that no board is to play.
    pub fn run(&self) -> Option<RunFile> {
        let file = match &self.recording {
            Some(recording) => recording,
            None if self.board.is_given() || self.board.firmware.elf.is_some() => return None,
            None => self.input.file.as_ref()?,
        };
        Some(RunFile {
            path: file.clone(),
            reading: self.input.reading(),
            settings: None,
            is_alone: self.recording.is_none(),
        })
    }

    pub fn open(&self) -> Result<Feed> {
        let pace = (self.pace > 0.0).then_some(self.pace);
        let Some(path) = &self.recording else {
            return self.board.open(Some(&self.input), pace, !self.once);
        };
        if self.input.is_given() || self.board.firmware.elf.is_some() {
            return Err(misplaced());
        }
        let feed = Feed::new(Recorded::open(path)?);
        Ok(match pace {
            Some(pace) => feed.paced(Pace::new(pace)),
            None => feed,
        })
    }
}
