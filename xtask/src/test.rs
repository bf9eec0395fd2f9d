//! `test`: the tests on the PC and one emulated run of each kind; with `--all` everything.

use crate::images::{self, Board};
use crate::python;
use crate::setup;
use crate::streams;
use crate::tools::{announce, clean, output_of, root, run};
use anyhow::{Context, Result, anyhow};

/// The emulated runs without `--all`: names of tests in `host/tests`.
const EMULATED: [&str; 7] = [
    "a_physical_finger_is_the_same_on_the_chip_and_on_the_pc",
    "the_readme_shows_what_the_demo_gives",
    "settings_that_are_kept_survive_a_restart",
    "the_emulated_board_passes_its_check",
    "the_log_and_the_greeting_agree",
    "what_a_finger_feels_is_the_same_on_the_chip_and_on_the_pc",
    "a_fit_too_slow_for_the_hop_costs_hops",
];

/// Runs of the boards' own images without `--all`: programs in `rig/tests`.
const RIG: [&str; 2] = ["boards", "stylus"];

/// Tests that take longer than all others together: `cargo test` runs them by their names.
const NEVER: [&str; 3] = [
    "touch_after_touch_for_thirty_days",
    "an_hour_and_a_quarter_of_touches_is_as_right_at_its_end",
    "an_hour_and_a_quarter_of_touches_on_the_register_model",
];

/// Long tests that are alone in their program, and so keep one core busy at most: they run beside the others.
const ALONE: [(&str, &str); 1] = [("book", "the_commands_that_take_long_run")];

/// Tests of the pages in a browser: their module.
const PAGES: &str = "page::";

/// The one that takes the picture.
const PICTURE: &str = "the_picture_of_the_page_shows_the_period_of_the_first_scene";

/// `cargo test` of the whole workspace, always with the same features: so nothing is built twice.
fn test(arguments: &[&str]) -> std::process::Command {
    let mut cargo = clean("cargo");
    cargo.args(["test", "--workspace"]).args(arguments);
    cargo
}

/// Runs the tests.
pub fn run_tests(all: bool) -> Result<()> {
    setup::qemu()?;
    images::build(Board::Emulated.image())?;
    announce("tests on this PC");
    run(&mut test(&[])).context("tests on this PC")?;
    for board in Board::REAL {
        images::build(board.image())?;
    }
    if all {
        return run_long();
    }
    announce("the images of the boards on the register model");
    let mut rig = test(&RIG.map(|program| ["--test", program]).concat());
    run(rig.args(["--", "--ignored"])).context("tests of the boards' images")?;
    announce("one run of each kind on the emulated chip; `cargo xtask test --all` runs all of them");
    let mut emulated = test(&["--test", "emulated", "--test", "crashes", "--test", "overload", "--", "--ignored"]);
    run(emulated.args(EMULATED)).context("tests of the emulated firmware")
}

/// Takes the pictures of the page that the documents show.
pub fn take_pictures() -> Result<()> {
    let browser = setup::browser()?;
    setup::qemu()?;
    images::build(Board::Emulated.image())?;
    let mut picture = test(&["--test", "view", "--", "--ignored", PICTURE]);
    picture.env("RIDGETONE_BROWSER", browser).env("RIDGETONE_PICTURES", root().join("docs"));
    run(&mut picture).context("the picture of the page")
}

/// Runs everything that is ignored by default, but for [`NEVER`].
fn run_long() -> Result<()> {
    let browser = setup::browser()?;
    let (checked, _) = images::build(images::OVERFLOW_CHECKED)?;
    let (bench, _) = images::build(images::BENCH)?;
    let (baselines, _) = images::build(images::BASELINES)?;
    let (pins, _) = images::build(images::PINS)?;
    announce("long tests, and all tests of the emulated firmware and of the boards' images");
    let mut alone = test(&[]);
    alone.args(ALONE.iter().flat_map(|(program, _)| ["--test", program])).args(["--", "--ignored"]);
    let alone = std::thread::spawn(move || output_of(&mut alone));
    let mut long = test(&["--lib", "--tests", "--", "--ignored", "--skip", PAGES]);
    long.args(NEVER.iter().chain(ALONE.iter().map(|(_, name)| name)).flat_map(|name| ["--skip", name]));
    long.env("RIDGETONE_CHECKED_ELF", checked);
    long.env("RIDGETONE_BENCH_ELF", bench).env("RIDGETONE_BASELINES_ELF", baselines);
    long.env("RIDGETONE_PINS_ELF", pins);
    run(&mut long).context("long tests and tests of the emulated firmware")?;
    let alone = alone.join().map_err(|_| anyhow!("the tests beside the others ended without a result"))?;
    println!("{}", alone.context("long tests beside the others")?);
    announce("tests of the pages in a browser");
    let mut pages = test(&["--test", "view", "--test", "touch", "--test", "pins", "--"]);
    // One of them prints how late the sound is.
    pages.args([PAGES, "--ignored", "--nocapture", "--test-threads=1"]);
    run(pages.env("RIDGETONE_BROWSER", browser)).context("tests of the pages")?;
    streams::run_tests()?;
    python::run_tests()?;
    println!(
        "ran: tests on this PC, long tests, all tests of the emulated firmware, all runs of the boards' images on the \
         register model, the benchmark, pages in a browser, streams, the Python package"
    );
    println!("not run: {}", NEVER.join(", "));
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    /// A test that is renamed or moved must not fall out of the list.
    #[test]
    fn the_listed_tests_exist() {
        let sources = |folder: &str| {
            let paths =
                fs::read_dir(root().join(folder)).expect("a folder").map(|entry| entry.expect("an entry").path());
            paths
                .filter(|path| path.is_file())
                .map(|path| fs::read_to_string(path).expect("a file"))
                .collect::<String>()
        };
        let tests: String =
            ["host/tests", "host/tests/emulated", "host/tests/view", "tests", "rig/tests"].map(sources).concat();
        for name in EMULATED.iter().chain(&NEVER).chain(&[PICTURE]).chain(ALONE.iter().map(|(_, name)| name)) {
            assert!(tests.contains(&format!("fn {name}")), "{name}");
        }
        assert!(tests.contains("mod page;"));
        assert!(RIG.iter().all(|program| root().join(format!("rig/tests/{program}.rs")).is_file()));
    }
}
