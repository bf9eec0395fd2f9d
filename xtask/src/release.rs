//! `release`: writes the images of the real boards as files for every way of flashing, and the
//! command and the Python package with embedded images, all with checksums.

mod command;
mod empty_root;
mod wheel;

use crate::images::{self, Board};
use crate::tools::{announce, create, read, remove, target_dir, write};
use anyhow::{Context, Result, bail, ensure};
use clap::ValueEnum;
use command::{EMBEDDED, Made, Processor};
use object::elf::{FileHeader32, PT_LOAD};
use object::read::elf::{FileHeader, ProgramHeader};
use object::{Endianness, Object, ObjectSection, ObjectSymbol};
use sha2::{Digest, Sha256};
use std::env::consts::{ARCH, OS};
use std::fs;

/// Output folder in cargo's target directory.
const FOLDER: &str = "release-images";

/// The list of checksums, which `sha256sum --check` reads.
const SUMS: &str = "SHA256SUMS";

/// Sections in flash, except for the initial values of `.data`, whose address a symbol holds.
const IN_FLASH: [&str; 3] = [".vector_table", ".text", ".rodata"];

/// Bytes to load, and their address.
struct Segment {
    address: u32,
    bytes: Vec<u8>,
}

/// A package other than the images.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Package {
    /// The static command for Linux on x86-64.
    #[value(name = "linux-x86_64")]
    LinuxX86_64,
    /// The static command for Linux on 64-bit Arm.
    LinuxAarch64,
    /// The Python package for Linux on this processor.
    Wheel,
    /// The command for this system.
    Host,
}

impl Package {
    fn make(self) -> Result<Made> {
        match self {
            Self::Host => command::host(),
            Self::Wheel => wheel::make(),
            Self::LinuxX86_64 => command::linux(Processor::X86_64),
            Self::LinuxAarch64 => command::linux(Processor::Aarch64),
        }
    }
}

/// Builds all images, or those that package `only` embeds, writes them as ELF and as raw bytes (for
/// dfu-util, and for an ST-LINK's drive), checks that these contain the image's sections, makes
/// package `only` or all that can be made here, and writes the checksums. On Linux, the static
/// command takes the place of the one for this system.
pub fn run(only: Option<Package>) -> Result<()> {
    let folder = target_dir().join(FOLDER);
    remove(&folder)?;
    create(&folder)?;
    let version = env!("CARGO_PKG_VERSION");
    let mut sums = String::new();
    let boards = only.map_or(&Board::REAL[..], |_| &EMBEDDED);
    for image in boards.iter().map(|board| board.image()) {
        let (path, sizes) = images::build(image)?;
        let elf = read(&path)?;
        let binary = raw(&segments(&elf)?)?;
        check(&elf, &binary).context(image.name)?;
        announce(format_args!("{}: {sizes}", image.name));
        for (extension, bytes) in [("elf", &elf), ("bin", &binary)] {
            let name = format!("ridgetone-{version}-{}.{extension}", image.name);
            write(&folder.join(&name), bytes)?;
            sums += &sum_line(&name, bytes);
        }
    }
    let packages = only
        .as_ref()
        .map_or(Package::value_variants(), std::slice::from_ref);
    let mut missing = Vec::new();
    for package in packages {
        let replaced = format!("-{OS}-{ARCH}\n");
        if only.is_none() && *package == Package::Host && sums.contains(&replaced) {
            continue;
        }
        let (name, path) = match package.make()? {
            Made::File { name, path } => (name, path),
            Made::Missing(why) if only.is_some() => bail!("{why}"),
            Made::Missing(why) => {
                missing.push(why);
                continue;
            }
        };
        sums += &sum_line(&name, &read(&path)?);
        // `copy` keeps the permissions.
        let copied = fs::copy(&path, folder.join(&name));
        copied.with_context(|| format!("cannot copy {}", path.display()))?;
    }
    write(&folder.join(SUMS), sums.as_bytes())?;
    print!("{sums}");
    println!("{}", folder.display());
    for why in missing {
        println!("not made: {why}");
    }
    Ok(())
}

/// A line of [`SUMS`].
fn sum_line(name: &str, bytes: &[u8]) -> String {
    let sum = Sha256::digest(bytes);
    let sum: String = sum.iter().map(|byte| format!("{byte:02x}")).collect();
    format!("{sum}  {name}\n")
}

/// Segments to load into flash, at their load addresses (physical), not where they run.
fn segments(elf: &[u8]) -> Result<Vec<Segment>> {
    let file = FileHeader32::<Endianness>::parse(elf).context("no ELF file")?;
    let endian = file.endian().context("an ELF file of unknown endianness")?;
    let headers = file.program_headers(endian, elf);
    let mut segments = Vec::new();
    for header in headers.context("an ELF file without segments")? {
        if header.p_type(endian) == PT_LOAD && header.p_filesz(endian) > 0 {
            let bytes = header.data(endian, elf).ok();
            let bytes = bytes
                .context("a segment lies outside of the file")?
                .to_vec();
            let address = header.p_paddr(endian);
            segments.push(Segment { address, bytes });
        }
    }
    segments.sort_by_key(|segment| segment.address);
    Ok(segments)
}

/// Joins segments into raw bytes, starting at the first segment's address. Gaps are filled with
/// 0xFF, as in erased flash.
fn raw(segments: &[Segment]) -> Result<Vec<u8>> {
    let first = segments.first().context("nothing to load")?.address;
    let mut bytes = Vec::new();
    for segment in segments {
        let at = (segment.address - first) as usize;
        ensure!(
            at >= bytes.len(),
            "two segments overlap at {:#x}",
            segment.address
        );
        bytes.resize(at, 0xff);
        bytes.extend(&segment.bytes);
    }
    Ok(bytes)
}

/// Compares the raw bytes with the image's sections, an independent source.
fn check(elf: &[u8], binary: &[u8]) -> Result<()> {
    let file = object::File::parse(elf).context("no ELF file")?;
    let mut symbols = file.symbols();
    let data_at = symbols.find(|symbol| symbol.name() == Ok("__sidata"));
    let data_at = data_at.context("no symbol __sidata")?.address();
    let section = |name| {
        file.section_by_name(name)
            .with_context(|| format!("no section {name}"))
    };
    let base = section(IN_FLASH[0])?.address();
    for name in IN_FLASH.into_iter().chain([".data"]) {
        let section = section(name)?;
        let content = section
            .data()
            .with_context(|| format!("{name} has no content"))?;
        let address = if name == ".data" {
            data_at
        } else {
            section.address()
        };
        let at = address
            .checked_sub(base)
            .context("it lies before the vector table")?;
        let there = binary.get(usize::try_from(at)?..).unwrap_or_default();
        ensure!(
            there.starts_with(content),
            "the section {name} is not at {address:#x}"
        );
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::{Segment, raw, sum_line};

    #[test]
    fn a_gap_is_erased_flash_and_an_overlap_is_refused() {
        let segment = |address, bytes: &[u8]| Segment {
            address,
            bytes: bytes.to_vec(),
        };
        let apart = [segment(0x100, &[1, 2]), segment(0x104, &[3])];
        assert_eq!(raw(&apart).expect("they fit"), [1, 2, 0xff, 0xff, 3]);
        assert!(raw(&[segment(0x100, &[1, 2]), segment(0x101, &[3])]).is_err());
        assert!(raw(&[]).is_err());
    }

    #[test]
    fn a_checksum_is_that_of_the_standard() {
        // FIPS 180-2, appendix B.1.
        let sum = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad";
        assert_eq!(sum_line("a.bin", b"abc"), format!("{sum}  a.bin\n"));
    }
}
