//! `serve` with its receivers: features of the command that nothing else builds.

use crate::setup;
use crate::tools::{announce, clean, run};
use anyhow::{Context, Result};

/// Runs the tests of streams.
pub fn run_tests() -> Result<()> {
    setup::broker()?;
    announce("streams: Foxglove, and MQTT with mosquitto");
    // Features of other crates as usual, so that little is built again. One test after the other:
    // they look at a clock while boards run at 2 kHz.
    let features = "ridgetone-host/foxglove,ridgetone-host/mqtt";
    let mut tests = crate::test::test(&["--features", features, "--test", "streams", "--"]);
    run(tests.arg("--test-threads=1")).context("tests of streams")
}

/// Other systems on which the command has to build, by the targets of rustup.
const OTHER_SYSTEMS: [&str; 2] = ["x86_64-pc-windows-gnu", "aarch64-apple-darwin"];

/// Checks that the command builds for other systems, if rustup may fetch their core libraries.
pub fn check_systems() -> Result<()> {
    for target in OTHER_SYSTEMS {
        if run(clean("rustup").args(["--quiet", "target", "add", target])).is_err() {
            println!("not checked: {target}, since rustup cannot fetch its core library");
            continue;
        }
        announce(format_args!("checking the command for {target}"));
        run(clean("cargo").args([
            "check",
            "--quiet",
            "--package",
            "ridgetone-host",
            "--target",
            target,
        ]))
        .with_context(|| format!("the command does not build for {target}"))?;
    }
    Ok(())
}
