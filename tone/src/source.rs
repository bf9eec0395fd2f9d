//! Where frames come from.

/// Most channels of a frame.
pub const CHANNELS_MAX: usize = 16;

/// One frame's values, in any unit, one for each channel.
pub type Values = [f32; CHANNELS_MAX];

/// Where the fit reads frames from: a table on a PC, or a ring behind a lock on a chip.
pub trait FrameSource {
    /// Shows `show` up to `most` consecutive frames from frame number `first` on, once: their values, and
    /// per frame a mask of the channels that hold a valid value (bit k is channel k; 0 is a missing
    /// frame). At least one frame is shown. None, and nothing shown, if `first` is not, or no longer, there.
    fn read(&mut self, first: u32, most: usize, show: &mut dyn FnMut(&[Values], &[u16])) -> Option<()>;
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
    fn read(&mut self, first: u32, most: usize, show: &mut dyn FnMut(&[Values], &[u16])) -> Option<()> {
        let at = first as usize;
        let end = at.saturating_add(most).min(self.values.len());
        if at >= end {
            return None;
        }
        show(self.values.get(at..end)?, self.valid.get(at..end)?);
        Some(())
    }
}
