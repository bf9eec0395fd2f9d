//! The abscissa of a span: `u`, -1 at its start and 1 at its end.
//!
//! It is a frame's place in time, or along a path. A frequency is `nu`, cycles per unit of `u`:
//! half the cycles in the span.

/// Frames that are visited at a time: as long a source is locked, and as many share one table of
/// the harmonics.
pub const BLOCK: usize = 16;

/// Frames from one place to the next whose distance counts for the length of a path.
const STRIDE_FRAMES: u32 = 8;

/// `u` of the frames of a span.
#[derive(Clone, Copy)]
pub enum Abscissa<'a> {
    /// In time: that of frame 0, and from one frame to the next.
    Time { start: f32, step: f32 },
    /// Along a path; `travel` is its length with all turns, and `short` by how much its ends are
    /// nearer than its extremes, both in `u`.
    Path {
        place: &'a dyn Fn(u32) -> f32,
        centre: f32,
        half: f32,
        travel: f32,
        short: f32,
    },
}

impl<'a> Abscissa<'a> {
    /// Of `frames` frames in time.
    pub fn time(frames: u32) -> Self {
        let step = 2.0 / frames.max(1) as f32;
        Self::Time {
            start: -0.5 * (frames as f32 - 1.0) * step,
            step,
        }
    }

    /// Of `frames` frames along a path. None if it does not move, or a place is not finite.
    pub fn path(place: &'a dyn Fn(u32) -> f32, frames: u32) -> Option<Self> {
        let (mut least, mut most) = (f32::INFINITY, f32::NEG_INFINITY);
        let (mut length, mut from) = (0.0, place(0));
        for frame in 0..frames {
            let to = place(frame);
            if !to.is_finite() {
                return None;
            }
            (least, most) = (least.min(to), most.max(to));
            // In strides, so that the steps of an encoder do not make the path longer.
            if frame.is_multiple_of(STRIDE_FRAMES) || frame + 1 == frames {
                length += (to - from).abs();
                from = to;
            }
        }
        let half = 0.5 * (most - least);
        let apart = (place(frames.saturating_sub(1)) - place(0)).abs();
        let [travel, short] = [length, 2.0 * half - apart].map(|way| way / half);
        (half > 0.0).then_some(Self::Path {
            place,
            centre: least + half,
            half,
            travel,
            short,
        })
    }

    /// From one frame to the next, in time.
    pub fn step(&self) -> Option<f32> {
        match self {
            Self::Time { step, .. } => Some(*step),
            Self::Path { .. } => None,
        }
    }

    /// Whether it is a path that turns back, by more than this share of its range in all.
    pub fn turns(&self, share: f32) -> bool {
        matches!(self, Self::Path { travel, .. } if *travel > 2.0 + 2.0 * share)
    }

    /// Whether it is one that turns near an end, by more than this share of its range: a stride may
    /// hide that.
    pub fn turns_at_an_end(&self, share: f32) -> bool {
        matches!(self, Self::Path { short, .. } if *short > 2.0 * share)
    }

    /// `u` of a frame.
    pub fn u(&self, frame: u32) -> f32 {
        match self {
            Self::Time { start, step } => start + step * frame as f32,
            Self::Path {
                place,
                centre,
                half,
                ..
            } => (place(frame) - centre) / half,
        }
    }

    /// `u` of the frames of a block that begins with frame `first`; not of use behind the last of
    /// `frames`.
    pub fn block(&self, first: u32, frames: u32) -> [f32; BLOCK] {
        match self {
            Self::Time { start, step } => {
                core::array::from_fn(|i| start + step * (first + i as u32) as f32)
            }
            Self::Path { .. } => {
                let mut u = [0.0; BLOCK];
                u.iter_mut()
                    .zip(first..frames)
                    .for_each(|(u, frame)| *u = self.u(frame));
                u
            }
        }
    }
}
