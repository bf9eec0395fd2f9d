//! The command `ridgetone-teletaction`; its work is in the library of this package.
#![forbid(unsafe_code)]

use ridgetone_teletaction::cli::Cli;
use std::process::ExitCode;

fn main() -> ExitCode {
    ridgetone_host::program::run(Cli::run)
}
