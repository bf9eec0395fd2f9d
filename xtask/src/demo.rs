//! `demo`: from nothing to a frequency and a picture.

use crate::images::{self, Board};
use crate::toolchain::Toolchain;
use crate::tools::{announce, clean, create, program, root, run};
use anyhow::{Context, Result, anyhow};
use std::path::{Path, PathBuf};
use std::{fs, thread};

/// Installs and builds everything, runs a scene file or else the default scene, and prints the
/// place of the picture.
pub fn demo(svg: &Path, scene: Option<&Path>) -> Result<()> {
    // Before anything that takes long.
    let absolute = |path: &Path| {
        fs::canonicalize(path).with_context(|| format!("cannot read {}", path.display()))
    };
    let scene = scene.map(absolute).transpose()?;
    let elf = build()?;
    let svg = root().join(svg);
    if let Some(folder) = svg.parent() {
        create(folder)?;
    }
    announce("sliding a grating over the emulated finger");
    let mut demo = program("ridgetone-host", "ridgetone", "demo");
    demo.arg("--force")
        .arg("--elf")
        .arg(elf)
        .arg("--svg")
        .arg(&svg);
    if let Some(scene) = scene {
        demo.arg("--scene").arg(scene);
    }
    run(&mut demo)?;
    println!("picture         {}", svg.display());
    Ok(())
}

/// Installs what is missing. Builds the command and the image, and gives the image's path.
fn build() -> Result<PathBuf> {
    announce(
        "building the firmware image and the command `ridgetone`, which takes a few minutes the first time",
    );
    let mut command = clean("cargo");
    command.args([
        "build",
        "--quiet",
        "--release",
        "--package",
        "ridgetone-host",
    ]);
    // Both at once: the last step of each build has one core.
    let command = thread::spawn(move || run(&mut command));
    let image =
        Toolchain::find_or_install().and_then(|_| images::build(Board::FeatherF405.image()));
    command
        .join()
        .map_err(|_| anyhow!("the build panicked"))??;
    Ok(image?.0)
}
