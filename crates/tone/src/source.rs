//! Sources of frames.

use crate::limits::CHANNELS_MAX;

/// Values of one frame, one per channel, in any unit; channels that a source does not have are
/// invalid.
pub type Values = [f32; CHANNELS_MAX];

/// Newer frames have overwritten those of the window before the fit read them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Overwritten;

impl core::fmt::Display for Overwritten {
    fn fmt(&self, f: &mut core::fmt::Formatter) -> core::fmt::Result {
        f.write_str("newer frames have overwritten those of the window")
    }
}

impl core::error::Error for Overwritten {}

/// Source of frames for a fit: memory, or a locked ring that another task writes to.
pub trait FrameSource {
    /// Calls `show` once with at least one and up to `most` consecutive frames, starting at frame
    /// `first`: their values, and for each frame a mask of the channels with a valid value (bit k
    /// is channel k; 0 is a missing frame).
    ///
    /// # Errors
    /// If frame `first` is not available yet, or no longer; `show` is then not called.
    fn read(
        &mut self,
        first: u32,
        max: usize,
        show: &mut dyn FnMut(&[Values], &[u16]),
    ) -> Result<(), Overwritten>;
}

/// Frames in memory, one after the other, numbered from 0. Non-finite values are invalid.
#[derive(Clone, Copy, Debug)]
pub struct Frames<'a> {
    values: &'a [f32],
    channels: usize,
}

impl<'a> Frames<'a> {
    /// Frames of `channels` values each. `None` if `channels` is not 1 to [`CHANNELS_MAX`]; values
    /// after the last whole frame are ignored.
    pub const fn new(values: &'a [f32], channels: usize) -> Option<Self> {
        if channels == 0 || channels > CHANNELS_MAX {
            None
        } else {
            Some(Self { values, channels })
        }
    }

    /// Number of frames.
    pub const fn count(&self) -> u32 {
        // `new` refuses zero channels.
        match self.values.len().checked_div(self.channels) {
            Some(count) => count as u32,
            None => 0,
        }
    }
}

impl FrameSource for Frames<'_> {
    fn read(
        &mut self,
        first: u32,
        max: usize,
        show: &mut dyn FnMut(&[Values], &[u16]),
    ) -> Result<(), Overwritten> {
        // The fit reads at most 16 frames at a time.
        let (mut values, mut valid) = ([[0.0; CHANNELS_MAX]; 16], [0; 16]);
        let mut count = 0;
        let from = self
            .values
            .get(first as usize * self.channels..)
            .unwrap_or_default();
        let places = values.iter_mut().zip(&mut valid);
        for (frame, (values, valid)) in from
            .chunks_exact(self.channels.max(1))
            .take(max)
            .zip(places)
        {
            for (c, (value, place)) in frame
                .iter()
                .zip(values)
                .enumerate()
                .filter(|(_, (value, _))| value.is_finite())
            {
                *place = *value;
                *valid |= 1 << c;
            }
            count += 1;
        }
        if count == 0 {
            return Err(Overwritten);
        }
        show(
            values.get(..count).unwrap_or_default(),
            valid.get(..count).unwrap_or_default(),
        );
        Ok(())
    }
}

/// Frames in memory, numbered from 0, in the form that a [`FrameSource`] passes on.
#[derive(Clone, Copy, Debug)]
pub struct Table<'a> {
    /// The frames' values.
    pub values: &'a [Values],
    /// Mask of valid channels of each frame.
    pub valid: &'a [u16],
}

impl FrameSource for Table<'_> {
    fn read(
        &mut self,
        first: u32,
        max: usize,
        show: &mut dyn FnMut(&[Values], &[u16]),
    ) -> Result<(), Overwritten> {
        let first = first as usize;
        let end = first.saturating_add(max).min(self.values.len());
        match (self.values.get(first..end), self.valid.get(first..end)) {
            (Some(values), Some(valid)) if first < end => show(values, valid),
            _ => return Err(Overwritten),
        }
        Ok(())
    }
}
