//! The ELF file of a firmware.

use crate::board::Board;
use object::elf::{FileHeader32, PT_LOAD};
use object::read::elf::{FileHeader, ProgramHeader};
use object::{Architecture, Object, ObjectSymbol, SymbolKind};
use std::fmt;
use std::path::{Path, PathBuf};

/// A firmware image built by `cargo xtask firmware`.
#[derive(Clone, Debug)]
pub struct Image {
    /// Physical addresses and their content.
    pub(crate) segments: Vec<(u32, Vec<u8>)>,
    symbols: Vec<(String, u32)>,
    /// Functions, sorted by address.
    pub(crate) functions: Vec<Function>,
}

#[derive(Clone, Debug)]
pub(crate) struct Function {
    pub name: String,
    pub address: u32,
    pub bytes: u32,
}

/// Reason why a file is not an image.
#[derive(Debug)]
pub struct ImageError(PathBuf, String);

impl fmt::Display for ImageError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{}: {}; `cargo xtask firmware` builds the images",
            self.0.display(),
            self.1
        )
    }
}

impl std::error::Error for ImageError {}

impl Image {
    /// Reads a board's image, built by `cargo xtask firmware` in this tree.
    pub fn built(board: Board) -> Result<Self, ImageError> {
        Self::built_as(board.name(), board.file())
    }

    /// Reads an image built by `cargo xtask firmware` in this tree, by its folder and file.
    pub fn built_as(folder: &str, file: &str) -> Result<Self, ImageError> {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
        let target = std::env::var_os("CARGO_TARGET_DIR")
            .map_or_else(|| root.join("target"), |target| root.join(target));
        Self::read(&target.join("firmware").join(folder).join(file))
    }

    /// Reads an ELF file.
    pub fn read(path: &Path) -> Result<Self, ImageError> {
        let bytes =
            std::fs::read(path).map_err(|error| ImageError(path.to_owned(), error.to_string()))?;
        Self::parse(&bytes, path)
    }

    /// Parses an ELF file in memory, such as one embedded in a program. `name` is for messages.
    pub fn parse(bytes: &[u8], name: &Path) -> Result<Self, ImageError> {
        let failed = |why: String| ImageError(name.to_owned(), why);
        let file = object::read::elf::ElfFile32::<object::LittleEndian>::parse(bytes)
            .map_err(|error| failed(error.to_string()))?;
        if file.architecture() != Architecture::Arm {
            return Err(failed(format!("built for {:?}", file.architecture())));
        }
        let endian = object::LittleEndian;
        let mut segments = Vec::new();
        let headers = FileHeader32::<object::LittleEndian>::parse(bytes)
            .and_then(|header| header.program_headers(endian, bytes))
            .map_err(|error| failed(error.to_string()))?;
        for header in headers {
            let data = header.data(endian, bytes);
            let data = data.map_err(|()| failed("a segment beyond the end".into()))?;
            if header.p_type(endian) == PT_LOAD && !data.is_empty() {
                segments.push((header.p_paddr(endian), data.to_vec()));
            }
        }
        let symbols = file
            .symbols()
            .filter_map(|one| Some((one.name().ok()?.to_owned(), one.address() as u32)))
            .collect();
        let mut functions: Vec<Function> = file
            .symbols()
            .filter(|one| one.kind() == SymbolKind::Text && one.size() > 0)
            .filter_map(|one| {
                Some(Function {
                    name: format!("{:#}", rustc_demangle::demangle(one.name().ok()?)),
                    address: one.address() as u32 & !1,
                    bytes: one.size() as u32,
                })
            })
            .collect();
        functions.sort_by(|a, b| (a.address, &a.name).cmp(&(b.address, &b.name)));
        functions.dedup_by_key(|function| function.address);
        Ok(Self {
            segments,
            symbols,
            functions,
        })
    }

    /// Creates an image with these words at the start of the flash, and a symbol.
    #[cfg(test)]
    pub(crate) fn of_words(words: &[u32], name: &str, value: u32) -> Self {
        let bytes = words.iter().flat_map(|word| word.to_le_bytes()).collect();
        Self {
            segments: vec![(0x0800_0000, bytes)],
            symbols: vec![(name.to_owned(), value)],
            functions: Vec::new(),
        }
    }

    /// Finds a function's address by a part of its mangled name.
    pub fn function(&self, part: &str) -> Option<u32> {
        self.symbols
            .iter()
            .find(|(name, _)| name.contains(part))
            .map(|(_, value)| value & !1)
    }

    /// Finds a symbol whose name begins with `start`, and returns the rest of the name.
    pub fn name_after(&self, start: &str) -> Option<&str> {
        self.symbols
            .iter()
            .find_map(|(name, _)| name.strip_prefix(start))
    }

    /// Finds the value of a symbol.
    pub fn symbol(&self, name: &str) -> Option<u32> {
        self.symbols
            .iter()
            .find(|(other, _)| other == name)
            .map(|(_, value)| *value)
    }
}
