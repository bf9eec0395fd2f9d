//! `events`: what follows from the description of the messages, written anew.

use crate::tools::{announce, clean, run};
use anyhow::{Context, Result};

/// The unit test that compares the files writes them if this is set.
const WRITE: &str = "RIDGETONE_WRITE";

/// Writes `host/src/events/schema.json`, the tables of `host/reference.md` and
/// `host/python/package/ridgetone/_events.py`.
pub fn write() -> Result<()> {
    announce("schemas, the reference's tables and Python's classes, from host/src/events/view.rs");
    let mut test = clean("cargo");
    test.args(["test", "--quiet", "--package", "ridgetone-host", "--lib"]);
    run(test.args(["events::generated"]).env(WRITE, "1")).context("the views")
}
