//! `serve` with its receivers: features of the command that nothing else builds.

use crate::eval;
use crate::python;
use crate::setup;
use crate::tools::{announce, clean, run};
use anyhow::{Context, Result};
use std::process::Command;

/// Features of what most people stream to.
const STREAMS: [&str; 2] = ["foxglove", "mqtt"];

/// A program of tests of `serve`, with features that are built here alone. Those of all other
/// crates are the usual ones, so that little is built again.
fn test(features: &[&str], program: &str) -> Command {
    crate::test::test(&["--features", &of_host(features), "--test", program, "--"])
}

/// The value of `--features`.
fn of_host(features: &[&str]) -> String {
    let features = features
        .iter()
        .map(|feature| format!("ridgetone-host/{feature}"));
    features.collect::<Vec<_>>().join(",")
}

/// Runs the tests of streams.
pub fn run_tests() -> Result<()> {
    setup::broker()?;
    announce("streams: Foxglove, and MQTT beside mosquitto");
    // One after the other: they look at a clock, beside boards of 2 kHz.
    run(test(&STREAMS, "streams").arg("--test-threads=1")).context("tests of streams")
}

/// Receivers by other authors, as packages for Python: Cyclone DDS reads what is for ROS 2, and
/// Zenoh has a package of its own.
const PEERS: [&str; 2] = ["cyclonedds==11.0.1", "eclipse-zenoh==1.10.2"];

/// Tests Zenoh and ROS 2, whose 253 crates take minutes, beside [`PEERS`] too. Then ten boards and
/// a fast one, a minute each: prints what is lost and how late the rest arrives.
pub fn measure() -> Result<()> {
    setup::broker()?;
    let peers = python::environment("peers", &PEERS).context("Cyclone DDS and Zenoh for Python")?;
    for one in ["zenoh", "ros2"] {
        announce(format_args!("streams: {one}"));
        let mut tests = test(&[one], one);
        run(tests
            .arg("--include-ignored")
            .env("RIDGETONE_PEERS", &peers))
        .with_context(|| format!("tests of {one}"))?;
    }
    announce("ten boards and a fast one, for a minute each");
    run(test(&STREAMS, "streams").args(["--ignored", "--nocapture", "latency::"]))
        .context("streams")
}

/// Measures up to `most` replayed fingers through a broker and a router, and the commands; optimised,
/// as they are installed.
pub fn fingers(most: u32, write: bool) -> Result<()> {
    setup::broker()?;
    announce(format_args!("up to {most} fingers, and the commands"));
    let features = of_host(&["mqtt", "zenoh"]);
    let mut fingers = crate::test::test(&["--release", "--features", &features]);
    fingers
        .args(["--test", "fingers", "--", "--ignored", "--nocapture"])
        .arg("--test-threads=1")
        .env("RIDGETONE_FINGERS", most.to_string());
    measured(&mut fingers, write).context("many fingers")
}

/// Runs two fingers through so many minutes of faults.
pub fn soak(minutes: f64, write: bool) -> Result<()> {
    setup::broker()?;
    announce(format_args!("two fingers for {minutes} minutes of faults"));
    let mut soak = test(&STREAMS, "streams");
    soak.args(["--ignored", "--nocapture", "soak::"])
        .env("RIDGETONE_SOAK_MINUTES", minutes.to_string());
    measured(&mut soak, write).context("the counts of the soak")
}

/// Runs a measurement. With `write` its figures go into `docs/results/live.json` and its page.
fn measured(test: &mut Command, write: bool) -> Result<()> {
    if !write {
        return run(test);
    }
    run(test.env("RIDGETONE_WRITE", "1"))?;
    eval::page("live")
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
