//! The source of packets: a board, the emulated board, or a recording.

use super::board::BoardOptions;
use super::parse::number;
use crate::feed::{Feed, Pace};
use crate::recording::{self, Recorded};
use crate::tables::TableForm;
use crate::view::RunFile;
use anyhow::Result;
use clap::Args;
use std::path::PathBuf;

#[derive(Args, Clone, Debug)]
pub struct SourceOptions {
    /// The same as FILE.
    #[arg(long = "file", value_name = "FILE", hide = true, conflicts_with_all = ["port", "usb_serial", "emulated"])]
    recording: Option<PathBuf>,
    /// A recording of telemetry, as `record` writes it.
    #[arg(value_name = "FILE", conflicts_with_all = ["recording", "port", "usb_serial", "emulated"])]
    file: Option<PathBuf>,
    #[command(flatten)]
    board: BoardOptions,
    /// Speed of the emulated board or of a recording, device time over wall time; 0: as fast as
    /// possible [default: 1].
    #[arg(long, value_name = "FACTOR", value_parser = pace, allow_negative_numbers = true)]
    pace: Option<f64>,
    /// Play the emulated touch once instead of repeating it.
    #[arg(long, requires = "emulated")]
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
    fn recording(&self) -> Option<&PathBuf> {
        self.recording.as_ref().or(self.file.as_ref())
    }

    /// Returns the recording to look back at; with a pace, telemetry is played as well.
    pub fn run(&self) -> Result<Option<RunFile>> {
        let Some(path) = self.recording() else {
            return Ok(None);
        };
        Ok(Some(RunFile {
            path: path.clone(),
            settings: None,
            rate_hz: None,
            form: TableForm::default(),
            is_alone: self.pace.is_none() || !recording::is_telemetry(path)?,
        }))
    }

    /// True if neither a board nor a recording is named.
    pub fn is_unnamed(&self) -> bool {
        self.recording().is_none() && self.board.is_unnamed()
    }

    pub fn open(&self) -> Result<Feed> {
        let pace = Some(self.pace.unwrap_or(1.0)).filter(|pace| *pace > 0.0);
        let Some(path) = self.recording() else {
            return self.board.open(pace, !self.once);
        };
        self.board.check_firmware()?;
        let feed = Feed::new(Recorded::open(path)?);
        Ok(match pace {
            Some(pace) => feed.paced(Pace::new(pace)),
            None => feed,
        })
    }
}
