//! `demo`: runs the firmware on a scene and compares its results with the truth.

use super::firmware::FirmwareOptions;
use crate::emulator::Options;
use crate::input::{demo_scene, frame_rate_hz};
use crate::{demo, output, settings_form};
use anyhow::{Result, bail};
use clap::Args;
use std::path::PathBuf;

#[derive(Debug, Args)]
#[command(after_help = "\
Example:
  ridgetone demo --svg demo.svg")]
pub struct DemoArgs {
    /// Scene file [default: hal-mock/scenes/demo.toml].
    #[arg(long, value_name = "FILE.toml")]
    scene: Option<PathBuf>,
    /// Firmware settings to send over the serial line at start-up [default: the firmware's own].
    #[arg(long, value_name = "FILE.toml")]
    settings: Option<PathBuf>,
    #[command(flatten)]
    firmware: FirmwareOptions,
    /// Draw the channels and the results to this file.
    #[arg(long, value_name = "FILE.svg")]
    svg: Option<PathBuf>,
}

impl DemoArgs {
    pub(super) fn run(self) -> Result<()> {
        let scene = self
            .scene
            .as_ref()
            .map(|path| hal_mock::load_scene(path, frame_rate_hz()))
            .transpose()?;
        let scene = scene.map_or_else(demo_scene, Ok)?;
        if scene.hand.is_some() {
            bail!("a hand has no single speed to compare with: use `ridgetone emulate --scene`");
        }
        self.svg.as_deref().map_or(Ok(()), output::check_new)?;
        let firmware = self.firmware.image()?;
        let mut options = Options::new(&firmware);
        if let Some(path) = &self.settings {
            options.settings = settings_form::load(path)?;
        }
        let demo = output::with_progress(|progress| demo::run(scene, options, progress))?;
        if let Some(path) = &self.svg {
            output::new_text(path, &demo.svg())?;
        }
        output::line(demo.to_string().trim_end())
    }
}
