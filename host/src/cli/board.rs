//! The board to talk to.

use super::firmware::FirmwareOptions;
use super::input::{InputOptions, remark};
use crate::feed::{Emulated, Feed};
use crate::input::{Opened, first_scene};
use crate::port::{Link, System, Wanted};
use crate::touches::{first_touches, of_scene};
use crate::usage::UsageError;
use anyhow::Result;
use clap::Args;

#[derive(Args, Clone, Debug)]
pub struct BoardOptions {
    /// A board at this serial port; without NAME, and without any of these, at the only port there
    /// is (`ridgetone ports`).
    #[arg(long, value_name = "NAME", num_args = 0..=1, conflicts_with_all = ["usb_serial", "emulated"])]
    port: Option<Option<String>>,
    /// The board, or the adapter on its line, with this USB serial number.
    #[arg(long, value_name = "NUMBER", conflicts_with = "emulated")]
    usb_serial: Option<String>,
    /// The emulated board: the firmware image in QEMU, in front of a scene.
    #[arg(long)]
    emulated: bool,
    #[command(flatten)]
    pub(super) firmware: FirmwareOptions,
}

impl BoardOptions {
    /// Whether an option names a board.
    pub(super) const fn is_given(&self) -> bool {
        self.emulated || self.port.is_some() || self.usb_serial.is_some()
    }

    /// Opens the board's line. The emulated board is in front of `input`, or of the first scene,
    /// and runs at `pace`, or as fast as it can; with `again` its input repeats, and of the first
    /// scene each touch is over another grating.
    pub fn open(
        &self,
        input: Option<&InputOptions>,
        pace: Option<f64>,
        again: bool,
    ) -> Result<Feed> {
        if self.emulated {
            let input = match input.filter(|input| input.is_given()) {
                Some(input) => {
                    let input = input.input(&ridgetone_proto::plan::Plan::PAPER)?.open()?;
                    if again { input.repeated() } else { input }
                }
                None if again => first_touches()?,
                None => of_scene(first_scene()?)?,
            };
            remark(&input);
            return self.emulate(input, pace);
        }
        if input.is_some_and(InputOptions::is_given) || self.firmware.elf.is_some() {
            return Err(misplaced());
        }
        let wanted = Wanted::new(self.port.clone().flatten(), self.usb_serial.clone());
        Ok(Feed::new(Link::open(System, wanted)?))
    }

    fn emulate(&self, input: Opened, pace: Option<f64>) -> Result<Feed> {
        let elf = self.firmware.image()?;
        let silence = self.firmware.options(&elf).silence;
        Ok(Feed::new(Emulated::start(input, elf, silence, pace)))
    }

    /// Opens a board for requests alone: the emulated one feels the first scene at the speed of a
    /// real one.
    pub fn open_for_request(&self) -> Result<Feed> {
        self.open(None, Some(1.0), true)
    }

    /// Opens a board; nothing touches the emulated one.
    pub fn open_untouched(&self) -> Result<Feed> {
        if self.emulated {
            self.emulate(Opened::untouched(), Some(1.0))
        } else {
            self.open_for_request()
        }
    }
}

/// Options of the emulated board without `--emulated`.
pub fn misplaced() -> anyhow::Error {
    UsageError("FILE.csv, a scene and --elf are for the emulated board: add --emulated".into())
        .into()
}
