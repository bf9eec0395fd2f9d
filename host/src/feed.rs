//! Where packets come from: a board on a port, the emulated board, or a recording. One decoder stands behind all three.
//!
//! A [`Source`] brings bytes; [`Feed`] makes packets of them, counts what is lost, and keeps the bytes if they are recorded.

mod asking;
mod emulated;
mod following;
mod pace;

pub use asking::{Asking, new_orders};
pub use emulated::Emulated;
pub use following::{Following, RawFrames};
pub use pace::Pace;

use crate::live::Counts;
use anyhow::{Context, Result, bail};
use ridgetone_proto::telemetry::{Decoder, PROTOCOL, Packet};
use std::collections::VecDeque;
use std::io::Write;
use std::time::{Duration, Instant};

/// What a source has to say.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Said {
    /// The board is there, under this name.
    Came(String),
    /// It is gone from there, with what the system said. It is waited for.
    Went(String, String),
    /// Bytes of telemetry, as they came.
    Bytes(Vec<u8>),
    /// There will be no more.
    Over,
}

/// Something that brings bytes of telemetry.
pub trait Source {
    /// What it is, for people: a port's name, a file's.
    fn name(&self) -> String;

    /// The next thing it has to say, waiting for it as long as `most`. Behind [`Said::Over`] it is not asked again.
    ///
    /// # Errors
    /// It cannot go on.
    fn next(&mut self, most: Duration) -> Result<Option<Said>>;

    /// Sends bytes to the board.
    ///
    /// # Errors
    /// It is unplugged, or there is no board.
    fn send(&mut self, bytes: &[u8]) -> Result<()>;

    /// Whether there is a board that can be told something.
    fn has_board(&self) -> bool {
        true
    }
}

impl<S: Source + ?Sized> Source for Box<S> {
    fn name(&self) -> String {
        (**self).name()
    }

    fn next(&mut self, most: Duration) -> Result<Option<Said>> {
        (**self).next(most)
    }

    fn send(&mut self, bytes: &[u8]) -> Result<()> {
        (**self).send(bytes)
    }

    fn has_board(&self) -> bool {
        (**self).has_board()
    }
}

/// Something that happened on a line.
#[derive(Clone, Debug, PartialEq)]
#[expect(clippy::large_enum_variant, reason = "nearly all of them are packets")]
pub enum Happening {
    /// The board is there, under this name.
    Came(String),
    /// It is gone from there, with what the system said. It is waited for.
    Went(String, String),
    /// A packet.
    Packet(Packet),
    /// There will be no more.
    Over,
}

/// A source and the decoder behind it.
pub struct Feed<S: Source = Box<dyn Source + Send>> {
    source: S,
    decoder: Decoder,
    received: u64,
    waiting: VecDeque<Happening>,
    is_over: bool,
    pace: Option<Pace>,
    record: Option<Box<dyn Write + Send>>,
    opened: Instant,
}

impl<S: Source> Feed<S> {
    /// Of a source that has said nothing yet.
    pub fn new(source: S) -> Self {
        let (waiting, decoder) = (VecDeque::new(), Decoder::new());
        Self { source, decoder, received: 0, waiting, is_over: false, pace: None, record: None, opened: Instant::now() }
    }

    /// With packets held back until it is their time: for a recording, which has all of them at once.
    #[must_use]
    pub fn paced(self, pace: Pace) -> Self {
        Self { pace: Some(pace), ..self }
    }

    /// With all bytes written down as they come.
    #[must_use]
    pub fn recorded(self, record: Box<dyn Write + Send>) -> Self {
        Self { record: Some(record), ..self }
    }

    /// The next thing that happens, waiting for it as long as `most`. A board that comes back is not asked what it sent
    /// meanwhile: the gap in the numbers tells how many packets are missing.
    ///
    /// # Errors
    /// The board speaks another protocol; the source cannot go on; the record cannot be written.
    pub fn next(&mut self, most: Duration) -> Result<Option<Happening>> {
        let begun = Instant::now();
        loop {
            let left = most.saturating_sub(begun.elapsed());
            if let Some(happening) = self.waiting.pop_front() {
                let wait = match (&mut self.pace, &happening) {
                    (Some(pace), Happening::Packet(packet)) => pace.wait(packet, Instant::now()),
                    _ => Duration::ZERO,
                };
                if wait <= left {
                    std::thread::sleep(wait);
                    return Ok(Some(happening));
                }
                self.waiting.push_front(happening);
                std::thread::sleep(left);
                return Ok(None);
            }
            if self.is_over {
                std::thread::sleep(left);
                return Ok(None);
            }
            if let Some(said) = self.source.next(left)? {
                self.hear(said)?;
            } else if left.is_zero() {
                return Ok(None);
            }
        }
    }

    fn hear(&mut self, said: Said) -> Result<()> {
        match said {
            Said::Came(name) => self.waiting.push_back(Happening::Came(name)),
            Said::Bytes(bytes) => self.decode(&bytes)?,
            Said::Went(name, why) => {
                // What was cut off ends here, or it would swallow the first frame when the board comes back.
                self.decode(&[0])?;
                self.waiting.push_back(Happening::Went(name, why));
            }
            Said::Over => {
                self.is_over = true;
                self.waiting.push_back(Happening::Over);
            }
        }
        if let Some(protocol) = self.decoder.foreign {
            bail!(
                "{}: the board speaks protocol {protocol}, this command {PROTOCOL}: build both from one version",
                self.name()
            );
        }
        Ok(())
    }

    fn decode(&mut self, bytes: &[u8]) -> Result<()> {
        if let Some(record) = &mut self.record {
            record.write_all(bytes).and_then(|()| record.flush()).context("the recording")?;
        }
        let before = self.waiting.len();
        self.waiting.extend(bytes.iter().filter_map(|byte| self.decoder.push(*byte)).map(Happening::Packet));
        self.received += (self.waiting.len() - before) as u64;
        Ok(())
    }

    /// Sends bytes to the board.
    ///
    /// # Errors
    /// It is unplugged, or there is no board.
    pub fn send(&mut self, bytes: &[u8]) -> Result<()> {
        self.source.send(bytes)
    }

    /// Whether there is a board that can be told something.
    pub fn has_board(&self) -> bool {
        self.source.has_board()
    }

    /// What the bytes come from.
    pub fn source(&self) -> &S {
        &self.source
    }

    /// What the packets come from, for people.
    pub fn name(&self) -> String {
        self.source.name()
    }

    /// What was received so far, and what was not.
    pub fn counts(&self) -> Counts {
        Counts::of(&self.decoder, self.received)
    }
}

#[cfg(test)]
mod tests;
