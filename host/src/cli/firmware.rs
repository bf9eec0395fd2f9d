//! The firmware image to emulate.

use super::parse::positive;
use crate::emulator;
use anyhow::{Result, bail};
use clap::Args;
use std::path::{Path, PathBuf};
use std::time::Duration;

/// Which firmware, and how long to wait for it.
#[derive(Args, Clone, Debug)]
pub struct FirmwareOptions {
    /// Firmware image [default: target/firmware/emulated/ridgetone-firmware.elf of the workspace].
    #[arg(long, value_name = "PATH")]
    pub elf: Option<PathBuf>,
    /// Give up when the emulator shows no sign of life for this long, seconds of wall time.
    #[arg(long, value_name = "S", default_value_t = 30.0, value_parser = positive)]
    pub patience: f64,
}

impl FirmwareOptions {
    pub fn image(&self) -> Result<PathBuf> {
        match &self.elf {
            Some(elf) if !elf.is_file() => {
                bail!(
                    "{}: there is no such firmware image; `cargo xtask firmware` builds one",
                    elf.display()
                )
            }
            Some(elf) => Ok(elf.clone()),
            None => emulator::image::find(),
        }
    }

    /// How the image is run.
    pub fn options<'a>(&self, elf: &'a Path) -> emulator::Options<'a> {
        let silence = Duration::try_from_secs_f64(self.patience).unwrap_or(Duration::MAX);
        emulator::Options {
            silence,
            ..emulator::Options::new(elf)
        }
    }
}
