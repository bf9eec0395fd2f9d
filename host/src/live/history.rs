//! The latest estimates, for a chart of the frequency.

use super::bounded::Bounded;
use crate::events::view;
use ridgetone_proto::telemetry::Estimate;

/// Estimates kept: eight minutes of sliding at the default stride.
pub const POINTS: usize = 2000;

pub type History = Bounded<view::Estimate, POINTS>;

/// Converts an estimate for the chart. Leaves out the channels, which are most of the data.
pub fn point(estimate: &Estimate) -> view::Estimate {
    view::Estimate {
        channels: Vec::new(),
        ..estimate.into()
    }
}
