//! Reports of the contact detector.

use crate::touch::averages::Grid;
use crate::touch::held::HeldLevel;
use ridgetone_tone::Values;

/// A change of the touch's phase.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Change<'a> {
    /// The contact spike.
    Contact {
        /// Frame of the peak.
        frame: u32,
        /// Frame from which on the load rises, not after the peak.
        onset: u32,
        /// Taxel with the greatest deviation.
        taxel: u8,
        /// Deviation of this taxel from the idle level, codes.
        height: f32,
    },
    /// A hold is over that was long enough for a pressure map.
    HoldEnd(HoldMean<'a>),
    /// The finger moves along the surface, since this frame or a little longer.
    Moving(u32),
    /// A slide began at this frame.
    SlideStart(u32),
    /// The slide has ended: first frame, and the one after the last.
    SlideEnd(u32, u32),
    /// The finger is in the air since this frame.
    Release(u32),
}

/// Mean of a hold, and the idle level for comparison.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HoldMean<'a> {
    pub held: &'a HeldLevel,
    /// First frame of the mean, and the one after the last.
    pub span: (u32, u32),
    /// Number of frames in the mean.
    pub frames: u32,
    /// Level before the touch, codes.
    pub idle: &'a Values,
    /// Number of frames whose mean has the variance of the idle level.
    pub idle_frames: f32,
    /// One over the variance of each taxel's frames.
    pub weights: &'a Values,
}

impl Change<'_> {
    /// Converts numbers of averaged frames to those of the scan's frames.
    pub fn in_frames(mut self, grid: &Grid) -> Self {
        let to_frame = |mean: &mut u32| *mean = grid.first_frame(*mean);
        match &mut self {
            Self::HoldEnd(hold) => {
                to_frame(&mut hold.span.0);
                to_frame(&mut hold.span.1);
                hold.frames *= grid.frames;
            }
            Self::Contact {
                frame: from,
                onset: until,
                ..
            }
            | Self::SlideEnd(from, until) => {
                to_frame(from);
                to_frame(until);
            }
            Self::Moving(one) | Self::SlideStart(one) | Self::Release(one) => to_frame(one),
        }
        self
    }
}
