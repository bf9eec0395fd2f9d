//! The command line: what can be said, and the help that says so.

mod array;
mod command;
mod input;
mod live;
mod settings;
mod source;

pub use array::ArrayOptions;
pub use command::{BoardCommand, FollowArgs};
pub use input::{Decibel, InputOptions, SceneOptions};
pub use live::{
    ExportArgs, LineOptions, ListenArgs, MonitorArgs, PortsArgs, RecordArgs, SettingsCommand, SettingsGetArgs,
    SettingsSetArgs, ViewArgs,
};
pub use settings::SettingsOptions;
pub use source::{BoardOptions, SourceOptions};

use crate::calibrate::CalibrateArgs;
use crate::emulator;
use anyhow::{Result, bail};
use clap::{Args, Parser, Subcommand};
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
    /// Have a board begin anew, stop, restart, or estimate by place.
    #[command(subcommand)]
    Command(BoardCommand),
    /// What a board on a serial line says. When it is unplugged it is waited for.
    Listen(ListenArgs),
    /// A scene through the emulated firmware: what it found beside the truth, and a picture.
    Demo(DemoArgs),
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
    /// Settings file, of which harmonics and interferer_hz mean something here; the two options below go over it.
    #[arg(long, value_name = "FILE.toml")]
    pub settings: Option<PathBuf>,
    /// Most harmonics to fit, the fundamental included, 1 to 5 [default: 5].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u8).range(1..=5))]
    pub harmonics: Option<u8>,
    /// Known interferer in all columns, hertz, such as mains of 50 or 60; it may be aliased [default: none].
    #[arg(long, value_name = "HZ", value_parser = positive)]
    pub mains: Option<f64>,
    /// One JSON object on one line instead of the table.
    #[arg(long)]
    pub json: bool,
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
  ridgetone emulate --log
  ridgetone emulate trace.csv --json > events.jsonl
  ridgetone emulate --scene scenes/c7.toml
  ridgetone emulate trace.csv --settings finger.toml
  ridgetone emulate --scene-speed 48 --period 3.1 --svg run.svg --serial-out run.bin")]
pub struct EmulateArgs {
    /// What the chip feels.
    #[command(flatten)]
    pub input: InputOptions,
    /// Settings of the firmware, sent to it over its line at once.
    #[command(flatten)]
    pub settings: SettingsOptions,
    /// Which firmware.
    #[command(flatten)]
    pub firmware: FirmwareOptions,
    /// Show the firmware's log, defmt, on standard error.
    #[arg(long)]
    pub log: bool,
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
    /// Settings of the firmware, sent to it over its line at once [default: its own].
    #[arg(long, value_name = "FILE.toml")]
    pub settings: Option<PathBuf>,
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

fn number(text: &str) -> Result<f64, String> {
    text.parse::<f64>().ok().filter(|value| value.is_finite()).ok_or_else(|| "not a number".into())
}

/// A number greater than zero.
pub fn positive(text: &str) -> Result<f64, String> {
    let value = number(text)?;
    if value > 0.0 { Ok(value) } else { Err("must be greater than 0".into()) }
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
    /// There is none by its name, or, without one, in the usual place.
    pub fn image(&self) -> Result<PathBuf> {
        match &self.elf {
            Some(elf) if !elf.is_file() => {
                bail!("{}: there is no such firmware image; `cargo xtask firmware` builds one", elf.display())
            }
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

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;
    use hal_mock::Sliding;
    use ridgetone_proto::settings::Settings;

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
