//! `test`: everything.

use crate::images::{self, Board};
use crate::setup;
use crate::tools::{self, clean, tell};
use anyhow::{Context, Result};

/// Runs the tests that need no emulator, then those that do, on an image built from this tree, and those that need a browser.
pub fn run() -> Result<()> {
    setup::qemu()?;
    let browser = setup::browser()?;
    images::build(Board::Emulated.image())?;
    let (checked, _) = images::build(images::OVERFLOW_CHECKED)?;
    let (bench, _) = images::build(images::BENCH)?;
    let (baselines, _) = images::build(images::BASELINES)?;
    tell("tests that need no emulator");
    tools::run(clean("cargo").args(["test", "--workspace"])).context("tests without the emulator")?;
    tell("tests of the emulated firmware, which take a few minutes");
    let mut emulated = clean("cargo");
    emulated.args(["test", "--package", "ridgetone-host"]);
    for test in ["emulated", "crashes", "overload", "book"] {
        emulated.args(["--test", test]);
    }
    emulated.args(["--", "--ignored"]).env("RIDGETONE_CHECKED_ELF", checked);
    tools::run(&mut emulated).context("tests of the emulated firmware")?;
    tools::run(clean("cargo").args([
        "test",
        "--package",
        "ridgetone-eval",
        "--test",
        "emulated_faults",
        "--",
        "--ignored",
    ]))
    .context("faults on the emulated firmware")?;
    tell("tests of the pages in a browser");
    let mut page = clean("cargo");
    page.args(["test", "--package", "ridgetone-host", "--test", "view", "--", "--ignored"]);
    tools::run(page.arg("--test-threads=1").env("RIDGETONE_BROWSER", browser)).context("the tests of the pages")?;
    tell("the test of the benchmark");
    let mut counted = clean("cargo");
    counted.args(["test", "--package", "ridgetone-eval", "--test", "bench", "--", "--ignored"]);
    tools::run(counted.env("RIDGETONE_BENCH_ELF", bench).env("RIDGETONE_BASELINES_ELF", baselines))
        .context("the test of the benchmark")
}
