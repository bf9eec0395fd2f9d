//! The command `ridgetone-teletaction`, implemented in this package's library.
#![forbid(unsafe_code)]

use ridgetone_teletaction::cli::Cli;
use std::process::ExitCode;

fn main() -> ExitCode {
    ridgetone_host::program::run(Cli::run)
}
