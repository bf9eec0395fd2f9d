//! Tests that every `cargo xtask` command in a document exists, with its options.

use crate::Arguments;
use crate::tools::{clean, output_of, root};
use clap::Parser;
use std::collections::BTreeSet;
use std::fs;

/// Reads every page except the changelog, which names removed tasks.
fn documents() -> Vec<String> {
    let mut git = clean("git");
    let pages = output_of(git.args(["ls-files", "--", "*.md"])).expect("the pages");
    let pages = pages.lines().filter(|path| !path.ends_with("CHANGELOG.md"));
    let pages = pages
        .map(|path| root().join(path))
        .filter(|path| path.exists());
    pages
        .map(|path| fs::read_to_string(path).expect("a page"))
        .collect()
}

#[test]
fn every_task_of_a_document_exists() {
    let mut tasks = BTreeSet::new();
    for page in documents() {
        for after in page.split("cargo xtask ").skip(1) {
            let task = after.split(['`', '\n', '#', ';']).next();
            tasks.insert(task.unwrap_or_default().trim().to_owned());
        }
    }
    assert!(!tasks.is_empty());
    for task in tasks {
        let words = ["cargo xtask"].into_iter().chain(task.split_whitespace());
        if let Err(error) = Arguments::try_parse_from(words) {
            panic!("cargo xtask {task}: {error}");
        }
    }
}
