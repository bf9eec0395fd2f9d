//! `replay`: a recording or a scene through the library.

use super::lines::{LineOptions, Printer, print, report};
use super::parse::number;
use super::scene::SceneOptions;
use super::settings::SettingsOptions;
use super::table::{OF_A_FILE, TableOptions};
use crate::feed::{Feed, Requester};
use crate::frames::{self, Frames, Reading};
use crate::messages::Form;
use crate::note;
use crate::output::with_progress;
use crate::recording::Recorded;
use crate::samples::Samples;
use crate::seen::Seen;
use crate::tables::TableForm;
use crate::usage::{NoEstimate, UsageError};
use crate::{replay, stop};
use anyhow::Result;
use clap::Args;
use ridgetone_proto::telemetry::Packet;
use std::path::{Path, PathBuf};

/// Advice for a recording without a slide.
const ALWAYS: &str = "`--set slide.rule=always` takes all of it as a slide";

#[derive(Debug, Args)]
#[command(after_help = "\
FILE may be a table of at most 16 channels in volts, at 180 to 23,740 rows a second: its rows go through the library as they are, at
their own rate. It may also be a recording of telemetry, as `record` writes it: then its packets are printed; with settings,
its raw frames go through the library again, bit for bit. Without FILE the library is behind a simulated ADS1258 in front of a scene.
Exit status: 3 if a recording gives no estimate.

Examples:
  ridgetone replay trace.csv
  ridgetone replay touch.rec
  ridgetone replay touch.rec --window 0.5 --set slide.rule=always
  ridgetone replay counts.csv --scale 1e-3 --json
  ridgetone replay --scene hal-mock/scenes/c8.toml
  ridgetone replay --scene-speed 15 --period 2.6 --snr 10
  ridgetone replay trace.csv --speed 30 --set slide.delay_s=1 --set slide.length_mm=55
  ridgetone replay trace.csv --settings finger.toml")]
pub struct ReplayArgs {
    /// A table with a header, or a recording of telemetry [default: a scene].
    #[arg(value_name = "FILE", conflicts_with_all = ["scene", "scene_speed", "period", "pure_tone", "snr", "seed"])]
    file: Option<PathBuf>,
    /// Volts per unit of a table.
    #[arg(
        long,
        value_name = "V_PER_UNIT",
        default_value_t = 1.0,
        value_parser = number,
        allow_negative_numbers = true,
        requires = "file"
    )]
    scale: f64,
    #[command(flatten)]
    table: TableOptions,
    /// Scene file, such as hal-mock/scenes/c1.toml; hal-mock/scenes/every_key.toml explains all keys
    /// [default: a plain scene].
    #[arg(long, value_name = "FILE.toml", conflicts_with_all = ["scene_speed", "period", "pure_tone", "snr"])]
    scene: Option<PathBuf>,
    #[command(flatten)]
    pub(super) scene_options: SceneOptions,
    #[command(flatten)]
    pub(super) settings: SettingsOptions,
    #[command(flatten)]
    lines: LineOptions,
}

impl ReplayArgs {
    pub(super) fn run(self) -> Result<()> {
        stop::on_signal()?;
        let Some(file) = &self.file else {
            if self.table.is_given() {
                return Err(UsageError(OF_A_FILE.into()).into());
            }
            return self.play_scene();
        };
        // A file that cannot be read is left to the reader of tables, whose message names the
        // problem.
        let form = Form::of(file).unwrap_or(Form::Table);
        if form != Form::Table && (self.table.form() != TableForm::default()) {
            let why = format!(
                "{}: --time-column and --flatten are for tables: telemetry has its own time",
                file.display()
            );
            return Err(UsageError(why).into());
        }
        let is_printed = !self.settings.is_given() && self.reading() == Reading::default();
        if form == Form::Telemetry && is_printed {
            let feed = Feed::new(Recorded::open(file)?);
            return print(feed, Requester::default(), self.lines);
        }
        self.play_frames(file)
    }

    fn reading(&self) -> Reading {
        Reading {
            rate_hz: self.table.rate,
            volts_per_unit: self.scale,
        }
    }

    fn play_frames(&self, file: &Path) -> Result<()> {
        let samples = Samples::file_as(file, self.table.form())?;
        let frames = Frames::open(&samples, self.reading())?;
        let settings = self.settings.over(&frames.settings, samples.name())?;
        frames.check_window(samples.name(), &settings)?;
        for remark in frames.remarks(&settings) {
            note!("{remark}");
        }
        let chosen = frames.settings_for(settings)?;
        if chosen != settings {
            note!("{}: {}", samples.name(), frames::ALWAYS);
        }
        let mut printer = Printer::new(self.lines, true).of_columns(frames.columns());
        let mut seen = Seen::default();
        let mut sink = |packet: &Packet| {
            seen.take(&packet.event);
            printer.print(packet, None)
        };
        with_progress(|progress| frames.run(&chosen, false, &mut sink, progress))?;
        drop(printer);
        match seen.why_no_estimate(chosen.window_s, ALWAYS) {
            Some(why) => Err(NoEstimate(format!("{}: {why}", samples.name())).into()),
            None => Ok(()),
        }
    }

    fn play_scene(&self) -> Result<()> {
        let settings = self.settings.settings()?;
        let plan = &settings.plan;
        let input = self.scene_options.input(self.scene.as_deref(), plan)?;
        let input = input.open_in(plan)?;
        if let Some(warning) = &input.warning {
            note!("warning: {warning}");
        }
        let mut printer = Printer::new(self.lines, true);
        let mut sink = |packet: &Packet| printer.print(packet, None);
        let outcome = with_progress(|progress| replay::run(input, settings, &mut sink, progress))?;
        drop(printer);
        report(outcome.counts);
        Ok(())
    }
}
