//! The sliding phase in a fixed buffer: windows of w seconds, hop by hop (stub).

use crate::settings::{RING_FRAMES, TAXELS};
use crate::telemetry::Span;

/// The latest frames, as volts-to-be: codes less each taxel's reference code, exact in f32.
#[derive(Debug)]
pub struct Ring {
    /// Values, frame by frame.
    pub values: [[f32; TAXELS]; RING_FRAMES],
}

impl Ring {
    /// An empty ring; `const`, so that it can live in a static.
    pub const fn new() -> Self {
        Self { values: [[0.0; TAXELS]; RING_FRAMES] }
    }
}

impl Default for Ring {
    fn default() -> Self {
        Self::new()
    }
}

/// A stretch of the ring to fit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Window {
    /// Number of its first frame.
    pub first: u32,
    /// Frames in it.
    pub frames: u16,
    /// What it covers.
    pub span: Span,
}

/// Where the fit reads frames from: the ring itself on a PC, the ring behind a lock on the chip.
pub trait FrameSource {
    /// Runs `read` on the ring for a short while.
    fn with<R>(&mut self, read: impl FnOnce(&Ring) -> R) -> R;
}

impl FrameSource for &Ring {
    fn with<R>(&mut self, read: impl FnOnce(&Ring) -> R) -> R {
        read(self)
    }
}
