//! The wavelengths of another paper: gratings of 0.5 to 3 mm under a hand's speeds, by its spectrum
//! of 32 ms and by the firmware.
//!
//! Okamoto et al., "Transmission of Tactile Roughness through Master-slave Systems", section IV:
//! Figures 8 (constant speeds), 9 (a hand to and fro), 10 and 11 (power over the speed and over the
//! wavelength). The finger is ours, once with ridges on its skin as theirs has them, and once with
//! its own smooth skin.

mod charts;
mod errors;
mod motion;
mod paper;
mod run;
mod scan;
mod skin;
mod tables;

use crate::page::{filled, table_of};
use crate::parallel;
use anyhow::{Context, Result};
use motion::Motion;
use paper::{SPEEDS_MM_S, WAVELENGTHS_MM};
use ridgetone_host::output;
use scan::scan;
use skin::Skin;
use std::fs;
use std::path::Path;
use tables::{polynomials, powers, wavelengths};

/// Scans all scales, fills in the tables of `reproduction.md` that are about them, and draws their
/// pictures in `reproduction/`.
pub fn write(folder: &Path) -> Result<()> {
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
    let path = folder.join("reproduction.md");
    let page = fs::read_to_string(&path).with_context(|| path.display().to_string())?;
    let text = filled(&page, |name| match name {
        "wavelengths_ridged" => Some(wavelengths(&scans, Skin::Ridged)),
        "wavelengths" => Some(wavelengths(&scans, Skin::Smooth)),
        "powers_ridged" => Some(powers(&scans, Skin::Ridged)),
        "powers" => Some(powers(&scans, Skin::Smooth)),
        "polynomials" => Some(polynomials(&scans)),
        _ => table_of(&page, name).map(str::to_owned),
    })?;
    output::whole_text(&path, &text)?;
    let pictures = folder.join("reproduction");
    fs::create_dir_all(&pictures).with_context(|| pictures.display().to_string())?;
    output::whole_text(
        &pictures.join("figure-8-9-okamoto.svg"),
        &charts::errors(&scans, Skin::Ridged),
    )?;
    output::whole_text(
        &pictures.join("figure-8-9-okamoto-smooth.svg"),
        &charts::errors(&scans, Skin::Smooth),
    )?;
    output::whole_text(
        &pictures.join("figure-10-11-okamoto.svg"),
        &charts::powers(&scans),
    )?;
    output::line(&path.display().to_string())
}

#[cfg(test)]
mod tests;
