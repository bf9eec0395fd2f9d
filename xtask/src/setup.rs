//! `setup`: finds or installs the tools for the firmware and the tests.

use crate::install;
use crate::toolchain::{TARGET, Toolchain};
use crate::tools::{clean, find, output_of};
use anyhow::{Context, Result};
use std::path::PathBuf;

/// Finds or installs all tools, and prints the result.
pub fn run() -> Result<()> {
    let library = match Toolchain::find_or_install()? {
        Toolchain::Rustup => "with the compiler".to_owned(),
        Toolchain::Debian { linker } => {
            format!(
                "built from Debian's sources, linked by {}",
                linker.display()
            )
        }
    };
    println!("core library for {TARGET}: {library}");
    for (name, found, use_of_it) in [
        ("browser", browser(), "one of the tests"),
        ("broker", broker(), "the tests of streams"),
        ("Python", python(), "the Python package"),
        (
            "probe-rs",
            find("probe-rs").context("see https://probe.rs"),
            "`flash`",
        ),
    ] {
        match found {
            Ok(path) => println!("{name}: {}", path.display()),
            Err(error) => println!("{name}: not there ({error:#}); needed for {use_of_it} only"),
        }
    }
    Ok(())
}

/// Returns the program that `there` finds, installed from Debian's packages if missing.
fn find_or_install(
    what: &str,
    there: impl Fn() -> Option<PathBuf>,
    packages: &[&str],
) -> Result<PathBuf> {
    if let Some(path) = there() {
        return Ok(path);
    }
    install::debian(packages).with_context(|| format!("{what} is missing"))?;
    there().with_context(|| format!("{what} is not in PATH"))
}

/// Finds a browser and fonts, or installs them.
pub fn browser() -> Result<PathBuf> {
    let programs = ["chromium", "chromium-browser", "google-chrome", "chrome"];
    let there = || programs.into_iter().find_map(find);
    let what = format!("a browser ({})", programs.join(", "));
    find_or_install(&what, there, &["chromium", "fonts-dejavu-core"])
}

/// Returns an MQTT broker with its clients, installed if missing. Debian installs it outside a
/// user's PATH.
pub fn broker() -> Result<PathBuf> {
    let there = || {
        find("mosquitto_sub")?;
        let elsewhere = || Some(PathBuf::from("/usr/sbin/mosquitto")).filter(|path| path.is_file());
        find("mosquitto").or_else(elsewhere)
    };
    find_or_install(
        "a broker of MQTT",
        there,
        &["mosquitto", "mosquitto-clients"],
    )
}

/// Returns an interpreter that can create an environment, installed if missing.
pub fn python() -> Result<PathBuf> {
    let programs = [
        "python3",
        "python3.14",
        "python3.13",
        "python3.12",
        "python3.11",
    ];
    // 3.11 is the first version with buffers in the stable interface.
    let check = "import sys, venv, ensurepip; sys.exit(sys.version_info < (3, 11))";
    let is_usable = |path: &PathBuf| output_of(clean(path).args(["-c", check])).is_ok();
    let there = || programs.into_iter().filter_map(find).find(is_usable);
    let what = format!("Python from 3.11 on with venv ({})", programs.join(", "));
    find_or_install(&what, there, &["python3", "python3-venv"])
}
