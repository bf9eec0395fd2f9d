//! `setup`: the tools of the firmware and the tests.

use crate::install;
use crate::toolchain::{TARGET, Toolchain};
use crate::tools::{clean, find, output_of};
use anyhow::{Context, Result, bail};
use std::path::PathBuf;

/// Programs of the browser that a test looks at pages with; the first is Debian's.
const BROWSERS: [&str; 4] = ["chromium", "chromium-browser", "google-chrome", "chrome"];

/// What Debian has a browser in, and letters for it.
const BROWSER_PACKAGES: [&str; 2] = ["chromium", "fonts-dejavu-core"];

/// What Debian has a broker of MQTT and its clients in.
const BROKER_PACKAGES: [&str; 2] = ["mosquitto", "mosquitto-clients"];

/// Finds or installs everything, and prints the result.
pub fn run() -> Result<()> {
    match Toolchain::find_or_install()? {
        Toolchain::Rustup => println!("core library for {TARGET}: with the compiler"),
        Toolchain::Debian { linker } => {
            println!(
                "core library for {TARGET}: built from Debian's sources, linked by {}",
                linker.display()
            );
        }
    }
    match browser() {
        Ok(path) => println!("browser: {}", path.display()),
        Err(error) => println!("browser: not there ({error:#}); needed for one of the tests only"),
    }
    match broker() {
        Ok(path) => println!("broker: {}", path.display()),
        Err(error) => {
            println!("broker: not there ({error:#}); needed for the tests of streams only")
        }
    }
    match python() {
        Ok(path) => println!("Python: {}", path.display()),
        Err(error) => println!("Python: not there ({error:#}); needed for the Python package only"),
    }
    match find("probe-rs") {
        Some(path) => println!("probe-rs: {}", path.display()),
        None => println!("probe-rs: not there; needed for `flash` only, see https://probe.rs"),
    }
    Ok(())
}

/// A browser, installed if there is none.
pub fn browser() -> Result<PathBuf> {
    let there = || BROWSERS.into_iter().find_map(find);
    if there().is_none() {
        install::debian(&BROWSER_PACKAGES).context("a browser is missing")?;
    }
    there().with_context(|| format!("none of {} is in PATH", BROWSERS.join(", ")))
}

/// A broker of MQTT, installed if there is none. Debian has it where PATH of a user does not lead.
pub fn broker() -> Result<PathBuf> {
    let there = || {
        find("mosquitto")
            .or_else(|| Some(PathBuf::from("/usr/sbin/mosquitto")).filter(|path| path.is_file()))
    };
    if there().is_none() || find("mosquitto_sub").is_none() {
        install::debian(&BROKER_PACKAGES).context("a broker of MQTT is missing")?;
    }
    there().context("mosquitto is not in PATH")
}

/// The interpreter's names, the first is Debian's.
const PYTHONS: [&str; 5] = [
    "python3",
    "python3.14",
    "python3.13",
    "python3.12",
    "python3.11",
];

/// Debian's packages with an interpreter that can make environments.
const PYTHON_PACKAGES: [&str; 2] = ["python3", "python3-venv"];

/// An interpreter that can make an environment; installed if there is none.
pub fn python() -> Result<PathBuf> {
    // 3.11 is the first with buffers in the stable interface.
    let check = "import sys, venv, ensurepip; sys.exit(sys.version_info < (3, 11))";
    let is_usable = |path: &PathBuf| output_of(clean(path).args(["-c", check])).is_ok();
    let there = || PYTHONS.into_iter().filter_map(find).find(is_usable);
    if there().is_none() {
        install::debian(&PYTHON_PACKAGES)
            .context("Python is missing, or older than 3.11, or without venv")?;
    }
    match there() {
        Some(path) => Ok(path),
        None => bail!(
            "no Python from 3.11 on with venv is in PATH (tried {})",
            PYTHONS.join(", ")
        ),
    }
}
