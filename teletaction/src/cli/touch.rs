//! `touch`: a texture under a person's hand.

use super::actuator::{ActuatorOptions, DelayOptions};
use crate::texture;
use crate::touch::live::{Options, Textures};
use crate::touch::serve;
use anyhow::Result;
use clap::Args;
use ridgetone_host::cli::board::BoardOptions;
use ridgetone_host::cli::lines::report;
use ridgetone_host::cli::parse::positive;
use ridgetone_host::feed::{Feed, Pace};
use ridgetone_host::recording::{Recorded, is_telemetry};
use ridgetone_host::stop;
use std::path::PathBuf;

#[derive(Debug, Args)]
#[command(after_help = "\
It prints the address of a page; open that in a browser of this computer, or give --open. Press a mouse's button, a finger or a pen
on the texture, and move, or press the arrow keys. A finger's texture is a new one when its board reports one, which
has changed by more than three standard deviations; the emulated finger waits while nobody looks. A recording is one of telemetry.

What to plug into the computer's sound output: a voice coil or a piezo actuator with its amplifier, which plays the texture itself. Headphones
and loudspeakers play little below 100 Hz: for them give --carrier-hz 200, a tone whose loudness is the texture.

Examples:
  ridgetone touch --emulated --open
  ridgetone touch texture.toml --carrier-hz 200 --open
  ridgetone touch texture.toml --law law.toml
  ridgetone touch --port /dev/ttyUSB0 --delay-ms 120 --jitter-ms 40")]
pub struct TouchArgs {
    /// A texture (at least `period_mm = 1.4`), or a recording of telemetry [default: from a
    /// board].
    #[arg(value_name = "TEXTURE", conflicts_with_all = ["port", "usb_serial", "emulated", "elf"])]
    texture: Option<PathBuf>,
    #[command(flatten)]
    board: BoardOptions,
    #[command(flatten)]
    actuator: ActuatorOptions,
    #[command(flatten)]
    delay: DelayOptions,
    /// Frequency of a tone, 150 to 250 Hz, whose amplitude follows the texture, so that headphones
    /// can play the texture [default: no tone, the texture itself].
    #[arg(long, value_name = "HZ", value_parser = carrier)]
    carrier_hz: Option<f64>,
    /// Open the page in the browser.
    #[arg(long)]
    open: bool,
}

/// Parses a carrier frequency, within the range where skin is most sensitive.
fn carrier(text: &str) -> Result<f64, String> {
    let hz = positive(text)?;
    if (150.0..=250.0).contains(&hz) {
        Ok(hz)
    } else {
        Err("choose 150 to 250".into())
    }
}

impl TouchArgs {
    pub(super) fn run(self) -> Result<()> {
        let output = self.actuator.output()?;
        self.delay.check()?;
        let carrier_hz = self.carrier_hz.map(|hz| hz as f32);
        stop::on_signal()?;
        let textures = match &self.texture {
            Some(path) if is_telemetry(path)? => Textures::Finger(Box::new(
                Feed::new(Recorded::open(path)?).paced(Pace::new(1.0)),
            )),
            Some(path) => Textures::Fixed(path.display().to_string(), texture::load(path)?),
            None => Textures::Finger(Box::new(self.board.open(Some(1.0), true)?)),
        };
        let DelayOptions {
            delay_ms,
            jitter_ms,
        } = self.delay;
        let options = Options {
            open: self.open,
            delay_ms: (delay_ms, jitter_ms),
            carrier_hz,
        };
        let (feed, served) = serve(textures, output, options);
        if let Some(feed) = feed {
            report(feed.counts());
        }
        served
    }
}
