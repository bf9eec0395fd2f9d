//! The command line. Each command has a file here with its arguments and its work; options that
//! several commands share have files of their own.

pub mod board;
mod calibrate;
mod check;
mod command;
mod demo;
mod emulate;
mod export;
pub mod firmware;
mod fit;
mod help;
pub mod lines;
mod monitor;
pub mod parse;
mod ports;
mod record;
mod replay;
mod scene;
mod serve;
mod settings;
mod settings_command;
pub mod source;
mod table;
mod view;

use crate::teletaction;
use anyhow::Result;
use clap::{CommandFactory, Parser, Subcommand};
use std::ffi::OsString;

/// The tone of the ridges under a tactile fingertip, on a PC: the same code as on the chip.
///
/// Results go to standard output, everything else to standard error. Times of events are device
/// time: seconds since the first conversion. Exit status: 0 done, 1 an error (one line says which),
/// 2 usage error, 3 a recording without an answer.
#[derive(Debug, Parser)]
#[command(
    name = "ridgetone",
    version,
    max_term_width = 100,
    after_help = "With ridgetone-teletaction installed: touch, pins, link."
)]
pub struct Cli {
    /// Replace files that exist already; a recording of telemetry is never replaced.
    #[arg(long, global = true)]
    force: bool,
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Fit all channels of a recording with one common frequency.
    Fit(Box<fit::FitArgs>),
    /// Run a recording, or a scene behind a simulated ADS1258, through the library.
    Replay(Box<replay::ReplayArgs>),
    /// Calibrate the array, so that phases give spatial periods, from recordings of gratings of
    /// known period.
    Calibrate(calibrate::CalibrateArgs),
    /// Run the firmware image on an emulated board, in front of a scene; with --port as a serial
    /// port.
    Emulate(Box<emulate::EmulateArgs>),
    /// Check every part of a board after its first power-up, and name the page of the guide that
    /// helps.
    Check(check::CheckArgs),
    /// List the serial ports of this computer.
    Ports(ports::PortsArgs),
    /// Show a board live on the terminal.
    Monitor(monitor::MonitorArgs),
    /// Show a board live in a browser on this computer, without any network. Ctrl-C ends it.
    View(view::ViewArgs),
    /// Record the telemetry of a board in a file.
    Record(record::RecordArgs),
    /// Stream the messages of one or more boards to other programs: Foxglove, MQTT, or
    /// lines of JSON.
    Serve(serve::ServeArgs),
    /// Turn a recording of telemetry into CSV, JSON lines or MCAP.
    Export(export::ExportArgs),
    /// Print or change the settings in force on a board.
    #[command(subcommand)]
    Settings(settings_command::SettingsCommand),
    /// Start, stop or restart a board.
    #[command(subcommand, name = "command")]
    Board(command::BoardCommand),
    /// Run a scene through the emulated firmware: print its results next to the truth, and draw a
    /// picture.
    Demo(demo::DemoArgs),
    /// Write the manual's pages, or completions for a shell.
    #[command(hide = true)]
    HelpFiles(help::HelpFilesArgs),
    #[command(hide = true)]
    Touch(TeletactionArgs),
    #[command(hide = true)]
    Pins(TeletactionArgs),
    #[command(hide = true)]
    Link(TeletactionArgs),
}

/// Arguments of `ridgetone-teletaction`, which parses them itself.
#[derive(Debug, clap::Args)]
#[command(disable_help_flag = true)]
struct TeletactionArgs {
    #[arg(trailing_var_arg = true, allow_hyphen_values = true)]
    words: Vec<OsString>,
}

impl Cli {
    /// Runs the command. Errors are one line; wrong options return a [`crate::usage::UsageError`].
    pub fn run(self) -> Result<()> {
        if self.force {
            crate::output::force();
        }
        match self.command {
            Command::Fit(args) => args.run(),
            Command::Replay(args) => args.run(),
            Command::Calibrate(args) => args.run(),
            Command::Emulate(args) => args.run(),
            Command::Check(args) => args.run(),
            Command::Ports(args) => args.run(),
            Command::Monitor(args) => args.run(),
            Command::View(args) => args.run(),
            Command::Record(args) => args.run(),
            Command::Serve(args) => args.run(),
            Command::Export(args) => args.run(),
            Command::Settings(command) => command.run(),
            Command::Board(command) => command.run(),
            Command::Demo(args) => args.run(),
            Command::HelpFiles(args) => args.run(Self::command()),
            Command::Touch(args) => teletaction::run("touch", &args.words, self.force),
            Command::Pins(args) => teletaction::run("pins", &args.words, self.force),
            Command::Link(args) => teletaction::run("link", &args.words, self.force),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::usage::UsageError;
    use clap::CommandFactory;
    use hal_mock::Sliding;
    use ridgetone_proto::settings::Settings;

    fn replay(arguments: &[&str]) -> Box<replay::ReplayArgs> {
        let cli = Cli::try_parse_from([&["ridgetone", "replay"], arguments].concat()).unwrap();
        let Command::Replay(args) = cli.command else {
            panic!("not a replay")
        };
        args
    }

    #[test]
    fn the_command_line_is_sound() {
        Cli::command().debug_assert();
    }

    #[test]
    fn defaults_are_the_librarys_own() {
        let args = replay(&[]);
        assert_eq!(args.settings.settings().unwrap(), Settings::default());
        assert_eq!(
            args.scene_options
                .sliding(None, &ridgetone_proto::plan::Plan::PAPER)
                .unwrap(),
            Sliding::default()
        );
    }

    #[test]
    fn settings_out_of_bounds_are_refused() {
        let error = replay(&["--window", "9"]).settings.settings().unwrap_err();
        assert!(
            error.is::<UsageError>() && error.to_string().starts_with("window_s = 9"),
            "{error}"
        );
    }
}
