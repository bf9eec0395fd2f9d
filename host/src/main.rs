//! The command `ridgetone`; its work is in the library of this crate.
#![forbid(unsafe_code)]

use ridgetone_host::cli::Cli;
use std::process::ExitCode;

fn main() -> ExitCode {
    ridgetone_host::program::run(Cli::run)
}
