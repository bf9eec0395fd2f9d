//! `cargo xtask`: every task of the workspace except building it.

#[cfg(test)]
mod documents;
#[cfg(test)]
mod elf;
mod frames;
mod images;
mod inspect;
mod install;
mod lint;
mod package;
mod panics;
mod python;
mod release;
mod results;
mod setup;
mod sizes;
mod tasks;
mod testing;
mod toolchain;
mod tools;

use clap::builder::PossibleValuesParser;
use clap::{Parser, Subcommand};
use images::Board;
use std::path::PathBuf;
use std::process::ExitCode;

/// Ridgetone's workspace tasks.
#[derive(Parser)]
#[command(name = "cargo xtask", bin_name = "cargo xtask", max_term_width = 100)]
struct Arguments {
    #[command(subcommand)]
    task: Task,
}

/// Flags for `ridgetone-eval`, including `--help`.
#[derive(clap::Args)]
struct Flags {
    /// Flags of the command of `ridgetone-eval`; `--help` lists them.
    #[arg(trailing_var_arg = true, allow_hyphen_values = true)]
    flags: Vec<String>,
}

#[derive(Subcommand)]
enum Task {
    /// Slides a simulated finger over ridges and shows what the firmware reports. Installs and
    /// builds everything it needs.
    Demo {
        /// Path of the picture, SVG.
        #[arg(long, default_value = "target/demo.svg")]
        svg: PathBuf,
        /// Scene file instead of hal-mock/scenes/demo.toml.
        #[arg(long, value_name = "FILE")]
        scene: Option<PathBuf>,
    },
    /// Runs the campaigns of lab, all or one, and writes their pages in docs/results.
    Results {
        /// Run this campaign only.
        #[arg(value_parser = PossibleValuesParser::new(results::TOPICS))]
        topic: Option<String>,
        /// Use a twentieth of the windows and write nothing. Fails if a requirement is missed by
        /// more than its statistical error.
        #[arg(long)]
        short: bool,
    },
    /// Counts the instructions of the fit in each scene, of a Hann FFT, of IEEE 1057 and of the
    /// flashed image on the emulator, and measures the scan plans. Writes docs/results/counts.json.
    Counts,
    /// Injects ten thousand faults and prints their consequences: one thousand with --quick; a
    /// hundred thousand with --full, which fills in docs/results/faults.md and takes most of an
    /// hour.
    #[command(disable_help_flag = true)]
    Faults(Flags),
    /// Checks that the command builds for Windows and macOS, where rustup may fetch their core
    /// libraries.
    CheckSystems,
    /// Runs the tests on this PC and one emulated run of each kind.
    Test {
        /// Everything: long tests, every emulated run, the pages in a browser,
        /// streams, the Python package.
        #[arg(long)]
        all: bool,
        /// Run only the random tests, with a new seed that is printed: `RIDGETONE_SEED` in the
        /// environment repeats a run.
        #[arg(long, conflicts_with = "all")]
        fresh: bool,
    },
    /// Takes the picture docs/view.png: the page during a touch of hal-mock/scenes/c1.toml.
    Pictures,
    /// Generates the messages' JSON schemas, the lists in host/reference.md and Python's classes
    /// from host/src/events/view.rs.
    Events,
    /// Builds teletaction/assets/touch/stimulus.wasm, which makes the sound of `ridgetone touch`.
    /// Run this after a change of teletaction/src/stimulus/.
    Worklet,
    /// Writes the list of settings in host/reference.md and Python's class. Run this after a change
    /// of the table in crates/proto/src/settings.rs.
    Settings,
    /// Finds or installs the tools for the firmware and its tests: the core library for Cortex-M, a
    /// browser, an MQTT broker, Python.
    Setup,
    /// Builds the firmware images, checks that they contain code, no unknown panics and no large
    /// stack frames, and prints their sizes: flash by crate, RAM by static.
    Firmware {
        /// Build this board's image only.
        #[arg(long, value_enum)]
        board: Option<Board>,
    },
    /// Builds the images of the real boards as ELF and raw files, static commands for Linux and a
    /// Python wheel with two embedded images, and their SHA-256 checksums, and reports what cannot
    /// be made here.
    Release {
        /// Make only this package and its two images; fails if that is not possible.
        #[arg(long, value_enum)]
        only: Option<release::Package>,
    },
    /// Packs the published crates, builds each from its package alone, without network, and fails
    /// if one lacks its licences, README or description. Reports if they have no `repository` yet.
    Package {
        /// Before a release: also fail without a `repository`.
        #[arg(long)]
        publish: bool,
    },
    /// Refuses what clippy does not check: files that import from each other in a circle, tuples as
    /// parameters, crates in two versions, licences that require more than attribution.
    Lint,
    /// Lints the firmware for every board and the benchmarks, warnings denied.
    LintFirmware,
    /// Builds the examples of `ads1258` for real boards, in `crates/ads1258/boards`, if their
    /// crates can be fetched.
    DriverBoards,
    /// Flashes a board through a debug probe, with probe-rs, and shows its log.
    Flash {
        /// Board to flash.
        #[arg(long, value_enum, default_value = "feather-f405")]
        board: Board,
        /// Flash this existing image instead of building one for the board: an ELF file built for
        /// one of the supported hardware boards.
        #[arg(long, value_name = "FILE", conflicts_with = "board")]
        image: Option<PathBuf>,
    },
}

fn main() -> ExitCode {
    let done = match Arguments::parse().task {
        Task::Demo { svg, scene } => tasks::demo(&svg, scene.as_deref()),
        Task::Results { topic, short } => results::measure(topic.as_deref(), short),
        Task::Counts => tasks::counts(),
        Task::Faults(Flags { flags }) => tasks::faults(&flags),
        Task::CheckSystems => tasks::check_systems(),
        Task::Test { fresh: true, .. } => testing::fresh(),
        Task::Test { all: true, .. } => testing::all(),
        Task::Test { .. } => testing::short(),
        Task::Pictures => testing::take_pictures(),
        Task::Release { only } => release::run(only),
        Task::Package { publish } => package::check(publish),
        Task::Lint => lint::run(),
        Task::LintFirmware => images::lint(),
        Task::DriverBoards => tasks::driver_boards(),
        Task::Events => tasks::generate("events"),
        Task::Worklet => tasks::worklet(),
        Task::Settings => tasks::generate("settings_form"),
        Task::Setup => setup::run(),
        Task::Firmware { board } => images::build_and_print(board),
        Task::Flash {
            image: Some(image), ..
        } => tasks::flash_image(&image),
        Task::Flash { board, image: None } => tasks::flash(board),
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error:#}");
            ExitCode::FAILURE
        }
    }
}
