//! `serve`: the messages of many boards for other programs.

use super::firmware::FirmwareOptions;
use crate::serve::source::{Source, check, fingers};
use crate::serve::topic::Names;
use crate::serve::{self, Serve};
use crate::stop;
use anyhow::Result;
use clap::Args;
use std::net::SocketAddr;

#[derive(Debug, Args)]
#[command(after_help = "\
Topics are /<board>/<finger>/ and frames, contact, tone, texture, diagnostics or health. Frames are best effort; all other
messages are reliable. Losses of a slow or dead receiver are counted, and reported to it when it is back.
`cargo install --path host --features foxglove,mqtt` builds a command with both receivers. For ROS 2, Zenoh and LSL see
the guide, docs/guide/5-live-data.md.

Examples:
  ridgetone serve --finger left=/dev/ttyUSB0 --finger right=emulated --foxglove
  ridgetone serve --finger left=/dev/ttyUSB0 --mqtt mqtt://robot.local
  ridgetone serve --finger left=touch.rec --json")]
pub struct ServeArgs {
    /// A finger's name and the source of its messages: a serial port; `emulated`, or
    /// `emulated:SCENE.toml`; or a recording of telemetry, played in real time. Repeat it for each
    /// finger.
    #[arg(long = "finger", value_name = "NAME=SOURCE", required = true)]
    fingers: Vec<String>,
    /// First part of all topics: the name of the device that carries the fingers.
    #[arg(long, value_name = "NAME", default_value = "ridgetone")]
    board: String,
    /// Serve Foxglove (WebSocket) at this address. Anyone who reaches it can read, but not send.
    #[arg(long, value_name = "ADDRESS:PORT", num_args = 0..=1, default_missing_value = "127.0.0.1:8765")]
    foxglove: Option<SocketAddr>,
    /// Publish to this broker of MQTT 5: mqtt://[USER:PASSWORD@]HOST[:PORT].
    #[arg(long, value_name = "URL", num_args = 0..=1, default_missing_value = "mqtt://127.0.0.1:1883")]
    mqtt: Option<String>,
    /// Print one JSON object per line: the topic and the message.
    #[arg(long)]
    json: bool,
    /// Do not request frames; everything else takes 1 kB per second of the line.
    #[arg(long)]
    no_frames: bool,
    #[command(flatten)]
    firmware: FirmwareOptions,
}

impl ServeArgs {
    pub(super) fn run(self) -> Result<()> {
        check(&self.board)?;
        let (names, sources) = fingers(&self.fingers)?;
        let mut sinks = Vec::new();
        if let Some(address) = self.foxglove {
            sinks.push(serve::foxglove(address)?);
        }
        if let Some(url) = &self.mqtt {
            sinks.push(serve::mqtt(url)?);
        }
        if self.json {
            sinks.push(Box::new(serve::Lines));
        }
        let is_emulated = sources
            .iter()
            .any(|source| matches!(source, Source::Emulated(_)));
        let firmware = (is_emulated || self.firmware.elf.is_some())
            .then(|| self.firmware.image())
            .transpose()?;
        stop::on_signal()?;
        let names = Names {
            board: self.board,
            fingers: names,
        };
        serve::run(
            Serve {
                names,
                sources,
                firmware,
                frames: !self.no_frames,
            },
            sinks,
        )
    }
}
