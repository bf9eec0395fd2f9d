//! The wavelengths of another paper: gratings of 0.5 to 3 mm under a hand's speeds, by its spectrum
//! of 32 ms and by the firmware.
//!
//! Okamoto et al., "Transmission of Tactile Roughness through Master-slave Systems", section IV:
//! Figures 8 (constant speeds), 9 (a hand to and fro), 10 and 11 (power over the speed and over the
//! wavelength). The finger is ours, once with ridges on its skin as theirs has them, and once with
//! its own smooth skin.

mod errors;
mod motion;
mod paper;
mod run;
mod scan;
mod skin;
pub mod tables;

use super::TOPIC;
use super::results::Reproduction;
use crate::page;
use crate::parallel;
use anyhow::Result;
use motion::Motion;
use paper::{SPEEDS_MM_S, WAVELENGTHS_MM};
use ridgetone_host::output::whole_text;
use scan::{Scan, scan};
use skin::Skin;
use std::path::Path;

/// Scans all scales.
fn scans() -> Result<Vec<Scan>> {
    let motions = [SPEEDS_MM_S.map(Motion::Steady).to_vec(), vec![Motion::Hand]].concat();
    let mut all = Vec::new();
    for skin in [Skin::Ridged, Skin::Smooth] {
        for motion in &motions {
            all.extend(WAVELENGTHS_MM.map(|wavelength_mm| (wavelength_mm, *motion, skin)));
        }
    }
    let mut scans = parallel::map("scales", &all, |(wavelength_mm, motion, skin)| {
        scan(*wavelength_mm, *motion, *skin)
    })?
    .concat();
    scans.sort_by_key(|scan| scan.is_turning);
    Ok(scans)
}

/// Measures, and writes the figures of this paper, the page and its picture; the other paper's
/// figures stay.
pub fn write(folder: &Path) -> Result<()> {
    let mut figures = page::load::<Reproduction>(folder, TOPIC)?;
    figures.tables.extend(tables::tables(&scans()?));
    page::write(folder, TOPIC, &figures)?;
    write_picture(folder)
}

/// Draws the picture from the figures that a folder has.
pub fn write_picture(folder: &Path) -> Result<()> {
    let figures = page::load::<Reproduction>(folder, TOPIC)?;
    let wavelengths = figures.tables.get("okamoto_wavelengths").cloned();
    whole_text(
        &folder.join("papers-wavelengths.svg"),
        &tables::picture(&wavelengths.unwrap_or_default()),
    )
}

#[cfg(test)]
mod tests;
