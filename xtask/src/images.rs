//! The firmware images: building, checking, flashing.

use crate::inspect::{self, Sizes};
use crate::toolchain::{TARGET, Toolchain};
use crate::tools::{clean, find, run, target_dir, tell};
use anyhow::{Context, Result, bail};
use clap::ValueEnum;
use std::fs;
use std::path::PathBuf;

/// The firmware's binary in `Cargo.toml`.
const BINARY: &str = "ridgetone-firmware";

/// The chip's name at probe-rs.
const CHIP: &str = "STM32F405RGTx";

/// A board there is an image for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Board {
    /// Adafruit Feather STM32F405 Express.
    FeatherF405,
    /// QEMU's netduinoplus2, with the ADS1258 on the PC.
    Emulated,
}

impl Board {
    /// All of them.
    pub const ALL: [Self; 2] = [Self::FeatherF405, Self::Emulated];

    /// Name of its feature and its folder.
    pub const fn name(self) -> &'static str {
        match self {
            Self::FeatherF405 => "feather-f405",
            Self::Emulated => "emulated",
        }
    }
}

/// Builds an image and checks it. Gives its path: `target/firmware/<board>/ridgetone-firmware.elf`.
pub fn build(board: Board) -> Result<PathBuf> {
    let toolchain = Toolchain::find_or_install()?;
    tell(format_args!("building the image for {}, which may take a minute the first time", board.name()));
    let mut cargo = toolchain.cargo("build");
    cargo.args(["--quiet", "--release", "--package", "ridgetone", "--bin", BINARY, "--features", board.name()]);
    run(&mut cargo).with_context(|| format!("the image for {} does not build", board.name()))?;

    let built = target_dir().join(TARGET).join("release").join(BINARY);
    let folder = target_dir().join("firmware").join(board.name());
    let image = folder.join(BINARY).with_extension("elf");
    fs::create_dir_all(&folder).with_context(|| format!("cannot create {}", folder.display()))?;
    fs::copy(&built, &image).with_context(|| format!("cannot copy {}", built.display()))?;
    sizes(&image)?;
    Ok(image)
}

/// Sizes of an image that is fit to run.
pub fn sizes(image: &std::path::Path) -> Result<Sizes> {
    let bytes = fs::read(image).with_context(|| format!("cannot read {}", image.display()))?;
    inspect::check(&bytes).with_context(|| format!("{} is not fit to run", image.display()))
}

/// Builds one image or all, and tells their sizes.
pub fn build_and_tell(board: Option<Board>) -> Result<()> {
    let boards = board.map_or_else(|| Board::ALL.to_vec(), |board| vec![board]);
    for board in boards {
        let image = build(board)?;
        println!("{:<12} {}", board.name(), sizes(&image)?);
        println!("{:<12} {}", "", image.display());
    }
    Ok(())
}

/// Lints the firmware for every board. Debian's packages have no clippy: with them the compiler's own
/// warnings are denied.
pub fn lint() -> Result<()> {
    let toolchain = Toolchain::find_or_install()?;
    for board in Board::ALL {
        tell(format_args!("linting the firmware for {}", board.name()));
        let clippy = toolchain == Toolchain::Rustup;
        let mut cargo = toolchain.cargo(if clippy { "clippy" } else { "check" });
        cargo.args(["--quiet", "--release", "--package", "ridgetone", "--bin", BINARY, "--features", board.name()]);
        if clippy {
            cargo.args(["--", "-D", "warnings"]);
        } else {
            cargo.env("RUSTFLAGS", "-D warnings");
        }
        run(&mut cargo).with_context(|| format!("the firmware for {} has faults", board.name()))?;
    }
    Ok(())
}

/// Flashes the Feather and shows its log until interrupted.
pub fn flash() -> Result<()> {
    let Some(probe_rs) = find("probe-rs") else {
        bail!("probe-rs is missing; install it with `cargo install probe-rs-tools --locked` or from https://probe.rs");
    };
    let image = build(Board::FeatherF405)?;
    run(clean(probe_rs).args(["run", "--chip", CHIP]).arg(image))
}
