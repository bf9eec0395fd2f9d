//! Short text files: settings, scenes, textures.

use crate::file_error::FileError;
use std::fs::File;
use std::io::Read;
use std::path::Path;

/// Longest file accepted, bytes. Files written by hand have some thousands.
const MAX: usize = 1 << 20;

/// Reads a whole short file. Refuses a file longer than `MAX`, such as a device that never ends.
pub fn short_text(path: impl AsRef<Path>) -> Result<String, FileError> {
    let file = path.as_ref().display().to_string();
    let mut bytes = Vec::new();
    File::open(&path)
        .and_then(|file| file.take(MAX as u64 + 1).read_to_end(&mut bytes))
        .map_err(|error| FileError::new(&file, None, error))?;
    if bytes.len() > MAX {
        let why = "longer than 1 MiB, which settings, scenes and textures never are";
        return Err(FileError::new(&file, None, why));
    }
    String::from_utf8(bytes).map_err(|error| {
        let before = &error.as_bytes()[..error.utf8_error().valid_up_to()];
        let line = before.iter().filter(|byte| **byte == b'\n').count() as u64 + 1;
        FileError::new(&file, Some(line), "not text in UTF-8")
    })
}
