//! The commands on boards and on recordings of telemetry.

use super::{BoardOptions, InputOptions, SourceOptions, positive};
use crate::export;
use crate::view::server::loopback;
use clap::{ArgGroup, Args, Subcommand};
use std::net::SocketAddr;
use std::path::PathBuf;

/// `ports`
#[derive(Debug, Args)]
#[command(after_help = "\
Example:
  ridgetone ports")]
pub struct PortsArgs {
    /// One JSON object a line instead of text.
    #[arg(long)]
    pub json: bool,
}

/// `monitor`
#[derive(Debug, Args)]
#[command(after_help = "\
The keys are in the last line of the screen. Where standard output is no terminal, and with --plain, --json or
--teleplot, it prints lines.

Examples:
  ridgetone monitor
  ridgetone monitor --port /dev/ttyUSB0
  ridgetone monitor --emulated
  ridgetone monitor --emulated --scene scenes/c7.toml
  ridgetone monitor --file touch.rec
  ridgetone monitor --emulated --once --plain")]
pub struct MonitorArgs {
    /// Where packets come from.
    #[command(flatten)]
    pub source: SourceOptions,
    /// Put these settings into force first; they are not stored.
    #[arg(long, value_name = "FILE.toml", conflicts_with = "recording")]
    pub settings: Option<PathBuf>,
    /// Print lines instead of a screen.
    #[arg(long)]
    pub plain: bool,
    /// What lines look like.
    #[command(flatten)]
    pub lines: LineOptions,
}

/// `view`
#[derive(Debug, Args)]
#[command(after_help = "\
It prints the page's address; open that in a browser. It can be reached from this computer only.

Examples:
  ridgetone view
  ridgetone view --port /dev/ttyUSB0
  ridgetone view --emulated
  ridgetone view --emulated --scene scenes/c7.toml --listen 127.0.0.1:9000
  ridgetone view --file touch.rec")]
pub struct ViewArgs {
    /// Where packets come from.
    #[command(flatten)]
    pub source: SourceOptions,
    /// Put these settings into force first; they are not stored.
    #[arg(long, value_name = "FILE.toml", conflicts_with = "recording")]
    pub settings: Option<PathBuf>,
    /// Where the page is served: an address of this computer's own, 127.0.0.1 or `[::1]`, and a port; port 0 is any free one.
    #[arg(long, value_name = "ADDRESS:PORT", default_value = "127.0.0.1:8321", value_parser = loopback)]
    pub listen: SocketAddr,
}

/// `record`
#[derive(Debug, Args)]
#[command(after_help = "\
Ends with Ctrl-C, after --for, or when the board's scene is over; the file is valid at any moment. `monitor --file`,
`replay` and `export` read it.

Examples:
  ridgetone record -o touch.rec
  ridgetone record --port /dev/ttyUSB0 --raw --for 60 -o touch.rec
  ridgetone record --emulated --raw -o touch.rec")]
pub struct RecordArgs {
    /// Which board.
    #[command(flatten)]
    pub board: BoardOptions,
    /// What the emulated chip feels.
    #[command(flatten)]
    pub input: InputOptions,
    /// File to write; one that is there is not overwritten.
    #[arg(short, long, value_name = "RECORDING")]
    pub output: PathBuf,
    /// With every frame as it was read (20 kB a second).
    #[arg(long)]
    pub raw: bool,
    /// So many seconds of device time [default: until Ctrl-C].
    #[arg(long = "for", value_name = "S", value_parser = positive)]
    pub length: Option<f64>,
    /// Put these settings into force first; they are not stored.
    #[arg(long, value_name = "FILE.toml")]
    pub settings: Option<PathBuf>,
}

/// `export`
#[derive(Debug, Args)]
#[command(after_help = "\
The CSV of frames is what `replay`, `fit` and `emulate` take: the same touch with other settings. In that of estimates
frequency and sigma are in hertz, or in cycles per mm where abscissa is place.

Examples:
  ridgetone export touch.rec --format csv -o estimates.csv
  ridgetone export touch.rec --format csv --table frames -o frames.csv
  ridgetone export touch.rec --format mcap -o touch.mcap
  ridgetone export touch.rec --format ndjson | head")]
pub struct ExportArgs {
    /// Recording of telemetry.
    #[arg(value_name = "RECORDING")]
    pub file: PathBuf,
    /// Format.
    #[arg(long, value_enum, value_name = "FORMAT")]
    pub format: export::Format,
    /// What the table of CSV is of [default: estimates].
    #[arg(long, value_enum, value_name = "KIND")]
    pub table: Option<export::Kind>,
    /// File to write [default: standard output].
    #[arg(short, long, value_name = "FILE")]
    pub output: Option<PathBuf>,
}

/// `settings`
#[derive(Debug, Subcommand)]
#[command(after_help = "\
Examples:
  ridgetone settings get > finger.toml
  ridgetone settings set window_s=0.5 --keep
  ridgetone replay trace.csv --settings finger.toml")]
pub enum SettingsCommand {
    /// Print the settings in force as TOML, and where they come from.
    #[command(after_help = "\
Examples:
  ridgetone settings get
  ridgetone settings get --port /dev/ttyUSB0 > finger.toml")]
    Get(SettingsGetArgs),
    /// Put settings into force, from the next window on.
    #[command(after_help = "\
What is not named stays as it is on the board, or with --settings as it is in that file.

Examples:
  ridgetone settings set window_s=0.5 hop_s=0.1
  ridgetone settings set --settings finger.toml --keep
  ridgetone settings set array.period_most_mm=3.5 slide.rule=found")]
    Set(SettingsSetArgs),
    /// Forget what is stored on the board, and use its defaults.
    #[command(after_help = "\
Example:
  ridgetone settings forget")]
    Forget(SettingsGetArgs),
}

/// `settings get`, `settings forget`
#[derive(Debug, Args)]
pub struct SettingsGetArgs {
    /// Which board.
    #[command(flatten)]
    pub board: BoardOptions,
}

/// `settings set`
#[derive(Debug, Args)]
pub struct SettingsSetArgs {
    /// Settings by their names in the file, such as window_s=0.5.
    #[arg(value_name = "NAME=VALUE", required_unless_present = "settings")]
    pub changes: Vec<String>,
    /// All settings of this file; what it leaves out has its default.
    #[arg(long, value_name = "FILE.toml")]
    pub settings: Option<PathBuf>,
    /// Store them: they are in force after the next start too.
    #[arg(long)]
    pub keep: bool,
    /// Which board.
    #[command(flatten)]
    pub board: BoardOptions,
}

/// What lines look like.
#[derive(Args, Clone, Copy, Debug)]
pub struct LineOptions {
    /// One JSON object a line instead of text.
    #[arg(long, conflicts_with = "teleplot")]
    pub json: bool,
    /// Numbers as Teleplot reads them, >NAME:TIME_MS:VALUE|g, instead of text.
    #[arg(long)]
    pub teleplot: bool,
}

/// `listen`
#[derive(Debug, Args)]
#[command(after_help = "\
A board that is unplugged is picked up again by its USB serial number, whatever its port is called then; one without a
number, by its port's name. Ctrl-C ends it.

Examples:
  ridgetone listen --port /dev/ttyUSB0
  ridgetone listen --usb-serial A50285BI --json > events.jsonl")]
#[command(group(ArgGroup::new("board").required(true)))]
pub struct ListenArgs {
    /// The serial port's name.
    #[arg(long, value_name = "NAME", group = "board")]
    pub port: Option<String>,
    /// The USB serial number of the board, or of the adapter on its line.
    #[arg(long, value_name = "NUMBER", group = "board")]
    pub usb_serial: Option<String>,
    /// What lines look like.
    #[command(flatten)]
    pub lines: LineOptions,
}
