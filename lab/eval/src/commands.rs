//! Command-line arguments, and the commands that they run.

use crate::faults::{self, FaultsArgs};
use clap::{Parser, Subcommand};
use ridgetone_host::usage::UsageError;
use std::process::ExitCode;

/// Runs the fault campaign.
#[derive(Debug, Parser)]
#[command(name = "ridgetone-eval", version, max_term_width = 100)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Inject faults into the chip, its bus and its lines, and count the consequences.
    Faults(FaultsArgs),
}

pub fn main() -> ExitCode {
    let Command::Faults(args) = Cli::parse().command;
    match faults::run(&args) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("ridgetone-eval: {error:#}");
            ExitCode::from(if error.is::<UsageError>() { 2 } else { 1 })
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arguments_that_make_no_sense_are_refused() {
        for (arguments, word) in [
            (&["--injections", "0"][..], "1.."),
            (&["--only", "edges"], "edges_lost"),
            (&["--only", "reset", "--write", "."], "--write"),
        ] {
            let refused = Cli::try_parse_from([&["ridgetone-eval", "faults"], arguments].concat());
            let error = refused.expect_err("refused");
            assert!(
                error.exit_code() == 2 && error.to_string().contains(word),
                "{arguments:?}: {error}"
            );
        }
    }
}
