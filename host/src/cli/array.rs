//! Options of the array: with them phases give a spatial period.

use clap::{Args, ValueEnum};
use ridgetone_proto::settings::Array;

/// Possible directions of the grating.
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
    /// Distance between the two columns of units along the motion, mm, as `calibrate` finds it
    /// [default: 2.364].
    #[arg(long, value_name = "MM")]
    pub pitch: Option<f32>,
    /// Phase by which the contact's ends reduce the lag between the columns, rad, as `calibrate`
    /// finds it [default: 0.41].
    #[arg(long, value_name = "RAD", allow_negative_numbers = true)]
    pub edge_phase: Option<f32>,
    /// Standard deviation of that phase, rad, as `calibrate` finds it [default: 0.01].
    #[arg(long, value_name = "RAD")]
    pub edge_phase_sigma: Option<f32>,
    /// Shortest possible spatial period, mm [default: 2.3].
    #[arg(long, value_name = "MM")]
    pub period_least: Option<f32>,
    /// Longest possible spatial period, mm; between one pitch and two the answer is unique
    /// [default: 4.2].
    #[arg(long, value_name = "MM")]
    pub period_most: Option<f32>,
    /// Possible directions of the grating; if only one, every period above one pitch is unique
    /// [default: either].
    #[arg(long, value_enum, value_name = "WAY")]
    pub direction: Option<Way>,
}

impl ArrayOptions {
    /// `array` with the given options.
    pub fn array(&self, array: Array) -> Array {
        Array {
            pitch_mm: self.pitch.unwrap_or(array.pitch_mm),
            edge_phase_rad: self.edge_phase.unwrap_or(array.edge_phase_rad),
            edge_phase_sigma_rad: self.edge_phase_sigma.unwrap_or(array.edge_phase_sigma_rad),
            period_least_mm: self.period_least.unwrap_or(array.period_least_mm),
            period_most_mm: self.period_most.unwrap_or(array.period_most_mm),
            may_go_forward: self
                .direction
                .map_or(array.may_go_forward, |way| way != Way::Backward),
            may_go_backward: self
                .direction
                .map_or(array.may_go_backward, |way| way != Way::Forward),
            ..array
        }
    }
}
