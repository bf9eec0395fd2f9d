//! The stimulus in the page of `ridgetone touch`, as WebAssembly.

use crate::tools::{announce, clean, find, root, run, target_dir};
use anyhow::{Context, Result, ensure};
use std::fs;

const TARGET: &str = "wasm32-unknown-unknown";

/// Builds it and puts it where the command has it from.
pub fn build() -> Result<()> {
    ensure!(
        find("rustup").is_some(),
        "the target {TARGET} comes with rustup, which is not here"
    );
    run(clean("rustup").args(["target", "add", TARGET])).context("the target for WebAssembly")?;
    announce("building teletaction/assets/touch/stimulus.wasm");
    let mut cargo = clean("cargo");
    cargo.args([
        "rustc",
        "--package",
        "ridgetone-teletaction",
        "--lib",
        "--crate-type",
        "cdylib",
        "--target",
        TARGET,
        "--profile",
        "image",
    ]);
    for setting in ["strip=true", "panic=\"abort\"", "opt-level=\"s\""] {
        cargo.args(["--config", &format!("profile.image.{setting}")]);
    }
    run(&mut cargo)?;
    let built = target_dir()
        .join(TARGET)
        .join("image/ridgetone_teletaction.wasm");
    let to = root().join("teletaction/assets/touch/stimulus.wasm");
    let bytes = fs::read(&built).with_context(|| built.display().to_string())?;
    fs::write(&to, &bytes).with_context(|| to.display().to_string())?;
    println!("{}: {} bytes", to.display(), bytes.len());
    Ok(())
}
