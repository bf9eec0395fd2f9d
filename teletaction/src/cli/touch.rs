//! `touch`: a texture under a person's hand.

use super::actuator::{ActuatorOptions, DelayOptions, HandOptions};
use crate::texture::{self, found};
use crate::touch::live::{Options, Textures};
use crate::touch::{Hand, Output, RATE_HZ, Run, ahap, render, serve, wav};
use anyhow::{Context, Result, bail};
use clap::Args;
use ridgetone_host::cli::board::BoardOptions;
use ridgetone_host::cli::lines::report;
use ridgetone_host::cli::parse::positive;
use ridgetone_host::feed::{Feed, FeedEvent, Pace};
use ridgetone_host::note;
use ridgetone_host::recording::{Recorded, is_telemetry};
use ridgetone_host::usage::UsageError;
use ridgetone_host::view::guard::address;
use ridgetone_host::{output, stop};
use ridgetone_stimulus::Texture;
use std::net::SocketAddr;
use std::path::{Path, PathBuf};
use std::time::Duration;

#[derive(Debug, Args)]
#[command(after_help = "\
It prints the address of a page; open that in a browser of this computer, or give --open. Press a mouse's button, a finger or a pen
on the texture, and move, or press the arrow keys. A finger's texture is a new one when its board reports one, which
has changed by more than three standard deviations; the emulated finger waits while nobody looks. A recording is one of telemetry.

What to plug into the computer's sound output: a voice coil or a piezo actuator with its amplifier, which plays the texture itself. Headphones
and loudspeakers play little below 100 Hz: for them give --carrier-hz 200, a tone whose loudness is the texture.

With -o it writes the vibration of a hand that nobody moves instead: out.wav, out.ahap, or - for raw samples of 16 bits, little endian,
48,000 a second, one channel.

Examples:
  ridgetone touch --emulated --open
  ridgetone touch texture.toml --carrier-hz 200 --open
  ridgetone touch texture.toml --law law.toml
  ridgetone touch --port /dev/ttyUSB0 --delay-ms 120 --jitter-ms 40
  ridgetone touch texture.toml --speed-mm-s 100 -o out.wav
  ridgetone touch texture.toml --speed-mm-s 125 --turns-hz 1.07 --delay-ms 120 -o out.ahap
  ridgetone touch texture.toml --speed-mm-s 100 -o - | aplay -f S16_LE -r 48000")]
pub struct TouchArgs {
    /// A texture, as `texture learn` writes it, or a recording of telemetry [default: from a
    /// board].
    #[arg(value_name = "TEXTURE", conflicts_with_all = ["port", "usb_serial", "emulated", "elf"])]
    texture: Option<PathBuf>,
    #[command(flatten)]
    board: BoardOptions,
    #[command(flatten)]
    actuator: ActuatorOptions,
    #[command(flatten)]
    delay: DelayOptions,
    /// Sound a tone of 150 to 250 Hz whose amplitude is the texture, so that a headphone makes it
    /// audible, Hz [default: the texture itself].
    #[arg(long, value_name = "HZ", value_parser = carrier)]
    carrier_hz: Option<f64>,
    #[command(flatten)]
    hand: HandOptions,
    /// Length of what is written, s.
    #[arg(long = "for", value_name = "S", default_value_t = 2.0, value_parser = positive, requires = "output")]
    seconds: f64,
    /// Write it here.
    #[arg(
        short,
        long,
        value_name = "FILE",
        requires = "texture",
        requires = "speed_mm_s"
    )]
    output: Option<PathBuf>,
    /// Where the page is served. Browsers play sound like this only from this computer's own
    /// addresses.
    #[arg(long, value_name = "ADDRESS:PORT", default_value = "127.0.0.1:8322", value_parser = address, conflicts_with = "output")]
    listen: SocketAddr,
    /// Open the page in the browser.
    #[arg(long, conflicts_with = "output")]
    open: bool,
}

/// Longest file, seconds: an hour is 350 MB.
const SECONDS_MAX: f64 = 3600.0;

/// The frequency of a carrier, where skin feels a vibration best.
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
        let delay = self.delay.delay(1)?;
        let carrier_hz = self.carrier_hz.map(|hz| hz as f32);
        if let Some(path) = &self.output {
            let texture = self
                .texture
                .as_deref()
                .context("no texture")
                .and_then(any_texture)?;
            let hand = self.hand.hand(Hand {
                speed_mm_s: 100.0,
                turns_hz: 0.0,
            })?;
            if self.seconds > SECONDS_MAX {
                return Err(
                    UsageError(format!("--for {}: at most {SECONDS_MAX} s", self.seconds)).into(),
                );
            }
            return self.write(
                path,
                &texture,
                &output,
                &Run {
                    hand,
                    delay,
                    carrier_hz,
                    seconds: self.seconds,
                },
            );
        }
        if self.hand.speed_mm_s.is_some() {
            return Err(UsageError("--speed-mm-s is for a file: add -o out.wav".into()).into());
        }
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
            address: self.listen,
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

    fn write(&self, path: &Path, texture: &Texture, output: &Output, run: &Run) -> Result<()> {
        let kind = path.extension().and_then(|kind| kind.to_str());
        let is_stdout = path == Path::new("-");
        if !is_stdout && !matches!(kind, Some("wav" | "ahap")) {
            return Err(UsageError(format!(
                "{}: write to a .wav, to an .ahap, or to -",
                path.display()
            ))
            .into());
        }
        if kind == Some("ahap") && self.carrier_hz.is_some() {
            let why = "--carrier-hz is for sound: an AHAP file has no tone of its own; write to a .wav, or to -";
            return Err(UsageError(why.into()).into());
        }
        output::check_new(path)?;
        let rendered = render(texture, output, run)?;
        match kind {
            _ if is_stdout => {
                output::new_file(path, |out| Ok(out.write_all(&wav::pcm(&rendered.samples))?))?;
            }
            Some("ahap") => {
                let pattern =
                    ahap::pattern(&rendered, texture, &run.hand, self.delay.delay_ms / 1e3);
                output::new_text(path, &(serde_json::to_string_pretty(&pattern)? + "\n"))?;
            }
            _ => output::new_file(path, |file| wav::write(file, &rendered.samples))?,
        }
        let peak = rendered
            .samples
            .iter()
            .fold(0.0f32, |peak, y| peak.max(y.abs()));
        let place = if is_stdout {
            "standard output".into()
        } else {
            path.display().to_string()
        };
        note!(
            "{place}: {:.4} mm at {:.1} mm/s is {:.1} Hz; {:.2} s at {RATE_HZ} Hz, peak {peak:.3} of 1",
            texture.period_mm,
            run.hand.speed_mm_s,
            run.hand.speed_mm_s / f64::from(texture.period_mm),
            run.seconds,
        );
        Ok(())
    }
}

/// A texture of a file, or the last one that a recorded finger has found.
fn any_texture(path: &Path) -> Result<Texture> {
    if !is_telemetry(path)? {
        return texture::load(path);
    }
    let (mut feed, mut latest) = (Feed::new(Recorded::open(path)?), None);
    loop {
        match feed.next(Duration::from_secs(1))? {
            Some(FeedEvent::Data(packet)) => latest = found(&packet).or(latest),
            Some(FeedEvent::Over) => break,
            _ => {}
        }
    }
    match latest {
        Some(texture) => Ok(texture),
        None => bail!(
            "{}: no texture in it: a slide with a spatial period is needed",
            path.display()
        ),
    }
}
