//! Forces of a pin display, as the board reports them and as `ridgetone pins` computes them.

use crate::digits::seconds;
use ridgetone_proto::telemetry::Pins;
use serde::Serialize;

/// Forces of a display, the board's and those that `ridgetone pins` computes.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PinForces {
    /// Device time, seconds.
    pub t_s: f64,
    pub rows: usize,
    pub columns: usize,
    /// Row by row, newtons.
    pub forces_n: Vec<f32>,
    /// Force of a level, newtons.
    pub level_n: f32,
    /// Pins whose wanted force is beyond the display's limits.
    pub limited: usize,
    /// Updates that were left out before this one.
    pub skipped: u8,
    pub is_optimal: bool,
    /// Bit k: taxel k counts.
    pub taxels: u16,
}

impl From<&Pins> for PinForces {
    fn from(pins: &Pins) -> Self {
        let Pins {
            t_us,
            taxels,
            limited,
            skipped,
            is_optimal,
            level_n,
            ..
        } = *pins;
        let (side, limited) = (pins.side(), limited.into());
        let forces_n = pins.forces_n().collect();
        Self {
            t_s: seconds(t_us),
            rows: side,
            columns: side,
            forces_n,
            level_n,
            limited,
            skipped,
            is_optimal,
            taxels,
        }
    }
}
