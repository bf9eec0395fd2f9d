//! The firmware image: its place, and checks that a file is one.

use anyhow::{Context, Result, bail, ensure};
use object::{Architecture, Object, ObjectSymbol};
use std::path::{Path, PathBuf};

/// Where `cargo xtask firmware` puts the emulated board's image, from cargo's target directory.
const IMAGE: &str = "firmware/emulated/ridgetone-firmware.elf";

/// DRDY's interrupt handler: an image without it is not ours.
const HANDLER: &str = "EXTI4";

/// Handler of all interrupts without their own.
const NO_HANDLER: &str = "DefaultHandler";

/// A file name that is only in the image for the emulator.
const MARKER: &[u8] = b"spi.request\0";

/// The default image: in `CARGO_TARGET_DIR`, else in `target` of the workspace around the current
/// directory, else of the one this program was built in.
pub fn find() -> Result<PathBuf> {
    let here = std::env::current_dir().unwrap_or_default();
    let root = Path::new(env!("CARGO_MANIFEST_DIR"))
        .parent()
        .unwrap_or(Path::new("."));
    let chosen = std::env::var_os("CARGO_TARGET_DIR").map(|target| root.join(target));
    let usual = here
        .ancestors()
        .chain([root])
        .map(|root| root.join("target"));
    let found = chosen
        .into_iter()
        .chain(usual)
        .map(|target| target.join(IMAGE))
        .find(|image| image.is_file());
    found.with_context(|| {
        format!("firmware image target/{IMAGE} not found: build it with `cargo xtask firmware --board emulated` in a clone of the repository, and run this in there or name the file with --elf FILE")
    })
}

/// The bytes of an image's file. A device may never end.
pub fn bytes(path: &Path) -> Result<Vec<u8>> {
    let named = || path.display().to_string();
    ensure!(
        std::fs::metadata(path).with_context(named)?.is_file(),
        "{}: not a file",
        named()
    );
    std::fs::read(path).with_context(named)
}

/// Checks that a file is an image of our firmware; gives its absolute path.
pub fn check(path: &Path) -> Result<PathBuf> {
    let shown = path.display();
    let bytes = bytes(path)?;
    let Ok(file) = object::File::parse(&*bytes) else {
        bail!("{shown}: not an ELF file");
    };
    ensure!(
        file.architecture() == Architecture::Arm && !file.is_64() && file.is_little_endian(),
        "{shown}: built for {:?}, not for the 32-bit ARM of the fingertip",
        file.architecture()
    );
    let address = |name| {
        file.symbols()
            .find(|s| s.name() == Ok(name) && s.is_definition())
            .map(|s| s.address())
    };
    let handler = address(HANDLER);
    ensure!(
        handler.is_some() && handler != address(NO_HANDLER),
        "{shown}: not Ridgetone's firmware (or stripped): it has no handler {HANDLER}"
    );
    ensure!(
        bytes.windows(MARKER.len()).any(|window| window == MARKER),
        "{shown}: not built for the emulator; build that image with `cargo xtask firmware --board emulated`"
    );
    path.canonicalize().with_context(|| format!("{shown}"))
}
