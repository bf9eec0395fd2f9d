//! A root directory with nothing in it, to run what a user gets as if on a computer without
//! anything else.

use crate::tools::{announce, clean, create, find, output_of, remove, target_dir};
use anyhow::{Context, Result};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Changes the root directory; the second also for a user who is not root.
const WAYS: [&[&str]; 2] = [&["chroot"], &["unshare", "--map-root-user", "chroot"]];

/// An empty directory, and the words that make it the root directory.
pub struct EmptyRoot {
    folder: PathBuf,
    way: &'static [&'static str],
}

impl EmptyRoot {
    /// Creates one; `None`, with a remark, if this system does not let this user change the root
    /// directory.
    pub fn create() -> Result<Option<Self>> {
        let works = |way: &&[&str]| {
            find(way[0]).is_some() && output_of(start(way).args(["/", "/bin/true"])).is_ok()
        };
        let Some(way) = WAYS.into_iter().find(works) else {
            announce("not run in an empty root directory: needs `chroot` as root, or `unshare`");
            return Ok(None);
        };
        let folder = target_dir().join("empty-root");
        remove(&folder)?;
        create(&folder)?;
        Ok(Some(Self { folder, way }))
    }

    /// The directory, as seen from outside.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// Copies a file into the directory.
    pub fn add(&self, file: &Path, name: &str) -> Result<()> {
        let copied = fs::copy(file, self.folder.join(name));
        copied.with_context(|| format!("cannot copy {}", file.display()))?;
        Ok(())
    }

    /// A command with this root directory.
    pub fn command(&self, program: &str) -> Command {
        let mut command = start(self.way);
        command.arg(&self.folder).arg(program);
        command
    }

    pub fn remove(self) -> Result<()> {
        remove(&self.folder)
    }
}

fn start(way: &[&str]) -> Command {
    let mut command = clean(way[0]);
    command.args(&way[1..]);
    command
}
