//! The data of a trade, as `trade.json` has them.

use super::units::{CLOCK_HZ, PASS_INSTRUCTIONS};
use super::{converters, plans};
use crate::accuracy::Accuracy;
use crate::page::Bar;
use serde::{Deserialize, Serialize};

/// Name of the fit under test.
pub const RIDGETONE: &str = "Ridgetone";

/// Name of the opponent on a PC.
pub const NLS: &str = "harmonic NLS, f64";

#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Trade {
    /// Windows of each line of Table 2 in a row.
    pub windows: u32,
    pub rows: Vec<Row>,
    /// The bars of instructions and memory on the chip.
    pub chip: Vec<Bar>,
    /// Scan plans, measured by a run of their own.
    pub plans: Vec<plans::Row>,
    /// Converters, measured by a run of their own.
    #[serde(default)]
    pub converters: Vec<converters::Row>,
}

impl Trade {
    /// The row of a fit of up to `harmonics` harmonics in scenes of `carried`.
    pub fn ridgetone(
        &self,
        window_s: f64,
        carried: u8,
        harmonics: u8,
        channels: u8,
    ) -> Option<&Row> {
        let key = (RIDGETONE, window_s, carried, harmonics, channels);
        self.rows.iter().find(|row| row.key() == key)
    }

    /// Rows of another method in scenes of `carried` harmonics: on all channels, and on those that
    /// fit the chip.
    pub fn baseline(&self, window_s: f64, carried: u8, method: &str) -> impl Iterator<Item = &Row> {
        let key = (method, window_s, carried);
        self.rows
            .iter()
            .filter(move |row| (row.method.as_str(), row.window_s, row.carried) == key)
    }
}

/// One choice, its cost and its accuracy. All windows of Table 2 that hold a cycle, at 20 dB.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Row {
    /// [`RIDGETONE`], or the name of another method.
    pub method: String,
    pub window_s: f64,
    pub frames: u32,
    pub carried: u8,
    pub harmonics: u8,
    pub channels: u8,
    pub accuracy: Accuracy,
    /// Instructions of the costliest window on the emulated chip, where they were counted.
    pub instructions: Option<u32>,
}

impl Row {
    /// Everything that was chosen.
    pub fn key(&self) -> (&str, f64, u8, u8, u8) {
        (
            &self.method,
            self.window_s,
            self.carried,
            self.harmonics,
            self.channels,
        )
    }

    /// From the first frame of the window to the estimate, seconds: one instruction a cycle.
    pub fn latency_s(&self) -> Option<f64> {
        self.instructions
            .map(|instructions| self.window_s + f64::from(instructions) / CLOCK_HZ)
    }

    /// The instructions in passes of cosine and sine over 16 x 240 samples.
    pub fn passes(&self) -> Option<f64> {
        self.instructions
            .map(|instructions| f64::from(instructions) / PASS_INSTRUCTIONS)
    }

    pub fn rms_percent(&self) -> Option<f64> {
        self.accuracy.error.map(|error| error.rms_percent)
    }
}
