//! `emulate`: the firmware image on an emulated board, in front of a scene.

use super::firmware::FirmwareOptions;
use super::lines::{LineOptions, Printer, report};
use super::scene::SceneOptions;
use super::settings::SettingsOptions;
use crate::demo::later;
use crate::events::JsonLines;
use crate::events::view::Message;
use crate::input::{SLOT_S, check_length, frame_rate_hz};
use crate::note;
use crate::picture::Recording;
use crate::pseudo_terminal;
use crate::touches::first_touches;
use crate::usage::UsageError;
use crate::{emulator, output, picture, stop};
use anyhow::Result;
use clap::Args;
use hal_mock::{SlidingScene, Truth, write_csv};
use ridgetone_proto::plan::Plan;
use ridgetone_proto::telemetry::Packet;
use serde::Serialize;
use std::path::{Path, PathBuf};

#[derive(Debug, Args)]
#[command(after_help = "\
`cargo xtask firmware` builds the image. With --port the board runs in real time and is touched again and again, until Ctrl-C.

Examples:
  ridgetone emulate
  ridgetone emulate --port
  ridgetone emulate hal-mock/scenes/c7.toml --json > events.jsonl
  ridgetone emulate --settings finger.toml
  ridgetone emulate --scene-speed 48 --period 3.1 --svg run.svg --serial-out run.bin
  ridgetone emulate --scene-speed 15 --period 2.6 --print-scene trace.csv
  ridgetone emulate hal-mock/scenes/hand.toml --print-scene hand.csv")]
pub struct EmulateArgs {
    /// Scene file; hal-mock/scenes/every_key.toml explains all keys [default: a plain scene].
    #[arg(value_name = "SCENE.toml", conflicts_with_all = ["scene_speed", "period", "pure_tone", "snr"])]
    scene: Option<PathBuf>,
    #[command(flatten)]
    scene_options: SceneOptions,
    /// Write the scene as a table instead of emulating it, and print its true values. The table has
    /// time_s and 16 columns of volts, read in turn as in the scan, 241.14 times per second.
    #[arg(long, value_name = "FILE.csv", conflicts_with_all = ["port", "serial_out", "svg", "settings_file", "elf"])]
    print_scene: Option<PathBuf>,
    #[command(flatten)]
    settings: SettingsOptions,
    #[command(flatten)]
    firmware: FirmwareOptions,
    /// Print the path of a pseudo-terminal that is the board's serial line, in real time: any program
    /// can open it as a serial port.
    #[arg(long, conflicts_with_all = ["serial_out", "svg", "json", "settings_file"])]
    port: bool,
    /// Write the raw bytes of the telemetry line here.
    #[arg(long, value_name = "FILE")]
    serial_out: Option<PathBuf>,
    /// Draw the channels and the results to this file.
    #[arg(long, value_name = "FILE.svg")]
    svg: Option<PathBuf>,
    /// One JSON object per line instead of text. `left_s` is the device time at which the message's
    /// last byte had left the board; the last line has the scene's true values, on the same clock.
    #[arg(long)]
    json: bool,
}

#[derive(Serialize)]
struct TruthJson<'a> {
    r#type: &'static str,
    #[serde(flatten)]
    table: Option<TableJson<'a>>,
    #[serde(flatten, with = "TruthForm")]
    truth: Truth,
}

/// Result of writing a scene as a table.
#[derive(Serialize)]
struct TableJson<'a> {
    file: &'a str,
    rows: u64,
    rate_hz: f64,
}

/// A message, with the device time at which its last byte had left the board.
#[derive(Serialize)]
struct SentJson {
    #[serde(flatten)]
    message: Message,
    left_s: f64,
}

#[derive(Serialize)]
#[serde(remote = "Truth")]
struct TruthForm {
    contact_s: f64,
    slide_start_s: f64,
    slide_end_s: f64,
    release_s: f64,
    end_s: f64,
    frequency_hz: f64,
}

impl EmulateArgs {
    pub(super) fn run(self) -> Result<()> {
        if let Some(scene) = &self.scene
            && scene
                .extension()
                .is_none_or(|extension| extension != "toml")
        {
            let file = scene.display();
            let why = format!(
                "{file}: a scene is a .toml file; `ridgetone replay {file}` takes a recording"
            );
            return Err(UsageError(why).into());
        }
        if let Some(path) = &self.print_scene {
            return self.write_scene(path);
        }
        stop::on_signal()?;
        self.svg
            .iter()
            .chain(&self.serial_out)
            .try_for_each(|path| output::check_new(path))?;
        let firmware = self.firmware.image()?;
        let settings = self.settings.settings()?;
        let plan = &settings.plan;
        let input = self.scene_options.input(self.scene.as_deref(), plan)?;
        let input = input.open_in(plan)?;
        if let Some(warning) = &input.warning {
            note!("warning: {warning}");
        }
        if self.port {
            let input = match self.scene {
                Some(_) => input.repeated(),
                None => first_touches()?,
            };
            return pseudo_terminal::run(input, firmware);
        }
        let options = emulator::Options {
            settings,
            keep_conversions: self.svg.is_some(),
            keep_serial: self.serial_out.is_some(),
            ..emulator::Options::new(&firmware)
        };
        let truth = input.truth;
        let mut printer = Printer::new(LineOptions { json: false }, true);
        let mut lines = JsonLines::default();
        let mut packets = Vec::new();
        let mut sink = |packet: &Packet, left_s| {
            if self.svg.is_some() {
                packets.push(packet.clone());
            }
            if self.json {
                let message = lines.message(packet, None);
                let line = serde_json::to_string(&SentJson { message, left_s })?;
                return output::line(&line);
            }
            printer.print(packet, None)
        };
        let outcome =
            output::with_progress(|progress| emulator::run(input, options, &mut sink, progress))?;
        drop(printer);
        if let Some(truth) = truth.filter(|_| self.json) {
            let json = TruthJson {
                r#type: "truth",
                table: None,
                truth: later(truth, -outcome.zero_s()),
            };
            output::line(&serde_json::to_string(&json)?)?;
        }
        for finding in &outcome.findings {
            note!("a rule is broken: {finding}");
        }
        if let Some(path) = &self.serial_out {
            output::new_file(path, |file| Ok(file.write_all(&outcome.serial)?))?;
        }
        if let Some(path) = &self.svg {
            let svg = picture::draw(&Recording::new(&outcome.conversions, &packets), None);
            output::new_text(path, &svg)?;
        }
        report(outcome.counts);
        Ok(())
    }

    fn write_scene(&self, path: &Path) -> Result<()> {
        let scene = self
            .scene_options
            .sliding(self.scene.as_deref(), &Plan::PAPER)?;
        let mut scene = SlidingScene::new(scene)?;
        let (truth, rate_hz, mut rows) = (scene.truth(), frame_rate_hz(), 0);
        check_length(truth.end_s)?;
        output::new_file(path, |file| {
            rows = write_csv(&mut scene, rate_hz, SLOT_S, file)?;
            Ok(())
        })?;
        let file = path.display().to_string();
        note!(
            "{file}: {rows} rows at {rate_hz:.2} Hz; contact {:.3} s, slide {:.3} to {:.3} s, release {:.3} s, end {:.3} s, tone {:.4} Hz",
            truth.contact_s,
            truth.slide_start_s,
            truth.slide_end_s,
            truth.release_s,
            truth.end_s,
            truth.frequency_hz
        );
        if self.json {
            let json = TruthJson {
                r#type: "truth",
                table: Some(TableJson {
                    file: &file,
                    rows,
                    rate_hz,
                }),
                truth,
            };
            output::line(&serde_json::to_string(&json)?)?;
        }
        Ok(())
    }
}
