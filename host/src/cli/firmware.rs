//! The firmware image to emulate.

use crate::emulator::image::{self, Firmware};
use anyhow::Result;
use clap::Args;
use std::path::PathBuf;

/// Firmware for an emulated board.
#[derive(Args, Clone, Debug)]
pub struct FirmwareOptions {
    /// Firmware image of a finger, for the board to emulate. A command with embedded images also
    /// takes feather-f405 and nucleo-f446re [default: feather-f405, else
    /// target/firmware/feather-f405/ridgetone-firmware.elf of the workspace].
    #[arg(long, value_name = "PATH")]
    pub elf: Option<PathBuf>,
}

impl FirmwareOptions {
    pub fn image(&self) -> Result<Firmware> {
        self.elf.as_deref().map_or_else(image::find, image::read)
    }
}
