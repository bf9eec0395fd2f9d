//! `cargo xtask`: what one does with the workspace besides building it.

mod bench;
mod demo;
mod dfu;
mod faults;
mod images;
mod inspect;
mod install;
mod package;
mod panics;
mod release;
mod setup;
mod test;
mod toolchain;
mod tools;

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

#[derive(Subcommand)]
enum Task {
    /// Slides a grating over the emulated finger and shows what the firmware makes of it. Installs
    /// what is missing and builds what is needed first.
    Demo {
        /// Where the picture goes, SVG.
        #[arg(long, default_value = "target/demo.svg")]
        svg: PathBuf,
        /// A scene file in place of the default grating, such as scenes/c1.toml.
        #[arg(long, value_name = "FILE")]
        scene: Option<PathBuf>,
    },
    /// Counts the instructions of the firmware's steps on the emulated chip and measures its accuracy beside other
    /// methods', with the bars they have to meet.
    Bench(bench::BenchArguments),
    /// Injects faults by the thousand and prints what became of them; with --full writes docs/faults.md.
    Faults(faults::FaultsArguments),
    /// Runs every test, those of the emulated firmware included.
    Test,
    /// Finds or installs what the firmware and its tests need: the core library for Cortex-M, the emulator, a browser.
    Setup,
    /// Builds the firmware images, checks that there is code in them and no panic that is not known, tells their sizes.
    Firmware {
        /// Only this board's image.
        #[arg(long, value_enum)]
        board: Option<Board>,
    },
    /// Builds the images of the real boards as ELF, raw and DFU files with their SHA-256 checksums.
    Release,
    /// Packs what is published and builds each from its package alone, without network.
    Package,
    /// Lints the firmware for every board and the benchmarks, warnings denied.
    LintFirmware,
    /// Flashes a board through a debug probe, with probe-rs, and shows its log.
    Flash {
        /// Which.
        #[arg(long, value_enum, default_value = "feather-f405")]
        board: Board,
    },
}

fn main() -> ExitCode {
    let done = match Arguments::parse().task {
        Task::Demo { svg, scene } => demo::run(&svg, scene.as_deref()),
        Task::Bench(arguments) => bench::run(&arguments),
        Task::Faults(arguments) => faults::run(&arguments),
        Task::Test => test::run(),
        Task::Release => release::run(),
        Task::Package => package::check(),
        Task::LintFirmware => images::lint(),
        Task::Setup => setup::run(),
        Task::Firmware { board } => images::build_and_tell(board),
        Task::Flash { board } => images::flash(board),
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error:#}");
            ExitCode::FAILURE
        }
    }
}
