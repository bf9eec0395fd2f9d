//! Frames of a window, and prior knowledge.

use crate::domain::Domain;
use crate::limits::CHANNELS_MAX;
use crate::source::{FrameSource, Overwritten, Values};
use core::ops::Range;

/// Maximum number of frames per read, which limits how long a source is locked.
pub const READ_FRAMES: usize = 16;

/// Consecutive frames of a source, and prior knowledge.
pub struct FrameSpan<'a> {
    source: &'a mut dyn FrameSource,
    first: u32,
    pub(crate) frames: u32,
    /// Frequency of a known interferer, cycles per frame.
    pub(crate) interferer: Option<f32>,
    /// Quantization step in the unit of the frames; 0 if none.
    pub(crate) quantization_step: f32,
    /// Expected frequency, in the unit of the result.
    pub(crate) expected: Option<f32>,
    /// Frames per unit of time.
    rate: f32,
    domain: Domain<'a>,
}

impl<'a> FrameSpan<'a> {
    /// Creates a span of `frames` frames of `source`, starting at frame `first`.
    pub fn new(source: &'a mut dyn FrameSource, first: u32, frames: u32) -> Self {
        Self {
            source,
            first,
            frames,
            interferer: None,
            quantization_step: 0.0,
            expected: None,
            rate: 1.0,
            domain: Domain::time(frames),
        }
    }

    /// Sets the rate in frames per second: results are then in hertz, otherwise in cycles per
    /// frame.
    pub fn with_frame_rate(self, frames_per_s: f32) -> Self {
        Self {
            rate: frames_per_s,
            ..self
        }
    }

    /// Declares a known interferer in all channels, such as mains hum, in cycles per frame (above
    /// one half if aliased). Its frequency is refined; amplitude and phase are fitted in each
    /// channel.
    pub fn with_interferer(self, cycles_per_frame: f32) -> Self {
        Self {
            interferer: Some(cycles_per_frame),
            ..self
        }
    }

    /// Declares that values are rounded to multiples of `step`. Residuals are then assumed to be no
    /// smaller than the rounding.
    pub fn with_quantization(self, step: f32) -> Self {
        Self {
            quantization_step: step,
            ..self
        }
    }

    /// Expects a tone near a frequency, usually that of the previous window, in the unit of the
    /// result. If a good tone is found there, no other frequency is searched, which halves the
    /// instructions.
    pub fn expecting(self, frequency: f32) -> Self {
        Self {
            expected: Some(frequency),
            ..self
        }
    }

    /// Fits along a path: `position` returns the position of a frame by its number in the span, in
    /// any unit; frequencies are then in cycles per that unit. `None` if the position never changes
    /// or is not finite.
    pub fn along(self, position: &'a dyn Fn(u32) -> f32) -> Option<Self> {
        Some(Self {
            domain: Domain::positions(position, self.frames)?,
            ..self
        })
    }

    pub(crate) fn domain(&self) -> &Domain<'a> {
        &self.domain
    }

    /// Number of frames in the window; along a path, the number per pass over its range at the mean
    /// speed.
    pub(crate) fn effective_frames(&self) -> f32 {
        match self.domain {
            Domain::Time { .. } => self.frames as f32,
            Domain::Position { travel, .. } => self.frames as f32 / travel,
        }
    }

    /// Converts cycles per window to the unit of the result.
    pub(crate) fn frequency(&self, cycles: f32) -> f32 {
        match self.domain {
            Domain::Time { .. } => cycles / self.frames as f32 * self.rate,
            Domain::Position { half, .. } => 0.5 * cycles / half,
        }
    }

    /// `u` per unit of time or of the path.
    pub(crate) fn per_u(&self) -> f32 {
        match self.domain {
            Domain::Time { .. } => 2.0 / self.frames as f32 * self.rate,
            Domain::Position { half, .. } => 1.0 / half,
        }
    }

    /// Visits the frames whose `channels` are all valid, with their number in the span and their
    /// values.
    pub(crate) fn visit(
        &mut self,
        channels: u16,
        visit: &mut dyn FnMut(u32, &Values),
    ) -> Result<(), Overwritten> {
        self.visit_runs(0..self.frames, channels, &mut |first, run| {
            for (number, values) in (first..).zip(run) {
                visit(number, values);
            }
        })
    }

    /// Visits runs of consecutive frames of `part` whose `channels` are all valid, with the number
    /// of the first frame and the values.
    pub(crate) fn visit_runs(
        &mut self,
        part: Range<u32>,
        channels: u16,
        visit: &mut dyn FnMut(u32, &[Values]),
    ) -> Result<(), Overwritten> {
        let is_valid = |mask: &u16| *mask & channels == channels && *mask != 0;
        let mut frame = part.start;
        let end = part.end.min(self.frames);
        while frame < end {
            let max = READ_FRAMES.min((end - frame) as usize);
            let mut read = 0;
            let from = self.first.wrapping_add(frame);
            self.source.read(from, max, &mut |values, valid| {
                let count = max.min(values.len()).min(valid.len());
                let mut at = 0;
                while at < count {
                    let left = valid.get(at..count).unwrap_or_default();
                    let mut run = 0;
                    while left.get(run).is_some_and(is_valid) {
                        run += 1;
                    }
                    if let Some(values) = values.get(at..at + run)
                        && run > 0
                    {
                        visit(frame + at as u32, values);
                    }
                    // The frame after a run is not valid.
                    at += run + 1;
                }
                read = count as u32;
            })?;
            frame += read.max(1);
        }
        Ok(())
    }

    /// Mask of the channels that are valid in at least nine tenths as many frames as the best one.
    /// Frames that lack one of these channels are not used.
    pub(crate) fn channels(&mut self) -> Result<u16, Overwritten> {
        let mut counts = [0u32; CHANNELS_MAX];
        // Consecutive frames mostly have the same channels, so count them in runs.
        let (mut mask, mut run) = (0, 0);
        let mut add = |mask: u16, run: u32| {
            for (c, count) in counts.iter_mut().enumerate() {
                *count += run * u32::from(mask >> c & 1);
            }
        };
        let mut frame = 0;
        while frame < self.frames {
            let max = READ_FRAMES.min((self.frames - frame) as usize);
            let mut read = 0;
            self.source
                .read(self.first.wrapping_add(frame), max, &mut |_, valid| {
                    let valid = valid.get(..max).unwrap_or(valid);
                    if valid.iter().all(|valid| *valid == mask) {
                        run += valid.len() as u32;
                        read += valid.len() as u32;
                        return;
                    }
                    for valid in valid {
                        if *valid != mask {
                            add(mask, run);
                            (mask, run) = (*valid, 0);
                        }
                        run += 1;
                        read += 1;
                    }
                })?;
            frame += read.max(1);
        }
        add(mask, run);
        let max = counts.iter().copied().max().unwrap_or(0);
        let is_used = |c: &usize| counts[*c] > 0 && 10 * counts[*c] >= 9 * max;
        Ok((0..CHANNELS_MAX)
            .filter(is_used)
            .fold(0, |mask, c| mask | 1 << c))
    }
}
