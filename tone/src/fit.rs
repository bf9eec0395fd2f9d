//! The result of a fit.

use crate::levels::Levels;
use crate::limits::CHANNELS_MAX;

/// How far a fit can be trusted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Status {
    /// A common tone, with its uncertainty.
    Good,
    /// The channels share no tone that is significant against their noise.
    NoTone,
    /// The window holds too little of a cycle, or too few frames, to decide.
    TooShort,
    /// No valid channel or no valid frame.
    Nothing,
    /// Two frequencies an octave (or another harmonic step) apart explain the window about equally well.
    Ambiguous,
}

impl Status {
    /// Whether a fit of this status has a frequency.
    pub const fn has_tone(self) -> bool {
        matches!(self, Self::Good | Self::Ambiguous)
    }
}

/// One channel of a [`Fit`], in the unit of its frames.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ChannelFit {
    /// Level at the window's centre.
    pub offset: f32,
    /// Amplitude of the fundamental.
    pub amplitude: f32,
    /// Phase of the fundamental at the window's centre, radians, -pi to pi: amplitude x cos(theta + phase).
    pub phase_rad: f32,
    /// Variance of that phase, radians squared; not finite in a channel without any tone.
    pub phase_variance: f32,
    /// Standard deviation of the residuals.
    pub residual: f32,
}

/// The result of a fit.
#[derive(Clone, Debug)]
pub struct Fit {
    /// Whether the window has a tone.
    pub status: Status,
    /// Hertz if the span has a frame rate ([`crate::FrameSpan::with_frame_rate`]), else cycles per frame; along a path
    /// cycles per its unit. Zero if there is no tone.
    pub frequency: f32,
    /// Standard deviation of the frequency, in the same unit.
    pub sigma: f32,
    /// Harmonics fitted.
    pub harmonics: u8,
    /// Frames that counted.
    pub frames: u32,
    /// Bit k: channel k was used.
    pub usable: u16,
    /// One for each channel; zeros where it was not used.
    pub channels: [ChannelFit; CHANNELS_MAX],
}

impl Fit {
    /// Of a path that does not move, so that nothing can be fitted along it.
    pub const fn at_rest(frames: u32) -> Self {
        const NONE: ChannelFit =
            ChannelFit { offset: 0.0, amplitude: 0.0, phase_rad: 0.0, phase_variance: 0.0, residual: 0.0 };
        let channels = [NONE; CHANNELS_MAX];
        Self { status: Status::TooShort, frequency: 0.0, sigma: 0.0, harmonics: 0, frames, usable: 0, channels }
    }

    /// Of a window without a tone: offsets and residuals about a straight line.
    pub(crate) fn without_tone(status: Status, levels: &Levels) -> Self {
        let (usable, mut fit) = (levels.usable, Self::at_rest(levels.frames));
        for (c, channel) in fit.channels.iter_mut().enumerate().filter(|(c, _)| usable & 1 << c != 0) {
            channel.offset = levels.offset[c];
            channel.residual = libm::sqrtf(levels.about_line[c] / (levels.frames as f32 - 2.0));
        }
        Self { status, usable, ..fit }
    }
}
