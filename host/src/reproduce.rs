//! The paper's experiment in the machine: its forty runs on the physical finger, figure for figure beside its own.
//!
//! Oddo et al., "Artificial roughness encoding with a bio-inspired MEMS-based tactile sensor array", Sensors 9 (2009).

mod estimate;
mod measure;
mod paper;
mod pictures;
mod protocol;
mod repeatability;
mod results;
mod still;
mod taken;

pub use measure::{causes, combinations, expected};
pub use paper::RUNS;
pub use results::{Cause, Combination, Expected, Pictures, Run, Windows};
pub use taken::Place;

use anyhow::Result;
use hal_mock::TABLE_2;
use paper::{COMBINATIONS, NOT_TESTED};
use serde::{Deserialize, Serialize};

/// All that was measured.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Reproduction {
    /// Whether the firmware image ran in the emulator, or its library on a PC.
    pub emulated: bool,
    /// The combinations of Table 2 that were tested.
    pub combinations: Vec<Combination>,
    /// What a perfect stimulator makes, those that the paper did not test included.
    pub expected: Vec<Expected>,
    /// Where the errors come from.
    pub causes: Vec<Cause>,
    /// What the pictures are drawn from.
    pub pictures: Pictures,
}

impl Reproduction {
    /// Takes so many runs of each of the ten combinations.
    ///
    /// # Errors
    /// A scene that cannot be made, a run in which the contact is not found, those of the emulator.
    pub fn measure(runs: u32, place: Place<'_>) -> Result<Self> {
        let all: Vec<usize> = (0..COMBINATIONS).collect();
        Self::measure_some(&all, runs, place)
    }

    /// Takes so many runs of some of the combinations, by their numbers from 0 on.
    ///
    /// # Errors
    /// As [`measure`](Self::measure).
    pub fn measure_some(which: &[usize], runs: u32, place: Place<'_>) -> Result<Self> {
        let (combinations, pictures) = combinations(which, runs, place)?;
        let mut cells: Vec<(f64, f64)> = which.iter().map(|c| TABLE_2[*c]).collect();
        if which.len() == COMBINATIONS {
            cells.extend(NOT_TESTED.map(|(speed_mm_s, period_mm, _)| (speed_mm_s, period_mm)));
        }
        Ok(Self {
            emulated: matches!(place, Place::Emulator(_)),
            combinations,
            expected: expected(&cells, place)?,
            causes: causes(which, place)?,
            pictures,
        })
    }
}
