//! Builds the command `ridgetone` with embedded firmware images, so that `ridgetone demo` needs
//! neither a checkout nor a compiler: statically for Linux, or for this system.

use super::empty_root::EmptyRoot;
use crate::images::Board;
use crate::toolchain;
use crate::tools::{announce, cargo, output_of, read, run, target_dir};
use anyhow::{Context, Result, ensure};
use object::Endianness;
use object::elf::{DT_NEEDED, EM_AARCH64, EM_X86_64, FileHeader64, PT_INTERP};
use object::read::elf::{Dyn, FileHeader, ProgramHeader};
use std::env::consts::{ARCH, EXE_SUFFIX, OS};
use std::path::{Path, PathBuf};

/// Boards whose images `host/build.rs` embeds.
pub const EMBEDDED: [Board; 2] = [Board::FeatherF405, Board::NucleoF446re];

/// Result of making a package.
pub enum Made {
    /// A file, and its name in the release.
    File { name: String, path: PathBuf },
    /// The package cannot be made here, for this reason.
    Missing(String),
}

/// Processor of a static command.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Processor {
    X86_64,
    Aarch64,
}

impl Processor {
    const fn name(self) -> &'static str {
        match self {
            Self::X86_64 => "x86_64",
            Self::Aarch64 => "aarch64",
        }
    }

    /// Machine number in an ELF file.
    const fn machine(self) -> u16 {
        match self {
            Self::X86_64 => EM_X86_64,
            Self::Aarch64 => EM_AARCH64,
        }
    }
}

pub fn host() -> Result<Made> {
    let path = build(None)?;
    Ok(named(&format!("{OS}-{ARCH}{EXE_SUFFIX}"), path))
}

/// Builds the command for any Linux on `processor`, checks that it is static, and runs it in an
/// empty root directory if this computer can.
pub fn linux(processor: Processor) -> Result<Made> {
    let target = format!("{}-unknown-linux-musl", processor.name());
    if let Err(error) = toolchain::add_target(&target) {
        return Ok(Made::Missing(format!("command for {target}: {error:#}")));
    }
    let path = build(Some(&target))?;
    check_static(&read(&path)?, processor).with_context(|| path.display().to_string())?;
    if (OS, ARCH) == ("linux", processor.name()) {
        run_alone(&path)?;
    }
    Ok(named(&format!("linux-{}", processor.name()), path))
}

/// Names the command for a system.
fn named(system: &str, path: PathBuf) -> Made {
    let name = format!("ridgetone-{}-{system}", env!("CARGO_PKG_VERSION"));
    Made::File { name, path }
}

/// Folder of the images to embed.
pub fn images() -> PathBuf {
    target_dir().join("firmware")
}

/// Fails if one of the images is missing in `file`.
pub fn check_embedded(file: &[u8]) -> Result<()> {
    for board in EMBEDDED {
        let name = board.image().name;
        let image = read(&images().join(name).join("ridgetone-firmware.elf"))?;
        let is_in = file.windows(image.len()).any(|bytes| bytes == image);
        ensure!(is_in, "built without the image {name}");
    }
    Ok(())
}

/// Builds the command for a target, or for this system. Returns its path.
fn build(target: Option<&str>) -> Result<PathBuf> {
    let system = target.unwrap_or("this system");
    announce(format_args!(
        "building the command `ridgetone` for {system}: a few minutes the first time"
    ));
    let mut build = cargo("build --quiet --release --package ridgetone-host", []);
    let mut path = target_dir();
    if let Some(target) = target {
        // The toolchain's own linker works for every processor.
        let linker = format!("target.{target}.linker='rust-lld'");
        build.args(["--target", target, "--config", &linker]);
        path.push(target);
    }
    run(build.env("RIDGETONE_IMAGES", images()))?;
    let suffix = if target.is_none() { EXE_SUFFIX } else { "" };
    path.push(format!("release/ridgetone{suffix}"));
    check_embedded(&read(&path)?).with_context(|| path.display().to_string())?;
    Ok(path)
}

/// Fails unless `command` runs on `processor` without a dynamic loader or shared libraries.
fn check_static(command: &[u8], processor: Processor) -> Result<()> {
    let file = FileHeader64::<Endianness>::parse(command).context("no ELF file of 64 bits")?;
    let endian = file.endian().context("an ELF file of unknown endianness")?;
    let machine = file.e_machine(endian);
    ensure!(
        machine == processor.machine(),
        "built for the processor {machine} in place of {}",
        processor.name()
    );
    let headers = file.program_headers(endian, command);
    for header in headers.context("an ELF file without segments")? {
        ensure!(header.p_type(endian) != PT_INTERP, "it needs a loader");
        let dynamic = header.dynamic(endian, command).context("a damaged table")?;
        let mut entries = dynamic.unwrap_or_default().iter();
        ensure!(
            !entries.any(|entry| entry.tag32(endian) == Some(DT_NEEDED)),
            "it needs a shared library"
        );
    }
    Ok(())
}

/// Runs the demo with each image in an otherwise empty root directory.
fn run_alone(command: &Path) -> Result<()> {
    let Some(root) = EmptyRoot::create()? else {
        return Ok(());
    };
    root.add(command, "ridgetone")?;
    for board in EMBEDDED.map(|board| board.image().name) {
        announce(format_args!(
            "`ridgetone demo --elf {board}` in an empty root directory"
        ));
        let mut demo = root.command("/ridgetone");
        let printed = output_of(demo.args(["demo", "--elf", board]))?;
        ensure!(
            printed.contains("sigma off"),
            "the demo found nothing:\n{printed}"
        );
    }
    root.remove()
}

#[cfg(all(test, target_os = "linux", target_env = "gnu"))]
mod tests {
    use super::{Processor, check_static};

    #[test]
    fn a_program_that_needs_a_loader_or_another_processor_is_refused() {
        let own = std::env::current_exe().expect("a path");
        let own = std::fs::read(own).expect("a file");
        for processor in [Processor::X86_64, Processor::Aarch64] {
            let is_own = processor.name() == std::env::consts::ARCH;
            let why = if is_own {
                "it needs a "
            } else {
                "built for the processor"
            };
            let refused = check_static(&own, processor).expect_err("it is refused");
            assert!(refused.to_string().starts_with(why), "{refused}");
        }
    }
}
