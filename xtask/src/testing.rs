//! `test`: runs the tests on the PC and one emulated run of each kind; `--all` runs everything,
//! `--fresh` the random tests.

use crate::images::{self, Board, Image};
use crate::tools::{announce, both, cargo, clean, output_of, root, run};
use crate::{python, setup};
use anyhow::{Context, Result};
use std::collections::BTreeSet;
use std::env;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::mpsc::{self, Receiver, Sender};
use std::time::{SystemTime, UNIX_EPOCH};

/// Emulated runs without `--all`: names of tests in `host/tests`.
const EMULATED: [&str; 4] = [
    "a_physical_finger_is_the_same_on_the_chip_and_on_the_pc",
    "the_readme_shows_what_the_demo_gives",
    "settings_that_are_kept_survive_a_restart",
    "the_emulated_board_passes_its_check",
];

/// Tests that take minutes and repeat shorter ones: run them by name with `cargo test`.
const NEVER: [&str; 2] = [
    "touch_after_touch_for_thirty_days",
    "an_hour_and_a_quarter_of_touches_on_the_register_model",
];

/// A long test in the program `book` that mostly waits.
const WAITING: &str = "the_commands_that_take_long_run";

/// Module of the browser tests of the `touch` page.
const PAGES: &str = "page::";

const PICTURE: &str = "test_the_picture_of_the_page_shows_the_period_of_the_first_scene";

/// Images that only long tests need, with the environment variables for their paths.
const IMAGES: [(&str, Image); 1] = [("RIDGETONE_CHECKED_ELF", images::OVERFLOW_CHECKED)];

/// Seed of a random run to repeat.
const SEED: &str = "RIDGETONE_SEED";

/// Seed that random tests read. `.cargo/config.toml` fixes it for all other runs.
const TESTS_SEED: &str = "PROPTEST_RNG_SEED";

/// Paths of images, with the environment variables that pass them to tests.
type Built = Vec<(&'static str, PathBuf)>;

/// `cargo test` of the whole workspace, always with the same features, so that nothing is built
/// twice.
pub fn test(arguments: &str) -> Command {
    cargo(&format!("test --workspace {arguments}"), [])
}

/// Images that the emulated runs need.
pub fn prepare() -> Result<()> {
    images::build(Board::FeatherF405.image()).map(drop)
}

/// Runs all tests that take no more than a few minutes.
pub fn short() -> Result<()> {
    prepare()?;
    announce("tests on this PC; beside them the other images, of which each keeps one core busy");
    both(on_this_pc, images::build_tested)?;
    announce("the images of the boards on the register model");
    run(&mut test(
        "--test boards --test log --test own_adc --test stylus_image -- --ignored",
    ))
    .context("tests of the boards' images")?;
    announce("one run of each kind on the emulated chip; `cargo xtask test --all` runs all");
    let mut emulated = test("--test emulated -- --ignored");
    run(emulated.args(EMULATED)).context("tests of the emulated firmware")
}

/// Builds all tests, and runs those that need neither an image nor a tool.
fn on_this_pc() -> Result<()> {
    run(&mut test("--no-fail-fast")).context("tests on this PC")
}

/// Takes the pictures of the page for the documents.
pub fn take_pictures() -> Result<()> {
    prepare()?;
    python::run_page_tests(
        Some(PICTURE),
        &[("RIDGETONE_PICTURES", root().join("docs"))],
    )
}

/// Runs all tests except [`NEVER`], on two cores.
pub fn all() -> Result<()> {
    prepare()?;
    let browser = setup::browser()?;
    setup::broker()?;
    let (sender, receiver) = mpsc::channel();
    announce("all tests: on this PC, long ones, the emulated firmware, the boards' images");
    both(|| run_busy(&browser, &receiver), move || run_beside(sender))?;
    println!(
        "ran: tests on this PC, long tests, all tests of the emulated firmware, all runs of the boards' images on the \
         register model, pages in a browser, streams, the Python package"
    );
    println!("not run: {}", NEVER.join(", "));
    Ok(())
}

/// Runs tests that keep two cores busy, then those of pages and streams, which depend on the clock.
fn run_busy(browser: &Path, images: &Receiver<Built>) -> Result<()> {
    on_this_pc()?;
    let images = images.recv().context("there are no images")?;
    announce("long tests, and tests of the emulated firmware");
    // Not `--lib`, which would also build the Python package's library, which has no tests. The
    // whole workspace, because a subset has fewer features, which forces a rebuild. Do not stop at
    // a failure: one run of an hour then shows all.
    let mut long = test("--tests --no-fail-fast -- --ignored");
    let elsewhere = NEVER.into_iter().chain([PAGES, WAITING]);
    long.args(elsewhere.flat_map(|name| ["--skip", name]));
    run(long.envs(images)).context("long tests")?;
    announce("tests of the pages in a browser");
    // One of these tests prints the sound's latency.
    let mut pages = test("--test touch --test pins -- --ignored --nocapture");
    pages
        .args([PAGES, "--test-threads=1"])
        .env("RIDGETONE_BROWSER", browser);
    run(&mut pages).context("tests of the pages")?;
    python::run_page_tests(None, &[])?;
    setup::broker()?;
    announce("streams: Foxglove, and MQTT with mosquitto");
    // The usual features of other crates, so that little is rebuilt. Tests run one by one, as they
    // depend on the clock while boards run at 2 kHz.
    let features = "--features ridgetone-host/foxglove,ridgetone-host/mqtt";
    run(&mut test(&format!(
        "{features} --test streams -- --test-threads=1"
    )))
    .context("tests of streams")
}

/// Does the work that keeps at most one core busy: links images, builds the wheel, or waits. Output
/// is printed at the end, because other tests print meanwhile.
fn run_beside(images: Sender<Built>) -> Result<()> {
    images::build_tested()?;
    let built: Result<Built> = IMAGES
        .into_iter()
        .map(|(name, image)| Ok((name, images::build(image)?.0)))
        .collect();
    // The receiver is gone if a test has failed meanwhile.
    let _ = images.send(built?);
    let python = python::build()?;
    let waiting = output_of(test("--test book -- --ignored").arg(WAITING));
    println!("{}", waiting.context("a long test beside the others")?);
    println!("{}", python::run_tests(&python)?);
    Ok(())
}

/// Returns test programs, files or folders in some `tests/`, that git lists with `arguments`.
fn programs(arguments: &[&str]) -> Result<BTreeSet<String>> {
    let files = output_of(clean("git").args(arguments))?;
    let names = files.lines().filter_map(|path| {
        let (_, program) = path.rsplit_once("tests/")?;
        Some(program.split(['/', '.']).next()?.to_owned())
    });
    Ok(names.collect())
}

/// Returns the test programs that draw random numbers.
fn random_programs() -> Result<BTreeSet<String>> {
    programs(&[
        "grep",
        "--files-with-matches",
        "use proptest::",
        "--",
        "tests",
        "*/tests/*.rs",
    ])
}

/// Runs the random tests, including long ones, with a seed from the clock or from [`SEED`].
pub fn fresh() -> Result<()> {
    let seed: u64 = match env::var(SEED) {
        Ok(text) => text
            .parse()
            .with_context(|| format!("{SEED}: {text}: not a whole number"))?,
        Err(_) => SystemTime::now().duration_since(UNIX_EPOCH)?.as_secs(),
    };
    let repeat = format!("{SEED}={seed} cargo xtask test --fresh");
    announce(format_args!("random tests; this run again: {repeat}"));
    let mut tests = test("");
    tests.args(
        random_programs()?
            .iter()
            .flat_map(|program| ["--test", program]),
    );
    tests.args(["--no-fail-fast", "--", "--include-ignored"]);
    run(tests.env(TESTS_SEED, seed.to_string()))
        .with_context(|| format!("random tests; again: {repeat}"))
}

/// A renamed or moved test must not drop out of a list.
#[test]
fn the_listed_tests_exist() {
    let git = |arguments: &[&str]| output_of(clean("git").args(arguments));
    for name in EMULATED.iter().chain(&NEVER).chain(&[WAITING]) {
        git(&["grep", "--quiet", &format!("fn {name}"), "--", "*tests/*"]).expect(name);
    }
    let picture = format!("def {PICTURE}");
    git(&["grep", "--quiet", &picture, "--", "*tests/page/*"]).expect(PICTURE);
    let pages = format!("mod {};", PAGES.trim_end_matches("::"));
    git(&["grep", "--quiet", &pages, "--", "*tests/touch*"]).expect(PAGES);
    for program in [
        "emulator/tests/boards",
        "emulator/tests/own_adc",
        "teletaction/tests/stylus_image",
    ] {
        assert!(root().join(format!("{program}.rs")).is_file(), "{program}");
    }
    assert!(random_programs().expect("programs").contains("extremes"));
}

/// Without this seed `proptest` would draw a new one in every run.
#[test]
fn cargo_fixes_the_seed_of_every_other_run() {
    let seed = env::var(TESTS_SEED).expect("set by .cargo/config.toml");
    assert!(seed.parse::<u64>().is_ok(), "{seed}");
}
