//! `test`: the tests on the PC and one emulated run of each kind; with `--all` everything.

use crate::images::{self, Board};
use crate::setup;
use crate::tools::{announce, both, clean, root, run};
use anyhow::{Context, Result};
use std::process::Command;

/// The whole-path runs without `--all`: names of tests in `host/tests`.
const EMULATED: [&str; 4] = [
    "a_physical_finger_is_the_same_on_the_chip_and_on_the_pc",
    "the_readme_shows_what_the_demo_gives",
    "settings_that_are_kept_survive_a_restart",
    "the_emulated_board_passes_its_check",
];

/// Runs of the boards' own images without `--all`: programs of tests, with their packages' folders.
const BOARDS: [(&str, &str); 3] = [
    ("emulator", "boards"),
    ("emulator", "own_adc"),
    ("teletaction", "stylus_image"),
];

/// Tests in real time: their program and module. They need a core for themselves.
pub const IN_REAL_TIME: (&str, &str) = ("link", "with_a_board::");

/// The one that takes the picture.
const PICTURE: &str = "the_picture_of_the_page_shows_the_period_of_the_first_scene";

/// `cargo test` of the whole workspace, always with the same features: so nothing is built twice.
pub fn test(arguments: &[&str]) -> Command {
    let mut cargo = clean("cargo");
    cargo.args(["test", "--workspace"]).args(arguments);
    cargo
}

/// What the whole-path runs need.
pub fn prepare() -> Result<()> {
    images::build(Board::FeatherF405.image()).map(drop)
}

/// Runs the tests.
pub fn run_tests() -> Result<()> {
    prepare()?;
    announce("tests on this PC; beside them the other images, of which each keeps one core busy");
    both(on_this_pc, || {
        Board::REAL
            .into_iter()
            .try_for_each(|board| images::build(board.image()).map(drop))
    })?;
    in_real_time()?;
    announce("the images of the boards on the register model");
    let mut boards = test(&BOARDS.map(|(_, program)| ["--test", program]).concat());
    run(boards.args(["--", "--ignored"])).context("tests of the boards' images")?;
    announce(
        "one run of each kind on the emulated chip; `cargo xtask test --all` runs all of them",
    );
    let mut emulated = test(&["--test", "emulated", "--", "--ignored"]);
    run(emulated.args(EMULATED)).context("tests of the emulated firmware")
}

/// Builds all tests, and runs those that need neither an image nor a tool.
pub fn on_this_pc() -> Result<()> {
    run(&mut test(&[])).context("tests on this PC")
}

/// Runs the tests that look at a clock, with nothing beside them.
pub fn in_real_time() -> Result<()> {
    announce("tests in real time");
    let (program, module) = IN_REAL_TIME;
    let mut tests = test(&["--test", program, "--", "--ignored", "--test-threads=1"]);
    run(tests.arg(module)).context("tests in real time")
}

/// Takes the pictures of the page that the documents show.
pub fn take_pictures() -> Result<()> {
    let browser = setup::browser()?;
    prepare()?;
    let mut picture = test(&["--test", "view", "--", "--ignored", PICTURE]);
    picture
        .env("RIDGETONE_BROWSER", browser)
        .env("RIDGETONE_PICTURES", root().join("docs"));
    run(&mut picture).context("the picture of the page")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::long::{NEVER, WAITING};
    use std::fs;

    /// A test that is renamed or moved must not fall out of the list.
    #[test]
    fn the_listed_tests_exist() {
        let sources = |folder: &str| {
            let paths = fs::read_dir(root().join(folder))
                .expect("a folder")
                .map(|entry| entry.expect("an entry").path());
            paths
                .filter(|path| path.is_file())
                .map(|path| fs::read_to_string(path).expect("a file"))
                .collect::<String>()
        };
        let tests: String = [
            "host/tests",
            "host/tests/emulated",
            "host/tests/view",
            "tests",
            "emulator/tests",
        ]
        .map(sources)
        .concat();
        for name in EMULATED.iter().chain(&NEVER).chain(&[PICTURE, WAITING.1]) {
            assert!(tests.contains(&format!("fn {name}")), "{name}");
        }
        assert!(tests.contains("mod page;"));
        let link = fs::read_to_string(root().join("teletaction/tests/link.rs")).expect("a file");
        assert!(link.contains("mod with_a_board;"));
        assert!(BOARDS.iter().all(|(folder, program)| {
            root()
                .join(format!("{folder}/tests/{program}.rs"))
                .is_file()
        }));
    }
}
