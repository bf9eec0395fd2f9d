//! `cargo xtask`: what one does with the workspace besides building it.

mod images;
mod inspect;
mod install;
mod setup;
mod toolchain;
mod tools;

use clap::{Parser, Subcommand};
use images::Board;
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
    /// Finds or installs what the firmware needs: the core library for Cortex-M, the emulator.
    Setup,
    /// Builds the firmware images, checks that there is code in them, tells their sizes.
    Firmware {
        /// Only this board's image.
        #[arg(long, value_enum)]
        board: Option<Board>,
    },
    /// Flashes the Feather through a debug probe, with probe-rs, and shows its log.
    Flash,
}

fn main() -> ExitCode {
    let done = match Arguments::parse().task {
        Task::Setup => setup::run(),
        Task::Firmware { board } => images::build_and_tell(board),
        Task::Flash => images::flash(),
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error:#}");
            ExitCode::FAILURE
        }
    }
}
