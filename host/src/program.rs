//! Runs a command of the `ridgetone` family as a program: arguments, exit status, and errors on one
//! line each.

use crate::note;
use crate::usage::{NoEstimate, UsageError};
use anyhow::Result;
use clap::Parser;
use clap::error::ErrorKind as ClapError;
use std::io::ErrorKind;
use std::process::ExitCode;

/// Parses the command line and runs the command.
pub fn run<C: Parser>(run: impl FnOnce(C) -> Result<()>) -> ExitCode {
    let command = match C::try_parse() {
        Ok(command) => command,
        Err(error) if error.use_stderr() => {
            match error.kind() {
                ClapError::DisplayHelpOnMissingArgumentOrSubcommand => {
                    note!("no command: --help lists them");
                }
                _ => note!(
                    "{}; see --help",
                    first_paragraph(&error.render().to_string())
                ),
            }
            return ExitCode::from(2);
        }
        // Help or the version.
        Err(error) => {
            return if error.print().is_ok() {
                ExitCode::SUCCESS
            } else {
                ExitCode::FAILURE
            };
        }
    };
    match run(command) {
        Ok(()) => ExitCode::SUCCESS,
        // A reader such as `head` has closed the output.
        Err(error) if is_closed_pipe(&error) => ExitCode::SUCCESS,
        Err(error) => {
            note!("{error:#}");
            ExitCode::from(if error.is::<UsageError>() {
                2
            } else if error.is::<NoEstimate>() {
                3
            } else {
                1
            })
        }
    }
}

fn is_closed_pipe(error: &anyhow::Error) -> bool {
    error
        .downcast_ref::<std::io::Error>()
        .is_some_and(|error| error.kind() == ErrorKind::BrokenPipe)
}

/// Returns clap's message and its suggestion on one line.
fn first_paragraph(message: &str) -> String {
    let lines = || message.lines().map(str::trim);
    let first = lines().take_while(|line| !line.is_empty());
    let tips = lines().filter_map(|line| line.strip_prefix("tip: "));
    let meant = tips
        .filter(|tip| tip.contains("similar"))
        .map(|tip| format!("({tip})"));
    let words: Vec<String> = first.map(str::to_owned).chain(meant).collect();
    words.join(" ").trim_start_matches("error: ").to_owned()
}
