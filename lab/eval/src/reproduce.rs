//! The paper's experiment in the machine: its forty runs on the physical finger, figure for figure
//! beside its own.
//!
//! Oddo et al., "Artificial roughness encoding with a bio-inspired MEMS-based tactile sensor
//! array", Sensors 9 (2009).

mod estimate;
pub mod measure;
pub mod okamoto;
pub mod paper;
pub mod protocol;
mod repeatability;
pub mod results;
mod tables;
pub mod taken;

use crate::page::{self, Figures};
use anyhow::Result;
use hal_mock::TABLE_2;
use paper::{COMBINATIONS, NOT_TESTED};
use results::Reproduction;
use ridgetone_host::output::whole_text;
use std::path::Path;
use taken::Place;

/// The topic of both papers' figures.
pub const TOPIC: &str = "papers-runs";

/// Takes `runs` runs of each of the ten combinations.
pub fn measure(runs: u32, place: Place<'_>) -> Result<Reproduction> {
    measure_some(&(0..COMBINATIONS).collect::<Vec<_>>(), runs, place)
}

/// Takes `runs` runs of some of the combinations, by their numbers from 0 on.
pub fn measure_some(which: &[usize], runs: u32, place: Place<'_>) -> Result<Reproduction> {
    let mut cells: Vec<(f64, f64)> = which.iter().map(|c| TABLE_2[*c]).collect();
    if which.len() == COMBINATIONS {
        cells.extend(NOT_TESTED.map(|(speed_mm_s, period_mm, _)| (speed_mm_s, period_mm)));
    }
    Ok(Reproduction {
        emulated: matches!(place, Place::Emulator(_)),
        combinations: measure::combinations(which, runs, place)?,
        expected: measure::expected(&cells, place)?,
        causes: measure::causes(which, place)?,
    })
}

/// The figures of a reproduction beside those of the other paper that a folder has.
pub fn figures(reproduction: Reproduction, before: Figures<Reproduction>) -> Figures<Reproduction> {
    let mut tables = before.tables;
    tables.extend(tables::tables(&reproduction));
    Figures {
        tables,
        detail: reproduction,
    }
}

/// Writes the figures, the page and its picture.
pub fn write(reproduction: Reproduction, folder: &Path) -> Result<()> {
    let before = page::load(folder, TOPIC)?;
    let figures = figures(reproduction, before);
    page::write(folder, TOPIC, &figures)?;
    whole_text(
        &folder.join("papers.svg"),
        &tables::picture(&figures.detail),
    )
}

/// The picture of the page.
#[cfg(test)]
pub use tables::picture;
