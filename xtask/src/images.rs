//! Builds and checks the firmware images.

use crate::inspect::{self, DMA, DRDY, Interrupt, Sizes, USART2_DMA, USART3_DMA};
use crate::inspect::{TIM6, USART2, USART3};
use crate::toolchain::{TARGET, Toolchain};
use crate::tools::{announce, create, read, run, target_dir, write};
use crate::{frames, panics, sizes};
use anyhow::{Context, Result};
use clap::ValueEnum;
use std::path::PathBuf;
use std::process::Command;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Image {
    package: &'static str,
    /// Feature in the package's `Cargo.toml`, and name of the folder.
    pub name: &'static str,
    binary: &'static str,
    profile: &'static str,
    /// Interrupts that the image must handle.
    interrupts: &'static [Interrupt],
}

/// The bench image: the fit in each scene, with built-in windows.
pub const COUNTS: Image = image("bench", "ridgetone-bench", "bench-image", &[]);

/// The Feather's firmware with every addition checked for overflow.
pub const OVERFLOW_CHECKED: Image = Image {
    profile: "overflow-checked",
    ..Board::FeatherF405.image()
};

/// The profile of all images except those for one test, in the workspace's `Cargo.toml`.
const USUAL: &str = "image";

const fn image(
    name: &'static str,
    package: &'static str,
    binary: &'static str,
    interrupts: &'static [Interrupt],
) -> Image {
    Image {
        package,
        name,
        binary,
        profile: USUAL,
        interrupts,
    }
}

/// A board with an image.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Board {
    /// Adafruit Feather STM32F405 Express.
    FeatherF405,
    /// ST Nucleo-F446RE.
    NucleoF446re,
    /// WeAct Black Pill with an STM32F411.
    BlackpillF411,
    /// WeAct Black Pill with an STM32F401 and its 96 KiB of RAM.
    BlackpillF401,
    /// The Feather without a second chip: its processor's own ADC.
    FeatherF405Adc,
    /// The Nucleo without a second chip.
    NucleoF446reAdc,
    /// The Black Pill F411 without a second chip.
    BlackpillF411Adc,
    /// Adafruit Feather STM32F405 Express with an encoder and an actuator: a stylus.
    StylusF405,
    /// The Nucleo with the whole job in one loop, src/minimal.rs.
    Minimal,
}

impl Board {
    /// Boards that run the whole firmware.
    pub const REAL: [Self; 7] = [
        Self::FeatherF405,
        Self::NucleoF446re,
        Self::BlackpillF411,
        Self::FeatherF405Adc,
        Self::NucleoF446reAdc,
        Self::BlackpillF411Adc,
        Self::StylusF405,
    ];

    /// Returns the board's image, with the interrupts that it must handle: of DRDY, of the ADC's
    /// DMA or of the stylus's timer, and of the line and its DMA.
    pub const fn image(self) -> Image {
        let (name, interrupts): (_, &[_]) = match self {
            Self::FeatherF405 => ("feather-f405", &[DRDY, USART3, USART3_DMA]),
            Self::NucleoF446re => ("nucleo-f446re", &[DRDY, USART2, USART2_DMA]),
            Self::BlackpillF411 => ("blackpill-f411", &[DRDY, USART2, USART2_DMA]),
            Self::BlackpillF401 => ("blackpill-f401", &[DRDY, USART2, USART2_DMA]),
            Self::FeatherF405Adc => ("feather-f405-adc", &[DRDY, DMA, USART3, USART3_DMA]),
            Self::NucleoF446reAdc => ("nucleo-f446re-adc", &[DRDY, DMA, USART2, USART2_DMA]),
            Self::BlackpillF411Adc => ("blackpill-f411-adc", &[DRDY, DMA, USART2, USART2_DMA]),
            Self::StylusF405 => ("stylus-f405", &[TIM6, USART3, USART3_DMA]),
            Self::Minimal => ("minimal", &[]),
        };
        let (package, binary) = match self {
            Self::StylusF405 => ("ridgetone-teletaction", "ridgetone-stylus-firmware"),
            Self::Minimal => ("ridgetone-firmware", "ridgetone-minimal"),
            _ => ("ridgetone-firmware", "ridgetone-firmware"),
        };
        image(name, package, binary, interrupts)
    }
}

impl Image {
    /// A cargo command for this image, such as `build`.
    fn cargo(self, toolchain: &Toolchain, subcommand: &str) -> Command {
        let mut cargo = toolchain.cargo(subcommand);
        cargo.args([
            "--quiet",
            "--profile",
            self.profile,
            "--package",
            self.package,
        ]);
        cargo.args(["--bin", self.binary, "--features", self.name]);
        cargo
    }
}

/// Builds an image and checks it. Returns its path, such as
/// `target/firmware/feather-f405/ridgetone-firmware.elf`, and sizes.
pub fn build(image: Image) -> Result<(PathBuf, Sizes)> {
    let Image {
        name,
        binary,
        profile,
        interrupts,
        ..
    } = image;
    let toolchain = Toolchain::find_or_install()?;
    announce(format_args!(
        "building the image {name}, which may take a minute the first time"
    ));
    run(&mut image.cargo(&toolchain, "build"))
        .with_context(|| format!("the image {name} does not build"))?;

    let bytes = read(&target_dir().join(TARGET).join(profile).join(binary))?;
    let unfit = || format!("the image {name} is not fit to run");
    let sizes = inspect::check(&bytes, interrupts).with_context(unfit)?;
    // Test images have larger stack frames.
    if image != COUNTS && profile == USUAL {
        frames::check(&bytes).with_context(unfit)?;
    }
    // Images that may panic are not checked: benchmark, loop, and overflow checks.
    if !interrupts.is_empty() && profile == USUAL {
        panics::check(&bytes).with_context(unfit)?;
    }
    let folder = match profile {
        USUAL => name.to_owned(),
        _ => format!("{name}-{profile}"),
    };
    let folder = target_dir().join("firmware").join(folder);
    create(&folder)?;
    let path = folder.join(binary).with_extension("elf");
    // Write only changes: a newer file would make cargo rebuild the command that embeds it.
    if !read(&path).is_ok_and(|there| there == bytes) {
        write(&path, &bytes)?;
    }
    Ok((path, sizes))
}

pub fn build_real() -> Result<()> {
    Board::REAL
        .into_iter()
        .try_for_each(|board| build(board.image()).map(drop))
}

pub fn build_tested() -> Result<()> {
    build_real()?;
    build(Board::Minimal.image()).map(drop)
}

/// Builds one image or all, and prints their sizes, in total, by crate and by static.
pub fn build_and_print(board: Option<Board>) -> Result<()> {
    let boards = board
        .as_ref()
        .map_or(Board::value_variants(), std::slice::from_ref);
    for board in boards {
        let (path, sizes) = build(board.image())?;
        println!("{:<18} {sizes}", board.image().name);
        println!("{:<18} {}", "", path.display());
        let image = read(&path)?;
        let (function, bytes) = frames::check(&image)?;
        println!("{:<18} largest stack frame: {bytes} bytes, {function}", "");
        print!("{}", sizes::table(&image)?);
    }
    Ok(())
}

/// Lints the firmware and the bench image. Debian's packages lack clippy; with them, compiler
/// warnings are denied instead.
pub fn lint() -> Result<()> {
    let toolchain = Toolchain::find_or_install()?;
    let images = Board::value_variants().iter().map(|board| board.image());
    for image in images.chain([COUNTS]) {
        announce(format_args!("linting the image {}", image.name));
        let clippy = toolchain == Toolchain::Rustup;
        let mut cargo = image.cargo(&toolchain, if clippy { "clippy" } else { "check" });
        if clippy {
            cargo.args(["--", "-D", "warnings"]);
        } else {
            cargo.env("RUSTFLAGS", "-D warnings");
        }
        run(&mut cargo).with_context(|| format!("the image {} has faults", image.name))?;
    }
    Ok(())
}
