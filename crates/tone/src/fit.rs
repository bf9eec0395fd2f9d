//! The result of a fit.

use crate::limits::{CHANNELS_MAX, OVERTONES};

/// Status of a fit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Status {
    /// A tone common to the channels. In 95 of 100 windows, its mean frequency over the window,
    /// modulation included, is within 1.96 sigma.
    Good,
    /// The channels have no common tone that is significant against their noise.
    NoTone,
    /// The window holds too few frames to decide.
    TooShort,
    /// No valid channel or no valid frame.
    Nothing,
    /// A different frequency explains the window about as well: see [`Fit::other_tone`].
    Ambiguous,
    /// A tone without a reliable confidence interval: its phase cannot be followed, it fades in or
    /// out, or a channel stays at an end of its range for a quarter of the window.
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
    /// Variance of `phase_rad`, radians squared; not finite in a channel without any tone.
    pub phase_variance: f32,
    /// Standard deviation of the residuals.
    pub residual: f32,
}

/// Frequency modulation within the window; zeros if there is no tone.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Movement {
    /// Deviation of the frequency from its mean, RMS over the window, as a fraction of the mean
    /// (0.02 is 2 %).
    pub wander: f32,
    /// Standard deviation of `wander`.
    pub wander_sigma: f32,
    /// Rate of change of the frequency, in hertz per second; without a frame rate, in cycles per
    /// frame squared; along a path, in cycles per unit squared.
    pub chirp: f32,
    /// Standard deviation of `chirp`.
    pub chirp_sigma: f32,
}

/// A frequency that competes with the reported one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OtherTone {
    /// Frequency, in the unit of [`Fit::frequency`].
    pub frequency: f32,
    /// Power relative to the reported tone.
    pub fraction: f32,
}

/// Test statistics behind a status, for diagnosis.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Tests {
    /// Log odds against the likeliest comb at a different frequency.
    pub margin: f32,
    /// Normal deviate of the strongest line over the local noise.
    pub line: f32,
    /// Normal deviate of the fundamental over its local noise.
    pub fundamental: f32,
    /// Normal deviate of the most significant line outside the comb.
    pub other: f32,
    /// Normal deviate of lines halfway between the harmonics.
    pub between: f32,
    /// Normal deviate of the power outside the lines.
    pub beside: f32,
    /// Power outside the lines relative to the tone.
    pub beside_fraction: f32,
    /// RMS phase beyond the fitted degrees, radians.
    pub unfollowed: f32,
    /// RMS change of the amplitude, as a fraction.
    pub fading: f32,
    /// Cycles in the window.
    pub cycles: f32,
    /// True if any single bump could pass for this tone: all channels have the same waveform, or
    /// there are at most two channels.
    pub one_shape: bool,
    /// Probability that the frequency is constant.
    pub steady: f32,
    /// Degree of the baseline.
    pub degree: u8,
    /// Number of fitted degrees of the phase.
    pub degrees: u8,
    /// Mask of the fitted lines; bit k is line k.
    pub lines: u16,
}

/// The result of a fit.
#[derive(Clone, Debug)]
pub struct Fit {
    /// Verdict on the window.
    pub status: Status,
    /// Mean frequency over the window: hertz if the span has a frame rate
    /// ([`crate::FrameSpan::with_frame_rate`]), else cycles per frame; along a path, cycles per
    /// unit of position. Zero if there is no tone.
    pub frequency: f32,
    /// Standard deviation of `frequency`, in its unit.
    pub sigma: f32,
    /// Frequency modulation.
    pub movement: Movement,
    /// Competing frequency, if the status is [`Status::Ambiguous`].
    pub other_tone: Option<OtherTone>,
    /// Fitted frequency of the interferer, cycles per frame; `None` if none was declared or found.
    pub interferer: Option<f32>,
    /// Number of the highest harmonic that was found.
    pub harmonics: u8,
    /// Complex ratios of the second and higher harmonics to the fundamental (real and imaginary
    /// part), common to all channels whatever their gains and delays. Zero for missing harmonics,
    /// and if there is no tone.
    pub overtones: [[f32; 2]; OVERTONES],
    /// Number of frames that were used.
    pub frames: u32,
    /// Bit k: channel k was used.
    pub usable: u16,
    /// Bit k: the tone is significant in channel k by itself.
    pub with_tone: u16,
    /// Results of each channel; zeros if not used.
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
