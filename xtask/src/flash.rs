//! Flashing through a debug probe, with probe-rs.

use crate::images::{self, Board};
use crate::inspect;
use crate::tools::{clean, find, read, run};
use anyhow::{Context, Result, bail};
use std::path::Path;

/// Flags of probe-rs from 0.28 on. Without them the probe halts the chip at each reset and HardFault,
/// and thereby disables the firmware's own recovery: restart, crash record, watchdog.
const NO_HALT: [&str; 2] = ["--no-catch-reset", "--no-catch-hardfault"];

/// Builds a board's image, flashes it and shows its log until interrupted.
pub fn flash(board: Board) -> Result<()> {
    let (image, _) = images::build(board.image())?;
    flash_image(&image)
}

/// Flashes an image that is built already, on the board that it is for. Cargo's runner.
pub fn flash_image(image: &Path) -> Result<()> {
    let chip = inspect::chip(&read(image)?)
        .with_context(|| format!("{} is for no board", image.display()))?;
    let Some(probe_rs) = find("probe-rs") else {
        bail!(
            "probe-rs is missing; install version 0.28 or later with `cargo install probe-rs-tools --locked` or from \
             https://probe.rs"
        );
    };
    run(clean(probe_rs)
        .args(["run", "--chip", &chip])
        .args(NO_HALT)
        .arg(image))
}
