//! The wavelengths of another paper: gratings of 0.5 to 3 mm under a hand's speeds, by its spectrum of 32 ms and by the firmware.
//!
//! Okamoto et al., "Transmission of Tactile Roughness through Master-slave Systems", section IV: Figures 8 (constant speeds), 9 (a
//! hand to and fro), 10 and 11 (power over the speed and over the wavelength). The finger is ours, and so is its skin.

mod charts;
mod errors;
mod motion;
mod run;
mod tables;

use crate::page::{filled, table_of};
use crate::parallel;
use anyhow::{Context, Result};
use errors::{Bound, Errors, fft};
use motion::Motion;
use ridgetone_host::output;
use ridgetone_proto::telemetry::{Span, Status};
use run::{FELT_LATE_S, Slid, settings};
use std::fs;
use std::ops::RangeInclusive;
use std::path::Path;
use tables::{polynomials, powers, wavelengths};

/// The scales, mm; a ridge is half as wide (section III-B). Figures 8 and 9 begin at 0.5 mm, Figure 11 at 0.8.
const WAVELENGTHS_MM: [f64; 10] = [0.5, 0.8, 1.0, 1.2, 1.4, 1.6, 1.8, 2.0, 2.5, 3.0];
/// The mean of a hand's speed, and two standard deviations to each side, mm/s (section IV-A).
const SPEEDS_MM_S: [f64; 3] = [73.5, 125.4, 177.4];
/// Length of a scan, mm (section IV-A).
const SCAN_MM: f64 = 175.0;
/// Its window, the best of four by its own search, and the longest of these, seconds.
const WINDOW_S: f64 = 0.032;
const LONGEST_S: f64 = 0.128;
/// The accuracy that the longer window is chosen by, as a share of the wavelength.
const ACCURACY: f32 = 0.005;
/// Fewest cycles in a window that is judged: fewer may be a single bump.
const CYCLES: f64 = 1.5;
/// Powers of Figure 11, in its unit, as its equation 2 has them.
const POLYNOMIAL: [f64; 5] = [72_298.0, -248_938.0, 309_743.0, -162_663.0, 30_770.0];

/// Wavelengths that it was fitted over, and its coefficient of determination.
const FITTED_MM: RangeInclusive<f64> = 0.8..=2.0;
const R2: f64 = 0.94;

/// A scan of a scale.
#[derive(Clone, Debug)]
struct Scan {
    wavelength_mm: f64,
    motion: Motion,
    /// Of the windows in which the finger turns; otherwise of the others.
    is_turning: bool,
    /// By the paper's method, by the firmware in its window, and in a window by accuracy.
    fft: Option<f64>,
    short: Errors,
    long: Errors,
    /// Mean square of the fundamental's amplitude over the channels, mV^2; none without a tone.
    power_mv2: Option<f64>,
}

/// Slides once; of a hand gives the windows in which it turns apart.
fn scan(wavelength_mm: f64, motion: Motion) -> Result<Vec<Scan>> {
    let slid = Slid::new(wavelength_mm, motion)?;
    let bound = Bound::new(&slid)?;
    let short = slid.estimates(settings(WINDOW_S, 0.0), FELT_LATE_S)?;
    let long = slid.estimates(settings(LONGEST_S, ACCURACY), FELT_LATE_S)?;
    let of_slide = short.iter().find(|estimate| estimate.span == Span::Slide && estimate.status == Status::Good);
    let power_mv2 = of_slide.map(|estimate| {
        let squares = estimate.channels.iter().map(|channel| (1e3 * f64::from(channel.amplitude_v)).powi(2));
        squares.sum::<f64>() / estimate.channels.len() as f64
    });
    let of = |is_turning: bool| Scan {
        wavelength_mm,
        motion,
        is_turning,
        fft: fft(&slid).filter(|_| !is_turning),
        short: Errors::new(&slid, &short, &bound, is_turning),
        long: Errors::new(&slid, &long, &bound, is_turning),
        power_mv2,
    };
    let both = [false, true].into_iter().filter(|is_turning| !is_turning || motion == Motion::Hand);
    Ok(both.map(of).collect())
}

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
