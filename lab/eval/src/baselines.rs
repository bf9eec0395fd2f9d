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
//! | [`ieee1057`] | IEEE Std 1057; Haendel 2000 |
//! | [`oddo2009`] | Oddo et al. 2009, the paper that Ridgetone follows |

pub mod ieee1057;
pub mod oddo2009;
pub mod periodogram;
mod rotation;
mod samples;

pub use samples::{CHANNELS, FRAMES_MAX, Frame, Scratch};

/// A method, by its number from 0 on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Method {
    Periodogram,
    Ieee1057,
    Oddo2009,
}

impl Method {
    pub const ALL: [Self; 3] = [Self::Periodogram, Self::Ieee1057, Self::Oddo2009];

    pub const fn name(self) -> &'static str {
        match self {
            Self::Periodogram => "periodogram",
            Self::Ieee1057 => "IEEE 1057",
            Self::Oddo2009 => "Oddo 2009",
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

    /// The common frequency of the first `channels` channels, cycles per frame, greater than 0 and
    /// less than 0.5. None if the method finds none, if there are fewer than 4 or more than
    /// [`FRAMES_MAX`] frames, or if no channel varies. A channel with a value that is not finite is
    /// left out.
    pub fn estimate(self, values: &[Frame], channels: usize, scratch: &mut Scratch) -> Option<f32> {
        let estimate = match self {
            Self::Periodogram => periodogram::estimate,
            Self::Ieee1057 => ieee1057::estimate,
            Self::Oddo2009 => oddo2009::estimate,
        };
        estimate(values, channels, scratch).filter(|frequency| *frequency > 0.0 && *frequency < 0.5)
    }
}
