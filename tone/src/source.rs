//! Where frames come from.

/// Most channels of a frame.
pub const CHANNELS_MAX: usize = 16;

/// One frame's values, in any unit, one for each channel.
pub type Values = [f32; CHANNELS_MAX];

/// The window's frames are gone from their source: newer ones took their place while, or before, the fit read them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Overwritten;

impl core::fmt::Display for Overwritten {
    fn fmt(&self, f: &mut core::fmt::Formatter) -> core::fmt::Result {
        f.write_str("newer frames have overwritten those of the window")
    }
}

impl core::error::Error for Overwritten {}

/// Where the fit reads frames from: a table on a PC, or a ring behind a lock on a chip.
pub trait FrameSource {
    /// Calls `show` once with at least one and up to `most` consecutive frames from frame number `first` on: their
    /// values, and for each frame a mask of the channels that hold a valid value (bit k is channel k; 0 is a missing
    /// frame).
    ///
    /// # Errors
    /// If frame `first` is not, or no longer, there; `show` is then not called.
    fn read(&mut self, first: u32, most: usize, show: &mut dyn FnMut(&[Values], &[u16])) -> Result<(), Overwritten>;
}

/// A table of frames in memory, numbered from 0: a recording on a PC.
#[derive(Clone, Copy, Debug)]
pub struct Table<'a> {
    /// The frames' values.
    pub values: &'a [Values],
    /// Mask of valid channels per frame.
    pub valid: &'a [u16],
}

impl FrameSource for Table<'_> {
    fn read(&mut self, first: u32, most: usize, show: &mut dyn FnMut(&[Values], &[u16])) -> Result<(), Overwritten> {
        let at = first as usize;
        let end = at.saturating_add(most).min(self.values.len());
        match (self.values.get(at..end), self.valid.get(at..end)) {
            (Some(values), Some(valid)) if at < end => show(values, valid),
            _ => return Err(Overwritten),
        }
        Ok(())
    }
}
