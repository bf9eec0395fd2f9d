//! A source of telemetry bytes.

use crate::utc::Receipt;
use anyhow::{Result, bail};
use std::time::Duration;

/// Event of a source, with bytes as data, or of a feed, with packets as data.
#[derive(Clone, Debug, PartialEq)]
pub enum FeedEvent<T> {
    /// The board is connected, under this name.
    Connected(String),
    /// The board is disconnected: its name, and the system's message. The source waits for it.
    Disconnected(String, String),
    Data(T),
    /// No more data will come.
    Over,
}

pub trait Source {
    /// Returns the name of the port or of the file, for people.
    fn name(&self) -> String;

    /// Waits for the next event, at most for `most`. Not called after [`FeedEvent::Over`].
    fn next(&mut self, max: Duration) -> Result<Option<FeedEvent<Vec<u8>>>>;

    /// Returns when the latest data were received; `None` for a recording without times of receipt.
    fn receipt(&self) -> Option<Receipt> {
        Some(Receipt::now(self.byte_s()))
    }

    /// Returns the time that a byte takes on the line, in seconds; 0 without a serial line.
    fn byte_s(&self) -> f64 {
        0.0
    }

    fn send(&mut self, bytes: &[u8]) -> Result<()>;

    /// Pauses the source while nobody watches, or resumes it: an emulated board waits, a real one
    /// goes on. Returns true if it was paused until now; its clock then stood still.
    fn idle(&mut self, _idle: bool) -> bool {
        false
    }

    /// True if a board can receive bytes.
    fn has_board(&self) -> bool {
        true
    }
}

/// Source without a board, for a page that only shows the file of this name.
pub struct NoBoard(pub String);

impl Source for NoBoard {
    fn name(&self) -> String {
        self.0.clone()
    }

    fn next(&mut self, _max: Duration) -> Result<Option<FeedEvent<Vec<u8>>>> {
        Ok(Some(FeedEvent::Over))
    }

    fn send(&mut self, _bytes: &[u8]) -> Result<()> {
        bail!("there is no board")
    }

    fn has_board(&self) -> bool {
        false
    }
}
