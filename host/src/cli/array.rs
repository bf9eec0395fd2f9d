//! The one option that stands for two settings of the array.

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

/// What is known of the gratings' direction.
#[derive(Args, Clone, Debug)]
pub struct ArrayOptions {
    /// Possible directions of the grating; if only one, every period above one pitch is unique
    /// [default: either].
    #[arg(long, value_enum, value_name = "WAY")]
    pub direction: Option<Way>,
}

impl ArrayOptions {
    /// `array` with the given options.
    pub fn array(&self, array: Array) -> Array {
        Array {
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
