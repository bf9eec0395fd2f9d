//! `test --fresh`: the random tests with another seed than that of every run.

use crate::test::test;
use crate::tools::{announce, clean, output_of, run};
use anyhow::{Context, Result};
use std::collections::BTreeSet;
use std::env;
use std::time::{SystemTime, UNIX_EPOCH};

/// The seed of a run to repeat.
const SEED: &str = "RIDGETONE_SEED";

/// The seed that the tests read. `.cargo/config.toml` fixes it for all other runs.
const TESTS_SEED: &str = "PROPTEST_RNG_SEED";

/// The programs of tests that draw numbers from it: files or folders below some `tests/`.
fn programs() -> Result<BTreeSet<String>> {
    let mut git = clean("git");
    git.args(["grep", "--files-with-matches", "use proptest::"]);
    let files = output_of(git.args(["--", "tests", "*/tests/*.rs"]))?;
    let names = files.lines().filter_map(|path| {
        let (_, program) = path.rsplit_once("tests/")?;
        Some(program.split(['/', '.']).next()?.to_owned())
    });
    Ok(names.collect())
}

/// Runs them, the long ones too, with a seed from the clock or from [`SEED`], and prints it.
pub fn run_tests() -> Result<()> {
    let seed = match env::var(SEED) {
        Ok(text) => text
            .parse()
            .with_context(|| format!("{SEED}: {text}: not a whole number"))?,
        Err(_) => SystemTime::now()
            .duration_since(UNIX_EPOCH)
            .context("a clock before 1970")?
            .as_secs(),
    };
    let repeat = format!("{SEED}={seed} cargo xtask test --fresh");
    announce(format_args!("random tests; this run again: {repeat}"));
    let mut tests = test(&[]);
    tests.args(programs()?.iter().flat_map(|program| ["--test", program]));
    tests
        .env(TESTS_SEED, seed.to_string())
        .args(["--no-fail-fast", "--", "--include-ignored"]);
    run(&mut tests).with_context(|| format!("random tests; again: {repeat}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn random_programs_are_found() {
        let found = programs().expect("programs");
        assert!(found.contains("extremes"), "{found:?}");
    }

    /// Without this seed `proptest` would draw one in every run.
    #[test]
    fn cargo_fixes_the_seed_of_every_other_run() {
        let seed = env::var(TESTS_SEED).expect("set by .cargo/config.toml");
        assert!(seed.parse::<u64>().is_ok(), "{seed}");
    }
}
