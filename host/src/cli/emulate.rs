//! `emulate`: the firmware image in QEMU, in front of a recording or a scene.

use super::firmware::FirmwareOptions;
use super::input::InputOptions;
use super::lines::{LineOptions, Printer, report};
use super::settings::SettingsOptions;
use crate::picture::Recording;
use crate::{emulator, output, picture, stop};
use anyhow::Result;
use clap::Args;
use ridgetone_proto::telemetry::Packet;
use std::path::PathBuf;

#[derive(Debug, Args)]
#[command(after_help = "\
Exclude FILE.csv the chip feels a scene. `cargo xtask setup` installs the emulator.

Examples:
  ridgetone emulate
  ridgetone emulate --log
  ridgetone emulate trace.csv --json > events.jsonl
  ridgetone emulate --scene hal-mock/scenes/c7.toml
  ridgetone emulate trace.csv --settings finger.toml
  ridgetone emulate --scene-speed 48 --period 3.1 --svg run.svg --serial-out run.bin")]
pub struct EmulateArgs {
    #[command(flatten)]
    input: InputOptions,
    #[command(flatten)]
    settings: SettingsOptions,
    #[command(flatten)]
    firmware: FirmwareOptions,
    /// Show the firmware's log, defmt, on standard error.
    #[arg(long)]
    log: bool,
    /// Write the raw bytes of the telemetry line here.
    #[arg(long, value_name = "FILE")]
    serial_out: Option<PathBuf>,
    /// Draw the channels and the results here.
    #[arg(long, value_name = "FILE.svg")]
    svg: Option<PathBuf>,
    /// One JSON object a line instead of text.
    #[arg(long)]
    json: bool,
}

impl EmulateArgs {
    pub(super) fn run(self) -> Result<()> {
        stop::on_signal()?;
        self.svg
            .iter()
            .chain(&self.serial_out)
            .try_for_each(|path| output::check_new(path))?;
        let elf = self.firmware.image()?;
        let settings = self.settings.settings()?;
        let input = self.input.open_for(&settings)?;
        let options = emulator::Options {
            settings,
            keep_conversions: self.svg.is_some(),
            keep_serial: self.serial_out.is_some(),
            log: self
                .log
                .then_some(|line| output::error_line(format_args!("log: {line}"))),
            ..self.firmware.options(&elf)
        };
        let mut printer = Printer::new(LineOptions { json: self.json }, true);
        let mut packets = Vec::new();
        let mut sink = |packet: &Packet| {
            if self.svg.is_some() {
                packets.push(packet.clone());
            }
            printer.print(packet, None)
        };
        let outcome =
            output::with_progress(|progress| emulator::run(input, options, &mut sink, progress))?;
        drop(printer);
        for line in outcome.messages.lines() {
            output::error_line(format_args!("firmware: {line}"));
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
}
