//! The result of a fit.

use crate::limits::{CHANNELS_MAX, OVERTONES};

/// Status of a fit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Status {
    /// A tone that the channels share; 1.96 sigma hold its mean frequency over the window, movement
    /// included, in 95 of 100 windows.
    Good,
    /// The channels share no tone that is significant against their noise.
    NoTone,
    /// The window holds too few frames to decide.
    TooShort,
    /// No valid channel or no valid frame.
    Nothing,
    /// Another reading explains the window about as well; [`Fit::other_tone`] names it.
    Ambiguous,
    /// A tone, but no interval can be promised: its phase is not followed, its amplitude comes or
    /// goes, or a channel stays at an end of its range for a quarter of the window.
    Unsteady,
}

impl Status {
    /// True if a fit of this status has a frequency.
    pub const fn has_tone(self) -> bool {
        matches!(self, Self::Good | Self::Ambiguous | Self::Unsteady)
    }
}

/// One channel of a [`Fit`], in the unit of its frames.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ChannelFit {
    /// Level at the window's centre.
    pub offset: f32,
    /// Amplitude of the fundamental.
    pub amplitude: f32,
    /// Phase of the fundamental at the window's centre, radians, -pi to pi: amplitude x cos(theta +
    /// phase).
    pub phase_rad: f32,
    /// Variance of that phase, radians squared; not finite in a channel without any tone.
    pub phase_variance: f32,
    /// Standard deviation of the residuals.
    pub residual: f32,
}

/// Frequency modulation within the window; zeros without a tone.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Movement {
    /// How much the frequency differs from its mean, RMS over the window, as a share
    /// of it (0.02 is 2 %).
    pub wander: f32,
    /// Standard deviation of `wander`.
    pub wander_sigma: f32,
    /// Change of the frequency: hertz per second, without a frame rate cycles per frame per frame;
    /// along a path cycles per its unit, squared.
    pub chirp: f32,
    /// Standard deviation of `chirp`.
    pub chirp_sigma: f32,
}

/// Another reading of the window than the reported one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OtherTone {
    /// In the unit of [`Fit::frequency`].
    pub frequency: f32,
    /// Power over that of the reported tone.
    pub share: f32,
}

/// Figures of the tests, for whoever wants to know why.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Tests {
    /// Logarithm of the odds against the likeliest comb of another frequency.
    pub margin: f32,
    /// Deviate of the strongest line over its neighbourhood.
    pub line: f32,
    /// Deviate of the fundamental over its own neighbourhood.
    pub fundamental: f32,
    /// Deviate of another line.
    pub other: f32,
    /// Deviate of the lines between the comb's.
    pub between: f32,
    /// Normal deviate of the power outside the lines.
    pub beside: f32,
    /// Power outside the lines over the tone's.
    pub beside_share: f32,
    /// Phase that is not followed, radians.
    pub unfollowed: f32,
    /// Change of the amplitude, RMS, as a fraction of it.
    pub fading: f32,
    /// Cycles in the window.
    pub cycles: f32,
    /// True if any bump may look like this: all channels have one shape in time, or there are at
    /// most two of them.
    pub one_shape: bool,
    /// Probability that the phase does not move.
    pub steady: f32,
    /// Degree of the baseline.
    pub degree: u8,
    /// Degrees of the phase that are fitted.
    pub degrees: u8,
    /// Lines that are fitted, bit by bit.
    pub lines: u16,
}

/// The result of a fit.
#[derive(Clone, Debug)]
pub struct Fit {
    /// Whether the window has a tone.
    pub status: Status,
    /// Mean frequency over the window: hertz if the span has a frame rate
    /// ([`crate::FrameSpan::with_frame_rate`]), else cycles per frame; along a path cycles per its
    /// unit. Zero if there is no tone.
    pub frequency: f32,
    /// Standard deviation of the frequency, in the same unit.
    pub sigma: f32,
    /// Frequency modulation.
    pub movement: Movement,
    /// The competing reading, where the status is [`Status::Ambiguous`].
    pub other_tone: Option<OtherTone>,
    /// Frequency of the interferer as fitted, cycles per frame; None if none was given.
    pub interferer: Option<f32>,
    /// The highest harmonic that is there.
    pub harmonics: u8,
    /// The second harmonic and those above it against the fundamental, common to all channels,
    /// whatever their gains and delays: real and imaginary part of a ratio. Zeros of harmonics that
    /// are not there, and without a tone.
    pub overtones: [[f32; 2]; OVERTONES],
    /// Frames that counted.
    pub frames: u32,
    /// Bit k: channel k was used.
    pub usable: u16,
    /// Bit k: the tone is significant in channel k alone.
    pub with_tone: u16,
    /// One for each channel; zeros where it was not used.
    pub channels: [ChannelFit; CHANNELS_MAX],
    /// Results of the tests.
    pub tests: Tests,
}

impl Fit {
    /// A fit without a tone.
    pub fn without_tone(status: Status, frames: u32) -> Self {
        Self {
            status,
            frequency: 0.0,
            sigma: 0.0,
            movement: Movement::default(),
            other_tone: None,
            interferer: None,
            harmonics: 0,
            overtones: [[0.0; 2]; OVERTONES],
            frames,
            usable: 0,
            with_tone: 0,
            channels: [ChannelFit::default(); CHANNELS_MAX],
            tests: Tests::default(),
        }
    }
}
