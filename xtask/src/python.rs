//! Builds the Python package's wheel in a separate environment, and runs its tests there.

use crate::setup;
use crate::tools::{announce, cargo, clean, output_of, run, target_dir};
use anyhow::{Context, Result, bail};
use std::path::{Path, PathBuf};
use std::process::Stdio;
use std::{env, fs};

/// Returns the interpreter of `target/python`, a separate environment, which is created if missing.
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

/// Pip's message if it cannot reach an index.
const UNREACHABLE: &str = "Retrying (";

/// Installs the packages listed in a file. Returns false if PyPI cannot be reached.
pub fn install(python: &Path, requirements: &str) -> Result<bool> {
    let mut pip = clean(python);
    pip.args([
        "-m",
        "pip",
        "install",
        "--quiet",
        "--disable-pip-version-check",
    ]);
    pip.args(["--retries", "1", "-r", requirements]);
    let output = pip.stdin(Stdio::null()).output()?;
    let errors = String::from_utf8_lossy(&output.stderr);
    match (output.status.success(), errors.contains(UNREACHABLE)) {
        (true, _) => Ok(true),
        (false, true) => Ok(false),
        (false, false) => bail!("{requirements}: {}", errors.trim()),
    }
}

/// Runs the tests of the page in a browser, all or those whose names contain `only`. Without a
/// browser or PyPI, prints the reason and runs none.
pub fn run_page_tests(only: Option<&str>, environment: &[(&str, PathBuf)]) -> Result<()> {
    announce("the page in a browser");
    let python = self::environment()?;
    let browser = match setup::browser() {
        Ok(browser) => browser,
        Err(error) => {
            println!("not run: the tests of the page. {error:#}");
            return Ok(());
        }
    };
    if !install(&python, "host/tests/page/requirements.txt")? {
        println!(
            "not run: the tests of the page. PyPI cannot be reached, and host/tests/page/requirements.txt is not installed"
        );
        return Ok(());
    }
    run(&mut cargo(
        "build --workspace --profile test --bin ridgetone --example page_recordings",
        [],
    ))?;
    let built = target_dir().join("debug");
    let mut tests = clean(&python);
    tests.args(["-m", "pytest", "--quiet", "host/tests/page"]);
    tests.args(only.iter().flat_map(|name| ["-k", name]));
    tests
        .env("RIDGETONE_BROWSER", browser)
        .env("RIDGETONE_COMMAND", built.join("ridgetone"))
        .env(
            "RIDGETONE_RECORDINGS",
            built.join("examples/page_recordings"),
        )
        .envs(environment.iter().cloned());
    run(&mut tests).context("tests of the page")
}

/// Builds the wheel into [`environment`]. Returns the interpreter there.
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

/// Runs the wheel's tests with the command built by `cargo test`. Returns their output.
pub fn run_tests(python: &Path) -> Result<String> {
    let command = copied(python, "ridgetone")?;
    let mut tests = clean(python);
    tests.args([
        "-m",
        "pytest",
        "--quiet",
        "-c",
        "host/python/pyproject.toml",
        "host/python/tests",
    ]);
    tests.env("RIDGETONE_COMMAND", command);
    output_of(&mut tests).context("tests of the Python package")
}

/// Copies a command built by `cargo test` next to the interpreter, since other tests rebuild it
/// meanwhile.
fn copied(python: &Path, command: &str) -> Result<PathBuf> {
    let name = format!("{command}{}", env::consts::EXE_SUFFIX);
    let copy = python.with_file_name(&name);
    fs::copy(target_dir().join("debug").join(&name), &copy)
        .with_context(|| format!("{name} of `cargo test`"))?;
    Ok(copy)
}
