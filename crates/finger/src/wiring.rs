//! Facts about a board's wiring, from the board's file. They are not settings, and are not sent.

use crate::converter::{Ads1258Plan, Facts};
use ridgetone_proto::plan::Plan;
use ridgetone_proto::settings::Settings;

/// Properties of a board's wiring that are not settings.
#[derive(Clone, Copy, Debug)]
pub struct Wiring {
    /// Converter of the board.
    pub converter: &'static Facts,
}

impl Wiring {
    /// The guide's wiring: an ADS1258.
    pub const GUIDE: Self = Self {
        converter: &Facts {
            name: "ADS1258",
            plan: Plan::PAPER,
            vref_v: Settings::DEFAULT.vref_v,
            check: Ads1258Plan::check,
        },
    };
}
