//! The paper's experiment in the machine: its forty runs on the physical finger, figure for figure beside its own.
//!
//! Oddo et al., "Artificial roughness encoding with a bio-inspired MEMS-based tactile sensor array", Sensors 9 (2009).

mod charts;
mod document;
mod estimate;
mod figures;
mod findings;
mod fourier;
mod maps;
mod measure;
mod page;
mod paper;
mod pictures;
mod plot;
mod protocol;
mod repeatability;
mod results;
mod still;
mod tables;
mod taken;

pub use measure::{causes, combinations, expected};
pub use paper::{Errors, PairErrors, TABLE_3};
pub use results::{Cause, Combination, Contact, Curve, Expected, Firmware, Opposite, Overlay, Pair, Pictures, Run};
pub use results::{Spectrum, Windows};
pub use taken::Place;

use anyhow::{Context, Result};
use hal_mock::TABLE_2;
use paper::{COMBINATIONS, NOT_TESTED};
use ridgetone_host::output::whole_file;
use serde::{Deserialize, Serialize};
use std::fs;
use std::path::Path;

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

    /// Writes `reproduction.json`, and from it all that [`render`](Self::render) does.
    ///
    /// # Errors
    /// Those of the system.
    pub fn write(&self, folder: &Path) -> Result<()> {
        let json = serde_json::to_string(self)?;
        // A line for each run, window and curve: a run's changes can be read.
        let json = ["{\"series\"", "{\"window_s\"", "{\"speed_mm_s\"", "{\"from_s\"", "{\"name\""]
            .into_iter()
            .fold(json, |json, start| json.replace(start, &format!("\n{start}")));
        fs::create_dir_all(folder).with_context(|| folder.display().to_string())?;
        whole_file(&folder.join("reproduction.json"), |file| Ok(writeln!(file, "{json}")?))?;
        Self::render(folder)
    }

    /// Writes `reproduction.md`, `reproduction.html` and the pictures in `reproduction/` from `reproduction.json`.
    ///
    /// # Errors
    /// Those of the system; the file is not what a run writes.
    pub fn render(folder: &Path) -> Result<()> {
        let reproduction = Self::load(&folder.join("reproduction.json"))?;
        let pictures = folder.join(document::FOLDER);
        fs::create_dir_all(&pictures).with_context(|| pictures.display().to_string())?;
        let write = |path: &Path, text: String| whole_file(path, |file| Ok(file.write_all(text.as_bytes())?));
        for (name, svg) in reproduction.svgs(plot::STYLE) {
            write(&pictures.join(name), svg)?;
        }
        write(&folder.join("reproduction.md"), reproduction.document()?)?;
        write(&folder.join("reproduction.html"), reproduction.page()?)
    }

    /// Reads `reproduction.json`.
    ///
    /// # Errors
    /// Those of the system; the file is not what a run writes.
    pub fn load(path: &Path) -> Result<Self> {
        let text = fs::read_to_string(path).with_context(|| path.display().to_string())?;
        serde_json::from_str(&text).with_context(|| path.display().to_string())
    }

    /// The document.
    ///
    /// # Errors
    /// The template asks for what there is not.
    pub fn document(&self) -> Result<String> {
        document::document(self)
    }

    /// The document as one page with its pictures in it.
    ///
    /// # Errors
    /// As [`document`](Self::document).
    pub fn page(&self) -> Result<String> {
        let svgs = self.svgs("");
        page::page(&self.document()?, |address| {
            let name = address.strip_prefix(document::FOLDER)?;
            svgs.iter().find(|(own, _)| *own == name).map(|(_, svg)| svg.clone())
        })
    }

    /// The pictures by the names of their files, with their style in them.
    pub fn pictures(&self) -> Vec<(&'static str, String)> {
        self.svgs(plot::STYLE)
    }

    fn svgs(&self, style: &str) -> Vec<(&'static str, String)> {
        let Pictures { contacts, spectra, overlay, opposite } = &self.pictures;
        let mut svgs = vec![
            ("errors.svg", charts::errors(&self.combinations, style)),
            ("figure-7.svg", charts::windows(&self.combinations, style)),
            ("repeatability.svg", charts::repeatability(&self.combinations, style)),
            ("images.svg", maps::images(&self.combinations, style)),
        ];
        if !contacts.is_empty() {
            svgs.push(("figure-3.svg", figures::contacts(contacts, style)));
        }
        if !spectra.is_empty() {
            svgs.push(("figure-4-5.svg", figures::spectra(spectra, style)));
        }
        svgs.extend(overlay.iter().map(|overlay| ("figure-6.svg", figures::overlay(overlay, style))));
        svgs.extend(opposite.iter().map(|opposite| ("figure-10.svg", figures::opposite(opposite, style))));
        svgs
    }
}
