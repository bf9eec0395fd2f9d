//! What the simulated chip feels: a recording or a scene.

use super::parse::{number, positive};
use crate::input::{Input, Opened, Source, rate_of};
use crate::note;
use crate::samples::Samples;
use crate::usage::UsageError;
use crate::view::reading::Reading;
use anyhow::Result;
use clap::Args;
use hal_mock::{Sliding, TimeColumn};
use ridgetone_proto::plan::Plan;
use ridgetone_proto::settings::Settings;
use std::path::PathBuf;

#[derive(Args, Clone, Debug)]
pub struct SceneOptions {
    /// Scene file, such as hal-mock/scenes/c1.toml; hal-mock/scenes/every_key.toml explains all keys [default: a
    /// plain scene; with --emulated hal-mock/scenes/c1.toml].
    #[arg(long = "scene", value_name = "FILE.toml", conflicts_with_all = ["scene_speed", "period", "snr"])]
    scene_file: Option<PathBuf>,
    /// Speed of the grating, mm/s [default: 30].
    #[arg(long, value_name = "MM_S", value_parser = positive)]
    scene_speed: Option<f64>,
    /// Spatial period of the grating, mm [default: 3.6].
    #[arg(long, value_name = "MM", value_parser = positive)]
    period: Option<f64>,
    /// Power of the tone over that of the noise, dB, or `none` for no noise [default: 20].
    #[arg(long, value_name = "DB", value_parser = decibel, allow_negative_numbers = true)]
    snr: Option<Decibel>,
    /// Seed of all noise, and of the channels' differences where there is no scene file [default:
    /// 1, or the file's].
    #[arg(long, value_name = "N")]
    seed: Option<u64>,
}

#[derive(Args, Clone, Debug)]
pub struct InputOptions {
    /// Recording to play: CSV with a header, at most 16 columns of volts, and time_s [default: a
    /// scene]. Rows at the scan's rate are held, others are resampled.
    #[arg(value_name = "FILE.csv")]
    pub(super) file: Option<PathBuf>,
    /// Volts per unit of FILE.csv.
    #[arg(
        long,
        value_name = "V_PER_UNIT",
        default_value_t = 1.0,
        value_parser = number,
        allow_negative_numbers = true,
        requires = "file"
    )]
    scale: f64,
    /// Rows per second, whatever the stamps say [default: from the stamps; without any the scan's
    /// 241.14].
    #[arg(long, value_name = "HZ", value_parser = positive, requires = "file")]
    pub(super) rate: Option<f64>,
    /// Column of FILE.csv that is the time, with its unit (s, ms, us, ns) if its name does not say
    /// it; `none` if none is [default: time_s, or a column whose name says that it is the time].
    #[arg(long, value_name = "NAME[:UNIT]", value_parser = TimeColumn::parse, requires = "file")]
    time_column: Option<TimeColumn>,
    /// Noise of the converter itself, 4.5 uV rms; a scene file may switch it off too.
    #[arg(long, value_name = "on|off", default_value = "on", value_parser = on_off, action = clap::ArgAction::Set)]
    noise: bool,
    #[command(flatten)]
    pub(super) scene: SceneOptions,
}

/// A ratio of powers in decibels; none for no noise at all.
#[derive(Clone, Copy, Debug)]
struct Decibel(Option<f64>);

fn decibel(text: &str) -> Result<Decibel, String> {
    if text == "none" {
        Ok(Decibel(None))
    } else {
        number(text).map(|db| Decibel(Some(db)))
    }
}

fn on_off(text: &str) -> Result<bool, String> {
    match text {
        "on" => Ok(true),
        "off" => Ok(false),
        _ => Err("choose on or off".into()),
    }
}

impl SceneOptions {
    /// Whether an option makes a scene.
    fn makes_scene(&self) -> bool {
        let Self {
            scene_file,
            scene_speed,
            period,
            snr,
            seed: _,
        } = self;
        scene_file.is_some() || scene_speed.is_some() || period.is_some() || snr.is_some()
    }

    /// The scene that the options describe, for a plan.
    pub fn sliding(&self, plan: &Plan) -> Result<Sliding> {
        if let Some(path) = &self.scene_file {
            let scene = hal_mock::load_scene(path, rate_of(plan))?;
            return Ok(Sliding {
                seed: self.seed.unwrap_or(scene.seed),
                ..scene
            });
        }
        let default = Sliding::default();
        Ok(Sliding {
            speed_mm_s: self.scene_speed.unwrap_or(default.speed_mm_s),
            period_mm: self.period.unwrap_or(default.period_mm),
            snr_db: self.snr.map_or(default.snr_db, |Decibel(db)| db),
            seed: self.seed.unwrap_or(default.seed),
            ..default
        })
    }
}

/// Says on standard error what was guessed of an input, and its warning.
pub fn remark(input: &Opened) {
    if let Some(guessed) = &input.guessed {
        note!("{guessed}");
    }
    if let Some(warning) = &input.warning {
        note!("warning: {warning}");
    }
}

impl InputOptions {
    pub fn is_given(&self) -> bool {
        self.file.is_some() || !self.noise || self.scene.makes_scene() || self.scene.seed.is_some()
    }

    /// How a table on the page is read.
    pub fn reading(&self) -> Reading {
        Reading {
            time_column: self.time_column.clone(),
            rate_hz: self.rate,
            // Volts are the page's guess, too.
            scale: (self.scale != 1.0).then_some(self.scale),
        }
    }

    /// The input that the options describe, for a plan.
    pub fn input(&self, plan: &Plan) -> Result<Input> {
        if self.file.is_some() && self.scene.makes_scene() {
            let why = "--scene, --scene-speed, --period and --snr make a scene: they do not go with FILE.csv";
            return Err(UsageError(why.into()).into());
        }
        let (source, seed) = match &self.file {
            Some(path) => {
                let samples = Samples::file_with(path, self.time_column.clone())?;
                let source = Source::Trace {
                    samples,
                    rate_hz: self.rate,
                    volts_per_unit: self.scale,
                };
                (source, self.scene.seed.unwrap_or(1))
            }
            None => {
                let scene = self.scene.sliding(plan)?;
                let seed = scene.seed;
                (Source::Scene(scene), seed)
            }
        };
        Ok(Input {
            source,
            converter_noise: self.noise,
            seed,
        })
    }

    /// Opens an input that has to fill a window, and prints its warning.
    pub fn open_for(&self, settings: &Settings) -> Result<Opened> {
        let input = self.input(&settings.plan)?.open_for(settings)?;
        remark(&input);
        Ok(input)
    }
}
