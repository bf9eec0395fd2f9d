//! The firmware images: building, checking, flashing.

use crate::inspect::{self, Interrupt, Sizes};
use crate::panics;
use crate::toolchain::{TARGET, Toolchain};
use crate::tools::{announce, clean, find, run, target_dir};
use anyhow::{Context, Result, bail};
use clap::ValueEnum;
use std::fs;
use std::path::{Path, PathBuf};

/// An image there is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Image {
    /// Its package.
    package: &'static str,
    /// Its feature in the package's `Cargo.toml`, and its folder.
    name: &'static str,
    /// Its binary in the package's `Cargo.toml`.
    binary: &'static str,
    /// Its profile in the workspace's `Cargo.toml`.
    profile: &'static str,
    /// Interrupts that it is about.
    interrupts: &'static [Interrupt],
}

/// The benchmark in the emulator.
pub const BENCH: Image =
    Image { package: "ridgetone-eval", name: "bench", binary: "ridgetone-bench", profile: USUAL, interrupts: &[] };

/// The benchmark of the methods that the fit is compared with.
pub const BASELINES: Image = Image {
    package: "ridgetone-eval",
    name: "bench-baselines",
    binary: "baselines-bench",
    profile: USUAL,
    interrupts: &[],
};

/// The emulated board's firmware with every addition checked for overflow.
pub const OVERFLOW_CHECKED: Image = Image { profile: "overflow-checked", ..Board::Emulated.image() };

/// The profile of all that is not for a test alone, in the workspace's `Cargo.toml`.
const USUAL: &str = "image";

/// The firmware's binary.
const FIRMWARE: &str = "ridgetone-firmware";

/// A board there is an image for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Board {
    /// Adafruit Feather STM32F405 Express.
    FeatherF405,
    /// ST Nucleo-F446RE.
    NucleoF446re,
    /// QEMU's netduinoplus2, with the ADS1258 on the PC.
    Emulated,
}

impl Board {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::FeatherF405, Self::NucleoF446re, Self::Emulated];

    /// Those of hardware.
    pub const REAL: [Self; 2] = [Self::FeatherF405, Self::NucleoF446re];

    /// Its feature in `Cargo.toml`.
    pub const fn name(self) -> &'static str {
        self.image().name
    }

    /// Its firmware.
    pub const fn image(self) -> Image {
        // DRDY's interrupt and the line's are what the firmware is about.
        let (name, interrupts): (_, &[_]) = match self {
            Self::FeatherF405 => ("feather-f405", &[inspect::DRDY, inspect::USART3]),
            Self::NucleoF446re => ("nucleo-f446re", &[inspect::DRDY, inspect::USART2]),
            Self::Emulated => ("emulated", &[inspect::DRDY, inspect::USART3]),
        };
        Image { package: "ridgetone-firmware", name, binary: FIRMWARE, profile: USUAL, interrupts }
    }

    /// Its chip's name at probe-rs; the emulated one has none.
    const fn chip(self) -> Option<&'static str> {
        match self {
            Self::FeatherF405 => Some("STM32F405RGTx"),
            Self::NucleoF446re => Some("STM32F446RETx"),
            Self::Emulated => None,
        }
    }
}

/// Builds an image and checks it. Gives its path, such as `target/firmware/emulated/ridgetone-firmware.elf`, and its
/// sizes.
pub fn build(image: Image) -> Result<(PathBuf, Sizes)> {
    let Image { package, name, binary, profile, interrupts } = image;
    let toolchain = Toolchain::find_or_install()?;
    announce(format_args!("building the image {name}, which may take a minute the first time"));
    let mut cargo = toolchain.cargo("build");
    cargo.args(["--quiet", "--profile", profile, "--package", package, "--bin", binary, "--features", name]);
    run(&mut cargo).with_context(|| format!("the image {name} does not build"))?;

    let built = target_dir().join(TARGET).join(profile).join(binary);
    let folder = if profile == USUAL { name.to_owned() } else { format!("{name}-{profile}") };
    let folder = target_dir().join("firmware").join(folder);
    let image = folder.join(binary).with_extension("elf");
    fs::create_dir_all(&folder).with_context(|| format!("cannot create {}", folder.display()))?;
    fs::copy(&built, &image).with_context(|| format!("cannot copy {}", built.display()))?;
    let sizes = sizes(&image, interrupts)?;
    // Overflow checks are panics of their own.
    if binary == FIRMWARE && profile == USUAL {
        let bytes = fs::read(&image).with_context(|| format!("cannot read {}", image.display()))?;
        panics::check(&bytes).with_context(|| format!("{} is not fit to run", image.display()))?;
    }
    Ok((image, sizes))
}

/// Sizes of an image that is fit to run.
fn sizes(image: &Path, interrupts: &[Interrupt]) -> Result<Sizes> {
    let bytes = fs::read(image).with_context(|| format!("cannot read {}", image.display()))?;
    inspect::check(&bytes, interrupts).with_context(|| format!("{} is not fit to run", image.display()))
}

/// Builds one image or all, and prints their sizes.
pub fn build_and_print(board: Option<Board>) -> Result<()> {
    let boards = board.map_or_else(|| Board::ALL.to_vec(), |board| vec![board]);
    for board in boards {
        let (path, sizes) = build(board.image())?;
        println!("{:<13} {sizes}", board.image().name);
        println!("{:<13} {}", "", path.display());
    }
    Ok(())
}

/// Lints the firmware for every board, and the benchmarks. Debian's packages have no clippy: with them the compiler's own
/// warnings are denied.
pub fn lint() -> Result<()> {
    let toolchain = Toolchain::find_or_install()?;
    for Image { package, name, binary, profile, .. } in
        Board::ALL.map(Board::image).into_iter().chain([BENCH, BASELINES])
    {
        announce(format_args!("linting the image {name}"));
        let clippy = toolchain == Toolchain::Rustup;
        let mut cargo = toolchain.cargo(if clippy { "clippy" } else { "check" });
        cargo.args(["--quiet", "--profile", profile, "--package", package, "--bin", binary, "--features", name]);
        if clippy {
            cargo.args(["--", "-D", "warnings"]);
        } else {
            cargo.env("RUSTFLAGS", "-D warnings");
        }
        run(&mut cargo).with_context(|| format!("the image {name} has faults"))?;
    }
    Ok(())
}

/// Flashes a board and shows its log until interrupted.
pub fn flash(board: Board) -> Result<()> {
    let Some(chip) = board.chip() else { bail!("the emulated board has no flash: `cargo xtask demo` runs it") };
    let Some(probe_rs) = find("probe-rs") else {
        bail!("probe-rs is missing; install it with `cargo install probe-rs-tools --locked` or from https://probe.rs");
    };
    let (image, _) = build(board.image())?;
    run(clean(probe_rs).args(["run", "--chip", chip]).arg(image))
}
