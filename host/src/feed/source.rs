//! A source of telemetry bytes.

use crate::utc::Receipt;
use anyhow::{Result, bail};
use std::time::Duration;

/// Report of a source, with bytes as data, or of a feed, with packets.
#[derive(Clone, Debug, PartialEq)]
pub enum FeedEvent<T> {
    /// The board is connected, under this name.
    Connected(String),
    /// The board at this name is disconnected, with the system's message. The source waits for it.
    Disconnected(String, String),
    Data(T),
    /// No more data will come.
    Over,
}

pub trait Source {
    /// Name for people: of a port or of a file.
    fn name(&self) -> String;

    /// Waits for the next event, at most for `most`. Nobody calls it after [`FeedEvent::Over`].
    fn next(&mut self, most: Duration) -> Result<Option<FeedEvent<Vec<u8>>>>;

    /// When the latest data were received; `None` of a recording that does not say it.
    fn receipt(&self) -> Option<Receipt> {
        Some(Receipt::now(self.byte_s()))
    }

    /// Time that a byte takes on the line, seconds; 0 without a serial line.
    fn byte_s(&self) -> f64 {
        0.0
    }

    fn send(&mut self, bytes: &[u8]) -> Result<()>;

    /// Pauses the source while nobody watches, or resumes it: an emulated board waits, a real one
    /// goes on. Returns whether it was paused until now, so that its clock stood still.
    fn idle(&mut self, _idle: bool) -> bool {
        false
    }

    /// True if a board can receive bytes.
    fn has_board(&self) -> bool {
        true
    }
}

/// No board: there is only a file of this name to look back at.
pub struct NoBoard(pub String);

impl Source for NoBoard {
    fn name(&self) -> String {
        self.0.clone()
    }

    fn next(&mut self, _most: Duration) -> Result<Option<FeedEvent<Vec<u8>>>> {
        Ok(Some(FeedEvent::Over))
    }

    fn send(&mut self, _bytes: &[u8]) -> Result<()> {
        bail!("there is no board")
    }

    fn has_board(&self) -> bool {
        false
    }
}
