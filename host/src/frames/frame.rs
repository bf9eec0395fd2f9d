//! A frame of a recording, and how the rows of a table become frames.

use ridgetone_finger::PlainFrame;
use ridgetone_proto::telemetry::Raw;

/// Options for reading the rows of a table.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reading {
    /// Rows per second, overriding their stamps; `None` to use the stamps.
    pub rate_hz: Option<f64>,
    pub volts_per_unit: f64,
}

impl Default for Reading {
    fn default() -> Self {
        Self {
            rate_hz: None,
            volts_per_unit: 1.0,
        }
    }
}

pub enum Frame<'a> {
    Raw(Raw),
    Plain(PlainFrame<'a>),
    /// The board restarted here; a new run follows.
    Restart,
}
