//! Where packets come from, on the command line: a board, the emulated board, or a recording.

use super::{FirmwareOptions, InputOptions, Senseless, number};
use crate::feed::{Emulated, Feed, Pace, Source};
use crate::input::Input;
use crate::port::{Link, System, Wanted};
use crate::recording::Recorded;
use anyhow::Result;
use clap::Args;
use std::path::PathBuf;

/// Which board.
#[derive(Args, Clone, Debug)]
pub struct BoardOptions {
    /// A board at this serial port; without NAME, and without any of these, at the only one there is (`ridgetone ports`).
    #[arg(long, value_name = "NAME", num_args = 0..=1, conflicts_with_all = ["usb_serial", "emulated"])]
    pub port: Option<Option<String>>,
    /// The board, or the adapter on its line, with this USB serial number.
    #[arg(long, value_name = "NUMBER", conflicts_with = "emulated")]
    pub usb_serial: Option<String>,
    /// The emulated board: the firmware image in QEMU, in front of a scene.
    #[arg(long)]
    pub emulated: bool,
    /// Which firmware.
    #[command(flatten)]
    pub firmware: FirmwareOptions,
}

/// Which source, and how fast.
#[derive(Args, Clone, Debug)]
pub struct SourceOptions {
    /// A recording of telemetry, as `record` writes it.
    #[arg(long = "file", value_name = "RECORDING", conflicts_with_all = ["port", "usb_serial", "emulated"])]
    pub recording: Option<PathBuf>,
    /// Which board.
    #[command(flatten)]
    pub board: BoardOptions,
    /// What the emulated chip feels.
    #[command(flatten)]
    pub input: InputOptions,
    /// Seconds of device time in a second, of the emulated board and of a recording; 0: as fast as it goes.
    #[arg(long, value_name = "FACTOR", default_value_t = 1.0, value_parser = pace, allow_negative_numbers = true)]
    pub pace: f64,
    /// The emulated touch once, not again and again.
    #[arg(long, requires = "emulated", conflicts_with = "recording")]
    pub once: bool,
}

fn pace(text: &str) -> Result<f64, String> {
    let pace = number(text)?;
    if pace >= 0.0 { Ok(pace) } else { Err("must be 0, as fast as it goes, or greater".into()) }
}

impl SourceOptions {
    /// Opens the source.
    ///
    /// # Errors
    /// [`Senseless`]: options that do not go together. The source is not there.
    pub fn open(&self) -> Result<Feed> {
        let pace = (self.pace > 0.0).then_some(self.pace);
        let Some(path) = &self.recording else { return self.board.open(Some(&self.input), pace, !self.once) };
        if self.input.is_given() || self.board.firmware.elf.is_some() {
            return Err(misplaced());
        }
        let feed = Feed::<Box<dyn Source + Send>>::new(Box::new(Recorded::open(path)?));
        Ok(match pace {
            Some(pace) => feed.paced(Pace::new(pace)),
            None => feed,
        })
    }
}

fn misplaced() -> anyhow::Error {
    Senseless("FILE.csv, a scene and --elf are for the emulated board: add --emulated".into()).into()
}

impl BoardOptions {
    /// Opens the board's line. The emulated one is in front of `input`, or of a plain scene, and goes at `pace`, or as fast as
    /// it can; with `again` its input begins anew when it is over.
    ///
    /// # Errors
    /// [`Senseless`]: options that do not go together. The board is not there.
    pub fn open(&self, input: Option<&InputOptions>, pace: Option<f64>, again: bool) -> Result<Feed> {
        if self.emulated {
            let elf = self.firmware.image()?;
            let silence = self.firmware.options(&elf).silence;
            let input = input.map_or_else(|| Ok(Input::default()), InputOptions::input)?.open()?;
            if let Some(warning) = &input.warning {
                eprintln!("ridgetone: warning: {warning}");
            }
            let input = if again { input.repeated() } else { input };
            return Ok(Feed::new(Box::new(Emulated::start(input, elf, silence, pace))));
        }
        if input.is_some_and(InputOptions::is_given) || self.firmware.elf.is_some() {
            return Err(misplaced());
        }
        let wanted = match (&self.port, &self.usb_serial) {
            (Some(Some(name)), _) => Wanted::Name(name.clone()),
            (_, Some(number)) => Wanted::UsbSerial(number.clone()),
            _ => Wanted::Only,
        };
        Ok(Feed::new(Box::new(Link::open(System, wanted)?)))
    }
}
