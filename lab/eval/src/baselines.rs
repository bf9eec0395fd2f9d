//! The estimators that one would otherwise pick for the one frequency that all channels share.
//! Ridgetone's own fit is compared with them.
//!
//! Each is written as its source describes it and as somebody who knows the chip would write it: in
//! f32, on samples less their mean, with a rotation in place of a sine for every sample. None of
//! them shares code with the fit. All take the same window and give cycles per frame
//! ([`Method::estimate`]).
//!
//! | method | source |
//! |---|---|
//! | [`periodogram`] | Rife and Boorstyn 1974 |
//! | [`parabolic`] | Smith and Serra 1987; Abe and Smith 2004 |
//! | [`interpolated_dft`] | Aboutanios and Mulgrew 2005; Ye and Aboutanios 2015 |
//! | [`zero_crossings`] | Friedman 1994 |
//! | [`ieee1057`] | IEEE Std 1057; Haendel 2000 |
//! | [`oddo2009`] | Oddo et al. 2009, the paper that Ridgetone follows |
//! | [`lm_joint`] | More 1978, the crate `levenberg-marquardt` |
//!
//! One more is for the PC alone, in f64, and gives an uncertainty too: `nls`, harmonic nonlinear
//! least squares.

pub mod ieee1057;
pub mod interpolated_dft;
pub mod lm_joint;
#[cfg(not(target_os = "none"))]
pub mod nls;
pub mod oddo2009;
pub mod parabolic;
pub mod periodogram;
mod rotation;
mod samples;
pub mod zero_crossings;

pub use samples::{CHANNELS, FRAMES_MAX, Frame, Scratch};

/// A method, by its number from 0 on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Method {
    Periodogram,
    Parabolic,
    InterpolatedDft,
    ZeroCrossings,
    Ieee1057,
    Oddo2009,
    LmJoint,
}

impl Method {
    pub const ALL: [Self; 7] = [
        Self::Periodogram,
        Self::Parabolic,
        Self::InterpolatedDft,
        Self::ZeroCrossings,
        Self::Ieee1057,
        Self::Oddo2009,
        Self::LmJoint,
    ];

    pub const fn name(self) -> &'static str {
        match self {
            Self::Periodogram => "periodogram",
            Self::Parabolic => "parabolic",
            Self::InterpolatedDft => "interpolated DFT",
            Self::ZeroCrossings => "zero crossings",
            Self::Ieee1057 => "IEEE 1057",
            Self::Oddo2009 => "Oddo 2009",
            Self::LmJoint => "levenberg-marquardt",
        }
    }

    pub fn from_number(number: u8) -> Option<Self> {
        Self::ALL.get(usize::from(number)).copied()
    }

    /// Most channels that it looks at: the rest of those it is given it leaves out.
    pub const fn channels_max(self) -> usize {
        match self {
            Self::Oddo2009 => oddo2009::CHANNELS_MAX,
            _ => CHANNELS,
        }
    }

    /// Most channels with which it fits the chip's memory in a window of a second.
    pub const fn channels_on_chip(self) -> usize {
        match self {
            Self::LmJoint => lm_joint::CHANNELS_ON_CHIP,
            _ => CHANNELS,
        }
    }

    /// The common frequency of the first `channels` channels, cycles per frame, greater than 0 and
    /// less than 0.5. None if the method finds none, if there are fewer than 4 or more than
    /// [`FRAMES_MAX`] frames, or if no channel varies. A channel with a value that is not finite is
    /// left out.
    ///
    /// [`Method::LmJoint`] allocates.
    pub fn estimate(self, values: &[Frame], channels: usize, scratch: &mut Scratch) -> Option<f32> {
        let estimate = match self {
            Self::Periodogram => periodogram::estimate,
            Self::Parabolic => parabolic::estimate,
            Self::InterpolatedDft => interpolated_dft::estimate,
            Self::ZeroCrossings => zero_crossings::estimate,
            Self::Ieee1057 => ieee1057::estimate,
            Self::Oddo2009 => oddo2009::estimate,
            Self::LmJoint => lm_joint::estimate,
        };
        estimate(values, channels, scratch).filter(|frequency| *frequency > 0.0 && *frequency < 0.5)
    }
}
