//! Options that turn phases into a spatial period.

use clap::{Args, ValueEnum};
use ridgetone_proto::settings::Array;

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
    /// From one column of units to the other along the motion, mm, as `calibrate` finds it [default: 2.364].
    #[arg(long, value_name = "MM")]
    pub pitch: Option<f32>,
    /// By how much the contact's ends pull the columns' phases together, rad, as `calibrate` finds it [default: 0.41].
    #[arg(long, value_name = "RAD", allow_negative_numbers = true)]
    pub edge_phase: Option<f32>,
    /// Standard deviation of the pull, rad, as `calibrate` finds it [default: 0.01].
    #[arg(long, value_name = "RAD")]
    pub edge_phase_sigma: Option<f32>,
    /// Shortest spatial period that is possible, mm [default: 2.3].
    #[arg(long, value_name = "MM")]
    pub period_least: Option<f32>,
    /// Longest spatial period that is possible, mm; between one pitch and two the answer is unique [default: 4.2].
    #[arg(long, value_name = "MM")]
    pub period_most: Option<f32>,
    /// Which way the grating can go. Where that is known, every period from one pitch on has an answer of its own [default: either].
    #[arg(long, value_enum, value_name = "WAY")]
    pub direction: Option<Way>,
}

impl ArrayOptions {
    /// The settings, over those of `array` where they are not given.
    pub fn array(&self, array: Array) -> Array {
        Array {
            pitch_mm: self.pitch.unwrap_or(array.pitch_mm),
            edge_phase_rad: self.edge_phase.unwrap_or(array.edge_phase_rad),
            edge_phase_sigma_rad: self.edge_phase_sigma.unwrap_or(array.edge_phase_sigma_rad),
            period_least_mm: self.period_least.unwrap_or(array.period_least_mm),
            period_most_mm: self.period_most.unwrap_or(array.period_most_mm),
            may_go_forward: self.direction.map_or(array.may_go_forward, |way| way != Way::Backward),
            may_go_backward: self.direction.map_or(array.may_go_backward, |way| way != Way::Forward),
            ..array
        }
    }
}
