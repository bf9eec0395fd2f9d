//! Options that turn phases into a spatial period.

use clap::{Args, ValueEnum};
use ridgetone::settings::Array;

/// Which ways are possible.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Way {
    /// Either.
    Either,
    /// Towards units 2 and 4.
    Forward,
    /// Towards units 1 and 3.
    Backward,
}

/// What is known of the units and of the gratings.
#[derive(Args, Clone, Debug)]
pub struct ArrayOptions {
    /// From one column of units to the other along the motion, mm, as `calibrate` finds it.
    #[arg(long, value_name = "MM", default_value_t = Array::DEFAULT.pitch_mm)]
    pub pitch: f32,
    /// By how much the contact's ends pull the columns' phases together, rad, as `calibrate` finds it.
    #[arg(long, value_name = "RAD", default_value_t = Array::DEFAULT.pull_rad, allow_negative_numbers = true)]
    pub pull: f32,
    /// Standard deviation of the pull, rad, as `calibrate` finds it.
    #[arg(long, value_name = "RAD", default_value_t = Array::DEFAULT.pull_sigma_rad)]
    pub pull_sigma: f32,
    /// Shortest spatial period that is possible, mm.
    #[arg(long, value_name = "MM", default_value_t = Array::DEFAULT.period_least_mm)]
    pub period_least: f32,
    /// Longest spatial period that is possible, mm. Between one pitch and two the answer is unique.
    #[arg(long, value_name = "MM", default_value_t = Array::DEFAULT.period_most_mm)]
    pub period_most: f32,
    /// Which way the grating can go. Where that is known, every period from one pitch on has an answer of its own.
    #[arg(long, value_enum, value_name = "WAY", default_value_t = Way::Either)]
    pub direction: Way,
}

impl ArrayOptions {
    /// The settings.
    pub fn array(&self) -> Array {
        Array {
            pitch_mm: self.pitch,
            pull_rad: self.pull,
            pull_sigma_rad: self.pull_sigma,
            period_least_mm: self.period_least,
            period_most_mm: self.period_most,
            may_go_forward: self.direction != Way::Backward,
            may_go_backward: self.direction != Way::Forward,
            ..Array::DEFAULT
        }
    }
}
