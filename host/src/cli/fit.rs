//! `fit`: the joint fit alone, on a table of channels.

use super::parse::{positive, time};
use crate::fit_rows::FitRows;
use crate::note;
use crate::output::Progress;
use crate::overview::Recorded;
use crate::part::Exclude;
use crate::positions::PositionFile;
use crate::samples::Samples;
use crate::speed::{Column, Quantity};
use crate::table_fit::{Band, Selection};
use crate::tables::{TableForm, TimeColumn};
use crate::track::{Point, Track};
use crate::usage::UsageError;
use crate::windows::{Steps, Window};
use crate::{fit_picture, fit_report, output, settings_form, touch_part, windows};
use anyhow::{Result, ensure};
use clap::Args;
use hal_mock::{escaped, printable};
use ridgetone_proto::settings::Declared;
use std::io::Write;
use std::path::{Path, PathBuf};

#[derive(Debug, Args)]
#[command(after_help = "\
FILE.csv has one row per sample, and a header; a column time_s is the time in seconds. Tables as instruments write them are
read too, gzip and UTF-16 included, as are WAV files and recordings of telemetry with raw frames; guesses are printed. The rate is
the slope of a straight line through all time stamps, and sigma includes its uncertainty. A gap of a few rows counts as missing
rows; rows that are not evenly spaced are fitted at their own times. A file may be long: no row after --to is read.
Exit status: 0 a fit, whatever its status; 1 an error; 2 wrong usage; 3 one row alone.

Examples:
  ridgetone fit recording.csv
  ridgetone fit touch.rec
  ridgetone fit recording.csv --from 1.57 --to 13.57 --json
  ridgetone fit recording.csv --svg fit.svg
  ridgetone fit recording.csv --exclude shared-noise,impulses --harmonics 2
  ridgetone fit sound.wav --window 0.2 --svg track.svg --labels track.TextGrid -o track.csv
  ridgetone fit monday.csv tuesday.csv --window 1 --stride 0.25 -o table.csv
  gunzip < pulse.csv.gz | ridgetone fit - --min-hz 0.7 --max-hz 3
  ridgetone fit no_time.csv --rate 241.14 --columns ain0,ain1,ain2
  ridgetone fit by_hand.csv --speed-column speed_mm_s
  ridgetone fit by_hand.csv --speed-column v:m/s
  ridgetone fit stage.csv --position-column encoder --mm-per-count 0.025
  ridgetone fit touch.rec --positions robot.csv --window 0.6")]
pub struct FitArgs {
    /// Recordings: CSV with a header; `-` is standard input. Several files or windows produce a
    /// table with one row each.
    #[arg(value_name = "FILE.csv", required = true)]
    files: Vec<PathBuf>,
    /// Fit windows of this length in seconds, back to back; a recording may have any length
    /// [default: one fit].
    #[arg(long, value_name = "S", value_parser = positive)]
    window: Option<f64>,
    /// Time from one window to the next, seconds [default: the window's length].
    #[arg(long, value_name = "S", value_parser = positive, requires = "window")]
    stride: Option<f64>,
    /// Write the table here: CSV, or lines of JSON with --json [default: standard output].
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Lowest frequency that the tone may have, hertz, such as 0.7 for a pulse, so that the
    /// fit takes neither a third of it nor a drift for the tone.
    #[arg(long, value_name = "HZ", value_parser = positive, conflicts_with_all = ["speed_column", "position_column"])]
    min_hz: Option<f64>,
    /// Highest frequency that the tone may have, hertz.
    #[arg(long, value_name = "HZ", value_parser = positive, conflicts_with_all = ["speed_column", "position_column"])]
    max_hz: Option<f64>,
    /// Rows per second, whatever the stamps say [default: from the stamps].
    #[arg(long, value_name = "HZ", value_parser = positive)]
    rate: Option<f64>,
    /// Time column, with its unit (s, ms, us, ns, min, h, d) unless its name states the unit;
    /// `none` for no time column [default: time_s, or a column whose name says that it is the
    /// time].
    #[arg(long, value_name = "NAME[:UNIT]", value_parser = TimeColumn::parse)]
    time_column: Option<TimeColumn>,
    /// Rows hold consecutive samples of one series: read them one after the other.
    #[arg(long, conflicts_with_all = ["columns", "speed_column", "position_column", "positions"])]
    flatten: bool,
    /// First time to use: seconds as in time_s, or a date; without that column, row / rate.
    #[arg(long, value_name = "S", value_parser = time, allow_negative_numbers = true)]
    from: Option<f64>,
    /// Last time to use, seconds or a date.
    #[arg(long, value_name = "S", value_parser = time, allow_negative_numbers = true)]
    to: Option<f64>,
    /// Fit all rows. Without this or a part, only the slide is fitted if four or more columns, in
    /// volts or without a unit, show a finger that touches, holds and slides.
    #[arg(long, conflicts_with_all = ["from", "to"])]
    whole: bool,
    /// Fit by position, integrated from this speed column (mm/s unless its name or the option says
    /// otherwise). The result is in cycles per mm, whatever the speed.
    #[arg(long, value_name = "NAME[:UNIT]", conflicts_with = "position_column", value_parser = speed)]
    speed_column: Option<Column>,
    /// Fit by position, with this column as the position on the surface (mm unless its name or the
    /// option says otherwise).
    #[arg(long, value_name = "NAME[:UNIT]", value_parser = position)]
    position_column: Option<Column>,
    /// Fit the raw frames of a recording by the positions or speeds of a robot in this CSV, at any
    /// speed and through turns. Times are UTC, seconds since 1970, or the device's own; the column
    /// is the one whose name begins with position or speed, or that of the two options above.
    #[arg(long, value_name = "FILE.csv", conflicts_with_all = ["min_hz", "max_hz", "rate"])]
    positions: Option<PathBuf>,
    /// Millimetres per count of the position.
    #[arg(long, value_name = "MM", value_parser = positive, requires = "position_column")]
    mm_per_count: Option<f64>,
    /// Columns to fit, by name, number or range: `Fx,Fy` or `3-8`; more than 16 in groups
    /// [default: all but time_s, speed and position].
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    columns: Vec<String>,
    /// Settings file; only harmonics, interferer_hz and the scene are used here, and the options
    /// below override them.
    #[arg(long, value_name = "FILE.toml")]
    settings: Option<PathBuf>,
    /// Maximum number of harmonics to fit, the fundamental included, 1 to 5 [default: 5].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u8).range(1..=5))]
    harmonics: Option<u8>,
    /// Effects to leave out of the model, separated by commas: faster, but biased if they are
    /// present.
    #[arg(long, value_name = "WHAT", value_delimiter = ',')]
    exclude: Vec<Exclude>,
    /// Assume a 50 % chance that the speed varies; sigma grows by 20 %.
    #[arg(long)]
    moving_speed: bool,
    /// Known interferer in all columns, hertz, such as mains of 50 or 60; it may be aliased
    /// [default: none].
    #[arg(long, value_name = "HZ", value_parser = positive)]
    mains: Option<f64>,
    /// One JSON object on one line instead of the table.
    #[arg(long)]
    json: bool,
    /// Plot channels, fit, residuals and spectra to this file; with --window the frequency of the
    /// windows over a spectrogram.
    #[arg(long, value_name = "FILE.svg")]
    svg: Option<PathBuf>,
    /// Write the frequencies of the windows as labels: for Audacity (.txt) or Praat (.TextGrid).
    #[arg(long, value_name = "FILE", requires = "window", conflicts_with_all = ["speed_column", "position_column", "positions"])]
    labels: Option<PathBuf>,
}

fn speed(text: &str) -> Result<Column, String> {
    Column::parse(Quantity::Speed, text)
}

fn position(text: &str) -> Result<Column, String> {
    Column::parse(Quantity::Position, text)
}

impl FitArgs {
    pub(super) fn run(self) -> Result<()> {
        let settings = self
            .settings
            .as_deref()
            .map(settings_form::load)
            .transpose()?;
        for path in self.svg.iter().chain(&self.output).chain(&self.labels) {
            output::check_new(path)?;
        }
        let is_batch = self.files.len() > 1 || self.window.is_some() || self.output.is_some();
        if self.files.len() > 1 && (self.svg.is_some() || self.labels.is_some()) {
            return Err(UsageError("--svg and --labels are for one file".into()).into());
        }
        let labels = self.labels.as_deref().map(LabelFile::new).transpose()?;
        let mut declared = settings.map_or(Declared::DEFAULT, |settings| settings.scene);
        self.exclude
            .iter()
            .for_each(|what| what.leave_out(&mut declared));
        declared.moving_speed |= self.moving_speed;
        let column = self
            .position_column
            .map(|column| column.with_mm_per_count(self.mm_per_count))
            .or(self.speed_column);
        let positions = self.positions.map(|path| PositionFile {
            path,
            column: column.clone(),
            time: self.time_column.clone(),
        });
        // With a file of positions the options name its columns.
        let (column, time_column) = match positions {
            Some(_) => (None, None),
            None => (column, self.time_column),
        };
        let selection = Selection {
            declared,
            rate_hz: self.rate,
            from_s: self.from,
            to_s: self.to,
            columns: self.columns,
            harmonics: self
                .harmonics
                .or(settings.map(|settings| settings.harmonics)),
            position: column,
            alignment: None,
            interferer_hz: self.mains.or(settings
                .map(|settings| settings.interferer_hz.into())
                .filter(|hz| *hz > 0.0)),
            band: Band::new(self.min_hz, self.max_hz)?,
        };
        let form = TableForm {
            time: time_column,
            is_flat: self.flatten,
            has_columns: !selection.columns.is_empty(),
        };
        if is_batch {
            let batch = Batch {
                files: &self.files,
                form: &form,
                positions: positions.as_ref(),
                selection: &selection,
                is_whole: self.whole,
                steps: self.window.map(|window_s| Steps {
                    window_s,
                    stride_s: self.stride.unwrap_or(window_s),
                }),
                is_json: self.json,
                svg: self.svg.as_deref(),
                labels,
            };
            let path = self.output.as_deref().unwrap_or(Path::new("-"));
            let mut failed = 0;
            output::whole_file(path, |out| {
                failed = batch.run(out)?;
                Ok(())
            })?;
            ensure!(
                failed == 0,
                "{failed} of {} files have no fit: the table says why",
                self.files.len()
            );
            return Ok(());
        }
        let samples = Samples::file_as(&self.files[0], form)?;
        let (samples, selection) = match &positions {
            Some(positions) => positions.join(&samples, &selection)?,
            None => (samples, selection),
        };
        let file = samples.name().to_owned();
        let mut progress = Progress::default();
        let fit = touch_part::fit(&samples, &selection, self.whole, &mut |read| {
            progress.show(format_args!("{read} rows read"))
        });
        progress.end();
        let fit = fit?;
        if let Some(guessed) = &fit.guessed {
            note!("{file}: {guessed}");
        }
        if let Some(warning) = fit.warning(&selection) {
            note!("warning: {warning}");
        }
        if let Some(path) = &self.svg {
            output::new_text(path, &fit_picture::draw(&samples, &selection, &fit)?)?;
        }
        if self.json {
            output::line(&fit_report::json(&file, &fit)?)
        } else {
            output::line(fit_report::text(&fit).trim_end())
        }
    }
}

/// Fits of many files, or of windows.
struct Batch<'a> {
    files: &'a [PathBuf],
    form: &'a TableForm,
    positions: Option<&'a PositionFile>,
    selection: &'a Selection,
    is_whole: bool,
    steps: Option<Steps>,
    is_json: bool,
    svg: Option<&'a Path>,
    labels: Option<LabelFile<'a>>,
}

/// A file of labels, by the extension of its name.
enum LabelFile<'a> {
    Audacity(&'a Path),
    Praat(&'a Path),
}

impl<'a> LabelFile<'a> {
    fn new(path: &'a Path) -> Result<Self, UsageError> {
        match path.extension().and_then(|ending| ending.to_str()) {
            Some("txt") => Ok(Self::Audacity(path)),
            Some("TextGrid") => Ok(Self::Praat(path)),
            _ => Err(UsageError(format!(
                "--labels {}: the name must end in .txt, for Audacity, or .TextGrid, for Praat",
                escaped(&path.display().to_string())
            ))),
        }
    }
}

impl Batch<'_> {
    /// Fits all files; one that cannot be read gets a row that says why. Returns the number of such
    /// files.
    fn run(&self, out: &mut dyn Write) -> Result<usize> {
        let mut rows = FitRows::new(out, self.is_json)?;
        let (mut progress, mut failed) = (Progress::default(), 0);
        for path in self.files {
            let file = path.display().to_string();
            if let Err(why) = self.one(path, &mut rows, &mut progress) {
                progress.end();
                let why = format!("{why:#}");
                note!("{why}");
                rows.refused(&escaped(&file), None, &printable(&why))?;
                failed += 1;
            }
        }
        progress.end();
        rows.finish()?;
        note!("{} rows, {} of them good", rows.count, rows.good);
        Ok(failed)
    }

    fn one(&self, path: &Path, rows: &mut FitRows, progress: &mut Progress) -> Result<()> {
        let samples = Samples::file_as(path, self.form.clone())?;
        let (samples, selection) = match self.positions {
            Some(positions) => positions.join(&samples, self.selection)?,
            None => (samples, self.selection.clone()),
        };
        let file = samples.name().to_owned();
        let mut show = |read: u64| progress.show(format_args!("{file}: {read} rows read"));
        let Some(steps) = self.steps else {
            let fit = touch_part::fit(&samples, &selection, self.is_whole, &mut show)?;
            if let Some(path) = self.svg {
                output::new_text(path, &fit_picture::draw(&samples, &selection, &fit)?)?;
            }
            return rows.fit(&file, &fit);
        };
        let mut points = Vec::new();
        let mut take = |window: Window| {
            points.extend(Point::of(&window));
            match window.fit {
                Ok(fit) => rows.fit(&file, &fit),
                Err(why) => rows.refused(&file, Some(window.from_s), &format!("{why:#}")),
            }
        };
        windows::fit(
            &mut *samples.open()?,
            &selection,
            steps,
            &mut take,
            &mut show,
        )?;
        self.draw(&samples, &selection, points, steps.window_s)
    }

    /// Writes the picture and the labels of the windows, if requested.
    fn draw(
        &self,
        samples: &Samples,
        selection: &Selection,
        points: Vec<Point>,
        window_s: f64,
    ) -> Result<()> {
        if self.svg.is_none() && self.labels.is_none() {
            return Ok(());
        }
        let file = samples.name();
        let is_empty = points.is_empty();
        ensure!(
            !is_empty,
            "{file}: no window was fitted in time: there is nothing to draw"
        );
        let recorded = Recorded::read(samples, selection, usize::MAX)?;
        let track = Track::new(points, &recorded, window_s);
        if let Some(path) = self.svg {
            output::new_text(path, &track.picture(file))?;
        }
        match self.labels {
            Some(LabelFile::Audacity(path)) => output::new_text(path, &track.audacity()),
            Some(LabelFile::Praat(path)) => output::new_text(path, &track.praat()),
            None => Ok(()),
        }
    }
}
