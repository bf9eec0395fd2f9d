//! `texture`: textures from recordings, and the law that a finger has.

use crate::texture::save;
use crate::texture::{self, Learned, Speed};
use anyhow::Result;
use clap::{Args, Subcommand};
use hal_mock::TimeColumn;
use ridgetone_host::cli::parse::{number, positive};
use ridgetone_host::digits::plus_minus;
use ridgetone_host::output;
use ridgetone_host::samples::Samples;
use ridgetone_host::table_fit::Selection;
use serde::Serialize;
use std::path::PathBuf;

#[derive(Debug, Subcommand)]
#[command(after_help = "\
Example:
  ridgetone texture learn recording.csv --speed 30 -o texture.toml")]
pub enum TextureCommand {
    /// Learn a texture from recordings of a slide at a known speed.
    Learn(LearnArgs),
    /// Fit how a finger's power depends on the period, from textures of at least five periods.
    Law(LawArgs),
}

#[derive(Debug, Args)]
#[command(after_help = "\
A texture is its spatial period with sigma, its power, and its overtones: what a person needs to feel it by the place of their own hand.
Several recordings are of one texture at one speed.

Examples:
  ridgetone texture learn recording.csv --speed 30 -o texture.toml
  ridgetone texture learn recording.csv --speed 30+-0.1 --from 1.6 --to 13 --json")]
pub struct LearnArgs {
    /// Recordings: CSV with a header.
    #[arg(value_name = "FILE.csv", required = true)]
    files: Vec<PathBuf>,
    /// Speed over the surface with its standard deviation, mm/s.
    #[arg(long, value_name = "MM_S[+-SIGMA]", value_parser = speed)]
    speed: Speed,
    /// Force, N, if it is known.
    #[arg(long, value_name = "N", default_value = "0", value_parser = number)]
    force_n: f64,
    /// Rows per second [default: from the column time_s].
    #[arg(long, value_name = "HZ", value_parser = positive)]
    rate: Option<f64>,
    /// First time to use, seconds.
    #[arg(long, value_name = "S", value_parser = number, allow_negative_numbers = true)]
    from: Option<f64>,
    /// Last time to use, seconds.
    #[arg(long, value_name = "S", value_parser = number, allow_negative_numbers = true)]
    to: Option<f64>,
    /// Columns to use, at most 16 [default: all but time_s].
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    columns: Vec<String>,
    /// Column that is the time, with its unit (s, ms, us, ns) if its name does not say it; `none`
    /// if none is.
    #[arg(long, value_name = "NAME[:UNIT]", value_parser = TimeColumn::parse)]
    time_column: Option<TimeColumn>,
    /// Learn from any fit that has a tone, not from good ones alone.
    #[arg(long)]
    accept: bool,
    /// Write the texture here.
    #[arg(short, long, value_name = "FILE.toml")]
    output: Option<PathBuf>,
    /// One JSON object on one line instead of text.
    #[arg(long)]
    json: bool,
}

#[derive(Debug, Args)]
#[command(after_help = "\
Example:
  ridgetone texture law a.toml b.toml c.toml d.toml e.toml -o law.toml")]
pub struct LawArgs {
    /// Textures, as `texture learn` writes them.
    #[arg(value_name = "FILE.toml", required = true)]
    files: Vec<PathBuf>,
    /// Write the law here.
    #[arg(short, long, value_name = "FILE.toml")]
    output: Option<PathBuf>,
}

fn speed(text: &str) -> Result<Speed, String> {
    let (mm_s, sigma) = text.split_once("+-").unwrap_or((text, ""));
    let sigma_mm_s = if sigma.is_empty() {
        0.0
    } else {
        positive(sigma.trim())?
    };
    Ok(Speed {
        mm_s: positive(mm_s.trim())?,
        sigma_mm_s,
    })
}

#[derive(Serialize)]
struct Json<'a> {
    r#type: &'static str,
    recordings: usize,
    scatter: f64,
    #[serde(flatten)]
    texture: &'a ridgetone_stimulus::Texture,
}

impl TextureCommand {
    pub(super) fn run(self) -> Result<()> {
        match self {
            Self::Learn(args) => args.run(),
            Self::Law(args) => args.run(),
        }
    }
}

impl LearnArgs {
    fn run(self) -> Result<()> {
        self.output.as_deref().map_or(Ok(()), output::check_new)?;
        let files = self
            .files
            .iter()
            .map(|path| Samples::file_with(path, self.time_column.clone()))
            .collect::<Result<Vec<_>>>()?;
        let (rate_hz, from_s, to_s) = (self.rate, self.from, self.to);
        let selection = Selection {
            rate_hz,
            from_s,
            to_s,
            columns: self.columns,
            ..Selection::default()
        };
        let learned = texture::learn(&files, &selection, self.speed, self.force_n, self.accept)?;
        if let Some(path) = &self.output {
            save(path, &learned.texture)?;
        }
        let Learned {
            texture,
            recordings,
            scatter,
        } = &learned;
        if self.json {
            let json = Json {
                r#type: "texture",
                recordings: *recordings,
                scatter: *scatter,
                texture,
            };
            return output::line(&serde_json::to_string(&json)?);
        }
        let mut text = format!(
            "period     {} mm\npower      {:.4e}, the recording's unit squared",
            plus_minus(texture.period_mm.into(), texture.period_sigma_mm.into()),
            texture.power
        );
        for (n, overtone) in (2..).zip(texture.overtones) {
            text += &format!(
                "\nharmonic {n} {:.4} of the first, {:+.3} cycles",
                overtone.amplitude, overtone.phase_cycles
            );
        }
        if *scatter > 1.0 {
            text += &format!(
                "\n{recordings} recordings scatter {scatter:.1} times more than their sigmas allow"
            );
        }
        output::line(&text)
    }
}

impl LawArgs {
    fn run(self) -> Result<()> {
        self.output.as_deref().map_or(Ok(()), output::check_new)?;
        let textures = self
            .files
            .iter()
            .map(|path| texture::load(path))
            .collect::<Result<Vec<_>>>()?;
        let law = texture::law(&textures)?;
        if let Some(path) = &self.output {
            save(path, &law)?;
        }
        let [a, b, c, d, e] = law.coefficients;
        let (least, most) = law.period_mm;
        output::line(&format!(
            "power = {a:e} {b:+e} p {c:+e} p^2 {d:+e} p^3 {e:+e} p^4, p from {least} to {most} mm\npower_max {:e}",
            law.power_max
        ))
    }
}
