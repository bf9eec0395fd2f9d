//! `lint`: refuses what clippy and rustfmt do not detect: files that import each other in a circle,
//! tuples as parameters, third-party licences that require more than attribution, and crates in two
//! versions.

mod circles;
mod crates;
mod parameters;

use crate::tools::{clean, output_of, root};
use anyhow::{Context, Result, ensure};
use std::fs;

/// Checks every Rust file that git tracks or would add, and all third-party crates.
pub fn run() -> Result<()> {
    let mut git = clean("git");
    git.args(["ls-files", "--cached", "--others", "--exclude-standard"]);
    let paths = output_of(git.args(["--", "*.rs"]))?;
    let mut sources = Vec::new();
    // Git also lists files whose deletion is not committed.
    for path in paths.lines().filter(|path| root().join(path).exists()) {
        let text = fs::read_to_string(root().join(path));
        sources.push((path, text.with_context(|| format!("cannot read {path}"))?));
    }
    let mut found = circles::find(&sources);
    for (path, text) in &sources {
        let tuples = parameters::tuples(text).into_iter();
        found.extend(tuples.map(|(line, name)| {
            format!(
                "{path}:{line}: `{name}` takes a tuple: give the values a struct with a name, or \
                 pass them one by one"
            )
        }));
    }
    let crates = crates::check()?.into_iter();
    found.extend(crates.map(|what| format!("Cargo.lock: {what}")));
    for what in &found {
        eprintln!("{what}");
    }
    ensure!(
        found.is_empty(),
        "{} findings of `cargo xtask lint`",
        found.len()
    );
    Ok(())
}
