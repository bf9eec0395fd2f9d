//! `fit`: the joint fit alone, on a table of channels.

use super::parse::{number, positive};
use crate::output::Progress;
use crate::speed::Column;
use crate::table_fit::Selection;
use crate::{fit_report, output, samples, settings_form, table_fit};
use anyhow::Result;
use clap::Args;
use hal_mock::TimeColumn;
use std::path::PathBuf;

#[derive(Debug, Args)]
#[command(after_help = "\
FILE.csv has a header, then one row per sample; a column time_s is the time in seconds. Separators, decimal commas and the
time's name and unit may be others: what is guessed is said. A recording of telemetry with raw frames is read too. The rate is that of the straight
line through all time stamps, and its uncertainty is a part of sigma. A gap of a few rows counts as missing rows; a blank
cell, or NaN, is a missing reading of its channel. A file may be long: no row after --to is read.

Examples:
  ridgetone fit recording.csv
  ridgetone fit recording.csv --from 1.57 --to 13.57 --json
  ridgetone fit no_time.csv --rate 241.14 --columns ain0,ain1,ain2
  ridgetone fit by_hand.csv --speed-column speed_mm_s")]
pub struct FitArgs {
    /// Recording: CSV with a header.
    #[arg(value_name = "FILE.csv")]
    file: PathBuf,
    /// Rows per second [default: from the column time_s].
    #[arg(long, value_name = "HZ", value_parser = positive)]
    rate: Option<f64>,
    /// Column that is the time, with its unit (s, ms, us, ns) if its name does not say it; `none`
    /// if none is [default: time_s, or a column whose name says that it is the time].
    #[arg(long, value_name = "NAME[:UNIT]", value_parser = TimeColumn::parse)]
    time_column: Option<TimeColumn>,
    /// First time to use, seconds as in time_s; without that column, row / rate.
    #[arg(long, value_name = "S", value_parser = number, allow_negative_numbers = true)]
    from: Option<f64>,
    /// Last time to use, seconds.
    #[arg(long, value_name = "S", value_parser = number, allow_negative_numbers = true)]
    to: Option<f64>,
    /// Fit by place, with this column as the speed over the surface, mm/s: cycles per mm at any
    /// speed.
    #[arg(long, value_name = "NAME", conflicts_with = "position_column")]
    speed_column: Option<String>,
    /// Fit by place, with this column as the place on the surface, mm.
    #[arg(long, value_name = "NAME")]
    position_column: Option<String>,
    /// Columns to fit, at most 16 [default: all but time_s, speed and place].
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    columns: Vec<String>,
    /// Settings file; only harmonics and interferer_hz are used here, and the two options below
    /// override them.
    #[arg(long, value_name = "FILE.toml")]
    settings: Option<PathBuf>,
    /// Most harmonics to fit, the fundamental included, 1 to 5 [default: 5].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u8).range(1..=5))]
    harmonics: Option<u8>,
    /// Known interferer in all columns, hertz, such as mains of 50 or 60; it may be aliased
    /// [default: none].
    #[arg(long, value_name = "HZ", value_parser = positive)]
    mains: Option<f64>,
    /// One JSON object on one line instead of the table.
    #[arg(long)]
    json: bool,
}

impl FitArgs {
    pub(super) fn run(self) -> Result<()> {
        let settings = self
            .settings
            .as_deref()
            .map(settings_form::load)
            .transpose()?;
        let mut rows = samples::open(&self.file, self.time_column.as_ref())?;
        let file = rows.file().to_owned();
        let selection = Selection {
            rate_hz: self.rate,
            from_s: self.from,
            to_s: self.to,
            columns: self.columns,
            harmonics: self
                .harmonics
                .or(settings.map(|settings| settings.harmonics)),
            place: self
                .position_column
                .map(Column::Position)
                .or(self.speed_column.map(Column::Speed)),
            interferer_hz: self.mains.or(settings
                .map(|settings| settings.interferer_hz.into())
                .filter(|hz| *hz > 0.0)),
        };
        let mut progress = Progress::default();
        let fit = table_fit::fit(&mut *rows, &selection, &mut |read| {
            progress.show(format_args!("{read} rows read"))
        });
        progress.end();
        let fit = fit?;
        if let Some(guessed) = &fit.guessed {
            eprintln!("ridgetone: {file}: {guessed}");
        }
        if let Some(warning) = fit.warning(&selection) {
            eprintln!("ridgetone: warning: {warning}");
        }
        if self.json {
            output::line(&fit_report::json(&file, &fit)?)
        } else {
            output::line(fit_report::text(&fit).trim_end())
        }
    }
}
