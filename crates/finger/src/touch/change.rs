//! What the contact detector reports.

use crate::touch::averages::Grid;
use crate::touch::held::HeldLevel;
use ridgetone_tone::Values;

/// A change of the touch's phase.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Change<'a> {
    /// The contact spike.
    Contact {
        /// Frame of its peak.
        frame: u32,
        /// Frame from which on the load rises, not after the peak.
        onset: u32,
        /// Taxel with the greatest deviation.
        taxel: u8,
        /// That deviation from the idle level, codes.
        height: f32,
    },
    /// A hold is over that was long enough for an image.
    HoldEnd {
        /// The level that was held.
        held: &'a HeldLevel,
        /// First frame of its mean, and the one behind its last.
        span: (u32, u32),
        /// Frames in it.
        frames: u32,
        /// Level before the touch, codes.
        idle: &'a Values,
        /// Frames that this level is the mean of, by its variance.
        idle_frames: f32,
        /// One over the variance of each taxel's frames.
        weights: &'a Values,
    },
    /// Something moves along the surface since this frame or a little longer.
    Moving(u32),
    /// A slide began at this frame.
    SlideStart(u32),
    /// The slide has ended: first frame and the one behind its last.
    SlideEnd(u32, u32),
    /// The finger is in the air since this frame.
    Release(u32),
}

impl Change<'_> {
    /// The change with numbers of the scan's frames, where touch detection counts means of them.
    pub fn in_frames(self, grid: &Grid) -> Self {
        let frame = |mean| grid.first_frame(mean);
        match self {
            Self::Contact {
                frame: peak,
                onset,
                taxel,
                height,
            } => Self::Contact {
                frame: frame(peak),
                onset: frame(onset),
                taxel,
                height,
            },
            Self::HoldEnd {
                held,
                span: (from, until),
                frames,
                idle,
                idle_frames,
                weights,
            } => {
                let span = (frame(from), frame(until));
                Self::HoldEnd {
                    held,
                    span,
                    frames: frames * grid.frames,
                    idle,
                    idle_frames,
                    weights,
                }
            }
            Self::Moving(since) => Self::Moving(frame(since)),
            Self::SlideStart(start) => Self::SlideStart(frame(start)),
            Self::SlideEnd(start, end) => Self::SlideEnd(frame(start), frame(end)),
            Self::Release(released) => Self::Release(frame(released)),
        }
    }
}
