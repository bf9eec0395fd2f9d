//! The static image: effect of a hold on every taxel.

use crate::settings::TAXELS;
use heapless::Vec;
use serde::{Deserialize, Serialize};

/// Which hold of a touch (paper, section 3.1).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemars", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum Hold {
    /// Phase B: between the contact spike and the first slide.
    BeforeSlide,
    /// Phase D: after a slide.
    AfterSlide,
}

/// Effect of a hold on one taxel.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemars", derive(schemars::JsonSchema))]
pub struct Pressed {
    /// Taxel, 0 to 15.
    pub taxel: u8,
    /// Mean over the hold less the level before the touch, volts.
    pub level_v: f32,
    /// Standard deviation of the level, from the noise in the hold and before the touch, volts.
    pub sigma_v: f32,
}

/// The pressure map of a hold, sent at its end, unless the hold lacks 0.1 s of uninterrupted rest.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Image {
    /// Device time of the first frame of the mean, microseconds.
    pub start_us: u64,
    /// Device time of the end of the last frame of the mean, microseconds.
    pub end_us: u64,
    /// Number of frames in the mean, without missing ones.
    pub frames: u32,
    /// Hold before or after the slide.
    pub hold: Hold,
    /// Working taxels. A taxel is dead if a conversion in the hold cannot be trusted, or if it has
    /// no noise and the same code as before the touch.
    pub taxels: Vec<Pressed, TAXELS>,
}
