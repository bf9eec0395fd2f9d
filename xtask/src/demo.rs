//! `demo`: from nothing to a frequency and a picture.

use crate::images::{self, Board};
use crate::setup;
use crate::tools::{self, clean, root, tell};
use anyhow::{Context, Result};
use std::fs;
use std::path::Path;

/// Installs what is missing, builds, runs a scene file or else the default scene, and tells where the picture is.
pub fn run(svg: &Path, scene: Option<&Path>) -> Result<()> {
    // Before anything that takes long.
    let absolute = |path: &Path| fs::canonicalize(path).with_context(|| format!("cannot read {}", path.display()));
    let scene = scene.map(absolute).transpose()?;
    setup::qemu()?;
    let (elf, _) = images::build(Board::Emulated.image())?;
    let svg = root().join(svg);
    if let Some(folder) = svg.parent() {
        fs::create_dir_all(folder).with_context(|| format!("cannot create {}", folder.display()))?;
    }
    tell("building the command `ridgetone`, which may take a minute the first time");
    let mut build = clean("cargo");
    tools::run(build.args(["build", "--quiet", "--release", "--package", "ridgetone-host"]))?;
    tell("sliding a grating over the emulated finger");
    let mut demo = clean("cargo");
    demo.args(["run", "--quiet", "--release", "--package", "ridgetone-host", "--bin", "ridgetone", "--", "demo"]);
    demo.arg("--elf").arg(elf).arg("--svg").arg(&svg);
    if let Some(scene) = scene {
        demo.arg("--scene").arg(scene);
    }
    tools::run(&mut demo)?;
    println!("picture         {}", svg.display());
    Ok(())
}
