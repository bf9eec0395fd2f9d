//! That every `cargo xtask` of a document is a task with these options.

use crate::Arguments;
use clap::Parser;
use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

/// Every document but the changelog, which names tasks that are gone.
fn documents() -> Vec<PathBuf> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let folder = |name: &str| {
        let entries = fs::read_dir(root.join(name)).expect("a folder");
        entries.map(|entry| entry.expect("an entry").path())
    };
    let single = [
        "README.md",
        "CONTRIBUTING.md",
        "host/reference.md",
        "emulator/README.md",
        "teletaction/README.md",
    ];
    folder("docs/guide")
        .chain(folder("docs/results"))
        .filter(|path| path.extension().is_some_and(|extension| extension == "md"))
        .chain(single.map(|name| root.join(name)))
        .collect()
}

#[test]
fn every_task_of_a_document_exists() {
    let mut tasks = BTreeSet::new();
    for path in documents() {
        let page = fs::read_to_string(&path).expect("a document");
        for after in page.split("cargo xtask ").skip(1) {
            let task = after.split(['`', '\n', '#', ';']).next();
            tasks.insert(task.unwrap_or_default().trim().to_owned());
        }
    }
    assert!(tasks.len() > 20, "{tasks:?}");
    for task in tasks {
        let words = ["cargo xtask"].into_iter().chain(task.split_whitespace());
        if let Err(error) = Arguments::try_parse_from(words) {
            panic!("cargo xtask {task}: {error}");
        }
    }
}
