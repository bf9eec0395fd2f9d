//! The emulated firmware's defmt log, as lines. The image has the texts, the log their numbers.

use super::image::bytes;
use anyhow::{Context, Result, bail};
use defmt_decoder::{DecodeError, Table};
use std::path::Path;

pub struct Log {
    table: Table,
    /// Bytes of an incomplete frame.
    rest: Vec<u8>,
    print: fn(&str),
}

impl Log {
    /// Decodes the log of this image; each line goes to `print`: board time in seconds, level,
    /// text.
    pub fn new(image: &Path, print: fn(&str)) -> Result<Self> {
        let shown = image.display();
        let bytes = bytes(image)?;
        let Some(table) = Table::parse(&bytes).with_context(|| format!("{shown}: its log"))? else {
            bail!("{shown}: an image without a log");
        };
        Ok(Self {
            table,
            rest: Vec::new(),
            print,
        })
    }

    pub fn push(&mut self, bytes: &[u8]) {
        self.rest.extend_from_slice(bytes);
        // A frame ends with a zero.
        let Some(last) = self.rest.iter().rposition(|byte| *byte == 0) else {
            return;
        };
        let mut decoder = self.table.new_stream_decoder();
        decoder.received(&self.rest[..=last]);
        loop {
            match decoder.decode() {
                Ok(frame) => (self.print)(&frame.display(false).to_string()),
                Err(DecodeError::UnexpectedEof) => break,
                Err(DecodeError::Malformed) => (self.print)("(a damaged frame)"),
            }
        }
        self.rest.drain(..=last);
    }
}
