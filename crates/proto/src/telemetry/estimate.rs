//! An estimate: one frequency for all channels of a window, with its uncertainty, and the travel
//! derived from the phases.

use crate::fault::FaultSet;
use crate::settings::TAXELS;
use heapless::Vec;
use serde::{Deserialize, Serialize};

/// One fit over all valid channels of a window.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Estimate {
    /// Device time of the window's end, microseconds.
    pub t_us: u64,
    /// Length of the window, seconds.
    pub window_s: f32,
    /// Part of the slide that the window covers.
    pub span: Span,
    /// Confidence in the estimate.
    pub status: Status,
    /// Mean of the common frequency over the window, hertz; zero without a tone
    /// ([`Status::has_tone`]).
    pub frequency: f32,
    /// Standard deviation of the frequency, modulation included, hertz; zero without a tone.
    pub sigma: f32,
    /// Frequency modulation within the window.
    pub movement: Movement,
    /// Second tone that is significant in the presence of the first.
    pub other_tone: Option<OtherTone>,
    /// Fitted frequency of the interferer
    /// ([`Settings::interferer_hz`](crate::settings::Settings::interferer_hz)), hertz; `None` if
    /// none is set, or if the window is too short to fit it.
    pub interferer_hz: Option<f32>,
    /// Number of harmonics fitted, including the fundamental.
    pub harmonics: u8,
    /// Number of frames of the window that were left out: missing, or without a valid value of an
    /// otherwise valid taxel.
    pub frames_missing: u16,
    /// Faults during the window that may have changed the frequency.
    pub faults: FaultSet,
    /// Spatial period, speed and direction.
    pub travel: Travel,
    /// The valid channels.
    pub channels: Vec<Channel, TAXELS>,
}

/// Confidence in an estimate.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemars", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum Status {
    /// A common tone, with its uncertainty.
    Good,
    /// The channels share no tone that stands out of their noise.
    NoTone,
    /// The window holds too little of a cycle, or too few frames.
    TooShort,
    /// No valid channel or no valid frame.
    Nothing,
    /// Two frequencies an octave (or another harmonic step) apart explain the window about equally
    /// well; or the window has too few cycles to tell a tone from a single bump, or another line
    /// about as strong.
    Ambiguous,
    /// A common tone, but [`Estimate::faults`] may have changed it.
    Doubtful,
    /// A common tone, but no interval can be promised: its phase is not followed, or its amplitude
    /// comes or goes.
    Unsteady,
}

impl Status {
    /// True if an estimate with this status has a frequency.
    pub const fn has_tone(self) -> bool {
        matches!(
            self,
            Self::Good | Self::Ambiguous | Self::Doubtful | Self::Unsteady
        )
    }
}

/// Frequency modulation within the window; zeros if there is no tone. In an [`Estimate`] the unit
/// is hertz.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Movement {
    /// RMS deviation of the frequency from its mean over the window, as a fraction of the mean
    /// (0.02 is 2 %).
    pub wander: f32,
    /// Standard deviation of `wander`.
    pub wander_sigma: f32,
    /// Rate of change of the frequency, in the unit of the frequency squared: hertz per second, or
    /// cycles per millimetre per millimetre.
    pub chirp: f32,
    /// Standard deviation of `chirp`, in the same unit.
    pub chirp_sigma: f32,
}

/// A second tone next to the reported one.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct OtherTone {
    /// Frequency in the unit of the reported frequency.
    pub frequency: f32,
    /// Power as a fraction of the reported tone's power.
    pub fraction: f32,
}

/// One channel of a fit.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemars", derive(schemars::JsonSchema))]
pub struct Channel {
    /// Taxel, 0 to 15.
    pub taxel: u8,
    /// Offset in the window, volts.
    pub offset_v: f32,
    /// Amplitude of the fundamental, volts.
    pub amplitude_v: f32,
    /// Phase of the fundamental as a cosine at the window's centre, radians, -pi to pi.
    pub phase_rad: f32,
    /// Standard deviation of the residual, volts.
    pub residual_v: f32,
}

/// Part of a slide that a window covers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemars", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum Span {
    /// One stride of the sliding window.
    Window,
    /// The whole sliding phase.
    Slide,
}

/// Spatial period, speed and direction; zeros if unknown.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Travel {
    /// Confidence in spacing, speed and direction.
    pub status: TravelStatus,
    /// Direction of the grating.
    pub direction: Direction,
    /// Spatial period of the grating, millimetres.
    pub spatial_period_mm: f32,
    /// Standard deviation of the spatial period, millimetres.
    pub spatial_period_sigma_mm: f32,
    /// Speed over the surface, millimetres per second, not negative.
    pub speed_mm_s: f32,
    /// Standard deviation of the speed, millimetres per second; zero if the settings specify the
    /// speed.
    pub speed_sigma_mm_s: f32,
}

impl Travel {
    /// Travel about which nothing is known.
    pub const NONE: Self = Self {
        status: TravelStatus::Nothing,
        direction: Direction::Unknown,
        spatial_period_mm: 0.0,
        spatial_period_sigma_mm: 0.0,
        speed_mm_s: 0.0,
        speed_sigma_mm_s: 0.0,
    };

    /// True if period and speed are known.
    pub const fn is_known(&self) -> bool {
        matches!(
            self.status,
            TravelStatus::Unique
                | TravelStatus::Given
                | TravelStatus::Contradicted
                | TravelStatus::Uncalibrated
        )
    }
}

/// Source of spatial period, speed and direction, or why they are unknown.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemars", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum TravelStatus {
    /// No tone, or no pair of corresponding channels in the two columns of units has the tone.
    Nothing,
    /// The phases allow one answer within the possible periods.
    Unique,
    /// The phases allow more than one answer, or one at the edge of the possible periods.
    Ambiguous,
    /// The phases allow no answer within the possible periods.
    OutOfRange,
    /// The settings give the speed, and with it the period; the phases agree.
    Given,
    /// The settings give the speed, and with it the period; the phases disagree.
    Contradicted,
    /// The array was never calibrated: one answer by the default constants. Its uncertainty is that
    /// of any finger, and the direction is unknown if it depends on the constants.
    Uncalibrated,
}

/// Direction in which the grating moves.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemars", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum Direction {
    /// Not known.
    Unknown,
    /// Along +x: towards the column in front ([`crate::settings::Array::front`]).
    Forward,
    /// Against +x.
    Backward,
}

impl Direction {
    /// Returns the direction, if it is known.
    pub fn known(self) -> Option<Self> {
        (self != Self::Unknown).then_some(self)
    }
}
