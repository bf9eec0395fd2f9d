//! `demo`: from nothing to a frequency and a picture.

use crate::images::{self, Board};
use crate::setup;
use crate::toolchain::Toolchain;
use crate::tools::{announce, clean, create, program, root, run};
use anyhow::{Context, Result, anyhow};
use std::path::Path;
use std::{fs, thread};

/// Installs and builds everything, runs a scene file or else the default scene, and prints the place of the picture.
pub fn demo(svg: &Path, scene: Option<&Path>) -> Result<()> {
    // Before anything that takes long.
    let absolute = |path: &Path| fs::canonicalize(path).with_context(|| format!("cannot read {}", path.display()));
    let scene = scene.map(absolute).transpose()?;
    setup::qemu()?;
    Toolchain::find_or_install()?;
    announce("building the firmware image and the command `ridgetone`, which takes a few minutes the first time");
    let mut build = clean("cargo");
    build.args(["build", "--quiet", "--release", "--package", "ridgetone-host"]);
    // Both at once: the last step of each has one core.
    let build = thread::spawn(move || run(&mut build));
    let image = images::build(Board::Emulated.image());
    build.join().map_err(|_| anyhow!("the build panicked"))??;
    let (elf, _) = image?;
    let svg = root().join(svg);
    if let Some(folder) = svg.parent() {
        create(folder)?;
    }
    announce("sliding a grating over the emulated finger");
    let mut demo = program("ridgetone-host", "ridgetone", "demo");
    demo.arg("--force").arg("--elf").arg(elf).arg("--svg").arg(&svg);
    if let Some(scene) = scene {
        demo.arg("--scene").arg(scene);
    }
    run(&mut demo)?;
    println!("picture         {}", svg.display());
    Ok(())
}
