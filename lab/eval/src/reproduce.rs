//! The paper's experiment in the machine: its forty runs on the physical finger, figure for figure
//! beside its own.
//!
//! Oddo et al., "Artificial roughness encoding with a bio-inspired MEMS-based tactile sensor
//! array", Sensors 9 (2009).

mod charts;
mod estimate;
mod figures;
mod maps;
pub mod measure;
pub mod okamoto;
pub mod paper;
mod pictures;
pub mod protocol;
mod repeatability;
pub mod results;
mod tables;
pub mod taken;

use crate::page::{filled, load, table_of};
use anyhow::{Context, Result};
use hal_mock::TABLE_2;
use paper::{COMBINATIONS, NOT_TESTED};
use results::{Pictures, Reproduction};
use ridgetone_host::output::whole_text;
use std::fs;
use std::path::Path;
use taken::Place;

/// The page with its tables as they were filled in last.
const PAGE: &str = include_str!("../../../docs/results/reproduction.md");

/// Takes `runs` runs of each of the ten combinations.
pub fn measure(runs: u32, place: Place<'_>) -> Result<Reproduction> {
    measure_some(&(0..COMBINATIONS).collect::<Vec<_>>(), runs, place)
}

/// Takes `runs` runs of some of the combinations, by their numbers from 0 on.
pub fn measure_some(which: &[usize], runs: u32, place: Place<'_>) -> Result<Reproduction> {
    let (combinations, pictures) = measure::combinations(which, runs, place)?;
    let mut cells: Vec<(f64, f64)> = which.iter().map(|c| TABLE_2[*c]).collect();
    if which.len() == COMBINATIONS {
        cells.extend(NOT_TESTED.map(|(speed_mm_s, period_mm, _)| (speed_mm_s, period_mm)));
    }
    Ok(Reproduction {
        emulated: matches!(place, Place::Emulator(_)),
        combinations,
        expected: measure::expected(&cells, place)?,
        causes: measure::causes(which, place)?,
        pictures,
    })
}

/// Writes `reproduction.json`, and from it all that [`render`] does.
pub fn write(reproduction: &Reproduction, folder: &Path) -> Result<()> {
    let json = serde_json::to_string(reproduction)?;
    // A line for each run, window and curve, so that a diff shows which changed.
    let json = [
        "{\"series\"",
        "{\"window_s\"",
        "{\"speed_mm_s\"",
        "{\"from_s\"",
        "{\"name\"",
    ]
    .into_iter()
    .fold(json, |json, start| {
        json.replace(start, &format!("\n{start}"))
    });
    fs::create_dir_all(folder).with_context(|| folder.display().to_string())?;
    whole_text(&folder.join("reproduction.json"), &(json + "\n"))?;
    render(folder)
}

/// Writes `reproduction.md` and the pictures in `reproduction/` from `reproduction.json`.
pub fn render(folder: &Path) -> Result<()> {
    let reproduction: Reproduction = load(&folder.join("reproduction.json"))?;
    let folder_of_pictures = folder.join("reproduction");
    fs::create_dir_all(&folder_of_pictures)
        .with_context(|| folder_of_pictures.display().to_string())?;
    for (name, svg) in pictures(&reproduction) {
        whole_text(&folder_of_pictures.join(name), &svg)?;
    }
    whole_text(&folder.join("reproduction.md"), &page(&reproduction)?)
}

/// The page. Figures that a run of some combinations lacks are dashes.
pub fn page(reproduction: &Reproduction) -> Result<String> {
    // The other paper's tables come from a run of their own.
    filled(PAGE, |name| {
        tables::table(reproduction, name).or_else(|| table_of(PAGE, name).map(str::to_owned))
    })
}

/// The pictures by the names of their files, without those of runs that were not made.
pub fn pictures(reproduction: &Reproduction) -> Vec<(&'static str, String)> {
    let combinations = &reproduction.combinations;
    let Pictures {
        contacts,
        spectra,
        overlay,
        opposite,
    } = &reproduction.pictures;
    let mut svgs = vec![
        ("errors.svg", charts::errors(combinations)),
        ("figure-7.svg", charts::windows(combinations)),
        ("repeatability.svg", charts::repeatability(combinations)),
        ("images.svg", maps::images(combinations)),
    ];
    if !contacts.is_empty() {
        svgs.push(("figure-3.svg", figures::contacts(contacts)));
    }
    if !spectra.is_empty() {
        svgs.push(("figure-4-5.svg", figures::spectra(spectra)));
    }
    svgs.extend(
        overlay
            .iter()
            .map(|overlay| ("figure-6.svg", figures::overlay(overlay))),
    );
    svgs.extend(
        opposite
            .iter()
            .map(|opposite| ("figure-10.svg", figures::opposite(opposite))),
    );
    svgs
}
