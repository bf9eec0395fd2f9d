//! Declared contents of a window. Effects that a scene does not declare cost nothing.

use crate::limits::{DEGREE_MAX, HARMONICS_MAX};

/// Model of a channel's level over the window.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Baseline {
    /// A level and a slope.
    Slope,
    /// A polynomial of up to the fourth degree, for skin that creeps.
    Curved,
}

/// The noise of a channel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Noise {
    /// Equal power at all frequencies.
    White,
    /// Any spectrum that is smooth next to the lines.
    Any,
}

/// Correlation of the noise between channels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Channels {
    /// Each channel has independent noise.
    Independent,
    /// Noise may be correlated between channels.
    MayShare,
}

/// Model of the speed over the window.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Speed {
    /// Probably constant: costs 3 % of sigma in white noise.
    Steady,
    /// As likely to change as not: costs 20 % of sigma in white noise.
    MayMove,
}

/// Contents that a window may have.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scene {
    /// Maximum number of harmonics, the fundamental included: 1 to 5.
    pub harmonics: u8,
    /// Model of the levels.
    pub baseline: Baseline,
    /// The noise of a channel.
    pub noise: Noise,
    /// Correlation of the noise between channels.
    pub channels: Channels,
    /// Model of the speed.
    pub speed: Speed,
    /// True if there may be impulses (single outliers).
    pub impulses: bool,
    /// Minimum and maximum frequency of a fundamental, in the unit of [`crate::Fit::frequency`];
    /// zeros if unknown.
    pub band: Band,
}

/// Minimum and maximum frequency of a fundamental.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Band {
    /// Minimum frequency.
    pub min: f32,
    /// Maximum frequency; 0 means half the frame rate.
    pub max: f32,
}

impl Band {
    /// Converts the band to multiples of `unit`.
    pub(crate) fn over(&self, unit: f32) -> Self {
        Self {
            min: self.min / unit,
            max: self.max / unit,
        }
    }

    pub(crate) fn has(&self, frequency: f32) -> bool {
        frequency >= self.min && (self.max <= 0.0 || frequency <= self.max)
    }
}

impl Scene {
    /// Scene of the paper's finger: ridges with overtones under skin that creeps.
    pub const DEFAULT: Self = Self {
        harmonics: 4,
        baseline: Baseline::Curved,
        noise: Noise::Any,
        channels: Channels::MayShare,
        speed: Speed::Steady,
        impulses: true,
        band: Band { min: 0.0, max: 0.0 },
    };

    /// Minimal scene: one harmonic in white noise with a slope.
    pub const LEAN: Self = Self {
        harmonics: 1,
        baseline: Baseline::Slope,
        noise: Noise::White,
        channels: Channels::Independent,
        impulses: false,
        ..Self::DEFAULT
    };

    /// Default scene with at most this many harmonics, the fundamental included.
    pub const fn with_harmonics(harmonics: u8) -> Self {
        Self {
            harmonics,
            ..Self::DEFAULT
        }
    }

    /// The scene without curved baselines, coloured or shared noise, and impulses.
    pub(crate) const fn plain(&self) -> Self {
        Self {
            harmonics: self.harmonics,
            speed: self.speed,
            band: self.band,
            ..Self::LEAN
        }
    }

    /// Maximum number of harmonics, limited to the fit's capacity.
    pub(crate) fn harmonics(&self) -> u8 {
        self.harmonics.clamp(1, HARMONICS_MAX as u8)
    }

    pub(crate) fn degree_max(&self) -> usize {
        match self.baseline {
            Baseline::Slope => 1,
            Baseline::Curved => DEGREE_MAX,
        }
    }

    pub(crate) fn steady(&self) -> f32 {
        match self.speed {
            Speed::Steady => 0.95,
            Speed::MayMove => 0.5,
        }
    }

    pub(crate) fn is_white(&self) -> bool {
        self.noise == Noise::White
    }

    pub(crate) fn may_share(&self) -> bool {
        self.channels == Channels::MayShare
    }
}

impl Default for Scene {
    fn default() -> Self {
        Self::DEFAULT
    }
}
