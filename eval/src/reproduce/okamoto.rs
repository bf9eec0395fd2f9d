//! The wavelengths of another paper: gratings of 0.5 to 3 mm under a hand's speeds, by its spectrum of 32 ms and by the firmware.
//!
//! Okamoto et al., "Transmission of Tactile Roughness through Master-slave Systems", section IV: Figures 8 (constant speeds), 9 (a
//! hand to and fro), 10 and 11 (power over the speed and over the wavelength). The finger is ours, and so is its skin.

mod charts;
mod errors;
mod motion;
mod paper;
mod run;
mod scan;
mod tables;

use crate::page::{filled, table_of};
use crate::parallel;
use anyhow::{Context, Result};
use motion::Motion;
use ridgetone_host::output;
use paper::{SPEEDS_MM_S, WAVELENGTHS_MM};
use scan::scan;
use std::fs;
use std::path::Path;
use tables::{polynomials, powers, wavelengths};

/// Scans all scales, fills in the tables of `reproduction.md` that are about them, and draws their pictures in `reproduction/`.
pub fn write(folder: &Path) -> Result<()> {
    let motions = [SPEEDS_MM_S.map(Motion::Steady).to_vec(), vec![Motion::Hand]].concat();
    let all: Vec<_> =
        motions.iter().flat_map(|motion| WAVELENGTHS_MM.map(|wavelength_mm| (wavelength_mm, *motion))).collect();
    let mut scans = parallel::map("scales", &all, |(wavelength_mm, motion)| scan(*wavelength_mm, *motion))?.concat();
    scans.sort_by_key(|scan| scan.is_turning);
    let path = folder.join("reproduction.md");
    let page = fs::read_to_string(&path).with_context(|| path.display().to_string())?;
    let text = filled(&page, |name| match name {
        "wavelengths" => Some(wavelengths(&scans)),
        "powers" => Some(powers(&scans)),
        "polynomials" => Some(polynomials(&scans)),
        _ => table_of(&page, name).map(str::to_owned),
    })?;
    output::whole_text(&path, &text)?;
    let pictures = folder.join("reproduction");
    fs::create_dir_all(&pictures).with_context(|| pictures.display().to_string())?;
    output::whole_text(&pictures.join("figure-8-9-okamoto.svg"), &charts::errors(&scans))?;
    output::whole_text(&pictures.join("figure-10-11-okamoto.svg"), &charts::powers(&scans))?;
    output::line(&path.display().to_string())
}

#[cfg(test)]
mod tests;
