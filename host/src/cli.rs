//! The command line: what can be said, and the help that says so.

mod array;
mod live;
mod source;

pub use array::ArrayOptions;
pub use live::{
    ExportArgs, LineOptions, ListenArgs, MonitorArgs, PortsArgs, RecordArgs, SettingsCommand, SettingsGetArgs,
    SettingsSetArgs, ViewArgs,
};
pub use source::{BoardOptions, SourceOptions};

use crate::bench::BenchArgs;
use crate::calibrate::CalibrateArgs;
use crate::emulator;
use crate::faults::FaultsArgs;
use crate::input::{Input, Source, frame_rate_hz};
use crate::settings_form;
use anyhow::Result;
use clap::{Args, Parser, Subcommand};
use hal_mock::Sliding;
use ridgetone::settings::{Settings, SlideRule};
use std::fmt;
use std::path::{Path, PathBuf};
use std::time::Duration;

/// The tone of the ridges under a tactile fingertip, on a PC: the same code as on the chip.
///
/// Results go to standard output, everything else to standard error. Times of events are device time: seconds since the
/// first conversion. Exit status: 0 done, 1 an error (one line says which), 2 a command that makes no sense.
#[derive(Debug, Parser)]
#[command(name = "ridgetone", version, max_term_width = 100)]
pub struct Cli {
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
}

/// What to do.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Fit all channels of a recording with one common frequency.
    Fit(FitArgs),
    /// Run a recording or a scene through the library, behind a simulated ADS1258.
    Replay(ReplayArgs),
    /// From recordings of gratings of known period: what turns phases between the units into periods.
    Calibrate(CalibrateArgs),
    /// Run the firmware image in QEMU, with a simulated ADS1258.
    Emulate(EmulateArgs),
    /// The serial ports of this computer.
    Ports(PortsArgs),
    /// What a board does, live on the terminal.
    Monitor(MonitorArgs),
    /// The same as one page in a browser on this computer, which needs no network. Ctrl-C ends it.
    View(ViewArgs),
    /// Write what a board says into a file, as it comes.
    Record(RecordArgs),
    /// Turn a recording of telemetry into CSV, JSON lines, MCAP or lines for Teleplot.
    Export(ExportArgs),
    /// The settings in force on a board: print them, change them.
    #[command(subcommand)]
    Settings(SettingsCommand),
    /// What a board on a serial line says. When it is unplugged it is waited for.
    Listen(ListenArgs),
    /// A scene through the emulated firmware: what it found beside the truth, and a picture.
    Demo(DemoArgs),
    /// Repeat the paper's experiment on the physical finger, figure for figure beside its own.
    Reproduce(ReproduceArgs),
    /// Count the instructions of the firmware's steps and measure their accuracy. `cargo xtask bench` builds what it
    /// needs.
    #[command(hide = true)]
    Bench(BenchArgs),
    /// Inject faults into the chip, its bus and its lines, and tell what became of them. `cargo xtask faults` writes docs/faults.md.
    #[command(hide = true)]
    Faults(FaultsArgs),
    /// Write a scene as a CSV trace and tell the truth about it.
    Scene(SceneArgs),
}

/// `fit`
#[derive(Debug, Args)]
#[command(after_help = "\
FILE.csv has a header, then one row per sample; a column time_s is the time in seconds. Jitter of the
time stamps is averaged out, and a gap of a few rows counts as missing rows.

Examples:
  ridgetone fit recording.csv
  ridgetone fit recording.csv --from 1.57 --to 13.57 --json
  ridgetone fit no_time.csv --rate 241.14 --columns ain0,ain1,ain2
  ridgetone fit by_hand.csv --speed-column speed_mm_s")]
pub struct FitArgs {
    /// Recording: CSV with a header.
    #[arg(value_name = "FILE.csv")]
    pub file: PathBuf,
    /// Rows per second [default: from the column time_s].
    #[arg(long, value_name = "HZ", value_parser = positive)]
    pub rate: Option<f64>,
    /// First time to use, seconds as in time_s; without that column, row / rate.
    #[arg(long, value_name = "S", value_parser = number, allow_negative_numbers = true)]
    pub from: Option<f64>,
    /// Last time to use, seconds.
    #[arg(long, value_name = "S", value_parser = number, allow_negative_numbers = true)]
    pub to: Option<f64>,
    /// Fit by place, with this column as the speed over the surface, mm/s: cycles per mm, however the speed varies.
    #[arg(long, value_name = "NAME", conflicts_with = "position_column")]
    pub speed_column: Option<String>,
    /// Fit by place, with this column as the place on the surface, mm.
    #[arg(long, value_name = "NAME")]
    pub position_column: Option<String>,
    /// Columns to fit, at most 16 [default: all but time_s, speed and place].
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    pub columns: Vec<String>,
    /// Most harmonics to fit, the fundamental included, 1 to 5.
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = clap::value_parser!(u8).range(1..=5))]
    pub harmonics: u8,
    /// Known interferer in all columns, hertz, such as mains of 50 or 60; it may be aliased [default: none].
    #[arg(long, value_name = "HZ", value_parser = positive)]
    pub mains: Option<f64>,
    /// One JSON object on one line instead of the table.
    #[arg(long)]
    pub json: bool,
}

/// Parameters of the scene.
#[derive(Args, Clone, Debug)]
pub struct SceneOptions {
    /// Scene file, such as scenes/c1.toml; scenes/every_key.toml tells what may be in it [default: a plain scene].
    #[arg(long = "scene", value_name = "FILE.toml", conflicts_with_all = ["scene_speed", "period", "snr"])]
    pub scene_file: Option<PathBuf>,
    /// Speed of the grating, mm/s [default: 30].
    #[arg(long, value_name = "MM_S", value_parser = positive)]
    pub scene_speed: Option<f64>,
    /// Spatial period of the grating, mm [default: 3.6].
    #[arg(long, value_name = "MM", value_parser = positive)]
    pub period: Option<f64>,
    /// Power of the tone over that of the noise, dB, or `none` for no noise [default: 20].
    #[arg(long, value_name = "DB", value_parser = decibel, allow_negative_numbers = true)]
    pub snr: Option<Decibel>,
    /// Seed of all noise, and of the channels' differences where there is no scene file [default: 1, or the file's].
    #[arg(long, value_name = "N")]
    pub seed: Option<u64>,
}

/// What the chip feels.
#[derive(Args, Clone, Debug)]
pub struct InputOptions {
    /// Recording to play: CSV with a header, at most 16 columns of volts, and time_s [default: a scene].
    #[arg(value_name = "FILE.csv")]
    pub file: Option<PathBuf>,
    /// Volts per unit of FILE.csv.
    #[arg(
        long,
        value_name = "V_PER_UNIT",
        default_value_t = 1.0,
        value_parser = number,
        allow_negative_numbers = true,
        requires = "file"
    )]
    pub scale: f64,
    /// Rows per second where FILE.csv has no time_s [default: the scan's 241.14].
    #[arg(long, value_name = "HZ", value_parser = positive, requires = "file")]
    pub rate: Option<f64>,
    /// Noise of the converter itself, 4.5 uV rms; a scene file may switch it off too.
    #[arg(long, value_name = "on|off", default_value = "on", value_parser = on_off, action = clap::ArgAction::Set)]
    pub noise: bool,
    /// The scene, without FILE.csv.
    #[command(flatten)]
    pub scene: SceneOptions,
}

/// Settings of the library.
#[derive(Args, Clone, Debug)]
pub struct SettingsOptions {
    /// Settings to begin with, as `settings get` prints them; the options below go over them [default: the library's].
    #[arg(long = "settings", value_name = "FILE.toml")]
    pub settings_file: Option<PathBuf>,
    /// Length of a window, seconds, 0.1 to 3.9 [default: 1].
    #[arg(long, value_name = "S")]
    pub window: Option<f32>,
    /// From the start of one window to that of the next, seconds [default: 0.25].
    #[arg(long, value_name = "S")]
    pub hop: Option<f32>,
    /// Most harmonics to fit, 1 to 5 [default: 4].
    #[arg(long, value_name = "N")]
    pub harmonics: Option<u8>,
    /// Accuracy asked for, percent of the frequency (one standard deviation): an estimate comes as soon as it
    /// is met, checked every --hop, or with a window of --window [default: windows of fixed length].
    #[arg(long, value_name = "PERCENT")]
    pub accuracy: Option<f32>,
    /// Known interferer in all channels, hertz, such as mains of 50 or 60 [default: none].
    #[arg(long, value_name = "HZ")]
    pub mains: Option<f32>,
    /// Speed of the stimulus, mm/s: the slide goes by the protocol [default: it is found in the signal].
    #[arg(long, value_name = "MM_S")]
    pub speed: Option<f32>,
    /// By the protocol: from contact to slide, seconds.
    #[arg(long, value_name = "S", default_value_t = 1.0, requires = "speed")]
    pub delay: f32,
    /// By the protocol: length of the slide to use, mm.
    #[arg(long, value_name = "MM", default_value_t = 55.0, requires = "speed")]
    pub length: f32,
    /// The units and the gratings.
    #[command(flatten)]
    pub array: ArrayOptions,
}

/// `replay`
#[derive(Debug, Args)]
#[command(after_help = "\
FILE.csv may also be a recording of telemetry, as `record` writes it: then what the board said is printed.

Examples:
  ridgetone replay trace.csv
  ridgetone replay touch.rec
  ridgetone replay counts.csv --scale 1e-3 --json
  ridgetone replay --scene scenes/c8.toml
  ridgetone replay --scene-speed 15 --period 2.6 --snr 10
  ridgetone replay trace.csv --speed 30 --delay 1 --length 55
  ridgetone replay trace.csv --settings finger.toml")]
pub struct ReplayArgs {
    /// What the chip feels.
    #[command(flatten)]
    pub input: InputOptions,
    /// Settings of the library.
    #[command(flatten)]
    pub settings: SettingsOptions,
    /// Speed over the surface while it varies: CSV with time_s (device time) and speed_mm_s, at most 32 rows, straight
    /// lines in between. Estimates then come in cycles per mm.
    #[arg(long, value_name = "FILE.csv")]
    pub profile: Option<PathBuf>,
    /// The profile begins again where it ends [default: its last speed goes on].
    #[arg(long, requires = "profile")]
    pub profile_repeats: bool,
    /// What lines look like.
    #[command(flatten)]
    pub lines: LineOptions,
}

/// Which firmware, and how long to wait for it.
#[derive(Args, Clone, Debug)]
pub struct FirmwareOptions {
    /// Firmware image [default: target/firmware/emulated/ridgetone-firmware.elf of the workspace].
    #[arg(long, value_name = "PATH")]
    pub elf: Option<PathBuf>,
    /// Give up when the emulator shows no sign of life for so long, seconds of wall time.
    #[arg(long, value_name = "S", default_value_t = 30.0, value_parser = positive)]
    pub patience: f64,
}

/// `emulate`
#[derive(Debug, Args)]
#[command(after_help = "\
Without FILE.csv the chip feels a scene. The emulator comes with `cargo xtask setup`.

Examples:
  ridgetone emulate
  ridgetone emulate trace.csv --json > events.jsonl
  ridgetone emulate --scene scenes/c7.toml
  ridgetone emulate --scene-speed 48 --period 3.1 --svg run.svg --serial-out run.bin")]
pub struct EmulateArgs {
    /// What the chip feels.
    #[command(flatten)]
    pub input: InputOptions,
    /// Which firmware.
    #[command(flatten)]
    pub firmware: FirmwareOptions,
    /// Write the raw bytes of the telemetry line here.
    #[arg(long, value_name = "FILE")]
    pub serial_out: Option<PathBuf>,
    /// Draw the channels and what was found in them here.
    #[arg(long, value_name = "FILE.svg")]
    pub svg: Option<PathBuf>,
    /// One JSON object a line instead of text.
    #[arg(long)]
    pub json: bool,
}

/// `demo`
#[derive(Debug, Args)]
#[command(after_help = "\
Example:
  ridgetone demo --svg demo.svg")]
pub struct DemoArgs {
    /// Another scene than the default one: a scene file.
    #[arg(long, value_name = "FILE.toml")]
    pub scene: Option<PathBuf>,
    /// Which firmware.
    #[command(flatten)]
    pub firmware: FirmwareOptions,
    /// Draw the channels and what was found in them here.
    #[arg(long, value_name = "FILE.svg")]
    pub svg: Option<PathBuf>,
}

/// `scene`
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  ridgetone scene --scene-speed 15 --period 2.6 -o trace.csv
  ridgetone scene --scene scenes/hand.toml -o hand.csv")]
pub struct SceneArgs {
    /// Which scene.
    #[command(flatten)]
    pub scene: SceneOptions,
    /// File to write: time_s and 16 columns of volts at the scan's 241.14 rows per second.
    #[arg(short, long, value_name = "FILE.csv")]
    pub output: PathBuf,
    /// Also the truth as one JSON object on standard output.
    #[arg(long)]
    pub json: bool,
}

/// `reproduce`
#[derive(Debug, Args)]
#[command(after_help = "\
Takes a minute or two, and some with --emulated. Writes reproduction.json, reproduction.md, reproduction.html and the pictures in reproduction/.

Examples:
  ridgetone reproduce --out paper
  ridgetone reproduce --emulated --out paper
  ridgetone reproduce --render --out paper")]
pub struct ReproduceArgs {
    /// Run the firmware image in QEMU instead of its library on this PC; both give the same numbers.
    #[arg(long)]
    pub emulated: bool,
    /// Which firmware.
    #[command(flatten)]
    pub firmware: FirmwareOptions,
    /// Runs of each of the ten combinations, 1 to 4 as in the paper.
    #[arg(long, value_name = "N", default_value_t = 4, value_parser = clap::value_parser!(u32).range(1..=4))]
    pub runs: u32,
    /// Folder to write to.
    #[arg(long, value_name = "FOLDER", default_value = "docs")]
    pub out: PathBuf,
    /// Measure nothing: write the documents anew from reproduction.json.
    #[arg(long, conflicts_with_all = ["emulated", "runs"])]
    pub render: bool,
}

/// A ratio of powers in decibels; none for no noise at all.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Decibel(pub Option<f64>);

fn number(text: &str) -> Result<f64, String> {
    text.parse::<f64>().ok().filter(|value| value.is_finite()).ok_or_else(|| "not a number".into())
}

/// A number greater than zero.
pub(crate) fn positive(text: &str) -> Result<f64, String> {
    let value = number(text)?;
    if value > 0.0 { Ok(value) } else { Err("must be greater than 0".into()) }
}

fn decibel(text: &str) -> Result<Decibel, String> {
    if text == "none" { Ok(Decibel(None)) } else { number(text).map(|db| Decibel(Some(db))) }
}

fn on_off(text: &str) -> Result<bool, String> {
    match text {
        "on" => Ok(true),
        "off" => Ok(false),
        _ => Err("say on or off".into()),
    }
}

/// A command that makes no sense, as opposed to one that fails.
#[derive(Debug)]
pub struct Senseless(pub String);

impl fmt::Display for Senseless {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for Senseless {}

impl FirmwareOptions {
    /// The image.
    ///
    /// # Errors
    /// None is named, and there is none in its usual place.
    pub fn image(&self) -> Result<PathBuf> {
        match &self.elf {
            Some(elf) => Ok(elf.clone()),
            None => emulator::image::find(),
        }
    }

    /// How it is run.
    pub fn options<'a>(&self, elf: &'a Path) -> emulator::Options<'a> {
        let silence = Duration::try_from_secs_f64(self.patience).unwrap_or(Duration::MAX);
        emulator::Options { silence, ..emulator::Options::new(elf) }
    }
}

impl SceneOptions {
    /// Whether any of it was given.
    fn is_given(&self) -> bool {
        let Self { scene_file, scene_speed, period, snr, seed } = self;
        scene_file.is_some() || scene_speed.is_some() || period.is_some() || snr.is_some() || seed.is_some()
    }

    /// The scene's parameters.
    ///
    /// # Errors
    /// What is wrong with the scene file, with its line.
    pub fn sliding(&self) -> Result<Sliding> {
        if let Some(path) = &self.scene_file {
            let scene = hal_mock::load_scene(path, frame_rate_hz())?;
            return Ok(Sliding { seed: self.seed.unwrap_or(scene.seed), ..scene });
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

impl InputOptions {
    /// Whether any of it was given.
    fn is_given(&self) -> bool {
        self.file.is_some() || !self.noise || self.scene.is_given()
    }

    /// What the chip feels.
    ///
    /// # Errors
    /// [`Senseless`]: parameters of a scene together with a recording. What is wrong with a scene file.
    pub fn input(&self) -> Result<Input> {
        let SceneOptions { scene_file, scene_speed, period, snr, seed } = &self.scene;
        let makes_scene = scene_file.is_some() || scene_speed.is_some() || period.is_some() || snr.is_some();
        if self.file.is_some() && makes_scene {
            let why = "--scene, --scene-speed, --period and --snr make a scene: they do not go with FILE.csv";
            return Err(Senseless(why.into()).into());
        }
        let source = match &self.file {
            Some(path) => Source::Trace { path: path.clone(), rate_hz: self.rate, volts_per_unit: self.scale },
            None => Source::Scene(self.scene.sliding()?),
        };
        let seed = match &source {
            Source::Scene(scene) => scene.seed,
            Source::Trace { .. } => seed.unwrap_or(1),
        };
        Ok(Input { source, converter_noise: self.noise, seed })
    }
}

impl SettingsOptions {
    /// The settings.
    ///
    /// # Errors
    /// [`Senseless`]: one is out of its bounds.
    pub fn settings(&self) -> Result<Settings> {
        let base = self.settings_file.as_deref().map_or(Ok(Settings::DEFAULT), settings_form::load)?;
        // Asked for with zero they would be switched off: that is out of bounds.
        let asked = |value: f32| if value == 0.0 { f32::NAN } else { value };
        let settings = Settings {
            window_s: self.window.unwrap_or(base.window_s),
            hop_s: self.hop.unwrap_or(base.hop_s),
            harmonics: self.harmonics.unwrap_or(base.harmonics),
            accuracy: self.accuracy.map_or(base.accuracy, |percent| asked(percent) / 100.0),
            interferer_hz: self.mains.map_or(base.interferer_hz, asked),
            slide: self.speed.map_or(base.slide, |speed_mm_s| SlideRule::Protocol {
                delay_s: self.delay,
                speed_mm_s,
                length_mm: self.length,
            }),
            array: self.array.array(base.array),
            ..base
        };
        settings.validate().map_err(|error| Senseless(settings_form::explained(&error)))?;
        Ok(settings)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    #[test]
    fn the_command_line_is_sound() {
        Cli::command().debug_assert();
    }

    #[test]
    fn defaults_are_the_librarys_own() {
        let cli = Cli::try_parse_from(["ridgetone", "replay"]).unwrap();
        let Command::Replay(args) = cli.command else { panic!("not a replay") };
        assert_eq!(args.settings.settings().unwrap(), Settings::default());
        assert_eq!(args.input.scene.sliding().unwrap(), Sliding::default());
    }

    #[test]
    fn settings_out_of_bounds_are_told() {
        let cli = Cli::try_parse_from(["ridgetone", "replay", "--window", "9"]).unwrap();
        let Command::Replay(args) = cli.command else { panic!("not a replay") };
        let error = args.settings.settings().unwrap_err();
        assert!(error.is::<Senseless>() && error.to_string().starts_with("window_s = 9"), "{error}");
    }
}
