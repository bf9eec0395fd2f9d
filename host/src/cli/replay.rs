//! `replay`: a recording or a scene through the library.

use super::input::{InputOptions, remark};
use super::lines::{LineOptions, Printer, print, report};
use super::settings::SettingsOptions;
use crate::detection;
use crate::feed::{Feed, Requester};
use crate::note;
use crate::output::with_progress;
use crate::recording::Recorded;
use crate::seen::Seen;
use crate::usage::{NoEstimate, UsageError};
use crate::{recording, replay, stop};
use anyhow::Result;
use clap::Args;
use ridgetone_proto::settings::Settings;
use ridgetone_proto::telemetry::Packet;
use std::path::Path;

/// What to do with a recording without a slide.
const ALWAYS: &str =
    "`slide.rule = \"always\"` in a file for --settings takes all of it as a slide";

#[derive(Debug, Args)]
#[command(after_help = "\
FILE.csv may also be a recording of telemetry, as `record` writes it: then its packets are printed.

Examples:
  ridgetone replay trace.csv
  ridgetone replay touch.rec
  ridgetone replay counts.csv --scale 1e-3 --json
  ridgetone replay --scene hal-mock/scenes/c8.toml
  ridgetone replay --scene-speed 15 --period 2.6 --snr 10
  ridgetone replay trace.csv --speed 30 --delay 1 --length 55
  ridgetone replay trace.csv --settings finger.toml")]
pub struct ReplayArgs {
    #[command(flatten)]
    pub(super) input: InputOptions,
    #[command(flatten)]
    pub(super) settings: SettingsOptions,
    #[command(flatten)]
    lines: LineOptions,
}

impl ReplayArgs {
    pub(super) fn run(self) -> Result<()> {
        stop::on_signal()?;
        // A file that cannot be read is left to the reader of tables, whose message names the
        // problem.
        if let Some(file) = self
            .input
            .file
            .as_ref()
            .filter(|file| recording::is_telemetry(file).unwrap_or(false))
        {
            return self.print_telemetry(file);
        }
        let mut settings = self.settings.settings()?;
        let input = self.input.input(&settings.plan)?;
        if let Some(file) = &self.input.file {
            let chosen = detection::settings_for(input.open_for(&settings)?, settings)?;
            if chosen != settings {
                note!("{}: {}", file.display(), detection::ALWAYS);
            }
            settings = chosen;
        }
        let input = input.open_for(&settings)?;
        remark(&input);
        let mut printer = Printer::new(self.lines, true);
        let mut seen = Seen::default();
        let mut sink = |packet: &Packet| {
            seen.take(&packet.event);
            printer.print(packet, None)
        };
        let outcome = with_progress(|progress| replay::run(input, settings, &mut sink, progress))?;
        drop(printer);
        report(outcome.counts);
        match (
            &self.input.file,
            seen.why_no_estimate(settings.window_s, ALWAYS),
        ) {
            (Some(file), Some(why)) => Err(NoEstimate(format!("{}: {why}", file.display())).into()),
            _ => Ok(()),
        }
    }

    fn print_telemetry(&self, file: &Path) -> Result<()> {
        if self.settings.settings()? != Settings::DEFAULT || self.input.rate.is_some() {
            let file = file.display();
            let why = format!(
                "{file}: the telemetry has its settings already; for others replay its frames: `ridgetone export {file} --format csv --table frames -o frames.csv`, `ridgetone replay frames.csv`"
            );
            return Err(UsageError(why).into());
        }
        print(
            Feed::new(Recorded::open(file)?),
            Requester::default(),
            self.lines,
        )
    }
}
