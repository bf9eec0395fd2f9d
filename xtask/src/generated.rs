//! `events` and `settings`: what follows from the description of the messages and from the table of
//! settings, written anew.

use crate::tools::{announce, clean, run};
use anyhow::{Context, Result};

/// The unit test that compares the files writes them if this is set.
const WRITE: &str = "RIDGETONE_WRITE";

/// Writes the schemas, the tables and lists of `host/reference.md` and Python's classes that a
/// module of the command's library describes: `events` or `settings_form`.
pub fn write(module: &str) -> Result<()> {
    announce(format_args!("what follows from host/src/{module}"));
    let mut test = clean("cargo");
    test.args(["test", "--quiet", "--package", "ridgetone-host", "--lib"]);
    test.arg(format!("{module}::generated")).env(WRITE, "1");
    run(&mut test).context(module.to_owned())
}
