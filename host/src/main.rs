//! The command `ridgetone`; the library of this crate does the work.
#![forbid(unsafe_code)]

use ridgetone_host::cli::Cli;
use std::process::ExitCode;

fn main() -> ExitCode {
    ridgetone_host::program::run(Cli::run)
}
