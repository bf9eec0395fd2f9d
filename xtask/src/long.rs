//! `test --all`: long tests, on two cores at once.

use crate::images::{self, Board, Image};
use crate::python;
use crate::setup;
use crate::streams;
use crate::test::{IN_REAL_TIME, in_real_time, on_this_pc, prepare, test};
use crate::tools::{announce, both, output_of, root, run};
use anyhow::{Context, Result};
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::mpsc::{self, Receiver, Sender};

/// Tests that take minutes and repeat what shorter ones show: `cargo test` runs them by name.
pub const NEVER: [&str; 2] = [
    "touch_after_touch_for_thirty_days",
    "an_hour_and_a_quarter_of_touches_on_the_register_model",
];

/// A long test that mostly waits, and its program.
pub const WAITING: (&str, &str) = ("book", "the_commands_that_take_long_run");

/// Tests of the pages in a browser: their module.
const PAGES: &str = "page::";

/// The package that runs the boards' images.
const EMULATOR: &str = "ridgetone-emulator";

/// Images that only long tests need, with the variables in which these find them.
const IMAGES: [(&str, Image); 1] = [("RIDGETONE_CHECKED_ELF", images::OVERFLOW_CHECKED)];

/// Paths with the variables in which tests find them.
type Built = Vec<(&'static str, PathBuf)>;

/// Runs all tests but for [`NEVER`].
pub fn run_tests() -> Result<()> {
    prepare()?;
    let browser = setup::browser()?;
    setup::broker()?;
    let (sender, receiver) = mpsc::channel();
    announce(
        "all tests: those on this PC, long ones, those of the emulated firmware and of the boards' images",
    );
    both(|| run_busy(&browser, &receiver), || run_beside(&sender))?;
    in_real_time()?;
    println!(
        "ran: tests on this PC, long tests, all tests of the emulated firmware, all runs of the boards' images on the \
         register model, pages in a browser, streams, the Python package, the papers' figures in NumPy"
    );
    println!("not run: {}", NEVER.join(", "));
    Ok(())
}

/// Tests that keep two cores busy, then those of pages and streams, which look at a clock.
fn run_busy(browser: &Path, images: &Receiver<Built>) -> Result<()> {
    on_this_pc()?;
    let images = images.recv().context("there are no images")?;
    announce("long tests, and tests of the emulated firmware");
    // Not `--lib`: it would build the Python package's library too, which has no tests.
    let mut long = test(&[
        "--exclude",
        EMULATOR,
        "--tests",
        "--",
        "--ignored",
        "--skip",
        PAGES,
        "--skip",
        WAITING.1,
        "--skip",
        IN_REAL_TIME.1,
    ]);
    run(long
        .args(NEVER.map(|name| ["--skip", name]).concat())
        .envs(images))
    .context("long tests")?;
    announce("tests of the pages in a browser");
    let mut pages = test(&["--test", "view", "--test", "touch", "--test", "pins", "--"]);
    // One of them prints how late the sound is.
    pages.args([PAGES, "--ignored", "--nocapture", "--test-threads=1"]);
    run(pages.env("RIDGETONE_BROWSER", browser)).context("tests of the pages")?;
    streams::run_tests()
}

/// What keeps one core busy at most: links images, builds the wheel, waits, or runs in virtual
/// time. The output of each is printed at its end, as the others print meanwhile.
fn run_beside(images: &Sender<Built>) -> Result<()> {
    for board in Board::REAL {
        images::build(board.image())?;
    }
    let built: Result<Built> = IMAGES
        .map(|(name, image)| Ok((name, images::build(image)?.0)))
        .into_iter()
        .collect();
    // Nobody receives them if a test has failed meanwhile.
    let _ = images.send(built?);
    let python = python::build()?;
    let (program, name) = WAITING;
    let waiting = output_of(test(&["--test", program, "--", "--ignored"]).arg(name));
    println!("{}", waiting.context("a long test beside the others")?);
    let mut boards = test(&[]);
    for program in emulator_programs()? {
        boards.args(["--test", &program]);
    }
    boards
        .args(["--", "--ignored", "--test-threads=1"])
        .args(NEVER.map(|name| ["--skip", name]).concat());
    println!(
        "{}",
        output_of(&mut boards).context("tests of the boards' images")?
    );
    println!("{}", python::run_tests(&python)?);
    println!("{}", python::run_papers(&python)?);
    Ok(())
}

/// The programs of tests of the register model.
fn emulator_programs() -> Result<Vec<String>> {
    let folder = root().join("emulator").join("tests");
    let mut programs = Vec::new();
    for entry in fs::read_dir(&folder).with_context(|| folder.display().to_string())? {
        let path = entry?.path();
        if path.extension().is_some_and(|extension| extension == "rs") {
            programs.extend(
                path.file_stem()
                    .map(|stem| stem.to_string_lossy().into_owned()),
            );
        }
    }
    Ok(programs)
}
