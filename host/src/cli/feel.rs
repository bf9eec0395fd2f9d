//! `feel`: what the receptors of a finger would fire over a recording, and what people would say of
//! it.

use super::parse::{number, positive};
use crate::feel::{self, Coefficients, Criteria, ForceColumns, KnownSurface, Options};
use crate::note;
use crate::output::{self, Progress};
use crate::samples::Samples;
use crate::table_fit::Selection;
use anyhow::{Context, Result, bail};
use clap::{Args, Subcommand};
use hal_mock::TimeColumn;
use ridgetone_feel::{PAPER_WINDOW_S, Reference, force_ratio};
use std::fs::File;
use std::io::{BufRead, BufReader, Read};
use std::path::{Path, PathBuf};

#[derive(Debug, Args)]
#[command(
    args_conflicts_with_subcommands = true,
    after_help = "\
FILE.csv has a header, then one row a sample, in any unit; a column time_s is the time in seconds. The reference is a
surface of known roughness: its amplitude at speed over RSm makes the unit micrometres. Use the sliding part alone:
--from and --to count for the reference's file too. An intensity is the sum over the bins of a window of 3 s of the decades
above the receptor's threshold; per hertz it is the same with one term a hertz. Scores go from 1 to 7.

Examples:
  ridgetone feel vibration.csv --rate 10000 --reference ra_um=0.5,rsm_mm=0.1,speed_mm_s=10
  ridgetone feel vibration.csv --rate 10000 --reference ra_um=0.5,rsm_mm=0.1,speed_mm_s=10,file=smooth.csv --m 1.2+-0.1 --json
  ridgetone feel vibration.csv --rate 10000 --reference ra_um=0.5,rsm_mm=0.1,speed_mm_s=10 --svg feel.svg
  ridgetone feel train scores.csv --rate 10000 --reference ra_um=0.5,rsm_mm=0.1,speed_mm_s=10,file=smooth.csv -o mine.toml"
)]
pub struct FeelArgs {
    #[command(subcommand)]
    command: Option<FeelCommand>,
    /// Recording: CSV with a header.
    #[arg(value_name = "FILE.csv", required = true)]
    file: Option<PathBuf>,
    #[command(flatten)]
    measure: Option<MeasureOptions>,
    /// Column of FILE.csv that is the time, with its unit (s, ms, us, ns) if its name does not say
    /// it; `none` if none is.
    #[arg(long, value_name = "NAME[:UNIT]", value_parser = TimeColumn::parse)]
    time_column: Option<TimeColumn>,
    /// M, tangential over normal force, with its standard deviation.
    #[arg(long, value_name = "VALUE[+-SIGMA]", value_parser = with_sigma, conflicts_with = "image")]
    m: Option<(f32, f32)>,
    /// Columns of the tangential and of the normal force: M is their ratio over 5 to 25 mm of the
    /// run, at the reference's speed from the first row used.
    #[arg(long, value_name = "F,N", value_parser = force_columns, conflicts_with_all = ["m", "image"])]
    forces: Option<ForceColumns>,
    /// Estimate M from the last static image in the JSON lines of `replay` or `emulate`: opposite
    /// piezoresistors of a unit differ by the tangential force.
    #[arg(long, value_name = "FILE.ndjson")]
    image: Option<PathBuf>,
    /// M by a force sensor over M by the image.
    #[arg(long, value_name = "FACTOR", default_value_t = 1.0, value_parser = positive, requires = "image")]
    image_gain: f64,
    /// Coefficients of the scores [default: the paper's, equations 11 and 12].
    #[arg(long, value_name = "FILE.toml")]
    coefficients: Option<PathBuf>,
    /// Draw the spectrum and the thresholds here.
    #[arg(long, value_name = "FILE.svg")]
    svg: Option<PathBuf>,
    /// One JSON object on one line instead of the table.
    #[arg(long)]
    json: bool,
}

#[derive(Debug, Subcommand)]
enum FeelCommand {
    /// Find coefficients of scores from recordings and what people said: stepwise linear
    /// regression.
    Train(TrainArgs),
}

#[derive(Debug, Args)]
#[command(after_help = "\
scores.csv has a column file with the recording of each row (beside scores.csv), a column for each score, and a column m for
M if it is known. Rows of the same file, such as those of several people, are averaged. At least three recordings
are needed; eight are what the paper has.

Example:
  ridgetone feel train scores.csv --rate 10000 --reference ra_um=0.5,rsm_mm=0.1,speed_mm_s=10,file=smooth.csv -o mine.toml")]
struct TrainArgs {
    /// Table of recordings and scores.
    #[arg(value_name = "scores.csv")]
    scores: PathBuf,
    #[command(flatten)]
    measure: MeasureOptions,
    /// A variable enters the model below this significance; the paper's is 0.10.
    #[arg(long, value_name = "P", value_parser = probability, default_value = "0.10")]
    enter: f64,
    /// A variable leaves the model above this significance.
    #[arg(long, value_name = "P", value_parser = probability, default_value = "0.10")]
    remove: f64,
    /// Write the coefficients here, for --coefficients.
    #[arg(short, long, value_name = "FILE.toml")]
    output: Option<PathBuf>,
    /// One JSON object on one line instead of text.
    #[arg(long)]
    json: bool,
}

#[derive(Debug, Args)]
struct MeasureOptions {
    /// Surface of known roughness: Ra in um, RSm in mm, the finger's speed in mm/s; also
    /// ra_sigma_um, and file, its recording if it is not FILE.csv itself.
    #[arg(long, value_name = "ra_um=UM,rsm_mm=MM,speed_mm_s=MM_S", value_parser = reference)]
    reference: KnownSurface,
    /// Rows per second, whatever the stamps say [default: from the stamps].
    #[arg(long, value_name = "HZ", value_parser = positive)]
    rate: Option<f64>,
    /// First time to use, seconds as in time_s; without that column, row / rate.
    #[arg(long, value_name = "S", value_parser = number, allow_negative_numbers = true)]
    from: Option<f64>,
    /// Last time to use, seconds.
    #[arg(long, value_name = "S", value_parser = number, allow_negative_numbers = true)]
    to: Option<f64>,
    /// Columns to use, at most 16 [default: all but time_s].
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    columns: Vec<String>,
    /// Longest window, seconds [default: the window of the coefficients, the paper's 3 s]. Intensities
    /// of other windows are converted to that one, with more uncertainty.
    #[arg(long, value_name = "S", value_parser = positive)]
    window: Option<f64>,
}

fn probability(text: &str) -> Result<f64, String> {
    positive(text).and_then(|p| {
        if p < 1.0 {
            Ok(p)
        } else {
            Err("must be less than 1".into())
        }
    })
}

fn reference(text: &str) -> Result<KnownSurface, String> {
    let (mut ra_um, mut rsm_mm, mut speed_mm_s, mut ra_sigma_um, mut samples) =
        (None, None, None, 0.0, None);
    for part in text.split(',') {
        let (name, value) = part
            .split_once('=')
            .ok_or_else(|| format!("{part}: write NAME=VALUE"))?;
        let value_of = |value| {
            positive(value)
                .map(|value| value as f32)
                .map_err(|why| format!("{name}: {why}"))
        };
        match name {
            "ra_um" => ra_um = Some(value_of(value)?),
            "rsm_mm" => rsm_mm = Some(value_of(value)?),
            "speed_mm_s" => speed_mm_s = Some(value_of(value)?),
            "ra_sigma_um" => ra_sigma_um = value_of(value)?,
            "file" => {
                samples = Some(Samples::file(value.as_ref()).map_err(|why| format!("{why:#}"))?)
            }
            _ => {
                return Err(format!(
                    "unknown {name}: choose ra_um, rsm_mm, speed_mm_s, ra_sigma_um or file"
                ));
            }
        }
    }
    let (Some(ra_um), Some(rsm_mm), Some(speed_mm_s)) = (ra_um, rsm_mm, speed_mm_s) else {
        return Err("ra_um, rsm_mm and speed_mm_s are needed".into());
    };
    Ok(KnownSurface {
        surface: Reference {
            ra_um,
            ra_sigma_um,
            rsm_mm,
            speed_mm_s,
        },
        samples,
    })
}

fn with_sigma(text: &str) -> Result<(f32, f32), String> {
    let (value, sigma) = text
        .split_once("+-")
        .map_or((text, Ok(0.0)), |(value, sigma)| {
            (value, positive(sigma.trim()))
        });
    Ok((number(value.trim())? as f32, sigma? as f32))
}

fn force_columns(text: &str) -> Result<ForceColumns, String> {
    let (tangential, normal) = text
        .split_once(',')
        .ok_or("write the names of two columns: F,N")?;
    Ok(ForceColumns {
        tangential: tangential.to_owned(),
        normal: normal.to_owned(),
    })
}

/// Bytes in which the last static image is looked for: a day of estimates. A device may never end.
const LINES_MOST: u64 = 256 << 20;

/// M by the last static image in a file of JSON lines.
fn image_ratio(path: &Path, gain: f64) -> Result<(f32, f32)> {
    let named = || path.display().to_string();
    let file = File::open(path).with_context(named)?.take(LINES_MOST);
    let (mut levels, mut sigmas) = ([[f32::NAN; 4]; 4], [[0.0; 4]; 4]);
    let mut last = None;
    for line in BufReader::new(file).lines() {
        let line = line.with_context(named)?;
        let image = serde_json::from_str::<serde_json::Value>(&line).ok();
        last = image.filter(|line| line["type"] == "image").or(last);
    }
    let Some(image) = last else {
        bail!(
            "{}: no static image: write it with `ridgetone replay --json`",
            named()
        )
    };
    for pressed in image["taxels"].as_array().into_iter().flatten() {
        let number = |name: &str| pressed[name].as_f64().unwrap_or(f64::NAN);
        let taxel = number("taxel") as usize;
        if let Some(place) = levels.as_flattened_mut().get_mut(taxel) {
            *place = number("level_v") as f32;
            sigmas.as_flattened_mut()[taxel] = number("sigma_v") as f32;
        }
    }
    force_ratio(&levels, &sigmas, gain as f32)
        .with_context(|| format!("{}: no whole unit is alive, or nothing presses", named()))
}

impl MeasureOptions {
    fn options(self, as_window_s: f64) -> Options {
        let Self {
            reference,
            rate: rate_hz,
            from: from_s,
            to: to_s,
            columns,
            window: window_s,
        } = self;
        Options {
            selection: Selection {
                rate_hz,
                from_s,
                to_s,
                columns,
                ..Selection::default()
            },
            window_s,
            as_window_s,
            reference,
        }
    }
}

fn with_progress<T>(run: impl FnOnce(&mut dyn FnMut(u64)) -> Result<T>) -> Result<T> {
    let mut progress = Progress::default();
    let result = run(&mut |read| progress.show(format_args!("{read} rows read")));
    progress.end();
    result
}

impl FeelArgs {
    pub(super) fn run(self) -> Result<()> {
        if let Some(FeelCommand::Train(train)) = self.command {
            return train.run();
        }
        let (Some(file), Some(measure)) = (self.file, self.measure) else {
            bail!("FILE.csv and --reference are needed")
        };
        let coefficients = self
            .coefficients
            .as_deref()
            .map_or_else(|| Ok(Coefficients::paper()), Coefficients::load)?;
        let by_image = self
            .image
            .as_deref()
            .map(|path| image_ratio(path, self.image_gain))
            .transpose()?;
        let samples = Samples::file_with(&file, self.time_column)?;
        let mut options = measure.options(coefficients.window_s);
        let mut m = self.m.or(by_image);
        if let Some(forces) = &self.forces {
            m = Some(forces.ratio(&samples, &options)?);
            forces.exclude(&samples, &mut options.selection)?;
        }
        let felt = with_progress(|progress| feel::measure(&samples, &options, progress))?;
        if let Some(guessed) = &felt.guessed {
            note!("{}: {guessed}", felt.file);
        }
        if let Some(path) = &self.svg {
            output::new_text(path, &feel::draw(&felt))?;
        }
        let text = if self.json {
            feel::json(&felt, &coefficients, m)?
        } else {
            feel::text(&felt, &coefficients, m)
        };
        output::line(text.trim_end())
    }
}

impl TrainArgs {
    fn run(self) -> Result<()> {
        let options = self.measure.options(PAPER_WINDOW_S.into());
        let criteria = Criteria {
            enter: self.enter,
            remove: self.remove,
        };
        let training =
            with_progress(|progress| feel::train(&self.scores, &options, criteria, progress))?;
        if let Some(path) = &self.output {
            let Some(coefficients) = training.coefficients() else {
                bail!(
                    "{}: nothing measured explains any score: no coefficients to write",
                    training.file
                )
            };
            output::new_text(path, &coefficients.toml()?)?;
        }
        output::line(&if self.json {
            serde_json::to_string(&training)?
        } else {
            training.to_string()
        })
    }
}
