//! `lint`: refuses what clippy and rustfmt do not know: comments with an unnatural opening, tuples
//! as parameters, licences of others that ask for more than to be named, and crates in two versions.

mod comments;
mod crates;
mod parameters;
#[cfg(test)]
mod tests;

use crate::tools::{clean, output_of, root};
use anyhow::{Context, Result, ensure};
use std::fs;

/// Beginnings of paths that are not looked at: the reader of recordings.
const EXEMPT: [&str; 7] = [
    "hal-mock/src/trace",
    "host/src/samples",
    "host/src/raw_rows",
    "host/src/grid",
    "host/src/part",
    "host/src/table_fit",
    "host/src/messages",
];

/// A line that has to change.
#[derive(Debug, PartialEq, Eq)]
struct Finding {
    /// Counted from 1.
    line: usize,
    what: String,
}

/// Looks at every Rust, JavaScript and Python file that git tracks or would add.
pub fn run() -> Result<()> {
    let mut git = clean("git");
    git.args(["ls-files", "--cached", "--others", "--exclude-standard"]);
    let files = output_of(git.args(["--", "*.rs", "*.js", "*.py"]))?;
    let mut count = 0;
    for path in files.lines().filter(|path| !is_exempt(path)) {
        let file = root().join(path);
        // A file that is deleted, but not yet in a commit.
        if !file.exists() {
            continue;
        }
        let text = fs::read_to_string(&file).with_context(|| format!("cannot read {path}"))?;
        for Finding { line, what } in look_at(path, &text) {
            eprintln!("{path}:{line}: {what}");
            count += 1;
        }
    }
    for what in crates::check()? {
        eprintln!("Cargo.lock: {what}");
        count += 1;
    }
    ensure!(
        count == 0,
        "{count} lines break the rules of `cargo xtask lint`"
    );
    Ok(())
}

fn is_exempt(path: &str) -> bool {
    EXEMPT.iter().any(|start| path.starts_with(start))
}

/// What has to change in a file, in the order of its lines.
fn look_at(path: &str, text: &str) -> Vec<Finding> {
    let is_rust = path.ends_with(".rs");
    let marker = if path.ends_with(".py") { "#" } else { "//" };
    let mut findings = comments::openings(text, marker);
    if is_rust {
        findings.extend(parameters::tuples(text));
    }
    findings.sort_by_key(|finding| finding.line);
    findings
}
