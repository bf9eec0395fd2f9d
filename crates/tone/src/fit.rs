//! The result of a fit.

use crate::limits::{CHANNELS_MAX, OVERTONES};

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
    /// Two frequencies an octave (or another harmonic step) apart explain the window about equally
    /// well; or the window holds too few cycles to tell a tone from a single bump, or another line
    /// about as strong.
    Ambiguous,
    /// A tone, but it moves within the window, or what disturbs it looks like it in all channels;
    /// or along a path that turns back its ways differ by more than noise. The uncertainty is that
    /// of the mean, weighted most in the window's middle.
    Unsteady,
}

impl Status {
    /// Whether a fit of this status has a frequency.
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

/// How the frequency moves within the window. Zeros without a tone.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Movement {
    /// How much the frequency differs from its mean, root mean square over the window, as a share
    /// of it (0.02 is 2 %).
    pub wander: f32,
    /// Standard deviation of `wander`.
    pub wander_sigma: f32,
    /// Standard deviation of [`Fit::frequency`] as an estimate of the frequency's plain mean over
    /// the window; [`Fit::sigma`] is against the mean that is weighted with a parabola, most in the
    /// window's middle.
    pub sigma_of_mean: f32,
    /// Change of the frequency: hertz per second, without a frame rate cycles per frame per frame;
    /// along a path cycles per its unit, squared.
    pub chirp: f32,
    /// Standard deviation of `chirp`.
    pub chirp_sigma: f32,
}

/// Another tone beside the one that is reported.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OtherTone {
    /// In the unit of [`Fit::frequency`].
    pub frequency: f32,
    /// Its power over that of the reported tone.
    pub share: f32,
}

/// The result of a fit.
#[derive(Clone, Debug)]
pub struct Fit {
    /// Whether the window has a tone.
    pub status: Status,
    /// Hertz if the span has a frame rate ([`crate::FrameSpan::with_frame_rate`]), else cycles per
    /// frame; along a path cycles per its unit. Zero if there is no tone.
    pub frequency: f32,
    /// Standard deviation of the frequency, in the same unit.
    pub sigma: f32,
    /// How the frequency moves.
    pub movement: Movement,
    /// A second tone that is significant beside the first.
    pub other_tone: Option<OtherTone>,
    /// Frequency of the interferer as fitted, cycles per frame; None if none was given, or if it is
    /// no line of its own.
    pub interferer: Option<f32>,
    /// Harmonics fitted.
    pub harmonics: u8,
    /// The second harmonic and those above it against the fundamental, common to all channels,
    /// whatever their gains and delays: real and imaginary part of a ratio. Its magnitude is the
    /// amplitude over the fundamental's, its angle the phase less as many times the fundamental's,
    /// both as cosines. In time phases are those of the motion as it was, along a path those of its
    /// places. Zeros of harmonics that were not fitted, and without a tone.
    pub overtones: [[f32; 2]; OVERTONES],
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
        const NONE: ChannelFit = ChannelFit {
            offset: 0.0,
            amplitude: 0.0,
            phase_rad: 0.0,
            phase_variance: 0.0,
            residual: 0.0,
        };
        let channels = [NONE; CHANNELS_MAX];
        const STEADY: Movement = Movement {
            wander: 0.0,
            wander_sigma: 0.0,
            sigma_of_mean: 0.0,
            chirp: 0.0,
            chirp_sigma: 0.0,
        };
        Self {
            status: Status::TooShort,
            frequency: 0.0,
            sigma: 0.0,
            movement: STEADY,
            other_tone: None,
            interferer: None,
            harmonics: 0,
            overtones: [[0.0; 2]; OVERTONES],
            frames,
            usable: 0,
            channels,
        }
    }
}
