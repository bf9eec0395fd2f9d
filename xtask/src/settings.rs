//! `settings`: what follows from the table of settings, written anew.

use crate::tools::{announce, clean, run};
use anyhow::{Context, Result};

/// The unit test that compares the files writes them if this is set.
const WRITE: &str = "RIDGETONE_WRITE";

/// Writes the list of `host/reference.md` and the class `Settings` of
/// `host/python/package/ridgetone/_objects.py`.
pub fn write() -> Result<()> {
    announce("the reference's list and Python's class, from crates/proto/src/settings.rs");
    let mut test = clean("cargo");
    test.args(["test", "--quiet", "--package", "ridgetone-host", "--lib"]);
    run(test.args(["settings_form::generated"]).env(WRITE, "1")).context("the table of settings")
}
