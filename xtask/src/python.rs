//! The Python package: its wheel in an environment of its own, and its tests there.

use crate::setup;
use crate::tools::{announce, clean, output_of, run, target_dir};
use anyhow::{Context, Result};
use std::path::{Path, PathBuf};
use std::{env, fs};

/// The interpreter of `target/python`, an environment of its own, which is made if it is missing.
pub fn environment() -> Result<PathBuf> {
    let environment = target_dir().join("python");
    let inside = environment.join(if cfg!(windows) { "Scripts" } else { "bin" });
    if !inside.join("pip").exists() {
        run(clean(setup::python()?)
            .args(["-m", "venv"])
            .arg(&environment))
        .context("an environment of Python")?;
    }
    Ok(inside.join("python"))
}

/// Builds the wheel into [`environment`]. Gives the interpreter there.
pub fn build() -> Result<PathBuf> {
    announce("the Python package, in target/python");
    let python = environment()?;
    let mut pip = clean(&python);
    pip.args([
        "-m",
        "pip",
        "install",
        "--quiet",
        "--disable-pip-version-check",
        "./host/python[test]",
    ]);
    run(&mut pip).context("the wheel")?;
    Ok(python)
}

/// Runs the wheel's tests next to the command that `cargo test` has built. Gives what they print.
pub fn run_tests(python: &Path) -> Result<String> {
    let command = copied(python, "ridgetone")?;
    let mut tests = clean(python);
    tests.args([
        "-m",
        "pytest",
        "--quiet",
        "-c",
        "host/python/pyproject.toml",
    ]);
    tests.env("RIDGETONE_COMMAND", command);
    output_of(&mut tests).context("tests of the Python package")
}

/// Copies a command that `cargo test` has built to beside the interpreter: other tests build it
/// anew meanwhile.
fn copied(python: &Path, command: &str) -> Result<PathBuf> {
    let name = format!("{command}{}", env::consts::EXE_SUFFIX);
    let copy = python.with_file_name(&name);
    fs::copy(target_dir().join("debug").join(&name), &copy)
        .with_context(|| format!("{name} of `cargo test`"))?;
    Ok(copy)
}
