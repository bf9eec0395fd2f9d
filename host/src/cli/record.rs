//! `record`: writes the telemetry of a board to a file.

use super::board::BoardOptions;
use super::lines::report;
use super::parse::positive;
use crate::feed::Requester;
use crate::{record, settings_form, stop};
use anyhow::Result;
use clap::Args;
use std::path::PathBuf;

#[derive(Debug, Args)]
#[command(after_help = "\
Ends with Ctrl-C, after --for, or when the board's scene is over; the file is valid at any moment. `monitor FILE`,
`replay` and `export` read it.

Examples:
  ridgetone record -o touch.rec
  ridgetone record --port /dev/ttyUSB0 --raw --for 60 -o touch.rec
  ridgetone record --emulated --raw -o touch.rec
  ridgetone record --raw -o - | gzip > touch.rec.gz")]
pub struct RecordArgs {
    #[command(flatten)]
    board: BoardOptions,
    /// File to write; an existing one is not overwritten. `-` is standard output, for another
    /// program.
    #[arg(short, long, value_name = "RECORDING")]
    output: PathBuf,
    /// Include every raw frame (20 kB a second).
    #[arg(long)]
    raw: bool,
    /// Length in seconds of device time [default: until Ctrl-C].
    #[arg(long = "for", value_name = "S", value_parser = positive)]
    length: Option<f64>,
    /// Apply these settings first, without storing them.
    #[arg(long, value_name = "FILE.toml")]
    settings: Option<PathBuf>,
}

impl RecordArgs {
    pub(super) fn run(self) -> Result<()> {
        let settings = self
            .settings
            .as_deref()
            .map(settings_form::load)
            .transpose()?;
        let mut requester = Requester::with_settings(settings);
        requester.want_raw_if(self.raw);
        stop::on_signal()?;
        // Run in real time: at full speed, the board would send a lot before a request takes
        // effect.
        let pace = (self.raw || settings.is_some()).then_some(1.0);
        // A length may exceed the scene of the emulated board, so repeat the scene.
        let feed = self.board.open(pace, self.length.is_some())?;
        let (feed, recorded) = record::record(feed, &self.output, requester, self.length)?;
        report(feed.counts());
        recorded
    }
}
