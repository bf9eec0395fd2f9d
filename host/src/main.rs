//! The command `ridgetone`; its work is in the library of this crate.
#![forbid(unsafe_code)]

use clap::Parser;
use ridgetone_host::cli::Cli;
use ridgetone_host::usage::UsageError;
use std::io::ErrorKind;
use std::process::ExitCode;

fn main() -> ExitCode {
    let cli = match Cli::try_parse() {
        Ok(cli) => cli,
        Err(error) if error.use_stderr() => {
            eprintln!(
                "ridgetone: {}; see --help",
                first_paragraph(&error.render().to_string())
            );
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
    match cli.run() {
        Ok(()) => ExitCode::SUCCESS,
        // The reader of the output has closed it, as `head` does.
        Err(error) if is_closed_pipe(&error) => ExitCode::SUCCESS,
        Err(error) => {
            let line = format!("{error:#}").replace(['\n', '\r'], " ");
            eprintln!("ridgetone: {line}");
            ExitCode::from(if error.is::<UsageError>() { 2 } else { 1 })
        }
    }
}

fn is_closed_pipe(error: &anyhow::Error) -> bool {
    error
        .downcast_ref::<std::io::Error>()
        .is_some_and(|error| error.kind() == ErrorKind::BrokenPipe)
}

/// clap's message and what it supposes was meant, on one line.
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
