//! The emulated firmware's defmt log, as lines. What the numbers in it stand for is in the image.

use anyhow::{Context, Result, bail};
use defmt_decoder::{DecodeError, Table};
use std::path::Path;

/// Makes lines of the bytes of a log.
pub struct Log {
    table: Table,
    /// Bytes of a frame that is not complete.
    rest: Vec<u8>,
    tell: fn(&str),
}

impl Log {
    /// Of this image's log; each line goes to `tell`: board time in seconds, level, text.
    ///
    /// # Errors
    /// The image has no log, or one in a version of defmt that is not known here.
    pub fn new(image: &Path, tell: fn(&str)) -> Result<Self> {
        let shown = image.display();
        let bytes = std::fs::read(image).with_context(|| format!("{shown}"))?;
        let Some(table) = Table::parse(&bytes).with_context(|| format!("{shown}: its log"))? else {
            bail!("{shown}: an image without a log");
        };
        Ok(Self { table, rest: Vec::new(), tell })
    }

    /// Takes bytes as they come.
    pub fn push(&mut self, bytes: &[u8]) {
        self.rest.extend_from_slice(bytes);
        // A frame ends with a zero.
        let Some(last) = self.rest.iter().rposition(|byte| *byte == 0) else { return };
        let mut decoder = self.table.new_stream_decoder();
        decoder.received(&self.rest[..=last]);
        loop {
            match decoder.decode() {
                Ok(frame) => (self.tell)(&frame.display(false).to_string()),
                Err(DecodeError::UnexpectedEof) => break,
                Err(DecodeError::Malformed) => (self.tell)("(a damaged frame)"),
            }
        }
        self.rest.drain(..=last);
    }
}
