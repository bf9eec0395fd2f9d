//! `test --fresh`: the random tests with another seed than that of every run.

use crate::test::test;
use crate::tools::{announce, run};
use anyhow::{Context, Result};
use std::env;
use std::time::{SystemTime, UNIX_EPOCH};

/// The seed of a run to repeat.
const SEED: &str = "RIDGETONE_SEED";

/// The seed that the tests read. `.cargo/config.toml` fixes it for all other runs.
const TESTS_SEED: &str = "PROPTEST_RNG_SEED";

/// The programs of tests that draw numbers from it, with their packages' folders.
const PROGRAMS: [(&str, &str); 4] = [
    ("", "extremes"),
    ("teletaction", "pins"),
    ("teletaction", "stimulus"),
    ("teletaction", "stylus"),
];

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
    let mut tests = test(&PROGRAMS.map(|(_, program)| ["--test", program]).concat());
    tests
        .env(TESTS_SEED, seed.to_string())
        .args(["--no-fail-fast", "--", "--include-ignored"]);
    run(&mut tests).with_context(|| format!("random tests; again: {repeat}"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tools::root;
    use std::collections::BTreeSet;
    use std::fs;
    use std::path::Path;

    /// The programs below `tests/` of a package that use `proptest`.
    fn random_programs(package: &Path) -> BTreeSet<String> {
        let entries = fs::read_dir(package.join("tests")).into_iter().flatten();
        let paths = entries.map(|entry| entry.expect("an entry").path());
        let is_random = |path: &Path| {
            let files = fs::read_dir(path).map_or(vec![path.to_owned()], |files| {
                files.map(|file| file.expect("a file").path()).collect()
            });
            files.iter().any(|file| {
                fs::read_to_string(file).is_ok_and(|text| text.contains("use proptest::"))
            })
        };
        paths
            .filter(|path| is_random(path))
            .map(|path| path.file_stem().expect("a name").display().to_string())
            .collect()
    }

    #[test]
    fn the_list_has_every_random_program() {
        let mut packages = vec![root().to_owned()];
        for folder in ["", "crates", "lab"] {
            packages.extend(
                fs::read_dir(root().join(folder))
                    .expect("the workspace")
                    .map(|entry| entry.expect("an entry").path()),
            );
        }
        let found: BTreeSet<_> = packages
            .iter()
            .flat_map(|package| {
                let folder = package
                    .strip_prefix(root())
                    .expect("in the workspace")
                    .display()
                    .to_string();
                random_programs(package)
                    .into_iter()
                    .map(move |program| (folder.clone(), program))
            })
            .collect();
        assert_eq!(
            found,
            PROGRAMS
                .map(|(folder, program)| (folder.to_owned(), program.to_owned()))
                .into()
        );
    }

    /// Without this seed `proptest` would draw one in every run.
    #[test]
    fn cargo_fixes_the_seed_of_every_other_run() {
        let seed = env::var(TESTS_SEED).expect("set by .cargo/config.toml");
        assert!(seed.parse::<u64>().is_ok(), "{seed}");
    }
}
