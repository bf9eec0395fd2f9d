//! Maps the frames of a span to `u`, from -1 to 1, by time or by position along a path.

/// Domain of a span: how `u` follows from a frame's number.
#[derive(Clone, Copy)]
pub enum Domain<'a> {
    /// Time.
    Time {
        /// `u` of frame 0.
        start: f32,
        /// Step of `u` per frame.
        step: f32,
    },
    /// Position along a path.
    Position {
        /// Returns the position of a frame, from its number.
        position: &'a dyn Fn(u32) -> f32,
        /// Middle of the range.
        centre: f32,
        /// Half of the range, plus half a frame.
        half: f32,
        /// Path length, reversals included, relative to the range; at least 1.
        travel: f32,
    },
}

/// Path length is summed over strides of this many frames, so that encoder steps do not lengthen
/// the path.
const STRIDE_FRAMES: u32 = 8;

impl<'a> Domain<'a> {
    /// The domain of `frames` frames in time.
    pub fn time(frames: u32) -> Self {
        let step = 2.0 / frames.max(1) as f32;
        Self::Time {
            start: -0.5 * (frames as f32 - 1.0) * step,
            step,
        }
    }

    /// The domain of `frames` frames along a path. `None` if the position never changes or is not
    /// finite.
    pub fn positions(position: &'a dyn Fn(u32) -> f32, frames: u32) -> Option<Self> {
        let (mut min, mut max) = (f32::INFINITY, f32::NEG_INFINITY);
        let (mut length, mut from) = (0.0, position(0));
        for frame in 0..frames {
            let to = position(frame);
            if !to.is_finite() {
                return None;
            }
            (min, max) = (min.min(to), max.max(to));
            if frame.is_multiple_of(STRIDE_FRAMES) || frame + 1 == frames {
                length += (to - from).abs();
                from = to;
            }
        }
        let range = 0.5 * (max - min);
        let travel = (0.5 * length / range).max(1.0);
        // As in time, the ends lie half a frame beyond the first and last frames.
        let half = range * (1.0 + travel / frames.max(1) as f32);
        (range > 0.0).then_some(Self::Position {
            position,
            centre: min + range,
            half,
            travel,
        })
    }

    /// `u` of a frame.
    pub fn u(&self, frame: u32) -> f32 {
        match self {
            Self::Time { start, step } => start + step * frame as f32,
            Self::Position {
                position,
                centre,
                half,
                ..
            } => (position(frame) - centre) / half,
        }
    }
}
