//! Runs commands of `ridgetone-teletaction`, as git and cargo run external subcommands.

use anyhow::{Context, Result, ensure};
use std::ffi::OsString;
use std::io::ErrorKind;
use std::path::PathBuf;
use std::process::Command;

const PROGRAM: &str = "ridgetone-teletaction";

/// Runs a command of the program, which is looked for next to this one and then on the PATH. On
/// Unix the program replaces this process; elsewhere this process exits with the program's status.
pub fn run(name: &str, words: &[OsString], force: bool) -> Result<()> {
    let mut command = Command::new(beside().unwrap_or_else(|| PROGRAM.into()));
    command.arg(name);
    if force {
        command.arg("--force");
    }
    let error = become_it(command.args(words));
    ensure!(
        error.kind() != ErrorKind::NotFound,
        "`{name}` is a command of {PROGRAM}, which is not installed; in a clone of the repository \
         type: cargo install --path teletaction"
    );
    Err(error).with_context(|| format!("cannot run {PROGRAM}"))
}

fn beside() -> Option<PathBuf> {
    let name = format!("{PROGRAM}{}", std::env::consts::EXE_SUFFIX);
    let path = std::env::current_exe().ok()?.with_file_name(name);
    path.is_file().then_some(path)
}

/// Replaces this process by the program; returns only if the program cannot be started.
#[cfg(unix)]
fn become_it(command: &mut Command) -> std::io::Error {
    std::os::unix::process::CommandExt::exec(command)
}

/// Exits with the program's status; returns only if the program cannot be started.
#[cfg(not(unix))]
fn become_it(command: &mut Command) -> std::io::Error {
    match command.status() {
        Ok(status) => std::process::exit(status.code().unwrap_or(1)),
        Err(error) => error,
    }
}
