//! The frames of a window as the fit visits them, a block at a time. Frames without a valid value
//! in every channel that is used are left out of every sum.

use crate::abscissa::Abscissa;
pub use crate::abscissa::BLOCK;
use crate::cleaned::{Cleaned, Impulses};
use crate::source::{FrameSource, Overwritten, Values};

/// The image of a harmonic above half the frame rate is a line of its own where it is this far, in
/// cycles a window, from others, from the baseline, and from half the frame rate.
const ROOM_CYCLES: f32 = 0.25;
const ROOM_BASELINE: f32 = 1.5;
const ROOM_NYQUIST: f32 = 0.1;

/// Consecutive frames of a source, and what is known of them beforehand.
pub struct FrameSpan<'a> {
    source: &'a mut dyn FrameSource,
    first: u32,
    pub(crate) frames: u32,
    /// Channels of which a frame must have valid values to count; the first pass finds them.
    pub(crate) channels: u16,
    /// An interferer's cycles per frame.
    pub(crate) interferer: Option<f32>,
    /// Step of quantization in the frames' unit; 0: none.
    pub(crate) quantization_step: f32,
    /// Frames per unit of time.
    rate: f32,
    abscissa: Abscissa<'a>,
    /// How many frames after its frame's place each channel is read.
    pub(crate) later: Option<&'a Values>,
}

/// Some frames of a span, always as many, so that loops over them have a fixed length.
pub(crate) struct Block<'a> {
    /// Number of its first frame in the span.
    pub first: u32,
    /// The frames; those that do not count, or are not there, have the substitute's values.
    pub values: &'a [Values; BLOCK],
    /// Mask of valid channels of each frame; 0 is a frame that is missing, not there, or does not
    /// count.
    pub valid: &'a [u16; BLOCK],
    /// All of them count.
    pub complete: bool,
}

/// Whether a frame with valid values of the channels in `valid` counts.
fn counts(valid: u16, channels: u16) -> bool {
    valid & channels == channels && valid != 0
}

/// Whether all frames of a block count, and have a valid channel in common; if not, each frame is
/// examined.
#[inline(always)]
fn all_count(valid: &[u16; BLOCK], channels: u16) -> bool {
    counts(
        valid.iter().fold(u16::MAX, |common, valid| common & valid),
        channels,
    )
}

impl<'a> FrameSpan<'a> {
    /// The `frames` frames of `source` from frame number `first` on.
    pub fn new(source: &'a mut dyn FrameSource, first: u32, frames: u32) -> Self {
        let abscissa = Abscissa::time(frames);
        Self {
            source,
            first,
            frames,
            channels: 0,
            interferer: None,
            quantization_step: 0.0,
            rate: 1.0,
            abscissa,
            later: None,
        }
    }

    /// The same at a rate in frames per second: the fit then gives hertz, without it cycles per
    /// frame.
    pub fn with_frame_rate(self, frames_per_s: f32) -> Self {
        Self {
            rate: frames_per_s,
            ..self
        }
    }

    /// The same with a known interferer in all channels, cycles per frame (an aliased one may have
    /// more than half a cycle): mains hum. Its amplitude and phase are unknowns of the fit.
    pub fn with_interferer(self, cycles_per_frame: f32) -> Self {
        Self {
            interferer: Some(cycles_per_frame),
            ..self
        }
    }

    /// The same where values are rounded to multiples of `step`: no residual is taken to be smaller
    /// than that rounding.
    pub fn with_quantization(self, step: f32) -> Self {
        Self {
            quantization_step: step,
            ..self
        }
    }

    /// The same along a path: `place` gives a frame's place, by the frame's number in the span, in
    /// any unit; frequencies are then cycles per that unit. The path may turn back. None if it does
    /// not move, or a place is not finite.
    pub fn along(self, place: &'a dyn Fn(u32) -> f32) -> Option<Self> {
        Some(Self {
            abscissa: Abscissa::path(place, self.frames)?,
            ..self
        })
    }

    /// The same where channels are read one after the other: each a part of a frame, at most one,
    /// after the frame's place; negative is before it. Along a path that goes one way a channel's
    /// own place then counts, wherever the speed is not the mean one. In time, and at the mean
    /// speed, being late is a phase, and stays in it. Noise that the channels share then widens the
    /// uncertainty, but is not taken out: what lateness leaves looks like it.
    pub fn with_lateness(self, frames: &'a Values) -> Self {
        Self {
            later: Some(frames),
            ..self
        }
    }

    /// Fits it with its impulses replaced.
    pub(crate) fn cleaned<T>(
        &mut self,
        impulses: &Impulses,
        fit: impl FnOnce(&mut FrameSpan) -> T,
    ) -> T {
        let Self {
            first,
            frames,
            channels,
            interferer,
            quantization_step,
            rate,
            abscissa,
            later,
            ..
        } = *self;
        let source = &mut Cleaned {
            source: self.source,
            first,
            impulses,
        };
        fit(&mut FrameSpan {
            source,
            first,
            frames,
            channels,
            interferer,
            quantization_step,
            rate,
            abscissa,
            later,
        })
    }

    pub(crate) fn abscissa(&self) -> Abscissa<'a> {
        self.abscissa
    }

    /// Whether `u` is the frame's place in time.
    pub(crate) fn is_in_time(&self) -> bool {
        matches!(self.abscissa, Abscissa::Time { .. })
    }

    /// Whether it is along a path and its channels are read one after the other.
    pub(crate) fn is_staggered(&self) -> bool {
        self.later.is_some() && !self.is_in_time()
    }

    /// Visits every frame in blocks of [`BLOCK`]; those that do not count have the values of
    /// `substitute`.
    pub(crate) fn blocks(
        &mut self,
        substitute: &Values,
        visit: &mut dyn FnMut(Block),
    ) -> Result<(), Overwritten> {
        for first in (0..self.frames).step_by(BLOCK) {
            let most = (self.frames - first).min(BLOCK as u32) as usize;
            let (mut complete, channels) = (false, self.channels);
            self.source.read(
                self.first.wrapping_add(first),
                most,
                &mut |values, valid| {
                    if let (Ok(values), Ok(valid)) =
                        (values.try_into(), <&[u16; BLOCK]>::try_from(valid))
                        && all_count(valid, channels)
                    {
                        complete = true;
                        visit(Block {
                            first,
                            values,
                            valid,
                            complete,
                        });
                    }
                },
            )?;
            if !complete {
                self.incomplete_block(first, most, substitute, visit)?;
            }
        }
        Ok(())
    }

    /// A block with gaps, at the end of the span, or cut by the end of a ring.
    #[inline(never)]
    fn incomplete_block(
        &mut self,
        first: u32,
        most: usize,
        substitute: &Values,
        visit: &mut dyn FnMut(Block),
    ) -> Result<(), Overwritten> {
        let mut copies = [*substitute; BLOCK];
        let (mut masks, mut copied) = ([0; BLOCK], 0);
        while copied < most {
            let from = copied;
            let number = self.first.wrapping_add(first).wrapping_add(from as u32);
            self.source
                .read(number, most - from, &mut |values, valid| {
                    let count = values.len().min(valid.len()).min(BLOCK - from);
                    copied = from + count.max(1);
                    copies[from..from + count].copy_from_slice(&values[..count]);
                    masks[from..from + count].copy_from_slice(&valid[..count]);
                })?;
        }
        for (copy, mask) in copies.iter_mut().zip(&mut masks).take(most) {
            if !counts(*mask, self.channels) {
                (*copy, *mask) = (*substitute, 0);
            }
        }
        visit(Block {
            first,
            values: &copies,
            valid: &masks,
            complete: false,
        });
        Ok(())
    }

    /// Values of the first frame that counts; None if none does.
    pub(crate) fn first_counted(&mut self) -> Result<Option<Values>, Overwritten> {
        let (mut found, channels) = (None, self.channels);
        for frame in 0..self.frames {
            self.source
                .read(self.first.wrapping_add(frame), 1, &mut |values, valid| {
                    if let (Some(values), Some(valid)) = (values.first(), valid.first())
                        && counts(*valid, channels)
                    {
                        found = Some(*values);
                    }
                })?;
            if found.is_some() {
                break;
            }
        }
        Ok(found)
    }

    /// A frequency of `nu`, or its standard deviation, in the unit that the fit gives: hertz, or
    /// cycles per frame or per unit of the path.
    pub(crate) fn frequency(&self, nu: f32) -> f32 {
        match self.abscissa {
            Abscissa::Time { .. } => nu / (0.5 * self.frames as f32) * self.rate,
            Abscissa::Path { half, .. } => nu / half,
        }
    }

    /// `nu` of half the frame rate, nearly: harmonics above it cannot be distinguished from their
    /// images. Along a path, at its mean speed.
    #[inline(never)]
    pub(crate) fn nu_max(&self) -> f32 {
        let travel = match self.abscissa {
            Abscissa::Time { .. } => 2.0,
            // A path that turns back is longer than its range, and takes more frames.
            Abscissa::Path { travel, .. } => travel.max(2.0),
        };
        0.4999 * self.frames as f32 / travel
    }

    /// As many of `harmonics` as stay clear of half the frame rate. On request also those above it,
    /// which are seen at their images, as far as these are apart from all that is below them.
    // Called from many places: one copy is enough.
    #[inline(never)]
    pub(crate) fn harmonics_apart(&self, nu: f32, harmonics: usize, images: bool) -> usize {
        let mut apart = 1;
        while apart < harmonics
            && ((apart + 1) as f32 * nu < 0.96 * self.nu_max()
                || images && self.is_apart(nu, apart + 1))
        {
            apart += 1;
        }
        apart
    }

    /// Whether the image of a harmonic is apart from the baseline, from half the frame rate, and
    /// from the images of those below.
    fn is_apart(&self, nu: f32, harmonic: usize) -> bool {
        let rate = 0.5 * self.frames as f32;
        let image = |h: usize| {
            let nu = h as f32 * nu;
            (nu - rate * (nu / rate + 0.5) as u32 as f32).abs()
        };
        let own = image(harmonic);
        self.is_in_time()
            && 2.0 * own > ROOM_BASELINE
            && rate - 2.0 * own > ROOM_NYQUIST
            && (1..harmonic).all(|h| 2.0 * (own - image(h)).abs() > ROOM_CYCLES)
    }
}
