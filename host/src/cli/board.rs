//! The board to talk to.

use super::firmware::FirmwareOptions;
use crate::feed::{Emulation, Feed, emulated, untouched};
use crate::port::{Link, System, Wanted};
use crate::usage::UsageError;
use anyhow::Result;
use clap::Args;
use std::path::PathBuf;

#[derive(Args, Clone, Debug)]
pub struct BoardOptions {
    /// A board at this serial port; without NAME, and without any of these, at the only port there
    /// is (`ridgetone ports`).
    #[arg(long, value_name = "NAME", num_args = 0..=1, conflicts_with_all = ["usb_serial", "emulated"])]
    port: Option<Option<String>>,
    /// The board, or the adapter on its line, with this USB serial number.
    #[arg(long, value_name = "NUMBER", conflicts_with = "emulated")]
    usb_serial: Option<String>,
    /// The emulated board, in front of a scene file such as hal-mock/scenes/c7.toml
    /// [default: hal-mock/scenes/c1.toml].
    #[arg(long, value_name = "SCENE.toml", num_args = 0..=1, require_equals = true)]
    emulated: Option<Option<PathBuf>>,
    #[command(flatten)]
    firmware: FirmwareOptions,
}

impl BoardOptions {
    /// True if no board is named: the only one there is will be used.
    pub fn is_unnamed(&self) -> bool {
        let is_named = matches!(self.port, Some(Some(_))) || self.usb_serial.is_some();
        !is_named && self.emulated.is_none()
    }

    /// Opens the board's line. The emulated board runs at `pace`, or as fast as it can; with
    /// `repeats` its scene repeats, and in the first scene each touch is over a different grating.
    pub fn open(&self, pace: Option<f64>, repeats: bool) -> Result<Feed> {
        if let Some(scene) = &self.emulated {
            return emulated(scene.as_deref(), self.emulation(pace, repeats)?);
        }
        self.check_firmware()?;
        let wanted = Wanted::new(self.port.clone().flatten(), self.usb_serial.clone());
        Ok(Feed::new(Link::open(System, wanted)?))
    }

    fn emulation(&self, pace: Option<f64>, repeats: bool) -> Result<Emulation> {
        Ok(Emulation {
            firmware: self.firmware.image()?,
            pace,
            repeats,
        })
    }

    /// Refuses a firmware image unless a board is emulated.
    pub(super) fn check_firmware(&self) -> Result<()> {
        match (&self.emulated, &self.firmware.elf) {
            (None, Some(_)) => {
                let why = "--elf is for the emulated board: add --emulated";
                Err(UsageError(why.into()).into())
            }
            _ => Ok(()),
        }
    }

    /// Opens a board for requests alone; an emulated one repeats its scene in real time.
    pub fn open_for_request(&self) -> Result<Feed> {
        self.open(Some(1.0), true)
    }

    /// Opens a board; nothing touches an emulated one unless a scene is supplied.
    pub fn open_untouched(&self) -> Result<Feed> {
        match self.emulated {
            Some(None) => Ok(untouched(self.emulation(Some(1.0), false)?)),
            _ => self.open_for_request(),
        }
    }
}
