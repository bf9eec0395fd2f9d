//! An empty root directory, to run released files as if nothing else were installed.

use crate::tools::{announce, clean, create, find, output_of, remove, target_dir};
use anyhow::{Context, Result};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Commands that change the root directory; the second also works for a user other than root.
const WAYS: [&[&str]; 2] = [&["chroot"], &["unshare", "--map-root-user", "chroot"]];

/// An empty directory, and the command that makes it the root directory.
pub struct EmptyRoot {
    folder: PathBuf,
    way: &'static [&'static str],
}

impl EmptyRoot {
    /// Creates a directory; `None`, with a remark, if this user may not change the root directory.
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

    /// Path of the directory, as seen from outside.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    pub fn add(&self, file: &Path, name: &str) -> Result<()> {
        let copied = fs::copy(file, self.folder.join(name));
        copied.with_context(|| format!("cannot copy {}", file.display()))?;
        Ok(())
    }

    /// A command that runs in this root directory.
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
