//! A stretch of frames as the fit goes over it, a block at a time.
//!
//! The abscissa is `u`, -1 at the stretch's start and 1 at its end: the frame's place in time, or, where
//! the speed varies, the finger's place on the surface. A frequency is `nu`, cycles per unit of `u`, that
//! is half the cycles in the stretch. Frames that do not count are left out of every sum.

use crate::source::{FrameSource, Values};

/// Frames read at a time: the time the ring is locked, and the stretch over which the harmonics are taken
/// from one table.
pub const BLOCK: usize = 16;

/// Frames from one place to the next that count for the length of a path.
const STRIDE: u32 = 8;

/// Frames and how to read them.
pub struct FrameSpan<'a> {
    source: &'a mut dyn FrameSource,
    first: u32,
    /// Frames in it.
    pub frames: u32,
    /// Taxels that a frame must have valid values of to count; found by [`crate::levels::levels`].
    pub taxels: u16,
    /// An interferer's cycles per frame.
    pub interferer: Option<f32>,
    abscissa: Abscissa<'a>,
}

/// `u` of the frames of a stretch.
#[derive(Clone, Copy)]
pub(crate) enum Abscissa<'a> {
    /// In time: that of frame 0, and from one frame to the next.
    Time { start: f32, step: f32 },
    /// By place; `travel` is the way there and back, in `u`.
    Place { of: &'a dyn Fn(u32) -> f32, centre: f32, half: f32, travel: f32 },
}

impl Abscissa<'_> {
    fn time(frames: u32) -> Self {
        let step = 2.0 / frames.max(1) as f32;
        Self::Time { start: -0.5 * (frames as f32 - 1.0) * step, step }
    }

    /// From one frame to the next, in time.
    pub fn step(&self) -> Option<f32> {
        match self {
            Self::Time { step, .. } => Some(*step),
            Self::Place { .. } => None,
        }
    }

    /// `u` of a frame.
    pub fn u(&self, frame: u32) -> f32 {
        match self {
            Self::Time { start, step } => start + step * frame as f32,
            Self::Place { of, centre, half, .. } => (of(frame) - centre) / half,
        }
    }

    /// `u` of the frames of a block that begins with frame `at`; behind the last of so many `frames` it means
    /// nothing.
    pub fn block(&self, at: u32, frames: u32) -> [f32; BLOCK] {
        let mut u = [0.0; BLOCK];
        match self {
            Self::Time { start, step } => {
                for (i, u) in u.iter_mut().enumerate() {
                    *u = start + step * (at + i as u32) as f32;
                }
            }
            Self::Place { .. } => {
                for (u, frame) in u.iter_mut().zip(at..frames) {
                    *u = self.u(frame);
                }
            }
        }
        u
    }
}

/// Some frames of a stretch, always as many as fit, so that loops over them have a fixed length.
pub(crate) struct Block<'a> {
    /// Number of its first frame in the stretch.
    pub at: u32,
    /// The frames; those that do not count, or are not there, have the values asked for.
    pub values: &'a [Values; BLOCK],
    /// Mask of valid taxels per frame; 0 is a frame that is missing, not there, or does not count.
    pub valid: &'a [u16; BLOCK],
    /// All of them count.
    pub whole: bool,
}

/// Whether a frame with valid values of the taxels in `valid` counts.
fn counts(valid: u16, taxels: u16) -> bool {
    valid & taxels == taxels && valid != 0
}

/// Whether all frames of a block do, and have a valid taxel in common: if not, each is looked at.
#[inline(always)]
fn all_count(valid: &[u16; BLOCK], taxels: u16) -> bool {
    counts(valid.iter().fold(u16::MAX, |common, valid| common & valid), taxels)
}

impl<'a> FrameSpan<'a> {
    /// The `frames` frames of `source` from frame number `first` on.
    pub fn new(source: &'a mut dyn FrameSource, first: u32, frames: u32) -> Self {
        Self { source, first, frames, taxels: 0, interferer: None, abscissa: Abscissa::time(frames) }
    }

    /// The same with a known interferer in all channels, cycles per frame (an aliased one may have more
    /// than half a cycle): mains hum. Its amplitude and phase are unknowns of the fit.
    pub fn with_interferer(self, cycles_per_frame: f32) -> Self {
        Self { interferer: Some(cycles_per_frame), ..self }
    }

    /// The same along a path: `place` gives a frame's place on the surface, by the frame's number in the
    /// stretch, in any unit; frequencies are then cycles per that unit. The path may turn back. None if it
    /// does not move, or a place is not finite.
    pub fn along(self, place: &'a dyn Fn(u32) -> f32) -> Option<Self> {
        let (mut least, mut most) = (f32::INFINITY, f32::NEG_INFINITY);
        let (mut way, mut from) = (0.0, place(0));
        for frame in 0..self.frames {
            let at = place(frame);
            if !at.is_finite() {
                return None;
            }
            (least, most) = (least.min(at), most.max(at));
            // In strides, so that the grains of an encoder do not make the way longer.
            if frame.is_multiple_of(STRIDE) || frame + 1 == self.frames {
                way += (at - from).abs();
                from = at;
            }
        }
        let half = 0.5 * (most - least);
        let abscissa = Abscissa::Place { of: place, centre: least + half, half, travel: way / half };
        (half > 0.0).then_some(Self { abscissa, ..self })
    }

    /// The `frames` frames from its frame `from` on; in time only.
    pub fn part(&mut self, from: u32, frames: u32) -> FrameSpan<'_> {
        let Self { taxels, interferer, .. } = *self;
        let first = self.first.wrapping_add(from);
        FrameSpan { source: &mut *self.source, first, frames, taxels, interferer, abscissa: Abscissa::time(frames) }
    }

    /// Means of every `by` frames of this stretch, in `source`.
    pub fn means<'b>(&self, source: &'b mut dyn FrameSource, count: u32, by: u32) -> FrameSpan<'b> {
        let interferer = self.interferer.map(|cycles| cycles * by as f32);
        FrameSpan { source, first: 0, frames: count, taxels: self.taxels, interferer, abscissa: Abscissa::time(count) }
    }

    /// The abscissa of its frames.
    pub(crate) fn abscissa(&self) -> Abscissa<'a> {
        self.abscissa
    }

    /// Whether `u` is the frame's place in time.
    pub fn is_in_time(&self) -> bool {
        matches!(self.abscissa, Abscissa::Time { .. })
    }

    /// Shows every frame in blocks of [`BLOCK`], those that do not count with the values of `instead`. None if
    /// frames were overwritten meanwhile.
    pub(crate) fn blocks(&mut self, instead: &Values, visit: &mut dyn FnMut(Block)) -> Option<()> {
        for at in (0..self.frames).step_by(BLOCK) {
            let most = (self.frames - at).min(BLOCK as u32) as usize;
            let (mut whole, taxels) = (false, self.taxels);
            self.source
                .read(self.first.wrapping_add(at), most, &mut |values, valid| {
                    if let (Ok(values), Ok(valid)) = (values.try_into(), <&[u16; BLOCK]>::try_from(valid))
                        && all_count(valid, taxels)
                    {
                        whole = true;
                        visit(Block { at, values, valid, whole });
                    }
                })
                .ok()?;
            if !whole {
                self.broken_block(at, most, instead, visit)?;
            }
        }
        Some(())
    }

    /// A block with gaps, at the end of the stretch, or cut by the end of a ring.
    #[inline(never)]
    fn broken_block(&mut self, at: u32, most: usize, instead: &Values, visit: &mut dyn FnMut(Block)) -> Option<()> {
        let mut some = [*instead; BLOCK];
        let (mut mask, mut shown) = ([0; BLOCK], 0);
        let taxels = self.taxels;
        while shown < most {
            let from = shown;
            let first = self.first.wrapping_add(at).wrapping_add(from as u32);
            self.source
                .read(first, most - from, &mut |values, valid| {
                    let count = values.len().min(valid.len()).min(BLOCK - from);
                    shown = from + count.max(1);
                    some[from..from + count].copy_from_slice(&values[..count]);
                    mask[from..from + count].copy_from_slice(&valid[..count]);
                })
                .ok()?;
        }
        for (place, mask) in some.iter_mut().zip(&mut mask).take(most) {
            if !counts(*mask, taxels) {
                (*place, *mask) = (*instead, 0);
            }
        }
        visit(Block { at, values: &some, valid: &mask, whole: false });
        Some(())
    }

    /// Values of the first frame that counts; the inner None says that none does. None if frames were
    /// overwritten meanwhile.
    pub(crate) fn first_counted(&mut self) -> Option<Option<Values>> {
        let (mut found, taxels) = (None, self.taxels);
        for at in 0..self.frames {
            self.source
                .read(self.first.wrapping_add(at), 1, &mut |values, valid| {
                    if let (Some(values), Some(valid)) = (values.first(), valid.first())
                        && counts(*valid, taxels)
                    {
                        found = Some(*values);
                    }
                })
                .ok()?;
            if found.is_some() {
                break;
            }
        }
        Some(found)
    }

    /// Half the stretch: one unit of `u`, in frames or in the unit of its places.
    pub fn half(&self) -> f32 {
        match self.abscissa {
            Abscissa::Time { .. } => 0.5 * self.frames as f32,
            Abscissa::Place { half, .. } => half,
        }
    }

    /// `nu` from which harmonics are too close to half the frame rate to be told from their images; along a
    /// path, at its mean speed.
    #[inline(never)]
    pub fn nu_most(&self) -> f32 {
        let way = match self.abscissa {
            Abscissa::Time { .. } => 2.0,
            // There and back is the path twice, and takes twice the frames.
            Abscissa::Place { travel, .. } => travel.max(2.0),
        };
        0.4999 * self.frames as f32 / way
    }
}
